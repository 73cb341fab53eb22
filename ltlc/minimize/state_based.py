"""Acceptance moved from transitions to states and back."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import permutations

import numpy as np

from ltlc.automata.acceptance import exactly_one
from ltlc.automata.canonical import CANONICAL, tells_columns_apart
from ltlc.automata.emptiness import MarkedEdge, accepting_parts
from ltlc.automata.languages import can_decide_languages
from ltlc.automata.marks import SIMPLE_MARKS, Component, components
from ltlc.automata.rabin import DRA
from ltlc.budget import NO_LIMIT, Budget, Overtime, check_time, overtime
from ltlc.errors import LimitExceeded, TimeLimitExceeded
from ltlc.minimize.lower_bound import proven_least
from ltlc.minimize.merge_by_trial import EFFORT, twins
from ltlc.minimize.reduce import NORMALIZED, merged_further, normalized, reduce

MAX_EDGES_CHECKED = 20_000
"""bound on edges looked at, over all attempts in one component, to make the marks into a state equal."""


def to_state_based(
    automaton: DRA,
    *,
    effort: int = EFFORT,
    budget: Budget = NO_LIMIT,
    reference: DRA | None = None,
    least: int | None = None,
) -> DRA:
    """An equivalent automaton with acceptance on states, reduced and canonical; `reduce` before it is worth the time.

    A state is split by the marks of the transitions that enter it from its own strong component; other transitions
    enter any copy. Before, marks that do not matter are chosen such that few states are split: the marks of one group
    of transitions into a state become those of another wherever no cycle changes its acceptance. The second attempt
    also leaves out a mark that the state before carries: a run takes it just as often infinitely often, and the copies
    have more in common. Where the time of the call is over, states are split once, with the marks that there are.

    Args:
        automaton: any Rabin automaton.
        effort: see `merge_by_trial`.
        budget: on the states before they are reduced.
        reference: see `merge_by_trial`; its `languages` are taken over.
        least: a lower bound on the states of the result, if one is known.

    Raises:
        StateLimitExceeded: there are more.
        TimeLimitExceeded: overtime did not suffice.
    """
    if automaton.acceptance == "state":
        return reduce(automaton, effort=effort)
    reference = automaton if reference is None else reference
    with overtime(Overtime.SPLIT):
        parts = list(components(automaton))
    marks: dict[MarkedEdge, int] = {}
    for component in parts:
        marks.update(_even_marks(component))
    with overtime(Overtime.SPLIT):
        split = _split(automaton, marks, budget)
    best = _with_languages(split, reference)
    with suppress(LimitExceeded):
        if NORMALIZED not in best.forms:
            best = normalized(best)
        least = proven_least(reference, "state") if least is None else least
        if best.n_states > least and automaton.n_pairs == 1:
            other = normalized(_with_languages(_split(automaton, marks, budget, once=True), reference))
            best = min(best, other, key=lambda a: a.n_states)
        best = merged_further(best, effort, reference=reference, least=least)
    return best


def _with_languages(automaton: DRA, reference: DRA) -> DRA:
    """The automaton with its `languages` if those of an equivalent one can be found within the time."""
    with suppress(TimeLimitExceeded):
        if reference.has_languages or can_decide_languages(reference):
            return automaton.annotated(languages=reference.languages[twins(automaton, reference)])
    return automaton


def _split(automaton: DRA, marks: Mapping[MarkedEdge, int], budget: Budget, once: bool = False) -> DRA:
    """States are (state, marks on entry).

    Args:
        automaton: with acceptance on transitions.
        marks: new marks of the edges inside strong components; the others have none.
        budget: on the states.
        once: leave out marks on entry that the state before has.
    """
    copies: dict[int, set[int]] = defaultdict(set)
    for (_, target, _), new in marks.items():
        copies[target].add(new)
    some_copy = {state: min(entry) for state, entry in copies.items()}

    rows, old_marks = automaton.delta.tolist(), automaton.edge_marks
    start = automaton.initial_state
    order = [(start, some_copy.get(start, 0))]
    number = {order[0]: 0}
    delta: list[list[int]] = []
    for state, carried in order:  # grows while it is read
        budget.check_size(len(order))
        budget.check_table(len(order), automaton.n_classes)
        delta.append([])
        for target, old in zip(rows[state], old_marks[state], strict=True):
            entry = marks.get((state, target, old))
            if entry is None:
                entry = some_copy.get(target, 0)
            elif once:
                entry &= ~carried
            node = (target, entry)
            if node not in number:
                number[node] = len(order)
                order.append(node)
            delta[-1].append(number[node])

    fin = [[bool(entry >> 2 * i & 1) for _, entry in order] for i in range(automaton.n_pairs)]
    inf = [[bool(entry >> 2 * i + 1 & 1) for _, entry in order] for i in range(automaton.n_pairs)]
    split = replace(
        automaton,
        delta=np.array(delta, dtype=np.int32),
        fin=np.array(fin, dtype=np.bool_).reshape(-1, len(order)),
        inf=np.array(inf, dtype=np.bool_).reshape(-1, len(order)),
        initial_state=0,
        acceptance="state",
        state_names=None,
    )
    forms = set() if once else {SIMPLE_MARKS} & automaton.forms
    if CANONICAL in automaton.forms and tells_columns_apart(split):
        forms.add(CANONICAL)
        if not once and all(new == old for (_, _, old), new in marks.items()):
            forms |= {NORMALIZED} & automaton.forms
    return split.annotated(*forms)


def _even_marks(component: Component) -> dict[MarkedEdge, int]:
    """New marks for the edges, equivalent on all cycles, with few different ones into each state."""
    marks = {edge: edge[2] for edge in component.edges}
    into: dict[int, list[MarkedEdge]] = defaultdict(list)
    for edge in component.edges:
        into[edge[1]].append(edge)
    to_check = MAX_EDGES_CHECKED
    with suppress(TimeLimitExceeded):
        for edges in into.values():
            merged = True
            while merged and to_check > 0:
                merged = False
                for old, new in permutations(sorted({marks[edge] for edge in edges}), 2):
                    check_time()
                    attempt = dict.fromkeys((edge for edge in edges if marks[edge] == old), new)
                    to_check -= len(marks)
                    if _same_acceptance(component, marks, attempt):
                        marks, merged = marks | attempt, True
                        break
    return marks


def _same_acceptance(component: Component, marks: Mapping[MarkedEdge, int], attempt: Mapping[MarkedEdge, int]) -> bool:
    """Whether every cycle is accepted with some marks changed iff it is with the old ones, as it is without that."""
    index = {node: i for i, node in enumerate(component.nodes)}
    rows: list[list[tuple[int, int]]] = [[] for _ in component.nodes]
    shift = 2 * component.n_pairs
    changed = 1 << shift
    for edge, kept in marks.items():
        new = attempt[edge] | changed if edge in attempt else kept
        rows[index[edge[0]]].append((index[edge[1]], edge[2] | new << shift))
    return (
        next(accepting_parts(rows, exactly_one(component.n_pairs, component.n_pairs, changed << shift)), None) is None
    )
