"""Which letters are possible, and their numbers.

Where every set of propositions is possible, the number of a letter is its bitmask: bit i = proposition i. Where some
are declared impossible, the alphabet is a product of *parts*. A part has some of the propositions and lists the
combinations of them that are possible, as bitmasks: `(0, 1, 2)` is a part of two propositions of which at most one
holds. The number of a letter is then in mixed radix, the place of the combination of each part being a digit, and that
of the first part the lowest. A free proposition is a part of two combinations, so that alphabets without
declarations are numbered by their bitmasks in both ways.

Letters that are labels of somebody else's (of an MDP, of an environment) are bitmasks over their own propositions; a
table that is indexed by letter is indexed by their numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from math import prod
from typing import Any, NamedTuple

from ltlc.arrays import np, npt
from ltlc.errors import AlphabetLimitExceeded, ImpossibleLetterError, InvalidArgumentError, check_type

Possible = tuple[tuple[int, ...], ...]
"""The parts of an alphabet: for each, its possible combinations, ascending. A proposition in no part never holds."""

MAX_APS = 21
"""so many propositions fit into tables over letters where nothing is impossible."""
MAX_LETTERS = 1 << MAX_APS
_BITS = 62
"""Bitmasks of more propositions are Python's integers."""


class DeclaredLetters(NamedTuple):
    """The possible letters, as `possible_letters` takes them.

    Attributes:
        exclusive: groups of propositions of which at most one holds at a time.
        letters: all letters that are possible, or None.
    """

    exclusive: tuple[frozenset[str], ...] = ()
    letters: tuple[frozenset[str], ...] | None = None


