"""Which states of a deterministic Rabin automaton have the same language."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from ltlc import graph
from ltlc.arrays import BoolArray, IntArray, np, npt
from ltlc.automata.acceptance import exactly_one, rabin_accepts
from ltlc.automata.emptiness import accepting_nodes
from ltlc.automata.partition import first_places, number_blocks, numbered, pairs_within, refine, refine_rows
from ltlc.automata.wide import Array, HasEntries, rows_of_marks
from ltlc.budget import check_time

MAX_PRODUCT_EDGES = 500_000
"""bound on the product in which states of the same language are looked for."""
_STEPS_AT_ONCE = 1 << 12
"""letter classes whose words are looked at together."""
_SMALL_AUTOMATON = 200
"""entries of the table up to which plain lists are faster than arrays."""


class HasTable(HasEntries, Protocol):
    """The part of a Rabin automaton that languages depend on."""

    @property
    def n_states(self) -> int:
        """Number of states."""

    @property
    def n_classes(self) -> int:
        """Number of letter classes."""

    @property
    def n_pairs(self) -> int:
        """Number of Rabin pairs."""

    @property
    def has_languages(self) -> bool:
        """Whether it is known which states accept the same words."""

    @property
    def alike(self) -> Sequence[int] | None:
        """Equal entries for states that are known to accept the same words, or None."""


def can_decide_languages(a: HasTable) -> bool:
    """Whether languages are known, or the automaton so small that `equivalent_states` keeps to `MAX_PRODUCT_EDGES`."""
    return a.has_languages or a.n_states**2 * a.n_classes <= MAX_PRODUCT_EDGES


def equivalent_states(a: HasTable, max_edges: int | None = None) -> IntArray:
    """`language_numbers` as an array, shape (n_states,), int32."""
    return np.array(language_numbers(a, max_edges), dtype=np.int32)


def language_numbers(a: HasTable, max_edges: int | None = None) -> list[int]:
    """Classes of states with the same language, numbered by their first states; one entry per state.

    Args:
        a: any Rabin automaton.
        max_edges: as for `languages_within`.
    """
    return languages_within(a, max_edges)[0]


def languages_within(a: HasTable, max_edges: int | None) -> tuple[list[int], bool]:
    """`language_numbers`, and whether all of them are known.

    Bisimilar states are merged first, and states that a short periodic word or a way to such a word tells apart are
    not looked at again. What remains is one product over all pairs of states, searched backwards from its cycles that
    exactly one side accepts.

    Args:
        a: any Rabin automaton.
        max_edges: product edges to look at; the largest groups of states that would need more count as different, so
            that states of one class still have the same language. None: decide all.
    """
    is_small = a.n_states * a.n_classes <= _SMALL_AUTOMATON
    if is_small and (max_edges is None or a.n_states**2 * a.n_classes <= max_edges):
        return _languages_of_few(a), True
    table = rows_of_marks(a)
    is_in_words = not isinstance(table, list) and table.dtype != object
    bisimilar = refine(a.delta, number_blocks(map(np.ndarray.tobytes if is_in_words else tuple, table)))
    first: list[int] = np.unique(bisimilar, return_index=True)[1].tolist()
    delta = bisimilar[a.delta[first]]
    marks = [table[q] for q in first]
    same = _known_to_be_alike(a, first)
    block = refine(delta, _periodic_verdicts(delta, marks, a.n_pairs))
    left, right = pairs_within(block, None if max_edges is None else max_edges // a.n_classes)
    is_exact = len(left) == sum(n * (n - 1) for n in np.bincount(block).tolist())
    alike = np.array(same, dtype=np.int32)
    unknown = alike[left] != alike[right]
    pairs = list(zip(left[unknown].tolist(), right[unknown].tolist(), strict=True))
    asked = sorted({q for pair in pairs for q in pair})
    rows = dict(zip(asked, delta[asked].tolist(), strict=True))
    seen = {q: row if isinstance(row := marks[q], list) else np.asarray(row).tolist() for q in asked}
    smallest = _smallest_alike(pairs, rows, seen, same, a.n_pairs)
    return numbered([smallest[b] for b in bisimilar.tolist()]), is_exact


def _languages_of_few(a: HasTable) -> list[int]:
    """`language_numbers` with lists, for small automata."""
    block = _told_apart_by_repetition(a)
    if max(block) + 1 == a.n_states:
        return list(range(a.n_states))
    bisimilar = refine_rows(a.rows, map(tuple, a.edge_marks))
    first = first_places(bisimilar)
    rows = dict(enumerate([bisimilar[target] for target in a.rows[q]] for q in first))
    seen = dict(enumerate(a.edge_marks[q] for q in first))
    same, blocks = _known_to_be_alike(a, first), [block[q] for q in first]
    pairs = [(p, q) for p in rows for q in rows if blocks[p] == blocks[q] and same[p] != same[q]]
    smallest = _smallest_alike(pairs, rows, seen, same, a.n_pairs)
    return numbered([smallest[b] for b in bisimilar])


def _known_to_be_alike(a: HasTable, states: Sequence[int]) -> list[int]:
    """Equal numbers for those of the states that are known to accept the same words."""
    return list(range(len(states))) if a.alike is None else numbered([a.alike[q] for q in states])


def _smallest_alike(
    pairs: Sequence[tuple[int, int]],
    rows: Mapping[int, Sequence[int]],
    marks: Mapping[int, Sequence[int]],
    same: Sequence[int],
    n_pairs: int,
) -> list[int]:
    """For each state, the smallest one that accepts the same words.

    Args:
        pairs: ordered pairs of states of which it is asked; other pairs accept different words, or are in `same`.
        rows: next states of those in some pair.
        marks: like `rows`.
        same: equal entries for states that are known to accept the same words.
        n_pairs: number of Rabin pairs.
    """
    node = {pair: i for i, pair in enumerate(pairs)}
    shift = 2 * n_pairs
    edges: list[list[tuple[int, int]]] = []
    told_apart: set[int] = set()
    for p, q in pairs:
        if not len(edges) & 255:
            check_time()
        steps = {
            (s, t, m | n << shift)
            for s, t, m, n in zip(rows[p], rows[q], marks[p], marks[q], strict=True)
            if same[s] != same[t]
        }
        if all((s, t) in node for s, t, _ in steps):
            edges.append(sorted((node[s, t], m) for s, t, m in steps))
        else:
            told_apart.add(len(edges))
            edges.append([])
    told_apart |= accepting_nodes(edges, exactly_one(n_pairs, n_pairs))
    different = set(graph.coreachable([[t for t, _ in row] for row in edges], sorted(told_apart)))
    first = first_places(same)
    smallest = [first[number] for number in same]
    for i, (p, q) in enumerate(pairs):
        if q < smallest[p] and i not in different:
            smallest[p] = q
    return smallest


def _told_apart_by_repetition(a: HasTable) -> list[int]:
    """A partition of the states by words that repeat one letter class in the end; with lists, for small automata."""
    block = [0] * a.n_states
    for c in range(a.n_classes if a.n_states > 1 else 0):
        verdicts = _repeated(c, a)
        block = numbered(zip(block, verdicts, strict=True))
        if max(block) + 1 == a.n_states:
            return block
    return refine_rows(a.rows, block)


def _repeated(c: int, a: HasTable) -> list[bool]:
    """From which states the word that repeats the letter class is accepted."""
    accepted: dict[int, bool] = {}
    for start in range(a.n_states):
        trail: list[int] = []
        state = start
        while state not in accepted and state not in trail:
            trail.append(state)
            state = a.rows[state][c]
        if state not in accepted:
            seen = 0
            for q in trail[trail.index(state) :]:
                seen |= a.edge_marks[q][c]
            accepted[state] = rabin_accepts(a.n_pairs, seen)
        accepted.update((q, accepted[state]) for q in trail)
    return [accepted[q] for q in range(a.n_states)]


def _periodic_verdicts(delta: IntArray, marks: Sequence[Sequence[int] | Array], n_pairs: int) -> IntArray:
    """A partition of the states by which words they accept that repeat one or two letter classes for ever."""
    n_states, n_classes = delta.shape
    blocks = np.zeros(n_states, dtype=np.int32)
    if not 1 <= n_pairs <= 31:
        return blocks
    target, seen = delta.T, np.array(marks, dtype=np.min_scalar_type((1 << 2 * n_pairs) - 1)).T
    for begin in range(0, n_classes, _STEPS_AT_ONCE):
        steps = slice(begin, begin + _STEPS_AT_ONCE)
        blocks = _refined_by(blocks, _accepted_for_ever(target[steps], seen[steps], n_pairs))
        if int(blocks.max()) == n_states - 1:
            return blocks
    rows = np.arange(n_classes)[:, None]
    for step in range(1, min(n_classes, 8) if n_states * n_classes < 100_000 else 1):
        other = (rows + step) % n_classes
        verdicts = _accepted_for_ever(target[other, target], seen | seen[other, target], n_pairs)
        blocks = _refined_by(blocks, verdicts)
    return blocks


def _refined_by(blocks: IntArray, verdicts: BoolArray) -> IntArray:
    """The partition of the states whose blocks are not told apart by verdicts, shape (n_words, n_states)."""
    columns = np.ascontiguousarray(verdicts.T)
    return number_blocks(zip(blocks.tolist(), map(np.ndarray.tobytes, columns), strict=True))


def _accepted_for_ever(target: IntArray, seen: npt.NDArray[Any], n_pairs: int) -> BoolArray:
    """Whether repeating each of some steps is accepted from each state; all arrays have shape (n_steps, n_states)."""
    n_steps, n_states = target.shape
    places = (target + np.arange(n_steps)[:, None] * n_states).reshape(-1)
    marks = seen.reshape(-1)
    for _ in range(n_states.bit_length()):  # afterwards one step stands for at least n_states ones
        check_time()
        places, marks = places[places], marks | marks[places]
    on_cycle = marks[places].reshape(n_steps, n_states)
    pair_bits = on_cycle.dtype.type(sum(1 << 2 * i for i in range(n_pairs)))
    accepted: BoolArray = ((on_cycle >> 1) & ~on_cycle & pair_bits) != 0
    return accepted
