"""From Emerson-Lei acceptance to Rabin pairs, one strong component at a time.

Two ways are tried in each component and the one with fewer states is kept:

* **counters**: each clause Fin(B) & Inf(G1) & ... & Inf(Gk) becomes a pair; clauses with the same list of Inf sets
  share a counter that waits for them in turn. One copy of the component if no clause has two Inf sets.
* **alternating cycle decomposition**: the optimal parity condition for the given graph, and a parity condition is a
  Rabin condition.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import Literal, Protocol

from ltlc import graph
from ltlc.arrays import BoolArray, IntArray, Numbers, np
from ltlc.automata.acceptance import Acceptance
from ltlc.automata.columns import grouped, grouped_partitions, n_classes
from ltlc.automata.cycles import CycleDecomposition
from ltlc.automata.emerson_lei import EmersonLei, LetterEdge, explore, merged
from ltlc.automata.emptiness import MarkedEdge
from ltlc.automata.possible import Possible
from ltlc.automata.rabin import DRA
from ltlc.automata.tables import FEW_ENTRIES, MARKS_IN_WORD
from ltlc.budget import Budget, check_time
from ltlc.graph import bits

_MAX_CYCLE_NODES = 2000
_MAX_CYCLE_WORK = 1 << 24
"""Edges looked at for one decomposition: some seconds."""
_ENTRIES_AT_ONCE = 1 << 21
"""of tables, beside which nothing larger than them is in memory."""
_PAIRS_PER_ENTRY = 16
"""The marks of so many pairs take the memory of one entry in the table of next states, as lists and as arrays."""


Way = Literal["smaller", "counters", "cycles"]


class Memory(Protocol):
    """What a strong component remembers to express its condition by Rabin pairs."""

    n_pairs: int
    is_constant: bool
    """whether the memory is always 0."""

    def size(self, states: Iterable[int]) -> int:
        """Upper bound of the number of copies of the states, in all."""

    def first_alike(self, edge: MarkedEdge) -> int:
        """The marks of one of the edges with which all moves are the same."""

    def start(self, state: int) -> int:
        """The memory on entering the component in a state."""

    def move(self, memory: int, edge: MarkedEdge) -> tuple[int, int]:
        """The next memory, and the marks of the pairs that are seen, as in `DRA.marks`."""


class Counters:
    """See the module docstring.

    Args:
        condition: of the component.
        ahead: whether a counter that has met all of its marks goes on with what the same edge has for the next round.
    """

    def __init__(self, condition: Acceptance, *, ahead: bool = True) -> None:
        self._ahead = ahead
        self._condition = condition
        self.n_pairs = len(condition)
        lists = {clause.inf for clause in condition if clause.inf.bit_count() > 1}
        self._waits = {inf: bits(inf) for inf in sorted(lists)}
        self.is_constant = not lists
        self._moves: dict[tuple[int, int], tuple[int, int]] = {}

    def size(self, states: Iterable[int]) -> int:
        """See `Memory`."""
        return len(list(states)) * reduce(int.__mul__, map(len, self._waits.values()), 1)

    def first_alike(self, edge: MarkedEdge) -> int:
        """See `Memory`."""
        return edge[2]

    def start(self, state: int) -> int:
        """See `Memory`."""
        return 0

    def move(self, memory: int, edge: MarkedEdge) -> tuple[int, int]:
        """See `Memory`; the memory is the counters' values in mixed radix."""
        key = memory, edge[2]
        known = self._moves.get(key)
        if known is None:
            known = self._moves[key] = self._moved(*key)
        return known

    def _moved(self, memory: int, marks: int) -> tuple[int, int]:
        following, radix = 0, 1
        met: dict[int, bool] = {}
        for inf, waits in self._waits.items():
            memory, level = divmod(memory, len(waits))
            level, met[inf] = _advance(level, waits, marks, self._ahead)
            following += radix * level
            radix *= len(waits)
        seen = 0
        for i, (fin, inf, _) in enumerate(self._condition):
            if fin & marks:
                seen |= 1 << 2 * i
            if met[inf] if inf in met else not inf & ~marks:
                seen |= 2 << 2 * i
        return following, seen


def _advance(level: int, waits: Sequence[int], marks: int, ahead: bool) -> tuple[int, bool]:
    while level < len(waits) and marks >> waits[level] & 1:
        level += 1
    if level < len(waits):
        return level, False
    level = 0
    while ahead and level < len(waits) - 1 and marks >> waits[level] & 1:
        level += 1
    return level, True


