"""Smaller Rabin automata of the same language: fewer pairs, marks and states."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ltlc.automata.canonical import canonical
from ltlc.automata.languages import MAX_PRODUCT_EDGES, can_decide_languages, equivalent_states
from ltlc.automata.marks import simplify_marks
from ltlc.automata.partition import IntArray, number_blocks, refine
from ltlc.automata.rabin import RabinAutomaton
from ltlc.errors import TimeLimitExceeded
from ltlc.minimize.lower_bound import is_smallest
from ltlc.minimize.merge_by_trial import EFFORT, merge_by_trial


def reduce(automaton: RabinAutomaton, *, effort: int = EFFORT) -> RabinAutomaton:
    """`normalized`, and merged by trial unless it is the smallest already; the kind of acceptance stays.

    Args:
        automaton: any Rabin automaton.
        effort: see `merge_by_trial`; 0 leaves that step out.
    """
    result = normalized(automaton)
    try:
        if effort <= 0 or is_smallest(result):
            return result
    except TimeLimitExceeded:
        return result
    smaller = merge_by_trial(result, effort)
    return result if smaller.n_states == result.n_states else normalized(smaller)


def normalized(automaton: RabinAutomaton) -> RabinAutomaton:
    """Simplify marks, merge states, and number canonically, until nothing changes; the kind of acceptance stays.

    One deadlock and one accepting sink remain at most. Where the time of the call is over, what is left is left out.
    """
    if "normalized" in automaton.facts:
        return automaton
    result = automaton
    with suppress(TimeLimitExceeded):
        result = numbered = canonical(automaton)
        result = merge_bisimilar(numbered)
        merged = merge_bisimilar(merge_equivalent(result))
        result = numbered if merged is numbered else canonical(merged)
        result = simplify_marks(result)
        while (merged := merge_bisimilar(result)) is not result:
            result = canonical(merged)
            result = simplify_marks(result)
        result = canonical(result)
        result.facts.add("normalized")
    return result


def merge_bisimilar(automaton: RabinAutomaton) -> RabinAutomaton:
    """Merge states with the same marks whose successors are again such states, for every letter."""
    if can_decide_languages(automaton) and automaton.n_languages == automaton.n_states:
        return automaton
    marks: Iterable[object] = map(tuple, automaton.edge_marks)
    if automaton.acceptance == "state":
        marks = (fin.tobytes() + inf.tobytes() for fin, inf in zip(automaton.fin.T, automaton.inf.T, strict=True))
    block = refine(automaton.delta, number_blocks(marks))
    first = np.unique(block, return_index=True)[1]
    if len(first) == automaton.n_states:
        return automaton
    names = automaton.state_names
    return replace(
        automaton,
        delta=block[automaton.delta[first]],
        fin=automaton.fin[:, first],
        inf=automaton.inf[:, first],
        initial_state=int(block[automaton.initial_state]),
        state_names=None if names is None else tuple(names[q] for q in first.tolist()),
    ).keeping_languages(automaton, first.tolist())


def merge_equivalent(automaton: RabinAutomaton, classes: IntArray | None = None) -> RabinAutomaton:
    """Enter, of states with the same language, only those in the last strong component that has one.

    Acceptance forgets prefixes, and a redirected run moves to a later component each time, hence finitely often. So
    whole components that repeat the language of later ones become unreachable; they are left in, for `canonical` to
    drop.

    Args:
        automaton: any Rabin automaton.
        classes: `equivalent_states(automaton)` if it is known already; by default within `MAX_PRODUCT_EDGES`.
    """
    if classes is None:
        exact = can_decide_languages(automaton)
        classes = automaton.languages if exact else equivalent_states(automaton, MAX_PRODUCT_EDGES)
    if int(classes.max()) + 1 == automaton.n_states:
        return automaton
    scc = np.array(automaton.scc)
    best: dict[int, int] = {}
    for state, language in enumerate(classes.tolist()):
        if language not in best or scc[state] > scc[best[language]]:
            best[language] = state
    entered = np.array([best[language] for language in classes.tolist()], dtype=np.int32)
    stays = scc[entered] == scc
    entered[stays] = np.flatnonzero(stays)
    initial = int(entered[automaton.initial_state])
    return replace(automaton, delta=entered[automaton.delta], initial_state=initial).keeping_languages(automaton)
