"""Which states of an automaton have the most similar rows."""

from __future__ import annotations

from collections.abc import Iterator

from ltlc.arrays import IntArray, np
from ltlc.automata.partition import number_blocks, pairs_within
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time

_FIRST_COLUMNS = 32
"""of tables are compared before pairs of states are left out that are not similar."""
_FEW_PAIRS = 64
"""that are similar in their first columns tell how similar the most similar ones are."""
_MARKS_IN_WORD = 31
"""so many marks fit into a machine word beside a state."""


def most_similar(codes: IntArray, block: IntArray) -> Iterator[tuple[int, int]]:
    """Ordered pairs of different states of one block, those whose rows differ in the fewest columns first.

    Mostly few of them are asked for, so pairs that are not similar are put off. Of pairs that differ as much, those
    come first whose first state has the larger number, and then those whose second one has the smaller.

    Args:
        codes: shape (n_states, n_columns); what is compared.
        block: shape (n_states,); states with different entries are in no pair.
    """
    one, other = pairs_within(block)
    one, other = one[one < other], other[one < other]  # the others are mirrored
    n_columns = codes.shape[1]
    limit = n_columns
    if n_columns > _FIRST_COLUMNS and len(one) > _FEW_PAIRS:
        _, first = _similar(codes[:, :_FIRST_COLUMNS], one, other, n_columns)
        some = np.argpartition(first, _FEW_PAIRS)[:_FEW_PAIRS]
        limit = int(_similar(codes, one[some], other[some], n_columns)[1].min())
    while len(one):
        similar, differences = _similar(codes, one, other, limit)
        left = np.concatenate([one[similar], other[similar]])
        right = np.concatenate([other[similar], one[similar]])
        order = np.lexsort((right, -left, np.tile(differences, 2)))
        yield from zip(left[order].tolist(), right[order].tolist(), strict=True)
        one, other = np.delete(one, similar), np.delete(other, similar)
        limit = 2 * limit + 1


def _similar(codes: IntArray, one: IntArray, other: IntArray, limit: int) -> tuple[IntArray, IntArray]:
    """The places of the pairs whose rows differ in so many columns at most, and in how many."""
    places = np.arange(len(one), dtype=np.int32)
    differences = np.zeros(len(one), dtype=np.int32)
    for position, column in enumerate(codes.T, 1):
        differences += column[one] != column[other]
        if not position % _FIRST_COLUMNS:
            check_time()
            near = differences <= limit
            places, differences, one, other = places[near], differences[near], one[near], other[near]
    near = differences <= limit
    return places[near], differences[near]


def edge_codes(automaton: DRA) -> IntArray:
    """Shape (n_states, n_classes), of a small integer type; equal entries for the same next state and marks."""
    codes = automaton.delta.astype(np.int64)
    if automaton.acceptance == "transition":  # otherwise marks are those of the next state
        if 2 * automaton.n_pairs <= _MARKS_IN_WORD:
            codes = codes << 2 * automaton.n_pairs | automaton.marks
        else:
            kinds = number_blocks(mark for row in automaton.edge_marks for mark in row).reshape(codes.shape)
            codes = codes * (int(kinds.max()) + 1) + kinds
    small: IntArray = codes.astype(np.min_scalar_type(int(codes.max()) + 1))
    return small
