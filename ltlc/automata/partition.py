"""Partition refinement: which states of a deterministic table can be told apart."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence

from ltlc.arrays import IntArray, np
from ltlc.budget import check_time

_WIDE = 1 << 12
"""columns from which on rows are looked at one by one,"""
_SOME = 1 << 10
"""and at so many places first."""


def numbered(keys: Iterable[Hashable]) -> list[int]:
    """Equal keys get equal numbers, in order of first appearance."""
    seen: dict[Hashable, int] = {}
    return [seen.setdefault(key, len(seen)) for key in keys]


def number_blocks(keys: Iterable[Hashable]) -> IntArray:
    """`numbered` as an array."""
    return np.array(numbered(keys), dtype=np.int32)


def first_places(numbers: Iterable[int]) -> list[int]:
    """The place of the first of each of the numbers 0..m, all of which occur."""
    first: dict[int, int] = {}
    for place, number in enumerate(numbers):
        first.setdefault(number, place)
    return [first[number] for number in range(len(first))]


def refine(delta: IntArray, block: IntArray) -> IntArray:
    """The coarsest partition inside `block` whose blocks no sequence of letters tells apart.

    Args:
        delta: shape (n_states, n_classes); entry = next state.
        block: shape (n_states,); states with different entries are different.

    Returns:
        The block of each state, numbered by their first states; shape (n_states,), int32.

    References:
        E. F. Moore, Gedanken-experiments on sequential machines, Automata Studies 1956, doi 10.1515/9781400882618-006.
    """
    if delta.shape[1] >= _WIDE:  # what some columns tell apart need not be asked of all
        block = _refine_long_rows(np.ascontiguousarray(delta[:, :: delta.shape[1] // _SOME | 1]), block)
        return _refine_long_rows(delta, block)
    numbers = refine_by(block.tolist(), lambda block: map(np.ndarray.tobytes, np.array(block, dtype=np.int32)[delta]))
    return np.array(numbers, dtype=np.int32)


def _refine_long_rows(delta: IntArray, block: IntArray) -> IntArray:
    """`refine`, with one row in memory at a time, and none of a state that is told apart from all others already."""

    def signatures(numbers: list[int]) -> Iterable[bytes]:
        block = np.array(numbers, dtype=np.int32)
        short = block.astype(np.min_scalar_type(int(block.max())))
        alone = (np.bincount(block) == 1)[block].tolist()
        return (b"" if single else short[row].tobytes() for single, row in zip(alone, delta, strict=True))

    return np.array(refine_by(block.tolist(), signatures), dtype=np.int32)


def refine_rows(rows: Sequence[Sequence[int]], block: Iterable[Hashable]) -> list[int]:
    """`refine` with lists, for small tables."""
    return refine_by(block, lambda block: [tuple([block[target] for target in row]) for row in rows])


def refine_by(initial: Iterable[Hashable], signatures: Callable[[list[int]], Iterable[Hashable]]) -> list[int]:
    """The coarsest partition inside the initial one whose blocks have states of equal signatures only.

    Args:
        initial: equal keys for states of one block.
        signatures: of the states, given the block of each.

    Returns:
        The block of each state, numbered by their first states.
    """
    block = numbered(initial)
    while True:
        check_time()
        if max(block) + 1 == len(block):
            return block
        finer = numbered(zip(block, signatures(block), strict=True))
        if max(finer) == max(block):
            return finer
        block = finer


def pairs_within(block: IntArray, limit: int | None = None) -> tuple[IntArray, IntArray]:
    """All ordered pairs of different states of one block, small blocks first, whole blocks up to a limit of pairs."""
    sizes = np.bincount(block).astype(np.int64)
    by_size = np.argsort(sizes, kind="stable")
    pairs = np.cumsum((sizes * (sizes - 1))[by_size])
    chosen = by_size if limit is None else by_size[pairs <= limit]
    found = [np.zeros((2, 0), dtype=np.int32)]
    for b in chosen[sizes[chosen] > 1].tolist():
        members = np.flatnonzero(block == b).astype(np.int32)
        left, right = np.repeat(members, len(members)), np.tile(members, len(members))
        found.append(np.array([left[left != right], right[left != right]]))
    left, right = np.concatenate(found, axis=1)
    return left, right
