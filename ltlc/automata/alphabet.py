"""Letters, letter classes, and guards: sets of letters written as short Boolean formulas.

A letter is a number: a bitmask, bit i = proposition i, unless some letters are impossible (`ltlc.automata.possible`). A
Boolean function of letters is a column: a bool array with one entry per letter. Letters on which all functions of
interest agree form one letter class.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, TypeVar

from ltlc.arrays import BoolArray, IntArray, Numbers, np, npt
from ltlc.automata.guards import Guard, shortest_guard, shortest_guard_among
from ltlc.automata.possible import LetterNumbers, Possible, repeated
from ltlc.automata.wide import told_apart
from ltlc.budget import check_time
from ltlc.graph import bits
from ltlc.ltl.formula import Proposition

_MANY_CLASSES = 48
"""from which on arrays are faster than a loop."""
_FEW_POSITIONS = 256
"""up to which plain integers and lists are faster than arrays."""

_FEW_TABLES = 64
"""are unpacked one by one."""
_MAX_BITS_AT_ONCE = 1 << 24
"""so many are unpacked to an octet each."""

_Scalar = TypeVar("_Scalar", bound="np.generic")


class HasLetters(Protocol):
    """Anything with propositions and a table of letter classes: an `Alphabet` or an automaton."""

    @property
    def aps(self) -> tuple[str, ...]:
        """Names of the propositions, bit 0 first."""

    @property
    def letter_class(self) -> IntArray:
        """Shape (n_letters,), int32; entry = class of the letter."""


@dataclass(frozen=True, eq=False)
class Alphabet:
    """Propositions and the class of every letter.

    Attributes:
        aps: the propositions; bit i of a letter is the i-th.
        classes: the class of each letter; a list where there are few.
        possible: which letters are possible, see `ltlc.automata.possible`; None: all 2**len(aps).
    """

    aps: tuple[str, ...]
    classes: Numbers
    possible: Possible | None = None

    @cached_property
    def letter_class(self) -> IntArray:
        """Shape (n_letters,), int32; `classes` as an array."""
        return np.asarray(self.classes, dtype=np.int32)

    @cached_property
    def numbers(self) -> LetterNumbers:
        """The numbering of the letters."""
        return LetterNumbers(self.aps, self.possible)

    @cached_property
    def relevant(self) -> tuple[int, ...]:
        """The propositions that the class of a letter depends on, as indices into `aps`."""
        return support(self.letter_class)

    @cached_property
    def relevant_class(self) -> IntArray:
        """Shape (2**len(relevant),), int32; the class of each valuation of the relevant propositions."""
        return project(self.letter_class, self.relevant)

    @cached_property
    def first_letter(self) -> IntArray:
        """Shape (n_classes,), int32; the smallest letter of each class."""
        return first_positions(self.letter_class)

    @cached_property
    def by_first_letter(self) -> list[int]:
        """The classes, ordered by their smallest letters."""
        if isinstance(self.classes, list):
            return list(dict.fromkeys(self.classes))
        ordered: list[int] = np.argsort(self.first_letter, kind="stable").tolist()
        return ordered

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The propositions as LTL syntax reads them back, in double quotes if need be."""
        return tuple(map(quoted, self.aps))

    @cached_property
    def extents(self) -> IntArray:
        """Per class, what all of its valuations of the relevant propositions have, what some have, and their number.

        Shape (3, n_classes), int32.
        """
        order = np.argsort(self.relevant_class, kind="stable").astype(np.int32)
        sizes = np.bincount(self.relevant_class).astype(np.int32)
        starts = np.cumsum(sizes) - sizes
        return np.array([np.bitwise_and.reduceat(order, starts), np.bitwise_or.reduceat(order, starts), sizes])

    @cached_property
    def _extent(self) -> list[list[int]]:
        """`extents` as lists."""
        extent: list[list[int]] = self.extents.tolist()
        return extent

    def _literals(self, classes: Sequence[int]) -> tuple[tuple[int, bool], ...] | None:
        """The literals whose conjunction is true of exactly these classes, or None if it is no conjunction."""
        everywhere, somewhere, sizes = self._extent
        low, high, size = -1, 0, 0
        if len(classes) < _MANY_CLASSES:
            for c in classes:
                low &= everywhere[c]
                high |= somewhere[c]
                size += sizes[c]
        else:
            table = self.extents[:, classes]
            low, high, size = (
                int(f.reduce(row)) for f, row in zip((np.bitwise_and, np.bitwise_or, np.add), table, strict=True)
            )
        free = high & ~low
        if size != 1 << free.bit_count():
            return None
        return tuple((name, bool(low >> i & 1)) for i, name in enumerate(self.relevant) if not free >> i & 1)

    def guard(self, classes: Iterable[int]) -> Guard:
        """A short formula that is true of exactly the letters of these classes."""
        classes = tuple(classes)
        if self.possible is not None:
            return self._guard_among(classes)
        if isinstance(self.classes, list):
            table = sum([1 << letter for letter, c in enumerate(self.classes) if c in classes])
            return shortest_guard(table, len(self.aps))
        literals = self._literals(classes) if classes else None
        if literals is not None:
            return Guard(True, (literals,))
        chosen = np.zeros(int(self.relevant_class.max()) + 1, dtype=np.bool_)
        chosen[np.array(classes, dtype=np.int64)] = True
        return self.guard_of(chosen[self.relevant_class])

    def guard_of(self, column: BoolArray) -> Guard:
        """A short formula that is true of exactly these valuations of the relevant propositions.

        Args:
            column: shape (2**len(relevant),).
        """
        table = truth_table(column)
        without = enumerate(self._without)
        needed = tuple([i for i, letters in without if (table ^ table >> (1 << i)) & letters])
        if len(needed) < len(self.relevant):
            if needed not in self._projections:
                self._projections[needed] = letters_over(needed)
            table = truth_table(column[self._projections[needed]])
        shape = table, len(needed)
        guard = self._guards.get(shape)
        if guard is None:
            guard = self._guards[shape] = shortest_guard(*shape)
        names = [self.relevant[i] for i in needed]
        return Guard(guard.disjunctive, tuple(tuple((names[i], sign) for i, sign in term) for term in guard.terms))

    @cached_property
    def _guards(self) -> dict[tuple[int, int], Guard]:
        """Guards that were found, by truth table and number of propositions; many differ by names only."""
        return {}

    @cached_property
    def _without(self) -> list[int]:
        """For each relevant proposition, the valuations of these without it, as truth tables."""
        n_aps = len(self.relevant)
        return [repeated((1 << (1 << i)) - 1, 2 << i, 1 << n_aps) for i in range(n_aps)]

    @cached_property
    def _projections(self) -> dict[tuple[int, ...], npt.NDArray[np.int64]]:
        """`letters_over` of the sets of propositions that were asked for."""
        return {}

    @cached_property
    def _signed(self) -> list[tuple[int, int]]:
        """For each proposition, the letters without it and those with it, as truth tables."""
        return [(self.numbers.all & ~table, table) for table in map(self.numbers.holding, range(len(self.aps)))]

    def _guard_among(self, classes: tuple[int, ...]) -> Guard:
        """The guard where letters are impossible: what it says of these does not matter."""
        chosen = np.zeros(int(self.letter_class.max()) + 1, dtype=np.bool_)
        chosen[list(classes)] = True
        return shortest_guard_among(truth_table(chosen[self.letter_class]), self._signed, self.numbers.all)


def guard_text(source: HasLetters, classes: Iterable[int]) -> str:
    """The letters of some classes as a short Boolean formula in LTL syntax, names quoted where they need it.

    The formula is exact among the possible letters, irredundant, and a sum of products or a product of sums, whichever
    has fewer literals.

    >>> guard_text(Alphabet(("a", "b"), np.array([0, 0, 0, 1])), [0])
    '!a | !b'
    """
    alphabet = source if isinstance(source, Alphabet) else getattr(source, "alphabet", None)
    if not isinstance(alphabet, Alphabet):
        alphabet = Alphabet(source.aps, source.letter_class, getattr(source, "possible", None))
    return alphabet.guard(classes).text(alphabet.names)


def quoted(name: str) -> str:
    """The name of a proposition as LTL syntax reads it back, in double quotes if need be."""
    return str(Proposition(name))


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