class CycleMemory:
    """The alternating cycle decomposition of the component; the memory is a leaf of the tree of a state."""

    def __init__(self, cycles: CycleDecomposition) -> None:
        self._cycles = cycles
        self._accepting = [d for d in range(cycles.depth + 1) if cycles.root_accepts == (d % 2 == 0)]
        self.n_pairs = len(self._accepting)
        self.is_constant = cycles.depth == 0
        self._marks = [
            sum((1 if d > depth else 2) << 2 * i for i, d in enumerate(self._accepting) if d >= depth)
            for depth in range(cycles.depth + 1)
        ]

    def size(self, states: Iterable[int]) -> int:
        """See `Memory`."""
        return self._cycles.n_leaves(states)

    def first_alike(self, edge: MarkedEdge) -> int:
        """See `Memory`."""
        return self._cycles.first_alike(edge)

    def start(self, state: int) -> int:
        """See `Memory`."""
        return self._cycles.leaf(state)

    def move(self, memory: int, edge: MarkedEdge) -> tuple[int, int]:
        """See `Memory`."""
        leaf, depth = self._cycles.step(memory, edge)
        return leaf, self._marks[depth]


def to_rabin(
    automaton: EmersonLei,
    aps: tuple[str, ...],
    letter_class: Numbers,
    budget: Budget,
    *,
    initial_state: int = 0,
    on_states: bool = False,
    way: Way = "smaller",
    least_pairs: int = 1,
    possible: Possible | None = None,
) -> DRA:
    """The Rabin automaton of an Emerson-Lei automaton, `localized` before unless each clause has one Inf mark at most.

    States keep their numbers if no component needs a memory; otherwise they are numbered breadth-first.

    Args:
        automaton: its letters are letter classes.
        aps: propositions of the result.
        letter_class: the class of each letter.
        budget: on the states and the size of the tables.
        initial_state: of the automaton.
        on_states: whether the edges of each state have the same marks, and those of the result are to be on states,
            which counters alone can do.
        way: which of the two each component that needs a memory takes; the marks of "cycles", which is then taken
            wherever it applies, form chains, which suits marks on states.
        least_pairs: the result has at least as many pairs.
        possible: which letters are possible.

    Raises:
        StateLimitExceeded, TimeLimitExceeded: the budget ran out.
    """
    component = automaton.component
    memories: list[Memory] = [
        Counters(automaton.acceptance[members[0]], ahead=False)
        if on_states
        else _best_memory(automaton, members, component, way)
        for members in graph.component_members(component)
    ]
    n_pairs = max(least_pairs, *(memory.n_pairs for memory in memories))

    def move(q: int, memory: int, edge: LetterEdge) -> tuple[int, int]:
        """The next memory, and the marks that are seen."""
        here, there = component[q], component[edge.target]
        if here != there:
            return memories[there].start(edge.target), 0
        return memories[here].move(memory, (q, edge.target, edge.marks))

    def fewer(q: int) -> list[LetterEdge]:
        """The edges of a state, those one edge that do the same with every memory."""
        memory = memories[component[q]]
        edges = automaton.edges[q]
        moves = ((e, component[e.target] == component[q]) for e in edges)
        return merged((e.letters, e.target, memory.first_alike((q, e.target, e.marks)) if i else 0) for e, i in moves)

    is_constant = all(memory.is_constant for memory in memories)
    edges_of = automaton.edges if is_constant else list(map(fewer, range(automaton.n_states)))

    def successors(state: tuple[int, int]) -> Iterable[tuple[int, tuple[int, int], int]]:
        q, memory = state
        for edge in edges_of[q]:
            following, marks = move(q, memory, edge)
            yield edge.letters, (edge.target, following), 0 if on_states else marks

    def marks_of(q: int, memory: int) -> int:
        """Those of a copy of a state."""
        seen = reduce(int.__or__, (edge.marks for edge in automaton.edges[q]))
        return move(q, memory, LetterEdge(0, q, seen))[1]

    if is_constant:
        copies = [(q, 0) for q in range(automaton.n_states)]
        edges = [merged([(letters, q, marks) for letters, (q, _), marks in successors(copy)]) for copy in copies]
    else:
        start = memories[component[initial_state]].start(initial_state)
        (copies, edges), initial_state = explore((initial_state, start), successors, budget), 0
    state_marks = [marks_of(q, memory) for q, memory in copies] if on_states else None
    acceptance: Literal["state", "transition"] = "state" if on_states else "transition"
    n_before = n_classes(letter_class)
    if len(edges) * n_before <= FEW_ENTRIES and n_pairs <= MARKS_IN_WORD:
        block, rows, marks = _as_lists(edges, n_before)
        classes = (
            [block[c] for c in letter_class]
            if isinstance(letter_class, list)
            else np.array(block, dtype=np.int32)[letter_class]
        )
        result = DRA.from_lists(
            aps,
            rows,
            marks if state_marks is None else state_marks,
            classes,
            n_pairs,
            initial_state=initial_state,
            acceptance=acceptance,
            possible=possible,
        )
    else:
        block_of, delta, fin, inf = _as_arrays(edges, state_marks, n_pairs, n_before, budget)
        class_of = block_of[np.asarray(letter_class)]
        result = DRA(aps, delta, class_of, fin, inf, initial_state, acceptance, possible=possible)
    return _with_known_languages(result, automaton.alike, [q for q, _ in copies])


