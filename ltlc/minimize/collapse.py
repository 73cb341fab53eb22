"""One state per residual language wherever that is enough: the smallest components there are, without any search."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ltlc.arrays import np, npt
from ltlc.automata.canonical import CANONICAL, canonical
from ltlc.automata.emptiness import MarkedEdge
from ltlc.automata.marks import SIMPLE_MARKS, Component, simplify_marks
from ltlc.automata.partition import first_places
from ltlc.automata.rabin import DRA
from ltlc.automata.rabin_type import LabelPair, rabin_condition
from ltlc.budget import check_time
from ltlc.minimize.lower_bound import part_lower_bound
from ltlc.minimize.residuals import Part, Residuals, residuals

MAX_NODES = 200
"""bound on the sets of edges, accepted or rejected, that the pairs of one component are made from."""


class Structure(NamedTuple):
    """A component that covers a part of the residual automaton.

    Attributes:
        residual_of: residual of the part, per state.
        step: per state and column: the next state; -1 where the part is left.
        pairs: labels as in `Part.cycle_graph`.
    """

    residual_of: tuple[int, ...]
    step: tuple[tuple[int, ...], ...]
    pairs: tuple[LabelPair, ...]


@dataclass(frozen=True)
class Minimized:
    """The smallest automaton found, and what is known about smaller ones.

    Attributes:
        automaton: the smaller automaton.
        lower_bound: no equivalent automaton with the same kind of acceptance has fewer states.
    """

    automaton: DRA
    lower_bound: int

    @property
    def is_proven(self) -> bool:
        """Whether the automaton is a smallest one."""
        return self.automaton.n_states == self.lower_bound


def collapse(automaton: DRA) -> Minimized:
    """Replace each component of the residual automaton by a single state per residual if that can be accepted by pairs.

    Exact where it applies, and polynomial but for the number of pairs. It finds what merging cannot, because the pairs
    are new: `F G a | F G !a` written as `F G (a <-> X a)` becomes one state with two pairs. More pairs may be needed
    than before.

    Args:
        automaton: any Rabin automaton.

    Returns:
        An equivalent automaton with the same kind of acceptance, never larger, and a lower bound as by `lower_bound`.
    """
    found = residuals(automaton)
    structures, bound = [], found.n_residuals
    for part in found.parts:
        least = part_lower_bound(part, automaton.acceptance)
        smallest = quotient(part) if least == len(part.residuals) else None
        structures.append(smallest or source_structure(found.automaton, part))
        bound += least - len(part.residuals)
    return Minimized(rebuild(found, structures), bound)


def quotient(part: Part) -> Structure | None:
    """One state per residual of the part, with simple marks, or None if no pairs make that accept the right words."""
    residual_of = tuple(range(len(part.residuals)))
    if len(part.states) == len(residual_of) or part.has_many_moves:
        return None
    cycles = part.cycle_graph(part.step, residual_of, part.acceptance == "state")
    pairs = rabin_condition(cycles, max_nodes=cycles.affordable(MAX_NODES))
    return with_simple_marks(part, residual_of, part.step, pairs) if isinstance(pairs, list) else None


def with_simple_marks(
    part: Part, residual_of: tuple[int, ...], step: tuple[tuple[int, ...], ...], pairs: Sequence[LabelPair]
) -> Structure:
    """A strongly connected structure with pairs that accept the same cycles, chosen as by `simplify_marks`."""
    on_states = part.acceptance == "state"
    labels_of: dict[MarkedEdge, int] = {}
    for q, row in enumerate(step):
        for c, target in enumerate(row):
            if target >= 0:
                label = target if on_states else q * part.n_columns + c
                marks = [(pair.fin >> label & 1) | (pair.inf >> label & 1) << 1 for pair in pairs]
                edge = q, target, sum(mark << 2 * i for i, mark in enumerate(marks))
                labels_of[edge] = labels_of.get(edge, 0) | 1 << label
    component = Component(list(range(len(step))), list(labels_of), len(pairs), on_states)
    chosen = [LabelPair(*(_union(labels_of[edge] for edge in edges) for edges in pair)) for pair in component.pairs()]
    return Structure(residual_of, step, tuple(chosen))


def _union(labels: Iterable[int]) -> int:
    found = 0
    for some in labels:
        found |= some
    return found


def source_structure(automaton: DRA, part: Part) -> Structure:
    """The component of the automaton itself."""
    columns = first_places(part.column)
    states = list(part.states)
    if automaton.is_listed:
        marks = [automaton.mark_lists[q] for q in states]
        if automaton.acceptance == "transition":
            marks = [row[c] for row in marks for c in columns]
        masks = [sum(1 << k for k, m in enumerate(marks) if m >> i & 1) for i in range(2 * automaton.n_pairs)]
        return Structure(part.residual_of, part.delta, tuple(map(LabelPair, masks[::2], masks[1::2])))
    if automaton.acceptance == "state":
        fin, inf = automaton.fin[:, states], automaton.inf[:, states]
    else:
        tables = (table[:, states][:, :, columns] for table in (automaton.fin, automaton.inf))
        fin, inf = [table.reshape(automaton.n_pairs, len(states) * len(columns)) for table in tables]
    pairs = [LabelPair(_mask(f), _mask(i)) for f, i in zip(fin, inf, strict=True)]
    return Structure(part.residual_of, part.delta, tuple(pairs))


def _mask(labels: npt.NDArray[np.bool_]) -> int:
    return sum(1 << int(k) for k in np.flatnonzero(labels))


def rebuild(found: Residuals, structures: Sequence[Structure]) -> DRA:
    """One structure per part, and one state for each residual in no part; the automaton itself if that is as small.

    The marks are simple: structures are made with such marks, or are those of the automaton.
    """
    automaton = found.automaton
    states: list[tuple[int, int]] = []  # (part or -1, state of the part or residual)
    number: dict[tuple[int, int], int] = {}
    entry: dict[int, int] = {}  # residual -> some state
    for i, (part, structure) in enumerate(zip(found.parts, structures, strict=True)):
        for k, residual in enumerate(structure.residual_of):
            entry.setdefault(part.residuals[residual], len(states))
            number[i, k] = len(states)
            states.append((i, k))
    for residual in range(found.n_residuals):
        if residual not in entry:
            entry[residual] = len(states)
            states.append((-1, residual))

    if len(states) >= automaton.n_states:
        return automaton
    on_states = automaton.acceptance == "state"
    n_pairs = max([1, *(len(s.pairs) for s in structures)])
    rows: list[list[int]] = []
    marks: list[Any] = []
    for i, k in states:
        check_time()
        if i < 0:
            rows.append([entry[target] for target in found.rows[k]])
            marks.append(0 if on_states else [0] * automaton.n_classes)
            continue
        part, structure = found.parts[i], structures[i]
        leaving = found.rows[part.residuals[structure.residual_of[k]]]
        step = [number[i, inside] if inside >= 0 else -1 for inside in structure.step[k]]
        rows.append([
            step[column] if step[column] >= 0 else entry[leaving[letter]] for letter, column in enumerate(part.column)
        ])  # fmt: skip
        if on_states:
            marks.append(_marks(structure.pairs, k))
        else:
            seen = [_marks(structure.pairs, k * part.n_columns + column) for column in range(part.n_columns)]
            marks.append([seen[column] for column in part.column])
    start = entry[found.language[automaton.initial_state]]
    result = automaton.with_tables(rows, marks, n_pairs, start, automaton.acceptance)
    smaller = canonical(result)
    if SIMPLE_MARKS in automaton.forms:
        return smaller.annotated(SIMPLE_MARKS)
    smaller = simplify_marks(smaller)
    return smaller if CANONICAL in smaller.forms else canonical(smaller)


def _marks(pairs: Sequence[LabelPair], label: int) -> int:
    """The marks of a label, as in `DRA.marks`."""
    return sum((pair.fin >> label & 1 | (pair.inf >> label & 1) << 1) << 2 * i for i, pair in enumerate(pairs))
