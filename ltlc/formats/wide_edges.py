"""The edges of automata with many letter classes, and their guards, found by arrays.

Most guards are conjunctions of literals. A set of letters is one iff it has 2**k letters, k being the number of
propositions on which they differ. Where there are about as many classes as letters, this is asked of the set as a table
over letters; elsewhere of what the letters of each class have in common, for all edges of many states at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ltlc.arrays import BoolArray, np
from ltlc.automata.alphabet import Alphabet
from ltlc.automata.factors import Factors
from ltlc.automata.wide import FEW, LONG, Array, Groups, coded_rows, grouped_columns, value_masks
from ltlc.budget import check_time

CodedEdge = tuple[int, int, int, str]
"""Source, target, marks as in `DRA.marks`, guard."""
_SPARSE = 4
"""So many letters for each class are still looked at as a table over letters."""
_MANY = 40
"""So many sets of letters that are no conjunctions of literals are worth looking for other factors."""
_TOGETHER = 4
"""propositions of which all conjunctions are kept."""
_AND = " & "


_Guarded = tuple[Array, Array, list[str]]
"""Of all edges of a block, the row, the next state and marks as one number (`coded_rows`), and the guard."""


class Names(NamedTuple):
    """What stands for propositions and constants in guards."""

    aps: Sequence[str]
    true: str = "true"
    false: str = "false"


def wide_edges(alphabet: Alphabet, delta: Array, fin: Array, inf: Array, names: Names) -> Iterator[CodedEdge]:
    """The edges ordered by source, then by the smallest letter.

    Args:
        alphabet: propositions and letter classes.
        delta: shape (n_states, n_classes).
        fin: marks of transitions, shape (n_pairs, n_states, n_classes); no pairs where marks are on states.
        inf: same shape.
        names: what guards consist of.
    """
    guards = _Guards(alphabet, names)
    source, shift = 0, 2 * len(fin)
    for codes in coded_rows(delta, fin, inf):
        rows, values, texts = guards.of_rows(codes) if guards.by_letter else guards.of_block(codes)
        numbers = (rows + source, values >> shift, values & (1 << shift) - 1)
        yield from zip(*(column.tolist() for column in numbers), texts, strict=True)
        source += len(codes)


class _Guards:
    """The guards of one automaton as texts, each set of letters that is no conjunction of literals written once."""

    def __init__(self, alphabet: Alphabet, names: Names) -> None:
        self.alphabet, self.names = alphabet, names
        self.order = _unless_identity(np.argsort(alphabet.first_letter, kind="stable"))
        self.known: dict[bytes, str] = {}
        self.known_tables: dict[bytes, str] = {}
        self.factors: Factors | None = None
        self.by_letter = False
        if alphabet.possible is None:
            n_letters = len(alphabet.relevant_class)
            self.by_letter = LONG <= n_letters <= _SPARSE * len(alphabet.first_letter)
            self.letters = _unless_identity(alphabet.relevant_class)
            self.cubes = _Cubes([names.aps[i] for i in alphabet.relevant], names.true)

    def of_rows(self, codes: Array) -> _Guarded:
        """The guard of each value of each row; found value by value in rows that have few."""
        rows, values, cubes, texts = [], [], [], []
        for place, row in enumerate(codes):
            found = list(value_masks(row if self.letters is None else row[self.letters]))
            if len(found) < FEW:
                own = np.array([value for value, _ in found])
                for _, table in found:
                    cubes.append(cube_of(table))
                    texts.append("" if cubes[-1] else self._of_table(table))
            else:
                _, own, more = self.of_block(row[None])
                cubes += [None] * len(more)
                texts += more
            rows.append(np.full(len(own), place))
            values.append(own)
        low, free = np.array([cube or (0, 0) for cube in cubes]).T
        texts = [text or cube for text, cube in zip(texts, self.cubes.texts(low, free), strict=True)]
        return np.concatenate(rows), np.concatenate(values), texts

    def of_block(self, codes: Array) -> _Guarded:
        """The guard of each value of each row."""
        groups = grouped_columns(codes if self.order is None else codes[:, self.order])
        classes = groups.columns if self.order is None else self.order[groups.columns]
        begins = groups.begins
        others = np.arange(len(begins))
        texts = [""] * len(begins)
        if self.alphabet.possible is None:
            everywhere, somewhere, sizes = self.alphabet.extents
            low = np.bitwise_and.reduceat(everywhere[classes], begins)
            free = np.bitwise_or.reduceat(somewhere[classes], begins) & ~low
            n_letters = np.add.reduceat(sizes[classes], begins)
            texts = self.cubes.texts(low, free)
            others = np.flatnonzero(n_letters != 1 << np.bitwise_count(free).astype(np.int32))
        self._write_others(classes, groups, others, texts)
        return groups.rows[groups.order], groups.values[groups.order], [texts[i] for i in groups.order.tolist()]

    def _write_others(self, classes: Array, groups: Groups, others: Array, texts: list[str]) -> None:
        """Write the guards of groups of classes that are no conjunctions of literals."""
        begins, sizes = groups.begins, groups.sizes
        keys = [(group, classes[begins[group] : begins[group] + sizes[group]].tobytes()) for group in others.tolist()]
        new = {key: group for group, key in keys if key not in self.known}
        if len(new) >= _MANY and self.factors is None and self.alphabet.possible is None:
            self.factors = Factors(self.alphabet.relevant_class, self.alphabet.relevant)
        factors = self.factors if self.factors is not None and self.factors.is_useful else None
        codes, is_product = factors.products(classes, begins) if factors and new else (begins, begins < 0)
        for key, group in new.items():
            check_time()
            if factors and is_product[group]:
                guard = factors.guard(int(codes[group]))
            else:
                guard = self.alphabet.guard(classes[begins[group] : begins[group] + sizes[group]].tolist())
            self.known[key] = guard.text(*self.names)
        for group, key in keys:
            texts[group] = self.known[key]

    def _of_table(self, table: BoolArray) -> str:
        """The guard of a table over the relevant propositions."""
        key = np.packbits(table).tobytes()
        if key not in self.known_tables:
            self.known_tables[key] = self.alphabet.guard_of(table).text(*self.names)
        return self.known_tables[key]


def cube_of(table: BoolArray) -> tuple[int, int] | None:
    """The first letter of a table that holds somewhere, and the propositions on which its letters differ.

    None if they do not do so in all ways.
    """
    first, last = int(table.argmax()), table.tobytes().rfind(1)
    free = first ^ last
    if first & ~last or np.count_nonzero(table) != 1 << free.bit_count():
        return None
    axes = range(len(table).bit_length() - 1)[::-1]
    inside = tuple([slice(None) if free >> i & 1 else first >> i & 1 for i in axes])
    return (first, free) if np.all(table.reshape((2,) * len(axes))[inside]) else None


class _Cubes:
    """Conjunctions of literals, put together from parts of a few propositions each."""

    def __init__(self, aps: Sequence[str], true: str) -> None:
        self.true = true
        self.parts = [_Part(aps[i : i + _TOGETHER]) for i in range(0, len(aps), _TOGETHER)]

    def texts(self, low: Array, free: Array) -> list[str]:
        """The conjunctions of all literals that hold in the letters `low` but for the propositions in `free`."""
        if not self.parts:
            return [self.true] * len(low)
        columns, mask = [], (1 << _TOGETHER) - 1
        for i, part in enumerate(self.parts):
            place = i * _TOGETHER
            keys = (low >> place & mask) << _TOGETHER | free >> place & mask
            columns.append(map(part.__getitem__, keys.tolist()))
        return [text[: -len(_AND)] or self.true for text in map("".join, zip(*columns, strict=True))]


class _Part(dict[int, str]):
    """The conjunctions over a few propositions, by letter and free propositions; behind each literal an operator."""

    def __init__(self, aps: Sequence[str]) -> None:
        super().__init__()
        self.literals = [(f"!{name}{_AND}", f"{name}{_AND}") for name in aps]

    def __missing__(self, key: int) -> str:
        low, free = key >> _TOGETHER, key
        bound = [literal[low >> i & 1] for i, literal in enumerate(self.literals) if not free >> i & 1]
        text = self[key] = "".join(bound)
        return text


def _unless_identity(numbers: Array) -> Array | None:
    """The numbers, or None if they are 0, 1, 2, ..."""
    return None if np.array_equal(numbers, np.arange(len(numbers))) else numbers
