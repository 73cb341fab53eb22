"""Letters, letter classes, and guards: sets of letters written as short Boolean formulas.

A letter is a number: a bitmask, bit i = proposition i, unless some letters are impossible (`ltlc.automata.possible`).
Letters on which all Boolean functions of interest agree form one letter class.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from ltlc.arrays import BoolArray, IntArray, Numbers, np, npt
from ltlc.automata.columns import first_positions, letters_over, project, support, truth_table
from ltlc.automata.guards import Guard, shortest_guard, shortest_guard_among
from ltlc.automata.possible import LetterNumbers, Possible, repeated
from ltlc.ltl.formula import Proposition

_MANY_CLASSES = 48
"""from which on arrays are faster than a loop."""


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
