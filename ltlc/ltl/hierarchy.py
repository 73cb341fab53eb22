"""Where a formula stands in the temporal hierarchy, and whether it is pure, as far as its shape shows.

A pure eventuality survives a longer past, a pure universality every step into the future; both at once is
*suspendable*, as GF a and FG a are: then no finite prefix matters. Purity is among the `flags` of a formula in negation
normal form.

References:
    Kousha Etessami and Gerard Holzmann, Optimizing Buchi automata, CONCUR 2000, doi:10.1007/3-540-44618-4_13.
    Suspendability: Tomas Babiak, Thomas Badie, Alexandre Duret-Lutz, Mojmir Kretinsky and Jan Strejcek, Compositional
    approach to suspension and other improvements to LTL translation, SPIN 2013, doi:10.1007/978-3-642-39176-7_6.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from ltlc.ltl.formula import Always, Eventually, Formula, Not, Release, StrongRelease, Until, WeakUntil
from ltlc.ltl.normal import nnf
from ltlc.ltl.past import PAST
from ltlc.ltl.shape import EVENTUAL, UNIVERSAL
from ltlc.ltl.traversal import fold


class HierarchyClass(Enum):
    """The classes of the temporal hierarchy, and what automaton is enough for a formula of each."""

    SAFETY = "safety"
    """a violation shows after finitely many letters"""
    CO_SAFETY = "co-safety"
    """satisfaction shows after finitely many letters; also called guarantee"""
    OBLIGATION = "obligation"
    """a Boolean combination of safety and co-safety: a weak deterministic automaton"""
    RECURRENCE = "recurrence"
    """a deterministic Buchi automaton"""
    PERSISTENCE = "persistence"
    """a deterministic co-Buchi automaton"""
    REACTIVITY = "reactivity"
    """anything: a deterministic Rabin automaton"""


class _Classes(NamedTuple):
    """All classes that the shape of a formula shows it to be in."""

    safety: bool
    co_safety: bool
    recurrence: bool
    persistence: bool

    @property
    def obligation(self) -> bool:
        """Recurrence and persistence at once; Boolean combinations of safety and co-safety are both."""
        return self.recurrence and self.persistence


def classify(formula: Formula) -> HierarchyClass:
    """The smallest class that the shape of the formula shows; simplifying first may show a smaller one.

    Formulas that are both safety and co-safety, such as X a, count as safety.

    >>> from ltlc.ltl import parse
    >>> [classify(parse(text)).value for text in ("G(a -> X b)", "a U b", "G(a -> F b)", "F G a | G F b")]
    ['safety', 'co-safety', 'recurrence', 'reactivity']

    References:
        Zohar Manna and Amir Pnueli, A hierarchy of temporal properties, PODC 1990, doi:10.1145/93385.93442.
        Ivana Cerna and Radek Pelanek, Relating hierarchy of temporal properties to model checking, MFCS 2003,
        doi:10.1007/978-3-540-45138-9_26.
    """
    classes = fold(nnf(formula), {}, _classes)
    if classes.safety:
        return HierarchyClass.SAFETY
    if classes.co_safety:
        return HierarchyClass.CO_SAFETY
    if classes.obligation:
        return HierarchyClass.OBLIGATION
    if classes.recurrence:
        return HierarchyClass.RECURRENCE
    return HierarchyClass.PERSISTENCE if classes.persistence else HierarchyClass.REACTIVITY


def _classes(node: Formula, args: list[_Classes]) -> _Classes:
    if not args or isinstance(node, (Not, *PAST)):  # what the past says is as certain as a letter
        return _Classes(safety=True, co_safety=True, recurrence=True, persistence=True)
    safety, co_safety, recurrence, persistence = (all(flags) for flags in zip(*args, strict=True))
    # A prefix can refute G W R and prove F U M. Across the two: a U b = (a W b) & F b is a recurrence formula if b is
    # co-safety, and a W b = (a U b) | G a is a persistence formula if a is safety.
    if isinstance(node, Always | WeakUntil | Release):
        lasting = args[-1] if isinstance(node, Release) else args[0]
        return _Classes(safety, False, recurrence, persistence and lasting.safety)
    if isinstance(node, Eventually | Until | StrongRelease):
        awaited = args[0] if isinstance(node, StrongRelease) else args[-1]
        return _Classes(False, co_safety, recurrence and awaited.co_safety, persistence)
    return _Classes(safety, co_safety, recurrence, persistence)


def is_pure_eventuality(formula: Formula) -> bool:
    """Whether the shape of the formula shows that a word satisfies it as soon as one of its suffixes does.

    >>> from ltlc.ltl import parse
    >>> is_pure_eventuality(parse("a U F b")), is_pure_eventuality(parse("a U b"))
    (True, False)
    """
    return bool(nnf(formula).flags & EVENTUAL)


def is_pure_universality(formula: Formula) -> bool:
    """Whether the shape of the formula shows that every suffix of a word that satisfies it does so too."""
    return bool(nnf(formula).flags & UNIVERSAL)
