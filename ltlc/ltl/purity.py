"""Pure eventuality and pure universality: truth that survives a longer past, or every step into the future.

The shape of a formula in negation normal form shows them; they are among its `facts`. Both at once is *suspendable*, as
GF a and FG a are: then no finite prefix matters.

References:
    Kousha Etessami and Gerard Holzmann, Optimizing Buchi automata, CONCUR 2000, doi:10.1007/3-540-44618-4_13.
    Suspendability: Tomas Babiak, Thomas Badie, Alexandre Duret-Lutz, Mojmir Kretinsky and Jan Strejcek, Compositional
    approach to suspension and other improvements to LTL translation, SPIN 2013, doi:10.1007/978-3-642-39176-7_6.
"""

from __future__ import annotations

from ltlc.ltl.formula import EVENTUAL, UNIVERSAL, Formula
from ltlc.ltl.normal import nnf


def is_pure_eventuality(formula: Formula) -> bool:
    """Whether the shape of the formula shows that a word satisfies it as soon as one of its suffixes does.

    >>> from ltlc.ltl import parse
    >>> is_pure_eventuality(parse("a U F b")), is_pure_eventuality(parse("a U b"))
    (True, False)
    """
    return bool(nnf(formula).facts & EVENTUAL)


def is_pure_universality(formula: Formula) -> bool:
    """Whether the shape of the formula shows that every suffix of a word that satisfies it does so too."""
    return bool(nnf(formula).facts & UNIVERSAL)
