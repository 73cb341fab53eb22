"""The residual automaton of a language, and what a Rabin automaton knows about each of its strong components.

The *residuals* of a language are the languages that remain after its prefixes. Every deterministic automaton maps onto
the residual automaton, state by state, so it has one state per residual at least. Within a strong component of the
residual automaton, the states of a last strong component alone would do: they cover all residuals of the component,
and entering them instead of others changes only a prefix of each run. So a smallest automaton has one strong component
for each of the residual automaton, and each of these can be made smallest by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ltlc import graph
from ltlc.automata.acceptance import rabin_accepts, recurring_marks
from ltlc.automata.canonical import CANONICAL, canonical
from ltlc.automata.partition import first_places
from ltlc.automata.rabin import DRA, AcceptanceKind
from ltlc.automata.rabin_type import CycleGraph
from ltlc.budget import check_time

_MANY_MOVES = 100_000
"""times pairs."""


@dataclass(frozen=True, eq=False)
class Part:
    """A non-trivial strong component of the residual automaton, with a component of the automaton that covers it.

    A *column* is a set of letter classes that no state of the component tells apart.
    """

    residuals: tuple[int, ...]
    """its residuals, in increasing order; residual i of the part is `residuals[i]`."""
    step: tuple[tuple[int, ...], ...]
    """per residual of the part and column: the next residual of the part, or -1 where it is left."""
    states: tuple[int, ...]
    """states of the automaton in one strong component; state i of the part is `states[i]`."""
    residual_of: tuple[int, ...]
    """residual of the part, per state of the part."""
    delta: tuple[tuple[int, ...], ...]
    """per state of the part and column: the next state of the part, or -1 where the part is left."""
    marks: tuple[tuple[int, ...], ...]
    """like `delta`; marks as in `DRA.edge_marks`."""
    column: tuple[int, ...]
    """per letter class of the automaton: its column."""
    n_pairs: int
    acceptance: AcceptanceKind
    """of the automaton."""

    @property
    def n_columns(self) -> int:
        """Number of columns."""
        return len(self.step[0])

    @property
    def has_many_moves(self) -> bool:
        """Whether there are so many that looking at the sets of their cycles takes seconds."""
        return len(self.states) * self.n_columns * self.n_pairs > _MANY_MOVES

    def cycle_graph(self, step: Sequence[Sequence[int]], residual_of: Sequence[int], on_states: bool) -> CycleGraph:
        """All joint runs of the part and of a table that maps onto its residuals.

        Labels are states of the table if acceptance is on states, else `state * n_columns + column`.

        Args:
            step: next state of the table per state and column; the entry is ignored where the part is left.
            residual_of: residual of the part, per state of the table.
            on_states: whether acceptance is to be on states.
        """
        order = [
            (place, state)
            for place, residual in enumerate(residual_of)
            for state, other in enumerate(self.residual_of)
            if residual == other
        ]
        number = {run: node for node, run in enumerate(order)}
        columns: list[dict[tuple[int, int], int]] = []
        for place, state in order:
            check_time()
            row: dict[tuple[int, int], int] = {}
            for c, (target, marks) in enumerate(zip(self.delta[state], self.marks[state], strict=True)):
                if target < 0:
                    continue
                label = step[place][c] if on_states else place * self.n_columns + c
                row.setdefault((number[step[place][c], target], marks | 1 << 2 * self.n_pairs + label), c)
            columns.append(row)
        return CycleGraph(list(map(list, columns)), columns, order, self.n_pairs)

    def after(self, residual: int, columns: Iterable[int]) -> int:
        """The residual of the part after some columns; -1 once the part is left."""
        for c in columns:
            residual = self.step[residual][c] if residual >= 0 else -1
        return residual

    def accepts(self, residual: int, columns: Sequence[int]) -> bool:
        """Whether the residual has the word that repeats these columns, which lead back to it."""

        def run(state: int) -> tuple[int, int]:
            seen = 0
            for c in columns:
                seen |= self.marks[state][c]
                state = self.delta[state][c]
            return state, seen

        return rabin_accepts(self.n_pairs, recurring_marks(self.residual_of.index(residual), run))


@dataclass(frozen=True, eq=False)
class Residuals:
    """The residual automaton of the language of a Rabin automaton."""

    automaton: DRA
    """the automaton, canonical."""
    language: list[int]
    """the residual of each state, numbered by their first states."""
    rows: list[list[int]]
    """the next residual for each residual and letter class."""
    parts: tuple[Part, ...]
    """non-trivial strong components, in topological order."""

    @property
    def n_residuals(self) -> int:
        """Number of residuals: no deterministic automaton for the language has fewer states."""
        return len(self.rows)


def residuals(automaton: DRA) -> Residuals:
    """The residual automaton of the language of a Rabin automaton."""
    if CANONICAL not in automaton.forms:
        automaton = canonical(automaton)
    language = automaton.language_numbers
    rows = [[language[target] for target in automaton.rows[q]] for q in first_places(language)]
    component = graph.strong_components(rows)
    parts = []
    for members in graph.component_members(component):
        inside = set(members)
        if any(not inside.isdisjoint(rows[q]) for q in members):
            parts.append(_part(automaton, language, members))
    return Residuals(automaton, language, rows, tuple(parts))


def _part(automaton: DRA, language: Sequence[int], members: Sequence[int]) -> Part:
    """The states of the last strong component that maps into these residuals; it covers them all."""
    here = set(members)
    last = max(c for c, residual in zip(automaton.scc, language, strict=True) if residual in here)
    states = [q for q, c in enumerate(automaton.scc) if c == last]
    index = {q: i for i, q in enumerate(states)}
    local = {residual: i for i, residual in enumerate(members)}
    residual_of = tuple(local[language[q]] for q in states)

    columns: dict[tuple[tuple[int, int], ...], int] = {}
    column = []
    for c in range(automaton.n_classes):
        check_time()
        key = tuple(
            (index[automaton.rows[q][c]], automaton.edge_marks[q][c]) if automaton.rows[q][c] in index else (-1, 0)
            for q in states
        )
        column.append(columns.setdefault(key, len(columns)))
    delta = tuple(zip(*([target for target, _ in key] for key in columns), strict=True))
    marks = tuple(zip(*([seen for _, seen in key] for key in columns), strict=True))
    example = first_places(residual_of)
    step = tuple(tuple(residual_of[t] if t >= 0 else -1 for t in delta[q]) for q in example)
    n_pairs, kind = automaton.n_pairs, automaton.acceptance
    return Part(tuple(members), step, tuple(states), residual_of, delta, marks, tuple(column), n_pairs, kind)
