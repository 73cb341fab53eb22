"""Smaller Rabin automata of the same language: fewer pairs, marks and states."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from contextlib import suppress

from ltlc.automata.canonical import CANONICAL, canonical
from ltlc.automata.languages import MAX_PRODUCT_EDGES, can_decide_languages, languages_within
from ltlc.automata.marks import SIMPLE_MARKS, simplify_marks
from ltlc.automata.partition import first_places, number_blocks, refine, refine_rows
from ltlc.automata.rabin import DRA
from ltlc.errors import TimeLimitExceeded
from ltlc.minimize.lower_bound import proven_least
from ltlc.minimize.merge_by_trial import EFFORT, merge_by_trial

NORMALIZED = "normalized"
"""the name of the form in `DRA.forms`."""
MERGED = "merged"
"""the name of the form in `DRA.forms`: no two states are bisimilar, and no language is that of states in two strong
components."""
QUOTIENT = "quotient"
"""the name of the form in `DRA.forms`: no two states are bisimilar."""


def reduce(automaton: DRA, *, effort: int = EFFORT) -> DRA:
    """`normalized`, and merged by trial unless it is the smallest already; the kind of acceptance stays.

    Args:
        automaton: any Rabin automaton.
        effort: see `merge_by_trial`; 0 leaves that step out.
    """
    result = normalized(automaton)
    with suppress(TimeLimitExceeded):
        if effort > 0 and result.n_states > (least := proven_least(result)):
            merged = merge_by_trial(result, effort, least=least)
            result = result if merged.n_states == result.n_states else normalized(merged)
    return result


def normalized(automaton: DRA) -> DRA:
    """Merge states, simplify marks, merge again, and number canonically; the kind of acceptance stays.

    One deadlock and one accepting sink remain at most. Where the time of the call is over, what is left is left out.
    """
    if NORMALIZED in automaton.forms:
        return automaton
    result = automaton
    with suppress(TimeLimitExceeded):
        if CANONICAL not in result.forms:
            result = canonical(result)
        result = merge_states(result)
        if SIMPLE_MARKS not in result.forms:
            forms = {MERGED} & result.forms
            result = merge_bisimilar(simplify_marks(result)).annotated(*forms)
        if CANONICAL not in result.forms:
            result = canonical(result).annotated(*result.forms)
        result = result.annotated(NORMALIZED)
    return result


def merge_states(automaton: DRA) -> DRA:
    """`merge_bisimilar` and `merge_equivalent`; marks stay."""
    if MERGED in automaton.forms:
        return automaton
    if can_decide_languages(automaton) and automaton.n_languages == automaton.n_states:
        return automaton.annotated(MERGED)
    result = merge_bisimilar(merge_equivalent(merge_bisimilar(automaton)))
    return result.annotated(MERGED) if can_decide_languages(result) else result


def merge_bisimilar(automaton: DRA) -> DRA:
    """Merge states with the same marks whose successors are again such states, for every letter; then `canonical`.

    The cycles of the quotient are those of the automaton, so marks that were simple stay simple.
    """
    if QUOTIENT in automaton.forms or (can_decide_languages(automaton) and automaton.n_languages == automaton.n_states):
        return automaton
    marks: Iterable[Hashable]
    if automaton.is_listed:
        marks = automaton.mark_lists if automaton.acceptance == "state" else map(tuple, automaton.mark_lists)
        block = refine_rows(automaton.rows, marks)
    else:
        if automaton.acceptance == "state" or automaton.entries is not None:
            tables = (table.swapaxes(0, 1) for table in (automaton.fin, automaton.inf))
            marks = (fin.tobytes() + inf.tobytes() for fin, inf in zip(*tables, strict=True))
        else:
            marks = map(tuple, automaton.edge_marks)
        block = refine(automaton.delta, number_blocks(marks)).tolist()
    if max(block) + 1 == automaton.n_states:
        return automaton.annotated(QUOTIENT)
    first = first_places(block)
    merged = canonical(automaton, [first[b] for b in block]).annotated(QUOTIENT)
    return merged.annotated(SIMPLE_MARKS) if SIMPLE_MARKS in automaton.forms else merged


def merge_equivalent(automaton: DRA) -> DRA:
    """Enter, of states with the same language, only those in the last strong component that has one; then `canonical`.

    Acceptance forgets prefixes, and a redirected run moves to a later component each time, hence finitely often. So
    whole components that repeat the language of later ones are not entered any more. Languages are those known within
    `MAX_PRODUCT_EDGES`.
    """
    if can_decide_languages(automaton):
        languages = automaton.language_numbers
    else:
        languages, is_exact = languages_within(automaton, MAX_PRODUCT_EDGES)
        automaton = automaton.annotated(languages=languages) if is_exact else automaton
    scc = automaton.scc
    best: dict[int, int] = {}
    for state, language in enumerate(languages):
        if language not in best or scc[state] > scc[best[language]]:
            best[language] = state
    last = [best[language] for language in languages]
    entered = [state if scc[q] == scc[state] else q for state, q in enumerate(last)]
    return automaton if entered == list(range(automaton.n_states)) else canonical(automaton, entered)
