"""From Emerson-Lei acceptance to Rabin pairs, one strong component at a time.

Two ways are tried in each component and the one with fewer states is kept:

* **counters**: each clause Fin(B) & Inf(G1) & ... & Inf(Gk) becomes a pair; clauses with the same list of Inf sets
  share a counter that waits for them in turn. One copy of the component if no clause has two Inf sets.
* **alternating cycle decomposition**: the optimal parity condition for the given graph, and a parity condition is a
  Rabin condition.

References:
    A. Casares, T. Colcombet, N. Fijalkow: Optimal Transformations of Games and Automata Using Muller Conditions.
    ICALP 2021, doi 10.4230/LIPIcs.ICALP.2021.123.
    A. Casares, A. Duret-Lutz, K. J. Meyer, F. Renkin, S. Sickert: Practical Applications of the Alternating Cycle
    Decomposition. TACAS 2022, doi 10.1007/978-3-030-99527-0_6.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import NamedTuple, Protocol

import numpy as np

from ltlc import graph
from ltlc.automata.acceptance import Acceptance, holds, negation
from ltlc.automata.alphabet import grouped
from ltlc.automata.emerson_lei import Edge, EmersonLei, explore, merged
from ltlc.automata.rabin import IntArray, RabinAutomaton
from ltlc.budget import Budget, check_time
from ltlc.graph import bits

_MAX_CYCLE_NODES = 2000
_PAIRS_PER_ENTRY = 16
"""The marks of so many pairs take the memory of one entry in the table of next states, as lists and as arrays."""


class InnerEdge(NamedTuple):
    """An edge that stays in its strong component."""

    source: int
    target: int
    marks: int


class Memory(Protocol):
    """What a strong component remembers to express its condition by Rabin pairs."""

    n_pairs: int
    is_constant: bool
    """whether the memory is always 0."""

    def size(self, states: Iterable[int]) -> int:
        """Upper bound of the number of copies of the states, in all."""

    def start(self, state: int) -> int:
        """The memory on entering the component in a state."""

    def move(self, memory: int, edge: InnerEdge) -> tuple[int, int, int]:
        """The next memory, and the pairs whose fin and whose inf marks are seen."""


class Counters:
    """See the module docstring."""

    def __init__(self, condition: Acceptance) -> None:
        self._condition = condition
        self.n_pairs = len(condition)
        lists = {clause.inf for clause in condition if clause.inf.bit_count() > 1}
        self._waits = {inf: bits(inf) for inf in sorted(lists)}
        self.is_constant = not lists

    def size(self, states: Iterable[int]) -> int:
        """See `Memory`."""
        return len(list(states)) * reduce(int.__mul__, map(len, self._waits.values()), 1)

    def start(self, state: int) -> int:
        """See `Memory`."""
        return 0

    def move(self, memory: int, edge: InnerEdge) -> tuple[int, int, int]:
        """See `Memory`; the memory is the counters' values in mixed radix."""
        following, radix = 0, 1
        met: dict[int, bool] = {}
        for inf, waits in self._waits.items():
            memory, level = divmod(memory, len(waits))
            level, met[inf] = _advance(level, waits, edge.marks)
            following += radix * level
            radix *= len(waits)
        fins = infs = 0
        for i, (fin, inf, _) in enumerate(self._condition):
            if fin & edge.marks:
                fins |= 1 << i
            if met[inf] if inf in met else not inf & ~edge.marks:
                infs |= 1 << i
        return following, fins, infs


def _advance(level: int, waits: Sequence[int], marks: int) -> tuple[int, bool]:
    while level < len(waits) and marks >> waits[level] & 1:
        level += 1
    if level < len(waits):
        return level, False
    level = 0
    while level < len(waits) - 1 and marks >> waits[level] & 1:
        level += 1
    return level, True


class _CycleNode(NamedTuple):
    edges: frozenset[int]
    states: frozenset[int]
    parent: int
    depth: int


