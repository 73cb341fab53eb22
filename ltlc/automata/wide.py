"""Tables with many columns: the different entries of their rows, found without looking at the columns one by one.

A table over thousands of letter classes has few different entries in most rows. In a long row they are found value by
value, each by one comparison with the whole row, and all rows of a block are sorted at once where that is not so.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, Protocol, TypeAlias

from ltlc.arrays import np, npt
from ltlc.budget import check_time

Array: TypeAlias = "npt.NDArray[Any]"
_WIDE = 64
_LARGE = 1 << 12
"""A table with so many columns and entries is wide."""
LONG = 1 << 11
"""columns from which on a row is looked at value by value"""
FEW = 32
"""as long as there are no more values than this."""
_AT_ONCE = 1 << 18
"""entries that are looked at in one block of rows."""
_WORD = 1 << 62
_SHORT = 1 << 15
"""Numbers below are sorted by counting their digits."""


class Entries(NamedTuple):
    """The different entries of the rows of a wide table.

    Attributes:
        rows: for each state its different codes, as in `coded_rows`, in the order of their first columns.
        shift: number of bits of the marks.
    """

    rows: list[list[int]]
    shift: int

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.rows)

    def successors(self) -> list[list[int]]:
        """The different next states of each state, in the order of their first columns."""
        return [list(dict.fromkeys(code >> self.shift for code in row)) for row in self.rows]

    def marked(self, state_marks: list[int] | None) -> list[list[tuple[int, int]]]:
        """The different next states with marks, in increasing order; `state_marks` where states have them."""
        if state_marks is not None:
            return [[(target, state_marks[target]) for target in sorted(row)] for row in self.rows]
        all_marks = (1 << self.shift) - 1
        return [[(code >> self.shift, code & all_marks) for code in sorted(row)] for row in self.rows]


def entries(delta: Array, fin: Array, inf: Array) -> Entries | None:
    """The entries of a table that is wide, else None; the marks are those of states or of transitions."""
    n_pairs = len(fin) if fin.ndim == delta.ndim + 1 else 0
    if not is_wide(delta, n_pairs):
        return None
    blocks = coded_rows(delta, fin[:n_pairs], inf[:n_pairs])
    return Entries([values for codes in blocks for values in _distinct_values(codes)], 2 * n_pairs)


class HasEntries(Protocol):
    """What `Columns` looks at of a Rabin automaton."""

    @property
    def entries(self) -> Entries | None:
        """The different entries of a wide table."""

    @property
    def rows(self) -> list[list[int]]:
        """Next states."""

    @property
    def edge_marks(self) -> list[list[int]]:
        """Marks of the same entries."""

    @property
    def marks(self) -> Array:
        """Marks of states or transitions."""

    @property
    def delta(self) -> npt.NDArray[np.int32]:
        """Next states."""

    @property
    def fin(self) -> npt.NDArray[np.bool_]:
        """Fin marks of states or transitions."""

    @property
    def inf(self) -> npt.NDArray[np.bool_]:
        """Inf marks."""


class Columns:
    """The rows of an automaton, looked at entry by entry, where a table is wide at different entries only.

    `spread(q, [f(target, marks) for target, marks in of(q)])` is the row of f at every letter class.
    """

    def __init__(self, automaton: HasEntries) -> None:
        self.automaton, self.entries = automaton, automaton.entries
        self.on_states = self.entries is not None and automaton.fin.ndim == automaton.delta.ndim
        self.state_marks: list[int] = automaton.marks.tolist() if self.entries and self.on_states else []

    def of(self, state: int) -> Iterable[tuple[int, int]]:
        """The next states with marks as in `DRA.edge_marks`, in the order of their first letter classes."""
        if self.entries is None:
            return zip(self.automaton.rows[state], self.automaton.edge_marks[state], strict=True)
        codes, shift = self.entries.rows[state], self.entries.shift
        if self.on_states:
            return [(target, self.state_marks[target]) for target in codes]
        return [(code >> shift, code & (1 << shift) - 1) for code in codes]

    def spread(self, state: int, values: Sequence[int]) -> Sequence[int] | Array:
        """The row that has these values at the entries of a state."""
        if self.entries is None:
            return values
        part, n_pairs = slice(state, state + 1), self.entries.shift // 2
        tables = (self.automaton.fin[:n_pairs, part], self.automaton.inf[:n_pairs, part])
        codes = next(coded_rows(self.automaton.delta[part], *tables, self.entries.n_states))[0]
        return replaced(codes, self.entries.rows[state], np.array(values))


def rows_of_marks(automaton: HasEntries) -> list[list[int]] | Array:
    """`edge_marks`, where the table is wide as an array of integers as short as can be."""
    if automaton.entries is None:
        return automaton.edge_marks
    marks = joined_marks(automaton.fin, automaton.inf, np.min_scalar_type((1 << 2 * len(automaton.fin)) - 1))
    return marks[automaton.delta] if automaton.fin.ndim == automaton.delta.ndim else marks


def joined_marks(fin: Array, inf: Array, kind: np.dtype[Any]) -> Array:
    """Marks as in `DRA.marks`, shape as one pair of `fin`, of an integer type with room for them."""
    marks = np.zeros(fin.shape[1:], dtype=kind)
    for i, tables in enumerate(zip(fin, inf, strict=True)):
        for place, table in enumerate(tables, 2 * i):
            marks |= table.astype(kind) << kind.type(place)
    return marks


def replaced(row: Array, old: Sequence[int], new: Array) -> Array:
    """A row with other values in place of those that it has."""
    keys = np.array(old)
    if int(keys.max()) < _SHORT:
        table = np.empty(int(keys.max()) + 1, dtype=new.dtype)
        table[keys] = new
        return table[row]
    order = np.argsort(keys)
    return new[order][np.searchsorted(keys[order], row)]


def has_codes(n_states: int, n_pairs: int) -> bool:
    """Whether a next state together with marks is a number of 63 bits."""
    return 2 * n_pairs + n_states.bit_length() < 64


def is_wide(delta: Array, n_pairs: int) -> bool:
    """Whether looking at different entries is faster than looking at lists."""
    n_states, n_classes = map(int, delta.shape)
    return n_classes >= _WIDE and n_states * n_classes >= _LARGE and has_codes(n_states, n_pairs)


def coded_rows(delta: Array, fin: Array, inf: Array, n_states: int = 0) -> Iterator[Array]:
    """The rows of a table, in blocks: next states, and below them the marks of transitions, as in `DRA.marks`.

    Args:
        delta: shape (n_states, n_classes).
        fin: shape (n_pairs, n_states, n_classes); no pairs where marks are on states.
        inf: same shape.
        n_states: number of all states, if these are not all rows.
    """
    n_rows, n_classes = delta.shape
    shift, n_states = 2 * len(fin), n_states or n_rows
    kind: type[Any] = np.int32 if shift + n_states.bit_length() < 32 else np.int64
    at_once = max(1, _AT_ONCE // n_classes)
    for start in range(0, n_rows, at_once):
        check_time()
        part = slice(start, start + at_once)
        codes: Array = np.left_shift(delta[part], shift, dtype=kind) if shift else delta[part]
        for place in range(shift):
            marks = (inf if place % 2 else fin)[place // 2, part]
            if marks.any():
                codes |= marks.astype(kind) << place
        yield codes


class Groups(NamedTuple):
    """Equal entries of each row of a block; all but `columns` have the shape (n_groups,)."""

    rows: Array
    values: Array
    begins: Array
    """where the columns of the group begin in `columns`, ascending."""
    sizes: Array
    columns: Array
    """shape (n_rows * n_columns,); increasing in each group."""
    order: Array
    """the groups by row, then by their first columns."""


def grouped_columns(codes: Array) -> Groups:
    """Group the columns of each row by their values."""
    n_columns = codes.shape[1]
    keys = codes.astype(np.int16) if int(codes.max()) < _SHORT else codes
    columns = np.argsort(keys, axis=1, kind="stable")
    ordered = np.take_along_axis(keys, columns, axis=1)
    begin = np.ones(codes.shape, dtype=np.bool_)
    np.not_equal(ordered[:, 1:], ordered[:, :-1], out=begin[:, 1:])
    begins, flat = np.flatnonzero(begin), columns.reshape(-1)
    rows, sizes = begins // n_columns, np.diff(begins, append=codes.size)
    values = ordered.reshape(-1)[begins]
    return Groups(rows, values, begins, sizes, flat, np.argsort(rows * n_columns + flat[begins]))


def value_masks(row: Array, limit: int = FEW) -> Iterator[tuple[int, Array]]:
    """The different values of a row in the order of their first columns, and where each is, up to a limit of values.

    Whoever is given as many as the limit does not know whether there are more.
    """
    seen = np.zeros(len(row), dtype=np.bool_)
    place = 0
    for _ in range(limit):
        value = row[place]
        mask = row == value
        yield int(value), mask
        seen |= mask
        place = int(seen.argmin())
        if seen[place]:
            return


def _distinct_values(codes: Array) -> list[list[int]]:
    """The different values of each row of a block, in the order of their first columns."""
    if codes.shape[1] >= LONG:
        return [_values_of(row) for row in codes]
    groups = grouped_columns(codes)
    ends = np.cumsum(np.bincount(groups.rows, minlength=len(codes))).tolist()
    values = groups.values[groups.order].tolist()
    return [values[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]


def _values_of(row: Array) -> list[int]:
    values = [value for value, _ in value_masks(row)]
    return values if len(values) < FEW else _sorted_values(row)


def _sorted_values(row: Array) -> list[int]:
    """The different values of a row in the order of their first columns, where there are many."""
    groups = grouped_columns(row[None])
    values: list[int] = groups.values[groups.order].tolist()
    return values


def told_apart(columns: Iterable[Array], size: int) -> npt.NDArray[np.int32]:
    """A code for each position, shape (size,), equal where every column is: all of 0, 1, ..., m in some order.

    Columns are joined as digits of one number: as long as such numbers are few enough to be counted, or where they
    never are, as long as they fit, since they are sorted then.
    """
    key, n_keys = np.zeros(size, dtype=np.int64), 1
    limit = most = 4 * size
    for column in map(np.asarray, columns):
        check_time()
        if column.dtype.kind not in "bui" or int(column.min()) < 0 or int(column.max()) > most:
            column = _dense(column)
        n_values = int(column.max()) + 1
        if n_values == 1:
            continue
        if n_keys * n_values > limit:
            key = _dense(key).astype(np.int64)
            n_keys = int(key.max()) + 1
            if n_keys == size:
                break
            limit = most if n_keys * n_values <= most else _WORD
        key *= n_values
        np.add(key, column, out=key, casting="unsafe")
        n_keys *= n_values
    return _dense(key)


def _dense(column: Array) -> npt.NDArray[np.int32]:
    """The values of a column as codes 0..m in their order; without sorting where they are small."""
    if column.dtype.kind in "bui" and int(column.min()) >= 0 and int(column.max()) <= 4 * len(column):
        present = np.bincount(column) > 0
        codes: npt.NDArray[np.int32] = (np.cumsum(present, dtype=np.int32) - 1)[column.astype(np.int64)]
        return codes
    inverse: npt.NDArray[np.int32] = np.unique(column, return_inverse=True)[1].astype(np.int32)
    return inverse
