"""Formula to text, in seven syntaxes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.ltl.bounded_text import to_bounded
from ltlc.ltl.formula import Always, And, Formula, Iff, Implies, Not, Or, Release, StrongRelease, Until, WeakUntil, Xor
from ltlc.ltl.lbt import to_prefix
from ltlc.ltl.shape import NO_PAST
from ltlc.ltl.syntax import PLAIN_WITH_PAST, STYLES, Syntax, with_past, write
from ltlc.ltl.traversal import fold


def to_text(formula: Formula, syntax: Syntax = "plain") -> str:
    """The formula as text.

    >>> from ltlc.ltl import parse
    >>> to_text(parse("G(near_goal -> F a)"), "unicode")
    '□(near_goal → ◇a)'

    Args:
        formula: any formula.
        syntax: `plain` is what `parse` reads and `str` gives; `unicode` and `latex` (math mode) are for people; `spot`
            is read by Spot; `prism` by PRISM and Storm, which share only ! & | X U F G, so the rest is rewritten; `lbt`
            by LBT, ltl2dstar and Spot; `bounded` is plain with bounds where they make it shorter.

    Raises:
        InvalidArgumentError: a proposition that PRISM cannot have as a label, or an operator of the past for another
            tool.
        UnknownNameError: no such syntax.
    """
    if syntax == "lbt":
        return to_prefix(formula)
    if syntax == "bounded":
        return to_bounded(formula)
    if syntax not in STYLES:
        raise UnknownNameError("syntax", syntax, (*STYLES, "lbt", "bounded"))
    style = STYLES[syntax]
    if not formula.flags & NO_PAST:
        if syntax in ("spot", "prism"):
            tool = "Spot" if syntax == "spot" else "PRISM"
            raise InvalidArgumentError(f"{tool} reads no operators of the past: give it the automaton of {formula}")
        style = with_past(style) if syntax == "unicode" else PLAIN_WITH_PAST if syntax == "plain" else style
    return write(_core(formula) if syntax == "prism" else formula, style)


def _core(formula: Formula) -> Formula:
    """The formula with ! & | X U F G only."""

    def rewrite(node: Formula, args: list[Formula]) -> Formula:
        return _CORE[type(node)](*args) if type(node) in _CORE else node.with_args(tuple(args))

    return fold(formula, {}, rewrite)


_CORE: Mapping[type[Formula], Callable[[Formula, Formula], Formula]] = MappingProxyType(
    {
        Implies: lambda a, b: Or(Not(a), b),
        Iff: lambda a, b: Or(And(a, b), And(Not(a), Not(b))),
        Xor: lambda a, b: Or(And(a, Not(b)), And(Not(a), b)),
        Release: lambda a, b: Or(Until(b, And(a, b)), Always(b)),
        WeakUntil: lambda a, b: Or(Until(a, b), Always(a)),
        StrongRelease: lambda a, b: Until(b, And(a, b)),
    }
)
