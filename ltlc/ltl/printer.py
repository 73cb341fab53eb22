"""Formula to text, in five syntaxes, with as few brackets as the precedences allow."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.ltl.formula import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
    fold,
)

Syntax = Literal["plain", "unicode", "latex", "spot", "prism"]


@dataclass(frozen=True)
class _Style:
    """How one syntax writes constants, names and operators.

    Attributes:
        binding: operator -> (its own strength, the least strength of a left and of a right operand without brackets).
    """

    constants: tuple[str, str]
    name: Callable[[str], str]
    prefix: Mapping[type[Formula], str]
    infix: Mapping[type[Formula], str]
    binding: Mapping[type[Formula], tuple[int, int, int]]


_ATOM = (9, 9, 9)
_BINDING: Mapping[type[Formula], tuple[int, int, int]] = MappingProxyType(
    dict.fromkeys((Not, Next, Eventually, Always), (6, 6, 6))
    | dict.fromkeys((Until, Release, WeakUntil, StrongRelease), (5, 6, 5))
    | {And: (4, 5, 5), Xor: (3, 3, 4), Or: (2, 3, 3)}
    | dict.fromkeys((Implies, Iff), (1, 2, 1))
)
# PRISM lets temporal operators bind loosest and Storm differs, so brackets leave neither a choice.
_PRISM_BINDING: Mapping[type[Formula], tuple[int, int, int]] = MappingProxyType(
    dict.fromkeys((Next, Eventually, Always), (6, 6, 6))
    | {Not: (7, 7, 7), And: (4, 7, 7), Or: (2, 7, 7), Until: (1, 7, 7)}
)
_PREFIX: dict[type[Formula], str] = {Not: "!", Next: "X ", Eventually: "F ", Always: "G "}
_INFIX: dict[type[Formula], str] = {
    And: " & ",
    Or: " | ",
    Xor: " xor ",
    Implies: " -> ",
    Iff: " <-> ",
    Until: " U ",
    Release: " R ",
    WeakUntil: " W ",
    StrongRelease: " M ",
}

# Names that the parser reads as one proposition wherever they stand; the second kind is also safe in Spot.
_RESERVED = r"(?!(?:t|f|[URWMV]|(?i:true|false)|and|or|xor|not|AND|OR|XOR|NOT)\Z)(?![XFG](?!\d))"
_BARE = re.compile(_RESERVED + r"[^\W\d][\w.]*")
_BARE_IN_SPOT = re.compile(_RESERVED + r"[A-Za-z_][A-Za-z0-9_.]*")
_BARE_IN_PRISM = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_LATEX_SPECIAL = re.compile(r"[\\{}$&#^_%~ ]")
_LATEX_ESCAPES = {"\\": r"\backslash{}", "^": r"\hat{}", "~": r"\sim{}"}


def _quote(name: str) -> str:
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _plain_name(name: str) -> str:
    return name if _BARE.fullmatch(name) else _quote(name)


def _spot_name(name: str) -> str:
    return name if _BARE_IN_SPOT.fullmatch(name) else _quote(name)


def _latex_name(name: str) -> str:
    escaped = _LATEX_SPECIAL.sub(lambda match: _LATEX_ESCAPES.get(match[0], "\\" + match[0]), name)
    return escaped if len(name) == 1 else f"\\mathrm{{{escaped}}}"


def _prism_name(name: str) -> str:
    if not _BARE_IN_PRISM.fullmatch(name):
        raise InvalidArgumentError(
            f"PRISM has no label {name!r}: a label is letters, digits and _. Rename the proposition."
        )
    return f'"{name}"'


_STYLES: Mapping[str, _Style] = MappingProxyType(
    {
        "plain": _Style(("false", "true"), _plain_name, _PREFIX, _INFIX, _BINDING),
        "unicode": _Style(
            ("⊥", "⊤"),
            _plain_name,
            _PREFIX | {Not: "¬", Next: "○", Eventually: "◇", Always: "□"},
            _INFIX | {And: " ∧ ", Or: " ∨ ", Xor: " ⊕ ", Implies: " → ", Iff: " ↔ "},
            _BINDING,
        ),
        "latex": _Style(
            (r"\bot", r"\top"),
            _latex_name,
            _PREFIX | {Not: r"\neg ", Next: r"\mathsf{X}\,", Eventually: r"\mathsf{F}\,", Always: r"\mathsf{G}\,"},
            {
                And: r" \wedge ",
                Or: r" \vee ",
                Xor: r" \oplus ",
                Implies: r" \rightarrow ",
                Iff: r" \leftrightarrow ",
                Until: r" \;\mathsf{U}\; ",
                Release: r" \;\mathsf{R}\; ",
                WeakUntil: r" \;\mathsf{W}\; ",
                StrongRelease: r" \;\mathsf{M}\; ",
            },
            _BINDING,
        ),
        "spot": _Style(("0", "1"), _spot_name, _PREFIX, _INFIX, _BINDING),
        "prism": _Style(("false", "true"), _prism_name, _PREFIX, _INFIX, _PRISM_BINDING),
    }
)


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
    if syntax not in _STYLES:
        raise UnknownNameError("syntax", syntax, _STYLES)
    return _write(_core(formula) if syntax == "prism" else formula, _STYLES[syntax])


def _write(formula: Formula, style: _Style) -> str:
    pieces: list[str] = []
    # Text to write and (formula, least strength without brackets) still to expand, the next one last.
    pending: list[str | tuple[Formula, int]] = [(formula, 0)]
    while pending:
        item = pending.pop()
        if isinstance(item, str):
            pieces.append(item)
            continue
        node, least = item
        if isinstance(node, Proposition):
            pieces.append(style.name(node.name))
            continue
        if isinstance(node, Constant):
            pieces.append(style.constants[node.value])
            continue
        operator = type(node)
        strength, left, right = style.binding[operator]
        if strength < least:
            pieces.append("(")
            pending.append(")")
        if operator in style.prefix:
            bracketed = style.binding.get(type(node.args[0]), _ATOM)[0] < right
            pieces.append(style.prefix[operator].rstrip(" ") if bracketed else style.prefix[operator])
            pending.append((node.args[0], right))
        else:
            for operand in node.args[:0:-1]:
                pending += (operand, right), style.infix[operator]
            pending.append((node.args[0], left))
    return "".join(pieces)


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