class CycleDecomposition:
    """The alternating cycle decomposition of one strong component; the memory is a leaf of the tree of a state."""

    def __init__(self, condition: Acceptance, edges: Sequence[InnerEdge]) -> None:
        self._edges = edges
        self._number = {edge: i for i, edge in enumerate(edges)}
        self._condition = condition
        everything = frozenset(range(len(edges)))
        self._root_accepts = self._accepts(everything)
        ways = {True: condition, False: negation(condition)}
        self._nodes = [self._node(everything, -1, 0)]
        self._children: list[list[int]] = []
        for index, node in enumerate(self._nodes):  # grows while it is read
            wanted = self._root_accepts == bool(node.depth % 2)
            parts = self._maximal_parts(node.edges, ways[wanted], wanted)
            self._children.append(list(range(len(self._nodes), len(self._nodes) + len(parts))))
            self._nodes.extend(self._node(part, index, node.depth + 1) for part in parts)
            if len(self._nodes) > _MAX_CYCLE_NODES:
                raise OverflowError
        depths = max(node.depth for node in self._nodes) + 1
        self._accepting = [d for d in range(depths) if self._root_accepts == (d % 2 == 0)]
        self.n_pairs = len(self._accepting)
        self.is_constant = len(self._nodes) == 1

    def _node(self, edges: frozenset[int], parent: int, depth: int) -> _CycleNode:
        return _CycleNode(edges, frozenset(self._edges[e].source for e in edges), parent, depth)

    def _accepts(self, edges: Iterable[int]) -> bool:
        return holds(self._condition, reduce(int.__or__, (self._edges[e].marks for e in edges), 0))

    def _maximal_parts(self, edges: frozenset[int], ways: Acceptance, wanted: bool) -> list[frozenset[int]]:
        """The largest strongly connected sets of edges whose cycles, taken together, have the wanted status."""
        found: dict[frozenset[int], None] = {}
        for fin, _, _ in ways:
            check_time()
            kept = sorted(e for e in edges if not self._edges[e].marks & fin)
            for part in _strong_edge_sets(kept, self._edges):
                if self._accepts(part) == wanted:
                    found[part] = None
        maximal = []
        for p in found:
            check_time()
            if not any(p < other for other in found):
                maximal.append(p)
        return sorted(maximal, key=lambda p: (-len(p), sorted(p)))

    def size(self, states: Iterable[int]) -> int:
        """See `Memory`."""
        leaves = 0
        for q in states:
            check_time()
            leaves += sum(
                q in node.states and not any(q in self._nodes[c].states for c in self._children[i])
                for i, node in enumerate(self._nodes)
            )
        return leaves

    def start(self, state: int) -> int:
        """See `Memory`."""
        return self._leftmost_leaf(0, state)

    def move(self, memory: int, edge: InnerEdge) -> tuple[int, int, int]:
        """See `Memory`."""
        number = self._number[edge]
        came_from, node = -1, memory
        while number not in self._nodes[node].edges:
            came_from, node = node, self._nodes[node].parent
        leaf = self._leftmost_leaf(self._next_child(node, came_from, edge.target), edge.target)
        depth = self._nodes[node].depth
        fins = sum(1 << i for i, d in enumerate(self._accepting) if d > depth)
        infs = sum(1 << i for i, d in enumerate(self._accepting) if d == depth)
        return leaf, fins, infs

    def _next_child(self, node: int, came_from: int, state: int) -> int:
        """The child after `came_from`, in cyclic order, that contains the state; the node itself if there is none."""
        children = self._children[node]
        turn = children.index(came_from) + 1 if came_from >= 0 else 0
        for child in (*children[turn:], *children[:turn]):
            if state in self._nodes[child].states:
                return child
        return node

    def _leftmost_leaf(self, node: int, state: int) -> int:
        while True:
            child = self._next_child(node, -1, state)
            if child == node:
                return node
            node = child


def _strong_edge_sets(kept: Sequence[int], edges: Sequence[InnerEdge]) -> list[frozenset[int]]:
    number: dict[int, int] = {}
    for e in kept:
        number.setdefault(edges[e].source, len(number))
        number.setdefault(edges[e].target, len(number))
    arcs = [(number[edges[e].source], number[edges[e].target]) for e in kept]
    component = graph.strong_components(graph.from_edges(len(number), arcs))
    parts: dict[int, list[int]] = {}
    for e, (source, target) in zip(kept, arcs, strict=True):
        if component[source] == component[target]:
            parts.setdefault(component[source], []).append(e)
    return [frozenset(part) for part in parts.values()]