class LetterNumbers:
    """The numbering of the possible letters over some propositions.

    Args:
        aps: the propositions.
        possible: the parts, or None where every letter is possible.

    Raises:
        AlphabetLimitExceeded: there are too many letters for tables.
        InvalidArgumentError: the parts are none.

    Example:
        >>> letters = LetterNumbers(("a", "b", "c"), ((0, 1, 2), (0, 4)))
        >>> letters.size, letters.number(0b101), letters.mask(4)
        (6, 4, 5)
    """

    def __init__(self, aps: tuple[str, ...], possible: Possible | None = None) -> None:
        self.aps = aps
        self.possible = possible
        if possible is None:
            if len(aps) > MAX_APS:
                raise AlphabetLimitExceeded(
                    f"{len(aps)} atomic propositions; tables over letters hold at most {MAX_APS}, unless it is "
                    "declared which of them exclude each other (exclusive)"
                )
            self.size = 1 << len(aps)
            return
        taken = 0
        for part in possible:
            support = _union(part)
            proper = part and list(part) == sorted(set(part)) and part[0] >= 0 and support < 1 << len(aps)
            if not proper or support & taken:
                raise InvalidArgumentError("the parts of an alphabet are no ascending combinations of own propositions")
            taken |= support
        self.size = prod(map(len, possible))
        check_size(self.size)

    @cached_property
    def _parts(self) -> list[tuple[int, dict[int, int]]]:
        """Of each part, its propositions, and the share of each combination in the number."""
        place, parts = 1, []
        for part in self.possible or ():
            parts.append((_union(part), {mask: place * digit for digit, mask in enumerate(part)}))
            place *= len(part)
        return parts

    def number(self, mask: int) -> int:
        """The number of a letter.

        Raises:
            ImpossibleLetterError: it was declared impossible.
        """
        if self.possible is None:
            return mask
        number = left = 0
        for support, share in self._parts:
            own = share.get(mask & support)
            if own is None:
                raise ImpossibleLetterError(self.names(mask & support), self.names(mask))
            number += own
            left |= support
        if mask & ~left:
            raise ImpossibleLetterError(self.names(mask & ~left), self.names(mask))
        return number

    def mask(self, number: int) -> int:
        """The letter of a number, as a bitmask."""
        if self.possible is None:
            return number
        mask = 0
        for part in self.possible:
            number, digit = divmod(number, len(part))
            mask |= part[digit]
        return mask

    def numbers(self, masks: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
        """`number` of many letters, in any shape.

        Raises:
            ImpossibleLetterError: see `number`.
        """
        if self.possible is None:
            return np.asarray(masks, dtype=np.int64)
        return _mapped(self.number, masks, np.dtype(np.int64))

    def masks(self, numbers: npt.NDArray[np.integer[Any]]) -> npt.NDArray[Any]:
        """`mask` of many numbers, as int64, or as Python's integers if there are more than 62 propositions."""
        if self.possible is None:
            return np.asarray(numbers, dtype=np.int64)
        return _mapped(self.mask, np.asarray(numbers), mask_type(len(self.aps)))

    def names(self, mask: int) -> frozenset[str]:
        """The propositions of a letter."""
        return names_in(self.aps, mask)

    def holding(self, index: int) -> int:
        """The letters in which proposition `index` holds, as a truth table: bit k = value at letter number k."""
        if index not in self._holding:
            self._holding[index] = self._table(index)
        return self._holding[index]

    @cached_property
    def _holding(self) -> dict[int, int]:
        return {}

    def _table(self, index: int) -> int:
        if self.possible is None:
            place = 1 << index
            return repeated((1 << place) - 1 << place, 2 * place, self.size)
        bit, block, n_block = 1 << index, 0, 0
        place = 1
        for part in self.possible:
            if bit & _union(part):
                ones = (1 << place) - 1
                block = sum(ones << place * digit for digit, mask in enumerate(part) if mask & bit)
                n_block = place * len(part)
                break
            place *= len(part)
        if not block:
            return 0
        return repeated(block, n_block, self.size)

    @property
    def all(self) -> int:
        """The truth table of every letter."""
        return (1 << self.size) - 1


def repeated(block: int, width: int, size: int) -> int:
    """The truth table of this size that repeats one of this width."""
    while width < size:
        block |= block << width
        width *= 2
    return block & (1 << size) - 1


def mask_type(n_aps: int) -> np.dtype[Any]:
    """What bitmasks over so many propositions are in arrays."""
    return np.dtype(np.int64 if n_aps <= _BITS else object)


def names_in(aps: Sequence[str], mask: int) -> frozenset[str]:
    """The propositions whose bit is set."""
    return frozenset(name for i, name in enumerate(aps) if mask >> i & 1)


def check_size(n_letters: int) -> None:
    """Raise AlphabetLimitExceeded if tables cannot have a column for each letter."""
    if n_letters > MAX_LETTERS:
        raise AlphabetLimitExceeded(
            f"more than {MAX_LETTERS} letters are possible, which are too many for tables; declare more propositions "
            "that exclude each other, or list the letters that occur"
        )


def possible_letters(
    aps: tuple[str, ...],
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> Possible | None:
    """The parts of the alphabet of a formula, from what is declared; None if that makes no letter impossible.

    Args:
        aps: the propositions of the formula; declarations may speak of others, too.
        exclusive: groups of propositions of which at most one holds; they may overlap.
        letters: all letters that are possible.

    Raises:
        InvalidArgumentError: these are no groups, or no letters, or both are given.
        AlphabetLimitExceeded: there are too many letters for tables.

    Example:
        >>> possible_letters(("a", "x", "b"), exclusive=[{"a", "b", "c"}])
        ((0, 1, 4), (0, 2))
        >>> possible_letters(("a", "b"), letters=[{"a"}, {"a", "b", "c"}])
        ((1, 3),)
    """
    groups = _name_sets(exclusive, "exclusive", "group of propositions")
    index = {name: i for i, name in enumerate(aps)}

    def mask(names: Iterable[str]) -> int:
        return sum(1 << index[name] for name in names if name in index)

    if letters is not None:
        if groups:
            raise InvalidArgumentError("give either exclusive or letters: letters lists all that are possible")
        known = sorted({mask(names) for names in _name_sets(letters, "letters", "letter")})
        if not known:
            raise InvalidArgumentError("letters is empty; at least one letter has to be possible")
        check_size(len(known))
        return None if len(known) == 1 << len(aps) else (tuple(known),)
    inside = [m for m in map(mask, groups) if m.bit_count() > 1]
    if not inside:
        return None
    parts: dict[int, list[int]] = {}
    for group in inside:
        joined = [group]
        for support in [s for s in parts if s & group]:
            joined += parts.pop(support)
        parts[_union(joined)] = joined
    free = [1 << i for i in range(len(aps)) if not any(support >> i & 1 for support in parts)]
    combined = [_combinations(support, own) for support, own in parts.items()]
    return tuple(sorted([*combined, *((0, bit) for bit in free)], key=lambda part: _union(part) & -_union(part)))


def _combinations(support: int, groups: list[int]) -> tuple[int, ...]:
    """The sets of propositions of which no two are in one group."""
    forbidden: dict[int, int] = {}
    for group in groups:
        for bit in _bits(group):
            forbidden[bit] = forbidden.get(bit, 0) | group & ~bit
    found = [(0, 0)]
    for bit in _bits(support):
        found += [(mask | bit, out | forbidden[bit]) for mask, out in found if not out & bit]
        check_size(len(found))
    return tuple(sorted(mask for mask, _ in found))


def _name_sets(sets: Iterable[Iterable[str]], name: str, what: str) -> list[frozenset[str]]:
    check_type(sets, Iterable, name, f"a list of sets of names, one for each {what}")
    found = []
    for names in sets if not isinstance(sets, str | Mapping) else [sets]:
        if isinstance(names, str | Mapping) or not isinstance(names, Iterable):
            raise InvalidArgumentError(f"{name} holds {names!r}; each {what} is a set of names, as in [{{'a', 'b'}}]")
        known = frozenset(names)
        for each in known:
            check_type(each, str, f"a name in {name}", "a text")
        found.append(known)
    return found


def _mapped(function: Any, values: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """A function of each distinct value."""
    values = np.asarray(values)
    distinct, where = np.unique(values, return_inverse=True)
    results = np.empty(len(distinct), dtype=dtype)
    results[:] = [function(int(value)) for value in distinct]
    mapped: npt.NDArray[Any] = results[where.reshape(values.shape)]
    return mapped


def _union(masks: Iterable[int]) -> int:
    union = 0
    for mask in masks:
        union |= mask
    return union


def _bits(mask: int) -> list[int]:
    return [1 << i for i in range(mask.bit_length()) if mask >> i & 1]