def _with_known_languages(result: DRA, alike: Sequence[int], origin: Sequence[int]) -> DRA:
    """The automaton with what is known of states that accept the same words, from those that its states come from."""
    known = len(set(alike))
    if known == len(alike):
        return result
    entries = [alike[q] for q in origin]
    return result.annotated(alike=entries, languages=entries if known == 1 else None)


def _best_memory(automaton: EmersonLei, members: Sequence[int], component: Sequence[int], way: Way) -> Memory:
    condition = automaton.acceptance[members[0]]
    counters = Counters(condition)
    if way == "counters" or (counters.is_constant and not (way == "cycles" and len(condition) > 1)):
        return counters
    inner = [(q, e.target, e.marks) for q in members for e in automaton.edges[q] if component[e.target] == component[q]]
    try:
        cycles = CycleDecomposition(condition, list(dict.fromkeys(inner)), _MAX_CYCLE_NODES, _MAX_CYCLE_WORK)
        decomposition = CycleMemory(cycles)
    except OverflowError:
        return counters
    return decomposition if way == "cycles" or decomposition.size(members) <= counters.size(members) else counters


def _as_arrays(
    edges: Sequence[Sequence[LetterEdge]],
    state_marks: Sequence[int] | None,
    n_pairs: int,
    n_before: int,
    budget: Budget,
) -> tuple[IntArray, IntArray, BoolArray, BoolArray]:
    """Dense tables over the coarsest letter classes that the edges respect; marks are those of edges if not of states.

    Returns:
        The new class of each old one, next states, Fin and Inf marks; as in `DRA`.
    """
    partitions: dict[tuple[int, ...], int] = {}
    kinds_of = [partitions.setdefault(tuple([e.letters for e in out]), len(partitions)) for out in edges]
    block_of, places = grouped_partitions(list(partitions), n_before)
    budget.check_table(len(edges), len(places[0]) * max(1, n_pairs // _PAIRS_PER_ENTRY))
    first = np.cumsum([0, *map(len, edges[:-1])], dtype=np.int32)
    target = np.array([edge.target for out in edges for edge in out], dtype=np.int32)
    marks = [edge.marks for out in edges for edge in out] if state_marks is None else state_marks
    kinds: dict[int, int] = {}
    kind = np.array([kinds.setdefault(mark, len(kinds)) for mark in marks], dtype=np.int32)
    table = (len(edges), len(places[0]))
    delta = np.empty(table, dtype=np.int32)
    shape = (n_pairs, *(table if state_marks is None else table[:1]))
    fin, inf = np.empty(shape, dtype=np.bool_), np.empty(shape, dtype=np.bool_)
    signs = [np.array([mark >> i & 1 for mark in kinds], dtype=np.bool_)[kind] for i in range(2 * n_pairs)]
    at_once = max(1, _ENTRIES_AT_ONCE // table[1])
    for begin in range(0, len(edges), at_once):
        check_time()
        rows = slice(begin, begin + at_once)
        taken = np.array([places[number] for number in kinds_of[rows]], dtype=np.int32) + first[rows, None]
        delta[rows] = target[taken]
        for i in range(n_pairs):
            fin[i, rows] = signs[2 * i][taken if state_marks is None else rows]
            inf[i, rows] = signs[2 * i + 1][taken if state_marks is None else rows]
    return block_of, delta, fin, inf


def _as_lists(
    edges: Sequence[Sequence[LetterEdge]], n_before: int
) -> tuple[list[int], list[list[int]], list[list[int]]]:
    """`_as_arrays` with lists, which are faster where tables have few entries.

    Returns:
        The new class of each old one, next states, and marks as in `DRA.edge_marks`.
    """
    distinct = list(dict.fromkeys([edge.letters for out in edges for edge in out]))
    block_of, by_group = grouped(distinct, n_before)
    groups = dict(zip(distinct, map(bits, by_group), strict=True))
    n_groups = n_classes(block_of)
    rows, marks = [[0] * n_groups for _ in edges], [[0] * n_groups for _ in edges]
    for out, row, seen in zip(edges, rows, marks, strict=True):
        for letters, target, mark in out:
            for group in groups[letters]:
                row[group], seen[group] = target, mark
    return block_of if isinstance(block_of, list) else block_of.tolist(), rows, marks
