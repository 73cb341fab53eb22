"""Pure eventuality and pure universality: truth that survives a longer past, or every step into the future."""

from __future__ import annotations

from typing import NamedTuple

from ltlc.ltl.formula import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    fold,
)
from ltlc.ltl.normal import nnf


class Purity(NamedTuple):
    """What the shape of a formula says about shifted words; both at once is *suspendable*, as GF a and FG a are.

    References:
        Kousha Etessami and Gerard Holzmann, Optimizing Buchi automata, CONCUR 2000, doi:10.1007/3-540-44618-4_13.
        Suspendability: Tomas Babiak, Thomas Badie, Alexandre Duret-Lutz, Mojmir Kretinsky and Jan Strejcek,
        Compositional approach to suspension and other improvements to LTL translation, SPIN 2013,
        doi:10.1007/978-3-642-39176-7_6.
    """

    eventual: bool
    """If a suffix of a word satisfies it, so does the word."""
    universal: bool
    """If a word satisfies it, so does every suffix."""

    @property
    def suspendable(self) -> bool:
        """Whether its truth depends on no finite prefix."""
        return self.eventual and self.universal


def purity(formula: Formula, done: dict[Formula, Purity]) -> Purity:
    """The purity of a formula in negation normal form; `done` as in `fold`."""
    return fold(formula, done, _purity)


def is_pure_eventuality(formula: Formula) -> bool:
    """Whether the shape of the formula shows that a word satisfies it as soon as one of its suffixes does.

    >>> from ltlc.ltl import parse
    >>> is_pure_eventuality(parse("a U F b")), is_pure_eventuality(parse("a U b"))
    (True, False)
    """
    return purity(nnf(formula), {}).eventual


def is_pure_universality(formula: Formula) -> bool:
    """Whether the shape of the formula shows that every suffix of a word that satisfies it does so too."""
    return purity(nnf(formula), {}).universal


def _purity(node: Formula, args: list[Purity]) -> Purity:
    operator = type(node)
    if operator is Constant:
        return Purity(True, True)
    if not args:
        return Purity(False, False)
    last = args[-1]
    every = Purity(all(arg.eventual for arg in args), all(arg.universal for arg in args))
    if operator in (And, Or, Next):
        return every
    if operator is Eventually:
        return Purity(True, last.universal)
    if operator is Always:
        return Purity(last.eventual, True)
    if operator in (Until, Release):
        return last
    if operator is WeakUntil:
        return Purity(every.eventual, last.universal)
    if operator is StrongRelease:
        return Purity(last.eventual, every.universal)
    return Purity(False, False)
