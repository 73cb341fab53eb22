"""Cycles that satisfy an acceptance condition.

A `MarkedGraph` is what acceptance is about: per node its distinct (successor, marks) edges, the marks of an edge being
the bits of an integer. The graph of a Rabin automaton uses bit 2i for Fin and bit 2i+1 for Inf of pair i, as HOA does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial, reduce
from typing import NamedTuple, TypeVar

from ltlc import graph
from ltlc.automata.acceptance import Acceptance, Clause
from ltlc.budget import check_time

MarkedGraph = Sequence[Sequence[tuple[int, int]]]
MarkedEdge = tuple[int, int, int]
"""source, target, marks."""
Nodes = TypeVar("Nodes")
_StrongParts = Callable[[Nodes, int, int], Iterable[tuple[Nodes, int]]]
"""The non-trivial strong components of a set of nodes without the edges with some marks, with the marks inside; only
those where all of some other marks are inside."""
MAX_MASK = 1024
"""Sets of up to so many nodes are bit masks, which is twice as fast; more would take memory in their square."""


class AcceptingPart(NamedTuple):
    """A strongly connected part of a graph; the walk that takes all its edges for ever is accepted."""

    nodes: tuple[int, ...]
    """in increasing order."""
    avoided: int
    """edges with one of these marks do not belong to the part."""
    needed: int
    """marks such that any closed walk in the part that takes them all is accepted."""


def accepting_parts(
    edges: MarkedGraph, acceptance: Acceptance, components: Iterable[Sequence[int]] | None = None
) -> Iterator[AcceptingPart]:
    """Parts that together cover every node, and every edge, that lies on an accepting cycle.

    Exact, and polynomial in the size of the condition: a strong component that breaks a promise of a clause is searched
    again without the edges that ask for the partner.

    Args:
        edges: the graph.
        acceptance: of a run by the marks it takes infinitely often.
        components: sets of nodes to look into; by default the whole graph.

    References:
        C. Baier, F. Blahoudek, A. Duret-Lutz, J. Klein, D. Mueller, J. Strejcek, Generic emptiness check for fun and
        profit, ATVA 2019, doi 10.1007/978-3-030-31784-3_26.
        E. A. Emerson, C.-L. Lei, Modalities for model checking: branching time logic strikes back, Science of Computer
        Programming 8, 1987, doi 10.1016/0167-6423(87)90036-0 (Streett pairs).
    """
    for within in [range(len(edges))] if components is None else components:
        if len(within) <= MAX_MASK:
            rows = _masks(edges, within)
            for mask, avoided, needed in _accepting(partial(_parts_of_mask, rows), (1 << len(rows)) - 1, acceptance):
                yield AcceptingPart(tuple([within[i] for i in graph.bits(mask)]), avoided, needed)
        else:
            for nodes, avoided, needed in _accepting(partial(_parts_of_list, edges), within, acceptance):
                yield AcceptingPart(tuple(nodes), avoided, needed)


def _accepting(parts: _StrongParts[Nodes], nodes: Nodes, acceptance: Acceptance) -> Iterator[tuple[Nodes, int, int]]:
    required = reduce(int.__and__, (clause.inf for clause in acceptance)) if acceptance else 0
    for part, seen in parts(nodes, 0, required):
        for clause in acceptance:
            if not clause.inf & ~seen:
                yield from _clause_parts(parts, part, seen, clause)


def _clause_parts(
    parts: _StrongParts[Nodes], nodes: Nodes, seen: int, clause: Clause
) -> Iterator[tuple[Nodes, int, int]]:
    todo = [(nodes, seen, 0)]
    while todo:
        nodes, seen, avoided = todo.pop()
        broken = clause.fin & seen
        needed = clause.inf
        for mark, partner in clause.promises:
            if mark & seen:
                if partner & seen:
                    needed |= partner & seen
                else:
                    broken |= mark
        if not broken:
            yield nodes, avoided, needed
            continue
        avoided |= broken
        todo += [(part, marks, avoided) for part, marks in parts(nodes, avoided, clause.inf)]


def accepting_nodes(
    edges: MarkedGraph, acceptance: Acceptance, components: Iterable[Sequence[int]] | None = None
) -> set[int]:
    """The nodes that lie on an accepting cycle."""
    return {node for part in accepting_parts(edges, acceptance, components) for node in part.nodes}


def accepting_walk(
    edges: MarkedGraph, acceptance: Acceptance, start: int, *, is_reachable: bool = False
) -> tuple[list[MarkedEdge], list[MarkedEdge]] | None:
    """A prefix from `start` and a cycle that together make an accepted walk, or None if there is none.

    Args:
        edges: the graph.
        acceptance: of a run by the marks it takes infinitely often.
        start: a node.
        is_reachable: every node is known to be reachable from `start`.
    """
    order: Sequence[int] = range(len(edges))
    if not is_reachable:
        order = sorted(graph.reachable([[target for target, _ in row] for row in edges], [start]))
    part = next(accepting_parts(edges, acceptance, [order]), None)
    if part is None:
        return None
    inside, avoided = set(part.nodes), part.avoided

    def within(edge: MarkedEdge) -> bool:
        return edge[1] in inside and not edge[2] & avoided

    prefix = [] if start in inside else _path(edges, start, lambda edge: edge[1] in inside)
    entry = prefix[-1][1] if prefix else start
    cycle: list[MarkedEdge] = []
    missing = part.needed
    while missing:
        cycle += _path(edges, cycle[-1][1] if cycle else entry, partial(_takes, missing), within)
        for _, _, marks in cycle:
            missing &= ~marks
    if not cycle or cycle[-1][1] != entry:
        cycle += _path(edges, cycle[-1][1] if cycle else entry, lambda edge: edge[1] == entry, within)
    return prefix, cycle


def _takes(wanted: int, edge: MarkedEdge) -> bool:
    return bool(edge[2] & wanted)


def _path(
    edges: MarkedGraph,
    start: int,
    is_goal: Callable[[MarkedEdge], bool],
    allowed: Callable[[MarkedEdge], bool] = lambda _: True,
) -> list[MarkedEdge]:
    """A shortest path of allowed edges from `start` whose last edge is a goal; the caller knows that there is one."""
    check_time()
    arrival: dict[int, MarkedEdge | None] = {start: None}
    queue = [start]
    for node in queue:  # grows while it is read
        for target, marks in edges[node]:
            edge = (node, target, marks)
            if not allowed(edge):
                continue
            if is_goal(edge):
                path = [edge]
                while (before := arrival[path[-1][0]]) is not None:
                    path.append(before)
                return path[::-1]
            if target not in arrival:
                arrival[target] = edge
                queue.append(target)
    raise AssertionError("no path inside a strongly connected part")


def _parts_of_list(
    edges: MarkedGraph, nodes: Sequence[int], avoided: int, required: int
) -> Iterator[tuple[Sequence[int], int]]:
    """See `_StrongParts`."""
    index = {node: i for i, node in enumerate(nodes)}
    inner = [[(index[t], marks) for t, marks in edges[node] if not marks & avoided and t in index] for node in nodes]
    component = graph.strong_components([[t for t, _ in row] for row in inner])
    for members in graph.component_members(component):
        here = component[members[0]]
        seen, n_edges = 0, 0
        for i in members:
            for target, marks in inner[i]:
                if component[target] == here:
                    seen |= marks
                    n_edges += 1
        if n_edges and not required & ~seen:
            yield [nodes[i] for i in members], seen


def _masks(edges: MarkedGraph, within: Sequence[int]) -> list[list[tuple[int, int]]]:
    """Per node, (marks, targets) for each set of marks on its edges: targets are a bit mask of places in `within`."""
    if len(within) == len(edges):
        bit: Sequence[int] | Mapping[int, int] = [1 << i for i in range(len(edges))]
    else:
        inside = bit = {node: 1 << i for i, node in enumerate(within)}
        edges = [[edge for edge in edges[node] if edge[0] in inside] for node in within]
    rows = []
    for row in edges:
        targets: dict[int, int] = {}
        for target, marks in row:
            targets[marks] = targets.get(marks, 0) | bit[target]
        rows.append(list(targets.items()))
    return rows


def _parts_of_mask(
    rows: Sequence[Sequence[tuple[int, int]]], nodes: int, avoided: int, required: int
) -> Iterator[tuple[int, int]]:
    """See `_StrongParts`; rows as from `_masks`, and sets of nodes as bit masks."""
    check_time()
    successors = [0] * len(rows)
    possible = 0
    for node in graph.bits(nodes):
        reached = 0
        for marks, targets in rows[node]:
            if not marks & avoided and targets & nodes:
                reached |= targets
                possible |= marks
        successors[node] = reached
    if required & ~possible:
        return
    for part in graph.strong_sets(successors, nodes):
        seen = 0
        for node in graph.bits(part):
            for marks, targets in rows[node]:
                if targets & part and not marks & avoided:
                    seen |= marks
        if not required & ~seen:
            yield part, seen
