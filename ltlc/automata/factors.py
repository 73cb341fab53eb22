"""Sets of letters that are products of sets over few propositions each, and their guards.

Where a table comes from many small conditions, such as `G(a -> F b)` for many a and b, what leads from one state to
another is a condition for each of them. Its shortest form as found by `shortest_guard` is that of its factors: a prime
implicant of a conjunction of functions without common propositions is one of each, of a disjunction one of any.
"""

from __future__ import annotations

from itertools import combinations

from ltlc.arrays import np, npt
from ltlc.automata.guards import Guard, Term, conjunction, irredundant_cover
from ltlc.automata.wide import Array

_SAMPLES = 32
_MIXED = 0x9E3779B1
"""Multiples of it are spread evenly over all letters."""
_MAX_PROPOSITIONS = 10
_MAX_DIGITS = 8
"""of a factor; a larger one is taken apart into single propositions."""
_MAX_BITS = 62


class Factors:
    """Groups of propositions, each with the valuations that letter classes do not tell apart as one *digit*.

    Args:
        column: shape (2**n,), the class of each valuation of the relevant propositions.
        names: the numbers of these propositions in guards.
    """

    def __init__(self, column: npt.NDArray[np.int32], names: tuple[int, ...]) -> None:
        n = len(names)
        code = np.zeros((2,) * n, dtype=np.int64)
        self._factors: list[_Factor] = []
        n_bits = 0
        for group in _groups(column, n):
            digits = _digits(column, group)
            for part in [group] if len(group) == 1 or max(digits) < _MAX_DIGITS else [[i] for i in group]:
                factor = _Factor(tuple(names[i] for i in part), digits if part == group else [0, 1], n_bits)
                own = [2 if i in part else 1 for i in reversed(range(n))]
                code |= np.left_shift(1, n_bits + np.array(factor.digits)).reshape(own)
                n_bits += len(factor.sizes).bit_length() - 1
                self._factors.append(factor)
        self.is_useful = n_bits <= _MAX_BITS and len(self._factors) < n
        order = np.argsort(column, kind="stable")
        sizes = np.bincount(column)
        self._codes = np.bitwise_or.reduceat(code.reshape(-1)[order], np.cumsum(sizes) - sizes)
        self._sizes = sizes

    def products(self, classes: Array, begins: Array) -> tuple[Array, Array]:
        """Of groups of classes, the digits that occur, and whether they occur in all combinations.

        Args:
            classes: group behind group.
            begins: where groups begin.
        """
        codes = np.bitwise_or.reduceat(self._codes[classes], begins)
        sizes = np.ones(len(codes), dtype=np.int64)
        for factor in self._factors:
            sizes *= factor.sizes[codes >> factor.place & len(factor.sizes) - 1]
        return codes, sizes == np.add.reduceat(self._sizes[classes], begins)

    def guard(self, code: int) -> Guard:
        """The guard of all letters with these digits."""
        return conjunction([factor.covers(code) for factor in self._factors])


class _Factor:
    """Some propositions, and the digit of each of their valuations."""

    def __init__(self, names: tuple[int, ...], digits: list[int], place: int) -> None:
        self.names, self.digits, self.place = names, digits, place
        counts = np.bincount(digits)
        self.sizes = np.array(
            [counts[[i for i in range(len(counts)) if s >> i & 1]].sum() for s in range(1 << len(counts))]
        )
        self._known: dict[int, tuple[list[Term], list[Term]]] = {}

    def covers(self, code: int) -> tuple[list[Term], list[Term]]:
        """Terms for the valuations with some digits, and terms for the others."""
        chosen = code >> self.place & len(self.sizes) - 1
        if chosen not in self._known:
            n_aps = len(self.names)
            table = sum(1 << value for value, digit in enumerate(self.digits) if chosen >> digit & 1)
            tables = table, (1 << (1 << n_aps)) - 1 & ~table
            terms, others = (
                [tuple((self.names[i], sign) for i, sign in term) for term in irredundant_cover(t, n_aps)]
                for t in tables
            )
            self._known[chosen] = terms, others
        return self._known[chosen]


def _groups(column: npt.NDArray[np.int32], n: int) -> list[list[int]]:
    """Propositions of which two have valuations that are the same class in each of some letters, together."""
    letters = np.arange(_SAMPLES) * _MIXED & len(column) - 1
    letters[-1] = len(column) - 1
    group = list(range(n))
    for i, j in combinations(range(n), 2):
        others = letters & ~(1 << i | 1 << j)
        classes = [column[others | a << i | b << j] for a in (0, 1) for b in (0, 1)]
        if group[i] != group[j] and any((a == b).all() for a, b in combinations(classes, 2)):
            old, new = group[j], group[i]
            group = [new if g == old else g for g in group]
    found = [[i for i in range(n) if group[i] == g] for g in sorted(set(group))]
    return [part for g in found for part in ([g] if len(g) <= _MAX_PROPOSITIONS else [[i] for i in g])]


def _digits(column: npt.NDArray[np.int32], group: list[int]) -> list[int]:
    """The digit of each valuation of some propositions."""
    n = len(column).bit_length() - 1
    axes = [n - 1 - i for i in reversed(group)]
    rows = np.moveaxis(column.reshape((2,) * n), axes, range(len(axes))).reshape(1 << len(group), -1)
    known: dict[bytes, int] = {}
    return [known.setdefault(row.tobytes(), len(known)) for row in rows]
