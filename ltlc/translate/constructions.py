"""The registry of constructions: each turns a formula into a deterministic Emerson-Lei automaton."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from ltlc.automata.emerson_lei import EmersonLei
from ltlc.budget import Budget
from ltlc.errors import InvalidArgumentError
from ltlc.registry import Registry
from ltlc.translate.closure import Closure
from ltlc.translate.decomposition import decompose, dual_safra, safra
from ltlc.translate.product import combine
from ltlc.translate.round_robin import by_turns

FormulaKind = Literal["fair", "recurrence", "persistence", "mixed", "high", "large"]
"""Obligations with fairness conditions, and single G F f or F G f; other Boolean combinations of recurrence, of
persistence, and of both; all others. Large are, besides, those whose first automaton has many states, but for the first
kind."""


@dataclass(frozen=True)
class Construction:
    """One way to a deterministic automaton.

    Attributes:
        name: by which `compile`, `translate` and the command line know it.
        description: one sentence: what it does, and for which formulas.
        citation: where it comes from.
        build: from a formula's closure; raises LimitExceeded, and InvalidArgumentError where it does not apply.
        portfolio: the kinds of formulas for which "auto" tries it, and its place among those tried; the first is the
            one that wins most often. Empty: it is used by name only.
    """

    name: str
    description: str
    citation: str
    build: Callable[[Closure, Budget], EmersonLei]
    portfolio: Mapping[FormulaKind, int] = field(default_factory=dict)


def _obligation(closure: Closure, budget: Budget) -> EmersonLei:
    if not closure.is_obligation(closure.root):
        raise InvalidArgumentError(
            "the formula is not a Boolean combination of safety and co-safety formulas; use another translator"
        )
    return _product(closure, budget)


def _product(closure: Closure, budget: Budget) -> EmersonLei:
    return _combined(closure, closure.root, budget)


def _normal_form(closure: Closure, budget: Budget) -> EmersonLei:
    from ltlc.translate.normal_form import normal_form

    return _combined(closure, normal_form(closure, closure.root), budget)


def _combined(closure: Closure, root: int, budget: Budget) -> EmersonLei:
    skeleton, components = by_turns(*decompose(closure, root, budget), budget)
    return combine(skeleton, components, closure.letters.all, budget)


def _safra(closure: Closure, budget: Budget) -> EmersonLei:
    return safra(closure, closure.root, budget)


def _dual_safra(closure: Closure, budget: Budget) -> EmersonLei:
    return dual_safra(closure, closure.root, budget)


_ALL = (
    Construction(
        "obligation",
        "Boolean combinations of safety and co-safety formulas only: formula progression, then the exact minimum.",
        "Loeding, IPL 79 (2001), doi 10.1016/S0020-0190(00)00183-6",
        _obligation,
    ),
    Construction(
        "product",
        "Any formula: deterministic automata for the parts of the outer Boolean combination (progression for safety and"
        " co-safety, breakpoints for recurrence and persistence, Safra trees above), with G F and F G parts suspended,"
        " and taking turns where they are only asked for together, then Rabin pairs from Emerson-Lei acceptance.",
        "Sickert and Esparza, LICS 2020, doi 10.1145/3373718.3394743; Mueller and Sickert, GandALF 2017, doi"
        " 10.4204/EPTCS.256.13; Casares et al., TACAS 2022, doi 10.1007/978-3-030-99527-0_6",
        _product,
        {"fair": 0, "recurrence": 0, "persistence": 0, "mixed": 0, "high": 3},
    ),
    Construction(
        "normal-form",
        "Any formula: first rewritten into a Boolean combination of recurrence and persistence formulas by guessing"
        " which fixpoints hold infinitely often or almost always, then as product.",
        "Sickert and Esparza, LICS 2020, doi 10.1145/3373718.3394743",
        _normal_form,
        {"high": 0, "large": 0},
    ),
    Construction(
        "safra",
        "Any formula: tableau to a generalized Buchi automaton, reduced by simulation, determinized by ordered Safra"
        " trees, apart for each strong component.",
        "Couvreur, FM 1999, doi 10.1007/3-540-48119-2_16; Safra, FOCS 1988, doi 10.1109/SFCS.1988.21948; Piterman,"
        " LMCS 3(3) 2007, doi 10.2168/LMCS-3(3:5)2007; Li et al., CAV 2022, doi"
        " 10.1007/978-3-031-13188-2_8",
        _safra,
        {"recurrence": 2, "persistence": 1, "mixed": 1, "high": 1},
    ),
    Construction(
        "dual-safra",
        "Any formula: tableau and Safra trees for its negation, then the complement.",
        "as safra; Schewe and Varghese, ATVA 2012, doi 10.1007/978-3-642-33386-6_5",
        _dual_safra,
        {"recurrence": 1, "persistence": 2, "mixed": 2, "high": 2},
    ),
)


def _check(name: str, part: Any) -> Construction:
    if not isinstance(part, Construction):
        raise InvalidArgumentError(f"translator {name!r}: {part!r} is no ltlc.translate.Construction")
    return part


CONSTRUCTIONS: Registry[Construction] = Registry("translator", "ltlc.constructions", _check)
"""every construction by name; `module:attribute` is a name, too."""


def register_construction(construction: Construction) -> Construction:
    """Make a construction known by its name.

    Installed packages offer theirs in the group of entry points "ltlc.constructions".

    Raises:
        InvalidArgumentError: it is none, or another one has its name.

    Example:
        >>> from ltlc.translate import TRANSLATORS
        >>> safra = TRANSLATORS["safra"]
        >>> mine = Construction("my-safra", "As safra.", "as safra", safra.build)
        >>> register_construction(mine) is TRANSLATORS["my-safra"]
        True
        >>> TRANSLATORS.remove("my-safra")
    """
    CONSTRUCTIONS.register(getattr(construction, "name", ""), construction)
    return construction


for _construction in _ALL:
    register_construction(_construction)


def in_portfolio(kind: FormulaKind) -> tuple[str, ...]:
    """The constructions that "auto" tries for a kind of formulas, in this order.

    They are among those that were registered: a formula has the same automaton whatever else is installed.
    """
    tried = [c for c in CONSTRUCTIONS.registered() if kind in c.portfolio]
    return tuple(c.name for c in sorted(tried, key=lambda c: c.portfolio[kind]))
