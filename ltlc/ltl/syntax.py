"""The syntaxes in which formulas are written, and how a node becomes text in one, with as few brackets as possible.

Operators are known by their symbols, so that formulas can print themselves: `Node` is all this file knows of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Protocol, Self

from ltlc.budget import check_time
from ltlc.errors import InvalidArgumentError
from ltlc.ltl.dialects import PAST_WORDS, RESERVED


class Node(Protocol):
    """A formula, as far as its text is concerned."""

    @property
    def symbol(self) -> str:
        """The operator; "proposition" and "constant" for the leaves, which have a `name` and a `value`."""
        ...

    @property
    def args(self) -> tuple[Self, ...]:
        """The operands, left to right."""
        ...


Syntax = Literal["plain", "unicode", "latex", "spot", "prism", "lbt", "bounded"]


class Style(NamedTuple):
    """How one syntax writes constants, names and operators.

    Attributes:
        binding: operator -> (its own strength, the least strength of a left and of a right operand without brackets).
    """

    constants: tuple[str, str]
    name: Callable[[str], str]
    prefix: Mapping[str, str]
    infix: Mapping[str, str]
    binding: Mapping[str, tuple[int, int, int]]


_WORDS = ("X", "F", "G", "Y", "Z", "O", "H", "WX")
_ATOM = (9, 9, 9)
_BINDING: Mapping[str, tuple[int, int, int]] = MappingProxyType(
    dict.fromkeys(("!", *_WORDS), (6, 6, 6))
    | dict.fromkeys(("U", "R", "W", "M", "S", "T"), (5, 6, 5))
    | {"&": (4, 5, 5), "xor": (3, 3, 4), "|": (2, 3, 3)}
    | dict.fromkeys(("->", "<->"), (1, 2, 1))
)
# PRISM lets temporal operators bind loosest and Storm differs, so brackets leave neither a choice.
_PRISM_BINDING: Mapping[str, tuple[int, int, int]] = MappingProxyType(
    dict.fromkeys(("X", "F", "G"), (6, 6, 6)) | {"!": (7, 7, 7), "&": (4, 7, 7), "|": (2, 7, 7), "U": (1, 7, 7)}
)
_PREFIX: dict[str, str] = {"!": "!", **{sign: f"{sign} " for sign in _WORDS}}
_INFIX: dict[str, str] = {
    "&": " & ",
    "|": " | ",
    "xor": " xor ",
    "->": " -> ",
    "<->": " <-> ",
    "U": " U ",
    "R": " R ",
    "W": " W ",
    "M": " M ",
    "S": " S ",
    "T": " T ",
}

# Names that the parser reads as one proposition wherever they stand, without a warning. The second kind is also safe in
# Spot.
_OPERATORS = "[URWM]|(?i:true|false)|tt|ff|and|or|xor|not|AND|OR|XOR|NOT"
_RESERVED = rf"(?!(?:{_OPERATORS}|{'|'.join(RESERVED)})\Z)(?![XFG](?!\d))"
_BARE = re.compile(_RESERVED + r"[^\W\d][\w.]*")
_BARE_IN_SPOT = re.compile(_RESERVED + r"[A-Za-z_][A-Za-z0-9_.]*")
_BARE_IN_PRISM = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_LATEX_SPECIAL = re.compile(r"[\\{}$&#^_%~ ]")
_LATEX_ESCAPES = {"\\": r"\backslash{}", "^": r"\hat{}", "~": r"\sim{}"}


def quote(name: str) -> str:
    """The name in double quotes."""
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _plain_name(name: str) -> str:
    return name if _BARE.fullmatch(name) else quote(name)


def _spot_name(name: str) -> str:
    return name if _BARE_IN_SPOT.fullmatch(name) else quote(name)


def _latex_name(name: str) -> str:
    escaped = _LATEX_SPECIAL.sub(lambda match: _LATEX_ESCAPES.get(match[0], "\\" + match[0]), name)
    return escaped if len(name) == 1 else f"\\mathrm{{{escaped}}}"


def _prism_name(name: str) -> str:
    if not _BARE_IN_PRISM.fullmatch(name):
        raise InvalidArgumentError(
            f"PRISM has no label {name!r}: a label is letters, digits and _. Rename the proposition."
        )
    return f'"{name}"'


STYLES: Mapping[str, Style] = MappingProxyType(
    {
        "plain": Style(("false", "true"), _plain_name, _PREFIX, _INFIX, _BINDING),
        "unicode": Style(
            ("⊥", "⊤"),
            _plain_name,
            _PREFIX | {"!": "¬", "X": "○", "F": "◇", "G": "□"},
            _INFIX | {"&": " ∧ ", "|": " ∨ ", "xor": " ⊕ ", "->": " → ", "<->": " ↔ "},
            _BINDING,
        ),
        "latex": Style(
            (r"\bot", r"\top"),
            _latex_name,
            {"!": r"\neg ", **{sign: rf"\mathsf{{{sign}}}\," for sign in _WORDS}},
            {
                "&": r" \wedge ",
                "|": r" \vee ",
                "xor": r" \oplus ",
                "->": r" \rightarrow ",
                "<->": r" \leftrightarrow ",
                "U": r" \;\mathsf{U}\; ",
                "R": r" \;\mathsf{R}\; ",
                "W": r" \;\mathsf{W}\; ",
                "M": r" \;\mathsf{M}\; ",
                "S": r" \;\mathsf{S}\; ",
                "T": r" \;\mathsf{T}\; ",
            },
            _BINDING,
        ),
        "spot": Style(("0", "1"), _spot_name, _PREFIX, _INFIX, _BINDING),
        "prism": Style(("false", "true"), _prism_name, _PREFIX, _INFIX, _PRISM_BINDING),
    }
)

PLAIN = STYLES["plain"]
"""What `parse` reads."""


def with_past(style: Style) -> Style:
    """The style for formulas with operators of the past: names that are read as such before an operand are quoted."""
    return style._replace(name=lambda name: quote(name) if name in PAST_WORDS else style.name(name))


PLAIN_WITH_PAST = with_past(PLAIN)


def write(formula: Node, style: Style) -> str:
    """The formula as text, with as few brackets as the strengths of the style allow."""
    pieces: list[str] = []
    # Text to write and (formula, least strength without brackets) still to expand, the next one last.
    pending: list[str | tuple[Any, int]] = [(formula, 0)]
    while pending:
        item = pending.pop()
        if isinstance(item, str):
            pieces.append(item)
            continue
        if not len(pieces) % 1024:
            check_time()
        node, least = item
        operator = node.symbol
        if operator == "proposition":
            pieces.append(style.name(node.name))
            continue
        if operator == "constant":
            pieces.append(style.constants[node.value])
            continue
        strength, left, right = style.binding[operator]
        if strength < least:
            pieces.append("(")
            pending.append(")")
        if operator in style.prefix:
            bracketed = style.binding.get(node.args[0].symbol, _ATOM)[0] < right
            pieces.append(style.prefix[operator].rstrip(" ") if bracketed else style.prefix[operator])
            pending.append((node.args[0], right))
        else:
            for operand in node.args[:0:-1]:
                pending += (operand, right), style.infix[operator]
            pending.append((node.args[0], left))
    return "".join(pieces)
