"""Boolean functions of letters, as columns and as truth tables, and the letters that they tell apart.

A column is an array with an entry per letter; a truth table is an integer, bit k = value at letter k.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from ltlc.arrays import BoolArray, IntArray, Numbers, np, npt
from ltlc.automata.wide import told_apart
from ltlc.budget import check_time
from ltlc.graph import bits

_FEW_POSITIONS = 256
"""up to which plain integers and lists are faster than arrays."""

_FEW_TABLES = 64
"""are unpacked one by one."""

_MAX_BITS_AT_ONCE = 1 << 24
"""so many are unpacked to an octet each."""

_Scalar = TypeVar("_Scalar", bound="np.generic")


def truth_column(table: int, size: int) -> BoolArray:
    """The lowest bits of a truth table as a column, shape (size,), bool."""
    octets = np.frombuffer(table.to_bytes((size + 7) // 8, "little"), dtype=np.uint8)
    return np.unpackbits(octets, count=size, bitorder="little").astype(np.bool_)


def n_classes(classes: Numbers) -> int:
    """The number of the classes 0..m, all of which occur."""
    return 1 + (max(classes) if isinstance(classes, list) else int(classes.max()))


def grouped(tables: Sequence[int], size: int) -> tuple[Numbers, list[int]]:
    """Group the positions at which the same truth tables hold; groups are numbered by their first positions.

    Args:
        tables: truth tables (bit k = value at position k), at least one.
        size: number of positions.

    Returns:
        The group of each position, as a list where there are few; and each table over groups instead of positions.
    """
    if size > _FEW_POSITIONS:
        columns = [truth_column(table, size) for table in tables]
        group, first = letter_classes(columns, size)
        return group, [truth_table(column[first]) for column in columns]
    digits = [f"{table:0{size}b}"[::-1] for table in tables]
    number: dict[tuple[str, ...], int] = {}
    groups = [number.setdefault(values, len(number)) for values in zip(*digits, strict=True)]
    by_group = zip(*number, strict=True)  # the digits of each table again, one per group
    return groups, [int("".join(column)[::-1], 2) for column in by_group]


def grouped_partitions(partitions: Sequence[Sequence[int]], size: int) -> tuple[IntArray, list[IntArray]]:
    """Group the positions that no partition tells apart; groups are numbered by their first positions.

    Args:
        partitions: each a sequence of disjoint truth tables that together hold at every position; at least one.
        size: number of positions.

    Returns:
        The group of each position, shape (size,), int32; and for each partition, shape (n_groups,), int32: the place in
        it of the table that holds at the positions of the group.
    """
    if size > _FEW_POSITIONS:
        known: Iterable[npt.NDArray[np.integer[Any]]] = (_places(tables, size) for tables in partitions)
        if len(partitions) * size <= _MAX_BITS_AT_ONCE:
            known = list(known)
        group, first = letter_classes(known, size)
        known = known if isinstance(known, list) else (_places(tables, size) for tables in partitions)
        return group, [places[first].astype(np.int32) for places in known]
    distinct = list(dict.fromkeys(table for tables in partitions for table in tables))
    known_group, by_group = grouped(distinct, size)
    group = np.asarray(known_group, dtype=np.int32)
    groups = dict(zip(distinct, map(bits, by_group), strict=True))
    places = np.empty((len(partitions), int(group.max()) + 1), dtype=np.int32)
    for row, tables in zip(places, partitions, strict=True):
        check_time()
        for place, table in enumerate(tables):
            row[groups[table]] = place
    return group, list(places)


def _places(tables: Sequence[int], size: int) -> npt.NDArray[np.integer[Any]]:
    """The place of the table that holds at each position, shape (size,)."""
    if len(tables) <= _FEW_TABLES:
        few = np.zeros(size, dtype=np.uint8)
        for number, table in enumerate(tables[1:], 1):
            few |= truth_column(table, size).view(np.uint8) * np.uint8(number)
        return few
    places = np.zeros(size, dtype=np.int32)
    n_octets = (size + 7) // 8
    at_once = max(1, _MAX_BITS_AT_ONCE // size)
    for begin in range(1, len(tables), at_once):
        check_time()
        part = tables[begin : begin + at_once]
        octets = np.frombuffer(b"".join([table.to_bytes(n_octets, "little") for table in part]), dtype=np.uint8)
        holds = np.unpackbits(octets.reshape(-1, n_octets), axis=1, count=size, bitorder="little").view(np.bool_)
        place, position = np.divmod(np.flatnonzero(holds), size)
        places[position] = place + begin
    return places


def letter_classes(columns: Iterable[npt.NDArray[np.generic]], n_letters: int) -> tuple[IntArray, IntArray]:
    """The coarsest letter classes on which every column is constant, numbered by their first letter.

    Args:
        columns: arrays of shape (n_letters,), of bool or of any integers.
        n_letters: number of letters.

    Returns:
        `letter_class`, shape (n_letters,), and the first letter of each class, shape (n_classes,); both int32.
    """
    key = told_apart(columns, n_letters)
    first = first_positions(key)
    order = np.argsort(first)
    rank = np.empty_like(key, shape=len(order))
    rank[order] = np.arange(len(order))
    return rank[key], first[order]


def first_positions(codes: IntArray) -> IntArray:
    """The first position of each of the codes 0..m, all of which occur; shape (m + 1,), int32."""
    first = np.empty(int(codes.max()) + 1, dtype=np.int32)
    first[codes[::-1]] = np.arange(len(codes) - 1, -1, -1, dtype=np.int32)  # the last assignment stays
    return first


def support(column: npt.NDArray[np.generic]) -> tuple[int, ...]:
    """The propositions that a column depends on, as indices."""
    needed = []
    for i in reversed(range(len(column).bit_length() - 1)):
        step = 1 << i
        if (column[:step] == column[step : 2 * step]).all():  # else nothing else is to be seen
            halves = column.reshape(-1, 2, step)
            if (halves[:, 0] == halves[:, 1]).all():
                column = halves[:, 0].reshape(-1)
                continue
        needed.append(i)
    return tuple(needed[::-1])


def project(column: npt.NDArray[_Scalar], indices: Sequence[int]) -> npt.NDArray[_Scalar]:
    """The column over these propositions alone (bit j = `indices[j]`), the others being absent."""
    return column[letters_over(indices)]


def letters_over(indices: Sequence[int]) -> npt.NDArray[np.int64]:
    """The letters in which other propositions than these are absent, ordered as letters over these alone."""
    letters = np.zeros(1, dtype=np.int64)
    for i in indices:
        letters = np.concatenate([letters, letters | (1 << i)])
    return letters


def truth_table(column: BoolArray) -> int:
    """The column as an integer: bit k is the value at letter k."""
    return int.from_bytes(np.packbits(column, bitorder="little").tobytes(), "little")
