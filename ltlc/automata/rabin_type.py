"""Whether a graph can carry a Rabin condition for given verdicts on its cycles, and the pairs if it can.

A graph is given together with an automaton that knows the verdicts: a run of both is a walk through a *cycle graph*,
whose edges carry the marks of the automaton, and one *label*, which is what the new condition may speak of: the edge of
the graph that is taken (acceptance on transitions), or the state that is entered (acceptance on states).

A set of labels that is accepted by a Rabin pair has a label in Inf, and then no cycle inside it with this label is
rejected. So a *conflict*, an accepted cycle all of whose labels are on rejected cycles inside it, excludes every Rabin
condition. Otherwise one pair accepts the largest accepted sets of labels by what is not on rejected cycles; the cycles
that remain are looked at in the same way. (An alternating cycle decomposition, for edges.)

References:
    C. Loeding: Optimal bounds for transformations of omega-automata. FSTTCS 1999, doi 10.1007/3-540-46691-6_8 (the
    closure property).
    A. Casares, T. Colcombet, N. Fijalkow: Optimal Transformations of Games and Automata Using Muller Conditions.
    ICALP 2021, doi 10.4230/LIPIcs.ICALP.2021.123 (the decomposition, and Rabin types in terms of it).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from ltlc.automata.acceptance import Acceptance, rabin, rabin_pair, streett
from ltlc.automata.emptiness import MarkedEdge, MarkedGraph, accepting_parts, accepting_walk
from ltlc.budget import check_time

_MAX_WORK = 500_000
"""Edges that are looked at for one decomposition, times pairs,"""
_LEAST_NODES = 4
"""except that so many nodes are always looked at."""


class LabelPair(NamedTuple):
    """A Rabin pair on labels; both sets as bit masks."""

    fin: int
    inf: int


class Conflict(NamedTuple):
    """Why there is no Rabin condition: sets of labels, as bit masks, of one accepted and of rejected cycles.

    The rejected cycles lie inside the accepted one, and together have all its labels.
    """

    accepted: int
    rejected: tuple[int, ...]


class CycleGraph(NamedTuple):
    """A graph whose cycles have known verdicts."""

    edges: MarkedGraph
    """marks: bits 2i and 2i + 1 are Fin and Inf of pair i of the automaton, bit 2 * n_pairs + k is label k."""
    columns: Sequence[Mapping[tuple[int, int], int]]
    """per node and edge: some column (see `residuals.Part`) that leads along it."""
    runs: Sequence[tuple[int, int]]
    """per node: the state of the graph that is to carry the condition, and the state of the automaton."""
    n_pairs: int

    def affordable(self, max_nodes: int) -> int:
        """A bound on the nodes of the decomposition: this one, or a lower one where each node takes long."""
        n_edges = sum(map(len, self.edges))
        return min(max_nodes, max(_LEAST_NODES, _MAX_WORK // (1 + n_edges * self.n_pairs)))

    def columns_along(self, walk: Iterable[MarkedEdge]) -> tuple[int, ...]:
        """Columns that lead along a walk."""
        return tuple(self.columns[source][target, marks] for source, target, marks in walk)

    def labels(self) -> int:
        """All labels that occur."""
        seen = 0
        for row in self.edges:
            for _, marks in row:
                seen |= marks
        return seen >> 2 * self.n_pairs

    def places(self, labels: int) -> set[int]:
        """The states of the graph on the cycles with exactly these labels."""
        return {self.runs[target][0] for row in self.within(labels) for target, _ in row}

    def within(self, labels: int) -> MarkedGraph:
        """The edges with these labels."""
        other = ~(labels << 2 * self.n_pairs | (1 << 2 * self.n_pairs) - 1)
        return [[edge for edge in row if not edge[1] & other] for row in self.edges]

    def accepted_parts(self, labels: int) -> list[int]:
        """The largest sets of labels of accepted cycles with these labels."""
        edges = self.within(labels)
        return _maximal(part for i in range(self.n_pairs) for part in self._parts(edges, (rabin_pair(i),)))

    def rejected_parts(self, labels: int) -> list[int]:
        """The largest sets of labels of rejected cycles with these labels."""
        return _maximal(self._parts(self.within(labels), (streett(self.n_pairs),)))

    def _parts(self, edges: MarkedGraph, acceptance: Acceptance) -> Iterator[int]:
        for nodes, avoided, _ in accepting_parts(edges, acceptance):
            inside, seen = set(nodes), 0
            for node in nodes:
                for target, marks in edges[node]:
                    if target in inside and not marks & avoided:
                        seen |= marks
            yield seen >> 2 * self.n_pairs

    def accepted_cycle(self, labels: int) -> list[MarkedEdge]:
        """An accepted cycle with exactly these labels, which exists."""
        return self._cycle(labels, rabin(self.n_pairs))

    def rejected_cycle(self, labels: int) -> list[MarkedEdge]:
        """A rejected cycle with exactly these labels, which exists."""
        return self._cycle(labels, (streett(self.n_pairs),))

    def _cycle(self, labels: int, acceptance: Acceptance) -> list[MarkedEdge]:
        acceptance = tuple(c._replace(inf=c.inf | labels << 2 * self.n_pairs) for c in acceptance)
        edges = self.within(labels)
        for start, row in enumerate(edges):
            if row and (walk := accepting_walk(edges, acceptance, start)) is not None:
                return walk[1]
        raise AssertionError("no cycle with these labels")


def _maximal(found: Iterable[int]) -> list[int]:
    """The sets of labels that are inside no other."""
    distinct = list(dict.fromkeys(found))
    return [part for part in distinct if not any(part & ~other == 0 and part != other for other in distinct)]


def rabin_condition(
    cycles: CycleGraph, labels: int | None = None, max_nodes: int | None = None
) -> list[LabelPair] | Conflict | None:
    """Pairs on labels that accept exactly the accepted cycles, or a conflict that shows that there are none.

    Args:
        cycles: the graph and the verdicts.
        labels: look at cycles with these labels only; by default at all.
        max_nodes: give up, with None, when the decomposition has more nodes than this.
    """
    everything = cycles.labels() if labels is None else labels
    todo = cycles.accepted_parts(everything)
    done: set[int] = set()
    pairs: list[LabelPair] = []
    while todo:
        check_time()
        accepted = todo.pop()
        if accepted in done:
            continue
        done.add(accepted)
        if max_nodes is not None and len(done) > max_nodes:
            return None
        rejected = cycles.rejected_parts(accepted)
        below = 0
        for part in rejected:
            below |= part
        if below == accepted:
            return Conflict(accepted, tuple(rejected))
        pairs.append(LabelPair(everything & ~accepted, accepted & ~below))
        todo += cycles.accepted_parts(below)
    return pairs


def smallest_conflict(cycles: CycleGraph, conflict: Conflict, columns: Sequence[int]) -> Conflict:
    """A conflict inside this one from which no column (tried in this order) and no label can be left out."""
    of_column = dict.fromkeys(columns, 0)
    for edges in cycles.columns:
        for (_, marks), c in edges.items():
            of_column[c] |= marks >> 2 * cycles.n_pairs
    labels = [1 << k for k in range(conflict.accepted.bit_length())]
    for group in (*of_column.values(), *labels):
        if conflict.accepted & group:
            smaller = rabin_condition(cycles, conflict.accepted & ~group)
            if isinstance(smaller, Conflict):
                conflict = smaller
    return conflict
