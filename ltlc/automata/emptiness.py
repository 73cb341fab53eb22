"""Cycles that satisfy an acceptance condition, for any Boolean combination of Fin and Inf.

A `MarkedGraph` is what acceptance is about: per node its distinct (successor, marks) edges, the marks of an edge being
the bits of an integer. The graph of a Rabin automaton uses bit 2i for Fin and bit 2i+1 for Inf of pair i, as HOA does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

from ltlc import graph
from ltlc.budget import check_time

MarkedGraph = Sequence[Sequence[tuple[int, int]]]
Edge = tuple[int, int, int]
"""source, target, marks."""


class Fin(NamedTuple):
    """The mark is taken finitely often."""

    mark: int


class Inf(NamedTuple):
    """The mark is taken infinitely often."""

    mark: int


class All(NamedTuple):
    """Every part holds; of no part, true."""

    parts: tuple[Condition, ...]


class Some(NamedTuple):
    """Some part holds; of no part, false."""

    parts: tuple[Condition, ...]


Condition = Fin | Inf | All | Some | bool


class AcceptingPart(NamedTuple):
    """A strongly connected part of a graph; the walk that takes all its edges for ever is accepted."""

    nodes: tuple[int, ...]
    """in increasing order."""
    avoided: int
    """edges with one of these marks do not belong to the part."""
    needed: int
    """marks such that any closed walk in the part that takes them all is accepted."""


def rabin(n_pairs: int, offset: int = 0) -> Condition:
    """Some pair i has its Fin mark (offset + 2i) finitely and its Inf mark (offset + 2i + 1) infinitely often."""
    return Some(tuple(All((Fin(offset + 2 * i), Inf(offset + 2 * i + 1))) for i in range(n_pairs)))


def streett(n_pairs: int, offset: int = 0) -> Condition:
    """The negation of `rabin`."""
    return negation(rabin(n_pairs, offset))


def only_first(n_first: int, n_second: int) -> Some:
    """The first automaton accepts and the second does not, whose marks come after those of the first.

    Written with one Rabin pair at a time, which keeps the search polynomial.
    """
    return _rabin_and(n_first, 0, streett(n_second, 2 * n_first))


def exactly_one(n_first: int, n_second: int) -> Some:
    """One of two automata accepts and the other does not; marks as in `only_first`."""
    only_second = _rabin_and(n_second, 2 * n_first, streett(n_first))
    return Some((*only_first(n_first, n_second).parts, *only_second.parts))


def _rabin_and(n_pairs: int, offset: int, other: Condition) -> Some:
    return Some(tuple(All((Fin(mark), Inf(mark + 1), other)) for mark in range(offset, offset + 2 * n_pairs, 2)))


def negation(condition: Condition) -> Condition:
    """The condition that holds exactly where this one does not."""
    match condition:
        case Fin(mark):
            return Inf(mark)
        case Inf(mark):
            return Fin(mark)
        case All(parts):
            return Some(tuple(negation(part) for part in parts))
        case Some(parts):
            return All(tuple(negation(part) for part in parts))
    return not condition


def holds(condition: Condition, seen: int) -> bool:
    """Whether the condition holds when exactly the marks in `seen` are taken infinitely often."""
    match condition:
        case Fin(mark):
            return not seen >> mark & 1
        case Inf(mark):
            return bool(seen >> mark & 1)
        case All(parts):
            return all(holds(part, seen) for part in parts)
        case Some(parts):
            return any(holds(part, seen) for part in parts)
    return condition


class _Clause(NamedTuple):
    """No mark of `avoided`, every mark of `needed`, and whenever a mark of a promise then its partner."""

    avoided: int
    needed: int
    promises: tuple[tuple[int, int], ...]


def accepting_parts(
    edges: MarkedGraph, condition: Condition, components: Iterable[Sequence[int]] | None = None
) -> Iterator[AcceptingPart]:
    """Parts that together cover every node, and every edge, that lies on an accepting cycle.

    Exact for every condition, and polynomial for Rabin, for Streett, and for one Rabin pair with Streett: the condition
    is a disjunction of clauses with Streett pairs, and a strong component that breaks a pair is searched again without
    the edges that ask for its other half.

    Args:
        edges: the graph.
        condition: acceptance of a run by the marks it takes infinitely often.
        components: sets of nodes to look into; by default the whole graph.

    References:
        C. Baier, F. Blahoudek, A. Duret-Lutz, J. Klein, D. Mueller, J. Strejcek, Generic emptiness check for fun and
        profit, ATVA 2019, doi 10.1007/978-3-030-31784-3_26.
        E. A. Emerson, C.-L. Lei, Modalities for model checking: branching time logic strikes back, Science of Computer
        Programming 8, 1987, doi 10.1016/0167-6423(87)90036-0 (Streett pairs).
    """
    clauses = _clauses(condition)
    for within in [range(len(edges))] if components is None else components:
        for nodes, seen in _strong_parts(edges, within, 0):
            for clause in clauses:
                if not clause.needed & ~seen:
                    yield from _clause_parts(edges, nodes, seen, clause)


def _clause_parts(edges: MarkedGraph, nodes: Sequence[int], seen: int, clause: _Clause) -> Iterator[AcceptingPart]:
    todo = [(nodes, seen, 0)]
    while todo:
        nodes, seen, avoided = todo.pop()
        broken = clause.avoided & seen
        needed = clause.needed
        for mark, partner in clause.promises:
            if mark & seen:
                if partner & seen:
                    needed |= partner
                else:
                    broken |= mark
        if not broken:
            yield AcceptingPart(tuple(nodes), avoided, needed)
            continue
        avoided |= broken
        for part, marks in _strong_parts(edges, nodes, avoided):
            if not clause.needed & ~marks:
                todo.append((part, marks, avoided))


def accepting_nodes(
    edges: MarkedGraph, condition: Condition, components: Iterable[Sequence[int]] | None = None
) -> set[int]:
    """The nodes that lie on an accepting cycle."""
    return {node for part in accepting_parts(edges, condition, components) for node in part.nodes}


def accepting_walk(edges: MarkedGraph, condition: Condition, start: int) -> tuple[list[Edge], list[Edge]] | None:
    """A prefix from `start` and a cycle that together make an accepted walk, or None if there is none."""
    order = graph.reachable([[target for target, _ in row] for row in edges], [start])
    part = next(accepting_parts(edges, condition, [sorted(order)]), None)
    if part is None:
        return None
    inside, avoided = set(part.nodes), part.avoided

    def within(edge: Edge) -> bool:
        return edge[1] in inside and not edge[2] & avoided

    prefix = [] if start in inside else _path(edges, start, lambda edge: edge[1] in inside)
    entry = prefix[-1][1] if prefix else start
    cycle: list[Edge] = []
    missing = part.needed
    while missing:
        cycle += _path(edges, cycle[-1][1] if cycle else entry, partial(_takes, missing), within)
        for _, _, marks in cycle:
            missing &= ~marks
    if not cycle or cycle[-1][1] != entry:
        cycle += _path(edges, cycle[-1][1] if cycle else entry, lambda edge: edge[1] == entry, within)
    return prefix, cycle


def _takes(wanted: int, edge: Edge) -> bool:
    return bool(edge[2] & wanted)


def _path(
    edges: MarkedGraph,
    start: int,
    is_goal: Callable[[Edge], bool],
    allowed: Callable[[Edge], bool] = lambda _: True,
) -> list[Edge]:
    """A shortest path of allowed edges from `start` whose last edge is a goal; the caller knows that there is one."""
    check_time()
    arrival: dict[int, Edge | None] = {start: None}
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


def _strong_parts(edges: MarkedGraph, nodes: Sequence[int], avoided: int) -> Iterator[tuple[Sequence[int], int]]:
    """The non-trivial strong components without the avoided edges, with the union of the marks inside."""
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
        if n_edges:
            yield [nodes[i] for i in members], seen


def _clauses(condition: Condition) -> list[_Clause]:
    """Disjunctive normal form, in which Fin(a) | Inf(b) stays whole as a promise."""
    match condition:
        case Fin(mark):
            return [_Clause(1 << mark, 0, ())]
        case Inf(mark):
            return [_Clause(0, 1 << mark, ())]
        case Some((Inf(partner), Fin(mark))) | Some((Fin(mark), Inf(partner))):
            return [_Clause(0, 0, ((1 << mark, 1 << partner),))]
        case Some(parts):
            return [clause for part in parts for clause in _clauses(part)]
        case All(parts):
            result = [_Clause(0, 0, ())]
            for part in parts:
                choices = _clauses(part)
                before, result = result, []
                for c in before:
                    check_time()
                    result += [
                        _Clause(c.avoided | d.avoided, c.needed | d.needed, c.promises + d.promises) for d in choices
                    ]
            return result
    return [_Clause(0, 0, ())] if condition else []
