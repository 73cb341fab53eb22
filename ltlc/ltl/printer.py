"""Formula to text, in five syntaxes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from ltlc.errors import UnknownNameError
from ltlc.ltl.formula import Always, And, Formula, Iff, Implies, Not, Or, Release, StrongRelease, Until, WeakUntil, Xor
from ltlc.ltl.syntax import STYLES, Syntax, write
from ltlc.ltl.traversal import fold


def to_text(formula: Formula, syntax: Syntax = "plain") -> str:
    """The formula as text.

    >>> from ltlc.ltl import parse
    >>> to_text(parse("G(near_goal -> F a)"), "unicode")
    '□(near_goal → ◇a)'

    Args:
        formula: any formula.
        syntax: `plain` is what `parse` reads and `str` gives; `unicode` and `latex` (math mode) are for people; `spot`
            is read by Spot; `prism` by PRISM and Storm, which share only ! & | X U F G, so the rest is rewritten.

    Raises:
        InvalidArgumentError: a proposition that PRISM cannot have as a label.
        UnknownNameError: no such syntax.
    """
    if syntax not in STYLES:
        raise UnknownNameError("syntax", syntax, STYLES)
    return write(_core(formula) if syntax == "prism" else formula, STYLES[syntax])


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
