"""Acceptance moved from transitions to states and back."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

from ltlc.arrays import np, npt
from ltlc.automata.canonical import CANONICAL, canonical, tells_columns_apart
from ltlc.automata.languages import can_decide_languages
from ltlc.automata.marks import SIMPLE_MARKS
from ltlc.automata.rabin import DRA
from ltlc.automata.wide import Columns
from ltlc.budget import NO_LIMIT, Budget, Overtime, has_time, overtime
from ltlc.errors import LimitExceeded, TimeLimitExceeded
from ltlc.minimize.even_marks import even_marks
from ltlc.minimize.lower_bound import proven_least
from ltlc.minimize.merge_by_trial import EFFORT, merge_by_trial, twins
from ltlc.minimize.reduce import MERGED, NORMALIZED, merge_states, normalized, reduce
from ltlc.minimize.words import Words

_PATIENCE = 2
"""An automaton that may split into this many times the states of the best split so far is not split."""


def to_state_based(
    automaton: DRA,
    *,
    effort: int = EFFORT,
    budget: Budget = NO_LIMIT,
    others: Sequence[DRA] = (),
    least: int = 1,
    words: Words | None = None,
) -> DRA:
    """An equivalent automaton with acceptance on states, reduced and canonical; `reduce` before it is worth the time.

    A state is split by the marks of the transitions that enter it from its own strong component; other transitions
    enter any copy. Before, marks that do not matter are chosen such that few states are split: the marks of one group
    of transitions into a state become those of another wherever no cycle changes its acceptance. The second attempt
    also leaves out a mark that the state before carries: a run takes it just as often infinitely often, and the copies
    have more in common. What is split is normalized once, before, and so are its copies; they are merged by trial.
    Where the time of the call is over, states are split once, with the marks that there are.

    Args:
        automaton: any Rabin automaton.
        effort: see `merge_by_trial`.
        budget: on the states before they are reduced.
        others: equivalent automata with acceptance on transitions that may split into fewer states.
        least: no equivalent automaton with acceptance on states has fewer states.
        words: see `merge_by_trial`.

    Raises:
        StateLimitExceeded: there are more.
        TimeLimitExceeded: overtime did not suffice.
    """
    if automaton.acceptance == "state":
        return reduce(automaton, effort=effort)
    if CANONICAL not in automaton.forms:
        with overtime(Overtime.SPLIT):
            automaton = canonical(automaton)
    with suppress(TimeLimitExceeded):
        least = max(least, proven_least(automaton, "state"))
    distinct: dict[object, DRA] = {}
    for way in (automaton, *others):
        distinct.setdefault(_tables(way), way)
    ways = sorted(distinct.values(), key=_n_copies)
    found: list[_Split] = []
    for number, way in enumerate(ways, 1):
        if found and way is automaton and _n_copies(way) > _PATIENCE * found[0].automaton.n_states:
            break
        try:
            found.append(_smallest_split(way, automaton, budget, least))
        except LimitExceeded:
            if not found and number == len(ways):
                raise
            continue
        if found[-1].automaton.n_states <= least or not has_time():
            break
    reference = min(ways, key=lambda a: a.n_states * a.n_pairs)
    n_pairs = min(split.automaton.n_pairs for split in found)  # with more pairs, fewer states can be merged
    smallest = min((split.automaton for split in found), key=lambda a: a.n_states)
    to_beat = budget.max_states
    for split, origin in found:
        if split.n_pairs == n_pairs and least < split.n_states <= to_beat:  # what is larger was never merged into less
            merged = merge_by_trial(split, effort, reference=reference, least=least, split_from=origin, words=words)
            smallest = min(merged, smallest, key=lambda a: a.n_states)
            to_beat = min(to_beat, merged.n_states)
    if CANONICAL not in smallest.forms:
        with overtime(Overtime.SPLIT):
            smallest = canonical(smallest)
    if NORMALIZED not in smallest.forms:
        with overtime(Overtime.REDUCE_AGAIN):
            smallest = normalized(smallest)
    return smallest


def _tables(automaton: DRA) -> object:
    """Equal for automata that are the same and come from the same kind of tables."""
    if automaton.is_listed:
        classes = automaton.alphabet.classes
        lists = map(tuple, automaton.rows + automaton.mark_lists)
        return automaton.n_pairs, tuple(classes) if isinstance(classes, list) else classes.tobytes(), *lists
    arrays = automaton.delta, automaton.letter_class, automaton.fin, automaton.inf
    return tuple(array.tobytes() for array in arrays)


def _n_copies(automaton: DRA) -> int:
    """Number of pairs of a state and the marks with which an edge enters it."""
    return len({edge for row in automaton.marked_graph for edge in row})


class _Split(NamedTuple):
    """An automaton with marks on states, and the one whose states were split, if no copy can replace another."""

    automaton: DRA
    origin: DRA | None


def _smallest_split(way: DRA, reference: DRA, budget: Budget, least: int) -> _Split:
    """The smaller one of two ways to split states, normalized; languages are taken over from the reference."""
    way, is_complete = even_marks(_with_languages(way, reference))
    with suppress(TimeLimitExceeded):
        way = merge_states(way)
    with overtime(Overtime.SPLIT):
        split = _with_languages(_split(way, budget), reference)
    with suppress(LimitExceeded):
        split = merge_states(split)
        if split.n_states > least and way.n_pairs == 1:
            other = merge_states(_with_languages(_split(way, budget, once=True), reference))
            if other.n_states > split.n_states:
                other = normalized(other)
            split = min(split, other, key=lambda a: a.n_states)
    return _Split(split, way if is_complete else None)


def _with_languages(automaton: DRA, reference: DRA) -> DRA:
    """The automaton with its `languages` if those of an equivalent one can be found within the time."""
    if automaton.has_languages:
        return automaton
    with suppress(TimeLimitExceeded):
        if can_decide_languages(reference):
            return automaton.annotated(languages=[reference.language_numbers[q] for q in twins(automaton, reference)])
    return automaton


def _split(automaton: DRA, budget: Budget, once: bool = False) -> DRA:
    """States are (state, marks on entry).

    Two copies with one future have one state behind them, if no two states of the automaton have one future, and no
    language is that of states in two strong components: so the copies of a normalized automaton are so, too.

    Args:
        automaton: with acceptance on transitions.
        budget: on the states.
        once: leave out marks on entry that the state before has.
    """
    scc, columns = automaton.scc, Columns(automaton)
    some_copy = [-1] * automaton.n_states
    for q, row in enumerate(automaton.marked_graph):
        for target, entry in row:
            if scc[q] == scc[target] and not 0 <= some_copy[target] <= entry:
                some_copy[target] = entry
    some_copy = [max(entry, 0) for entry in some_copy]

    start = automaton.initial_state
    order = [(start, some_copy[start])]
    number = {order[0]: 0}
    delta: list[Sequence[int] | npt.NDArray[np.int32]] = []
    for state, carried in order:  # grows while it is read
        budget.check_size(len(order))
        budget.check_table(len(order), automaton.n_classes)
        here, left_out = scc[state], carried if once else 0
        numbers = []
        for target, entry in columns.of(state):
            node = (target, entry & ~left_out if scc[target] == here else some_copy[target])
            if node not in number:
                number[node] = len(order)
                order.append(node)
            numbers.append(number[node])
        delta.append(columns.spread(state, numbers))

    split = automaton.with_tables(delta, [entry for _, entry in order], automaton.n_pairs, 0, "state")
    if once:
        return split.annotated(CANONICAL) if CANONICAL in automaton.forms and tells_columns_apart(split) else split
    forms = {SIMPLE_MARKS, MERGED, CANONICAL} & automaton.forms
    return split.annotated(*forms, *((NORMALIZED,) if len(forms) == 3 else ()))
