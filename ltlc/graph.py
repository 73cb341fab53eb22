"""Finite directed graphs: strong components, reachability, distances.

A graph is given by its successors: a list of lists of node numbers, or an integer array of shape (n, k) whose row q
holds the k successors of q. Everything is iterative, needs numpy only, and depends on the order of the input alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from ltlc.arrays import np, npt
from ltlc.budget import check_time

Graph: TypeAlias = "Sequence[Sequence[int]] | npt.NDArray[np.integer]"


_BITS = tuple(tuple(i for i in range(8) if mask >> i & 1) for mask in range(256))
"""the members of sets of integers below 8, which are asked for most."""


def bits(mask: int) -> list[int]:
    """The members of a set of small integers given as a bit mask, in increasing order."""
    if mask < len(_BITS):
        return list(_BITS[mask])
    if mask >> 32 and 3 * mask.bit_count() > mask.bit_length():  # dense: four times as fast
        return [i for i, digit in enumerate(bin(mask)[:1:-1]) if digit == "1"]
    found: list[int] = []
    while mask:
        low = mask & -mask
        found.append(low.bit_length() - 1)
        mask ^= low
    return found


def from_edges(n: int, edges: Iterable[tuple[int, int]]) -> list[list[int]]:
    """The successor lists of n nodes with these (source, target) edges, in the order given."""
    successors: list[list[int]] = [[] for _ in range(n)]
    for source, target in edges:
        successors[source].append(target)
    return successors


def successor_lists(graph: Graph) -> Sequence[Sequence[int]]:
    """The graph as lists of distinct successors per node (lists are taken as they are)."""
    if isinstance(graph, (list, tuple)) or not isinstance(graph, np.ndarray):
        return graph
    return [list(dict.fromkeys(row)) for row in graph.tolist()]


def predecessor_lists(graph: Graph) -> list[list[int]]:
    """The reversed graph: predecessors in increasing order."""
    successors = successor_lists(graph)
    predecessors: list[list[int]] = [[] for _ in successors]
    for node, targets in enumerate(successors):
        for target in targets:
            predecessors[target].append(node)
    return predecessors


def strong_components(graph: Graph) -> list[int]:
    """The component of each node, numbered in topological order: no edge leads to a smaller number.

    References:
        R. Tarjan, Depth-first search and linear graph algorithms, SIAM J. Comput. 1972, doi 10.1137/0201010;
        with an explicit stack instead of recursion.
    """
    check_time()
    successors = successor_lists(graph)
    n = len(successors)
    # low[q]: 0 = unseen, else lowest visit number known to be reachable on the stack; done nodes get n + 1.
    low = [0] * n
    component = [0] * n
    done = n + 1
    visits = found = 0
    open_nodes: list[int] = []
    for root in range(n):
        if low[root]:
            continue
        visits += 1
        low[root] = visits
        open_nodes.append(root)
        path = [(root, visits, iter(successors[root]))]
        while path:
            node, number, targets = path[-1]
            lowest = low[node]
            for target in targets:
                seen = low[target]
                if not seen:
                    visits += 1
                    if not visits & 8191:
                        check_time()
                    low[target] = visits
                    low[node] = lowest
                    open_nodes.append(target)
                    path.append((target, visits, iter(successors[target])))
                    break
                if seen < lowest:  # noqa: PLR1730 - min() costs a third of the time of this loop
                    lowest = seen
            else:
                path.pop()
                low[node] = lowest
                if lowest == number:
                    member = -1
                    while member != node:
                        member = open_nodes.pop()
                        component[member] = found
                        low[member] = done
                    found += 1
                elif lowest < low[path[-1][0]]:
                    low[path[-1][0]] = lowest
    return [found - 1 - c for c in component]


def strong_sets(successors: Sequence[int], nodes: int) -> list[int]:
    """The non-trivial strong components of some nodes, in the order of `strong_components`; sets are bit masks.

    References:
        H. N. Gabow, Path-based depth-first search for strong and biconnected components, Information Processing
        Letters 74, 2000, doi 10.1016/S0020-0190(00)00051-X.
    """
    found: list[int] = []
    unseen, on_path = nodes, 0
    path: list[int] = []
    parts: list[int] = []  # of the nodes on the path and those behind it, a strongly connected set each
    while unseen or path:
        following = unseen
        if path:
            targets = successors[path[-1]]
            while targets & on_path & ~parts[-1]:
                part = parts.pop()
                parts[-1] |= part
            following &= targets
        if following:
            low = following & -following
            unseen ^= low
            on_path |= low
            path.append(low.bit_length() - 1)
            parts.append(low)
            continue
        node = path.pop()
        if not path or not parts[-1] >> path[-1] & 1:
            part = parts.pop()
            on_path ^= part
            if part & part - 1 or successors[node] & part:
                found.append(part)
    return found[::-1]


def component_members(component: Sequence[int]) -> list[list[int]]:
    """The nodes of each strong component, in increasing order."""
    members: list[list[int]] = [[] for _ in range(max(component, default=-1) + 1)]
    for node, c in enumerate(component):
        members[c].append(node)
    return members


def distances(graph: Graph, sources: Iterable[int]) -> list[int]:
    """Number of edges on a shortest path from the nearest source to each node; -1 where there is none."""
    successors = successor_lists(graph)
    distance = [-1] * len(successors)
    queue = []
    for source in sources:
        if distance[source] < 0:
            distance[source] = 0
            queue.append(source)
    for node in queue:  # grows while it is read
        if not node & 8191:
            check_time()
        following = distance[node] + 1
        for target in successors[node]:
            if distance[target] < 0:
                distance[target] = following
                queue.append(target)
    return distance


def reachable(graph: Graph, sources: Iterable[int]) -> list[int]:
    """The nodes that can be reached from the sources, sources included, in breadth-first order."""
    successors = successor_lists(graph)
    order = list(dict.fromkeys(sources))
    seen = set(order)
    for node in order:  # grows while it is read
        if not node & 8191:
            check_time()
        for target in successors[node]:
            if target not in seen:
                seen.add(target)
                order.append(target)
    return order


def coreachable(graph: Graph, targets: Iterable[int]) -> list[int]:
    """The nodes from which some target can be reached, targets included, in breadth-first order."""
    return reachable(predecessor_lists(graph), targets)