def to_rabin(
    automaton: EmersonLei, aps: tuple[str, ...], letter_class: IntArray, budget: Budget, *, parity: bool = False
) -> RabinAutomaton:
    """The transition-based Rabin automaton of a (localized) Emerson-Lei automaton.

    Args:
        automaton: its letters are letter classes.
        aps: propositions of the result.
        letter_class: shape (2**len(aps),); entry = class of the letter.
        budget: on the states and the size of the tables.
        parity: take the second way wherever it can be: its marks form chains, which suits marks on states.

    Raises:
        StateLimitExceeded, TimeLimitExceeded: the budget ran out.
    """
    component = automaton.component
    memories: list[Memory] = [
        _best_memory(automaton, members, component, parity) for members in graph.component_members(component)
    ]
    n_pairs = max(1, *(memory.n_pairs for memory in memories))

    def move(q: int, memory: int, edge: Edge) -> tuple[int, int]:
        """The next memory, and the pairs whose Fin (high) and Inf (low) marks are seen."""
        here, there = component[q], component[edge.target]
        if here != there:
            return memories[there].start(edge.target), 0
        following, fins, infs = memories[here].move(memory, InnerEdge(q, edge.target, edge.marks))
        return following, fins << n_pairs | infs

    def successors(state: tuple[int, int]) -> Iterable[tuple[int, tuple[int, int], int]]:
        q, memory = state
        for edge in automaton.edges[q]:
            following, marks = move(q, memory, edge)
            yield edge.letters, (edge.target, following), marks

    if all(memory.is_constant for memory in memories):
        edges = [merged((e.letters, e.target, move(q, 0, e)[1]) for e in out) for q, out in enumerate(automaton.edges)]
    else:
        _, edges = explore((0, memories[component[0]].start(0)), successors, budget)
    return _as_arrays(edges, n_pairs, aps, letter_class, budget)


def _best_memory(automaton: EmersonLei, members: Sequence[int], component: Sequence[int], parity: bool) -> Memory:
    condition = automaton.acceptance[members[0]]
    counters = Counters(condition)
    if counters.is_constant and not (parity and len(condition) > 1):
        return counters
    inner = [
        InnerEdge(q, e.target, e.marks)
        for q in members
        for e in automaton.edges[q]
        if component[e.target] == component[q]
    ]
    try:
        decomposition = CycleDecomposition(condition, list(dict.fromkeys(inner)))
    except OverflowError:
        return counters
    return decomposition if parity or decomposition.size(members) <= counters.size(members) else counters


def _as_arrays(
    edges: Sequence[Sequence[Edge]], n_pairs: int, aps: tuple[str, ...], letter_class: IntArray, budget: Budget
) -> RabinAutomaton:
    """Dense tables over the coarsest letter classes that the edges respect."""
    distinct = list(dict.fromkeys(e.letters for out in edges for e in out))
    block_of, block_sets = grouped(distinct, int(letter_class.max()) + 1)
    n_blocks = int(block_of.max()) + 1
    budget.check_table(len(edges), n_blocks * max(1, n_pairs // _PAIRS_PER_ENTRY))
    columns = dict(zip(distinct, map(bits, block_sets), strict=True))
    targets = [[0] * n_blocks for _ in edges]
    seen = [[0] * n_blocks for _ in edges]
    for out, target_row, seen_row in zip(edges, targets, seen, strict=True):
        check_time()
        for letter_set, target, marks in out:
            for i in columns[letter_set]:
                target_row[i], seen_row[i] = target, marks
    table = np.array(seen, dtype=np.int64 if n_pairs <= 31 else object)
    fin, inf = np.empty((n_pairs, *table.shape), dtype=np.bool_), np.empty((n_pairs, *table.shape), dtype=np.bool_)
    for i in range(n_pairs):
        check_time()
        fin[i], inf[i] = table >> (n_pairs + i) & 1, table >> i & 1
    delta = np.array(targets, dtype=np.int32)
    return RabinAutomaton(aps, delta, block_of[letter_class], fin, inf, acceptance="transition")
