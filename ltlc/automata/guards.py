"""Guards: sets of letters as short Boolean formulas in two levels.

A set of letters is a truth table: an integer, bit k = value at letter k.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import accumulate, product
from math import prod
from typing import NamedTuple

from ltlc.budget import check_time

Term = tuple[tuple[int, bool], ...]
"""Literals: index of the proposition, and whether it is positive."""


class Guard(NamedTuple):
    """A Boolean formula in two levels, of literals (index of the proposition, whether it is positive).

    Attributes:
        disjunctive: True: an Or of And terms; False: an And of Or clauses.
    """

    disjunctive: bool
    terms: tuple[tuple[tuple[int, bool], ...], ...]

    @property
    def size(self) -> int:
        """Number of literals."""
        return sum(map(len, self.terms))

    def text(self, names: Sequence[str], true: str = "true", false: str = "false") -> str:
        """The guard with these names of the propositions, e.g. `a & !b | c`."""
        inner, outer = (" & ", " | ") if self.disjunctive else (" | ", " & ")
        if not self.terms or not self.terms[0]:
            return true if bool(self.terms) == self.disjunctive else false
        parts = [inner.join(("" if positive else "!") + names[i] for i, positive in term) for term in self.terms]
        if not self.disjunctive and len(parts) > 1:
            parts = [f"({part})" if len(term) > 1 else part for part, term in zip(parts, self.terms, strict=True)]
        return outer.join(parts)


def shortest_guard(table: int, n_aps: int) -> Guard:
    """A short two-level formula for a truth table over n_aps propositions (bit k = value at letter k).

    Both the function and its complement are covered; ties go to the sum of products.
    """
    full = (1 << (1 << n_aps)) - 1
    return _shorter(irredundant_cover(table, n_aps), irredundant_cover(full & ~table, n_aps))


def _shorter(terms: Sequence[Term], others: Sequence[Term]) -> Guard:
    """A function as the terms of a cover, or by those of its complement if they have fewer literals."""
    if sum(map(len, others)) < sum(map(len, terms)):
        return Guard(False, _sorted_terms(_negated(others)))
    return Guard(True, _sorted_terms(terms))


def _negated(terms: Iterable[Term]) -> list[Term]:
    """The clauses that are true where these terms are false."""
    return [tuple([(i, not sign) for i, sign in term]) for term in terms]


def conjunction(factors: Sequence[tuple[Sequence[Term], Sequence[Term]]]) -> Guard:
    """What `shortest_guard` gives for a conjunction of functions that have no proposition in common.

    Args:
        factors: of each function an irredundant cover, and one of its complement.
    """
    others = [term for _, terms in factors for term in terms]
    n_terms = prod(len(terms) for terms, _ in factors)
    size = sum(sum(map(len, terms)) * n_terms // len(terms) for terms, _ in factors if terms)
    if sum(map(len, others)) < size:
        return Guard(False, _sorted_terms(_negated(others)))
    joined = (sum(parts, ()) for parts in product(*(terms for terms, _ in factors)))
    return Guard(True, _sorted_terms([tuple(sorted(term)) for term in joined]))


def irredundant_cover(table: int, n_aps: int) -> list[tuple[tuple[int, bool], ...]]:
    """An irredundant sum of products of a truth table: terms of literals, propositions in increasing order.

    References:
        S. Minato, Fast generation of irredundant sum-of-products forms from binary decision diagrams, SASIMI 1992;
        E. Morreale, Recursive operators for prime implicant and irredundant normal form determination, IEEE Trans.
        Computers 1970, doi 10.1109/T-C.1970.222967. Here on integers as truth tables.
    """
    known: dict[tuple[int, int, int], tuple[int, list[tuple[tuple[int, bool], ...]]]] = {}

    def cover(lower: int, upper: int, n: int) -> tuple[int, list[tuple[tuple[int, bool], ...]]]:
        """Terms over n propositions of a function between lower and upper, and its table."""
        if not lower:
            return 0, []
        if upper == (1 << (1 << n)) - 1:
            return upper, [()]
        result = known.get((lower, upper, n))
        if result is not None:
            return result
        check_time()
        n -= 1
        half = 1 << n
        mask = (1 << half) - 1
        low0, low1, up0, up1 = lower & mask, lower >> half, upper & mask, upper >> half
        table0, terms0 = cover(low0 & ~up1, up0, n)
        table1, terms1 = cover(low1 & ~up0, up1, n)
        both, shared = cover((low0 & ~table0) | (low1 & ~table1), up0 & up1, n)
        terms = [(*t, (n, False)) for t in terms0] + [(*t, (n, True)) for t in terms1] + shared
        result = ((table0 | both) | ((table1 | both) << half), terms)
        known[(lower, upper, n + 1)] = result
        return result

    return cover(table, table, n_aps)[1]


def _sorted_terms(terms: Iterable[tuple[tuple[int, bool], ...]]) -> tuple[tuple[tuple[int, bool], ...], ...]:
    """Short terms first, then by proposition, positive literals first."""
    return tuple(sorted(terms, key=lambda term: (len(term), [2 * i + (not sign) for i, sign in term])))


def shortest_guard_among(table: int, literals: Sequence[tuple[int, int]], everything: int) -> Guard:
    """A short formula for a set of letters, where some letters are impossible and do not matter.

    Args:
        table: the set.
        literals: for each proposition, the letters without it and the letters with it.
        everything: the set of all possible letters.
    """
    return _shorter(prime_cover(table, literals, everything), prime_cover(everything & ~table, literals, everything))


def prime_cover(table: int, literals: Sequence[tuple[int, int]], everything: int) -> list[Term]:
    """An irredundant sum of prime terms that holds on exactly the letters of the table, among all possible ones.

    The smallest letter that no term covers yet is written as all its literals, of which those are left out, the
    negative ones first, that are not needed to stay inside the table.

    Args:
        table: truth table.
        literals: for each proposition, the letters without it and the letters with it.
        everything: the set of all possible letters.
    """
    found: list[tuple[int, Term]] = []
    left = table
    while left:
        check_time()
        letter = left & -left
        own = [(i, bool(with_it & letter)) for i, (_, with_it) in enumerate(literals)]
        own.sort(key=lambda literal: literal[1])
        sets = [literals[i][sign] for i, sign in own]
        rest = [*accumulate(reversed(sets), int.__and__, initial=everything)][-2::-1]  # of all literals that follow
        cube, kept = everything, []
        for literal, letters, following in zip(own, sets, rest, strict=True):
            if cube & following & ~table:
                cube &= letters
                kept.append(literal)
        found.append((cube, tuple(sorted(kept))))
        left &= ~cube
    for entry in reversed(found[:-1]):  # the last one covers a letter that no other does
        others = 0
        for other, _ in found:
            others |= other if other != entry[0] else 0
        if not entry[0] & ~others:
            found.remove(entry)
    return [term for _, term in found]
