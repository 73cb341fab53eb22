"""The alternating cycle decomposition of a strong component: which of its cycles an acceptance condition accepts.

References:
    A. Casares, T. Colcombet, N. Fijalkow: Optimal Transformations of Games and Automata Using Muller Conditions.
    ICALP 2021, doi 10.4230/LIPIcs.ICALP.2021.123.
    A. Casares, A. Duret-Lutz, K. J. Meyer, F. Renkin, S. Sickert: Practical Applications of the Alternating Cycle
    Decomposition. TACAS 2022, doi 10.1007/978-3-030-99527-0_6.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ltlc.automata.acceptance import Acceptance, Clause, TooManyClausesError, holds, negation
from ltlc.automata.emptiness import MarkedEdge
from ltlc.automata.marks import strong_parts
from ltlc.budget import check_time


class _Node(NamedTuple):
    edges: frozenset[int]
    states: frozenset[int]
    parent: int
    depth: int


class CycleDecomposition:
    """A tree of sets of edges.

    The root has all edges. The children of a set are the maximal strongly connected sets in it that are judged
    otherwise. A leaf of a state is a node whose set meets the state while those of its children do not.

    Args:
        condition: acceptance of a run that takes some of the edges for ever, by their marks.
        edges: of the component, without repetition.
        max_nodes: of the tree.
        max_work: number of edges looked at, over all clauses and nodes; None: any.

    Raises:
        OverflowError: there are more.
    """

    def __init__(
        self, condition: Acceptance, edges: Sequence[MarkedEdge], max_nodes: int, max_work: int | None = None
    ) -> None:
        self._edges = edges
        self._number = {edge: i for i, edge in enumerate(edges)}
        everything = frozenset(range(len(edges)))
        seen = 0
        for _, _, marks in edges:
            seen |= marks
        self.root_accepts = holds(condition, seen)
        try:
            ways = {True: condition, False: negation(condition, max_nodes, with_promises=True)}
        except TooManyClausesError:
            raise OverflowError from None
        work = 0
        self._nodes = [self._node(everything, -1, 0)]
        self._children: list[range] = []
        for index, node in enumerate(self._nodes):  # grows while it is read
            wanted = ways[self.root_accepts == bool(node.depth % 2)]
            work += len(node.edges) * len(wanted)
            if max_work is not None and work > max_work:
                raise OverflowError
            parts = self._maximal_parts(node.edges, wanted)
            self._children.append(range(len(self._nodes), len(self._nodes) + len(parts)))
            self._nodes.extend([self._node(part, index, node.depth + 1) for part in parts])
            if len(self._nodes) > max_nodes:
                raise OverflowError
        self.depth = max(node.depth for node in self._nodes)
        inside: list[list[int]] = [[] for _ in edges]
        for index, node in enumerate(self._nodes):
            check_time()
            for e in node.edges:
                inside[e].append(index)
        first: dict[tuple[int, int, tuple[int, ...]], int] = {}
        self._first = {
            edge: first.setdefault((edge[0], edge[1], tuple(nodes)), edge[2])
            for edge, nodes in zip(edges, inside, strict=True)
        }

    def _node(self, edges: frozenset[int], parent: int, depth: int) -> _Node:
        return _Node(edges, frozenset(self._edges[e][0] for e in edges), parent, depth)

    def _maximal_parts(self, edges: frozenset[int], ways: Acceptance) -> list[frozenset[int]]:
        """The largest strongly connected sets of edges whose cycles, taken together, satisfy a clause."""
        found: dict[frozenset[int], None] = {}
        for clause in ways:
            check_time()
            for part in self._parts(edges, clause):
                found[part] = None
        maximal = []
        for p in found:
            check_time()
            if not any(p < other for other in found):
                maximal.append(p)
        return sorted(maximal, key=lambda p: (-len(p), sorted(p)))

    def _parts(self, edges: frozenset[int], clause: Clause) -> Iterable[frozenset[int]]:
        """The largest strongly connected sets of edges that satisfy one clause."""
        found = []
        todo = strong_parts([self._edges[e] for e in edges if not self._edges[e][2] & clause.fin])
        while todo:
            part, seen = todo.pop()
            broken = 0
            for mark, partner in clause.promises:
                if mark & seen and not partner & seen:
                    broken |= mark
            if broken:
                todo += strong_parts([edge for edge in part if not edge[2] & broken])
            elif not clause.inf & ~seen:
                found.append(frozenset([self._number[edge] for edge in part]))
        return found

    def first_alike(self, edge: MarkedEdge) -> int:
        """The marks of the first edge between the same states that is in the same sets: steps along both agree."""
        return self._first[edge]

    def n_leaves(self, states: Iterable[int]) -> int:
        """Number of leaves of these states, in all."""
        leaves = 0
        for q in states:
            check_time()
            leaves += sum(
                q in node.states and not any(q in self._nodes[c].states for c in self._children[i])
                for i, node in enumerate(self._nodes)
            )
        return leaves

    def leaf(self, state: int, node: int = 0) -> int:
        """The first leaf of a state below a node."""
        while True:
            child = self._next_child(node, -1, state)
            if child == node:
                return node
            node = child

    def step(self, leaf: int, edge: MarkedEdge) -> tuple[int, int]:
        """The leaf after an edge, and the depth of the lowest node above the leaf that has the edge.

        A run of leaves takes for ever the least such depth of the cycle that it settles in: even iff it is judged like
        all edges together.
        """
        number = self._number[edge]
        came_from, node = -1, leaf
        while number not in self._nodes[node].edges:
            came_from, node = node, self._nodes[node].parent
        following = self._next_child(node, came_from, edge[1])
        return self.leaf(edge[1], following), self._nodes[node].depth

    def _next_child(self, node: int, came_from: int, state: int) -> int:
        """The child after `came_from`, in cyclic order, that contains the state; the node itself if there is none."""
        children = self._children[node]
        turn = came_from + 1 if came_from >= 0 else children.start
        child: int
        for child in (*range(turn, children.stop), *range(children.start, turn)):
            if state in self._nodes[child].states:
                return child
        return node
