"""Marks on transitions, chosen such that few different ones enter each state."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import permutations
from typing import NamedTuple

from ltlc.automata.acceptance import exactly_one, rabin_accepts
from ltlc.automata.canonical import CANONICAL, canonical, tells_columns_apart
from ltlc.automata.emptiness import MarkedEdge, accepting_parts
from ltlc.automata.marks import SIMPLE_MARKS, Component, components
from ltlc.automata.rabin import DRA
from ltlc.automata.wide import Columns
from ltlc.budget import Overtime, check_time, overtime
from ltlc.errors import TimeLimitExceeded

MAX_EDGES_CHECKED = 20_000
"""bound on edges looked at, over all attempts in one component, to make the marks into a state equal."""


class EvenMarks(NamedTuple):
    """An automaton with even marks.

    Attributes:
        automaton: equivalent to the one before, on the same states, and canonical.
        is_complete: whether every attempt was made: there was time, and no component was too large.
    """

    automaton: DRA
    is_complete: bool


def even_marks(automaton: DRA) -> EvenMarks:
    """Make the marks of one group of transitions into a state those of another wherever no cycle changes its verdict.

    Marks of transitions between strong components are left out. Where the time of the call is over, the other marks
    stay as they are.

    Args:
        automaton: with acceptance on transitions, canonical.
    """
    with overtime(Overtime.SPLIT):
        parts = list(components(automaton))
    evened = [_Evened(component) for component in parts]
    marks = {edge: new for part in evened for edge, new in part.marks.items()}
    is_complete = all(part.is_complete for part in evened)
    if SIMPLE_MARKS in automaton.forms and all(new == edge[2] for edge, new in marks.items()):
        return EvenMarks(automaton, is_complete)
    columns = Columns(automaton)
    table = [
        columns.spread(q, [marks.get((q, t, old), 0) for t, old in columns.of(q)]) for q in range(automaton.n_states)
    ]
    languages = automaton.language_numbers if automaton.has_languages else None
    changed = automaton.with_marks(table, automaton.n_pairs).annotated(languages=languages)
    is_canonical = CANONICAL in automaton.forms and tells_columns_apart(changed)
    with overtime(Overtime.SPLIT):
        changed = changed.annotated(CANONICAL) if is_canonical else canonical(changed)
    return EvenMarks(changed.annotated(*({SIMPLE_MARKS} & automaton.forms)), is_complete)


class _Evened:
    """New marks for the edges of a strong component, equivalent on all cycles.

    Attributes:
        marks: for each edge.
        is_complete: see `EvenMarks`.
    """

    def __init__(self, component: Component) -> None:
        self.marks = {edge: edge[2] for edge in component.edges}
        self._component = component
        self._to_check = MAX_EDGES_CHECKED
        index = {node: i for i, node in enumerate(component.nodes)}
        self._places = [(index[source], index[target]) for source, target, _ in component.edges]
        self._loops: dict[int, list[MarkedEdge]] = defaultdict(list)
        into: dict[int, list[MarkedEdge]] = defaultdict(list)
        for edge in component.edges:
            into[edge[1]].append(edge)
            if edge[0] == edge[1]:
                self._loops[edge[0]].append(edge)
        try:
            for edges in into.values():
                self._even(edges)
            self.is_complete = self._to_check > 0
        except TimeLimitExceeded:
            self.is_complete = False

    def _even(self, edges: Sequence[MarkedEdge]) -> None:
        """Give edges into one state fewer different marks."""
        merged = True
        while merged and self._to_check > 0:
            merged = False
            for old, new in permutations(sorted({self.marks[edge] for edge in edges}), 2):
                check_time()
                attempt = dict.fromkeys((edge for edge in edges if self.marks[edge] == old), new)
                if self._is_equivalent(attempt):
                    self.marks |= attempt
                    merged = True
                    break

    def _is_equivalent(self, attempt: Mapping[MarkedEdge, int]) -> bool:
        """Whether every cycle is accepted with these new marks iff it is with those of the automaton."""
        n_pairs = self._component.n_pairs
        for loop, new in attempt.items():
            for other in self._loops[loop[0]] if loop[0] == loop[1] else ():  # cycles of two loops are quickly judged
                changed = new | attempt.get(other, self.marks[other])
                if rabin_accepts(n_pairs, loop[2] | other[2]) != rabin_accepts(n_pairs, changed):
                    return False
        self._to_check -= len(self.marks)
        rows: list[list[tuple[int, int]]] = [[] for _ in self._component.nodes]
        shift = 2 * n_pairs
        replaced = 1 << shift
        for (source, target), edge in zip(self._places, self._component.edges, strict=True):
            marks = attempt[edge] | replaced if edge in attempt else self.marks[edge]
            rows[source].append((target, edge[2] | marks << shift))
        return next(accepting_parts(rows, exactly_one(n_pairs, n_pairs, replaced << shift)), None) is None
