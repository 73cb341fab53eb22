"""Why a text is not a formula, in a reader's words; and what was read although it may be meant otherwise."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ltlc.errors import LtlSyntaxError

if TYPE_CHECKING:
    from lark import Token


class LtlSyntaxWarning(UserWarning):
    """A formula was read as other LTL tools read it, and perhaps not as it was meant."""


_BINARY = {
    "_IMPLIES": "->",
    "_IFF": "<->",
    "_OR": "|",
    "_XOR": "xor",
    "_AND": "&",
    "_UNTIL": "U",
    "_RELEASE": "R",
    "_WEAK_UNTIL": "W",
    "_STRONG_RELEASE": "M",
}
_PREFIX = {"_NOT": "!", "_NEXT": "X", "_EVENTUALLY": "F", "_ALWAYS": "G"}
_OPERAND = {"NAME", "QUOTED", "_TRUE", "_FALSE"}

# What people write for an operator that is written otherwise here: word or sign -> what to write.
_WORDS = {
    "until": "U",
    "weakuntil": "W",
    "release": "R",
    "releases": "R",
    "v": "R",
    "next": "X",
    "eventually": "F",
    "finally": "F",
    "always": "G",
    "globally": "G",
    "implies": "->",
    "iff": "<->",
    "equals": "<->",
    "and": "&",
    "or": "|",
    "not": "!",
}
_SIGNS = {
    "==": "write <-> for equivalence",
    "=": "write <-> for equivalence, or quote a comparison: \"x=1\"",
    "!=": "write xor for exclusive or, or quote a comparison: \"x!=1\"",
    "<=": "write <-> for equivalence or -> for implication, or quote a comparison: \"x<=1\"",
    ">=": "write -> for implication, or quote a comparison: \"x>=1\"",
    "<": "write <> for F (eventually), or quote a comparison: \"x<1\"",
    ">": "write -> for implication, or quote a comparison: \"x>1\"",
    "*": "write & for conjunction",
    "+": "write | for disjunction",
    "-": "write ! for negation or -> for implication, or quote the name: \"x-1\"",
    "/": "write /\\ for conjunction, or quote the name",
    "\\": "write \\/ for disjunction, or quote the name",
    ";": "a formula has no sequence; words do: \"a; b; cycle{c}\"",
    "[": "bounds are not supported: write X X a or a | X a for a few steps",
    "]": "bounds are not supported: write X X a or a | X a for a few steps",
    "'": 'names are quoted with double quotes: "name"',
    "#": "comments belong in formula files, not in a formula",
}


def explain_character(text: str, position: int) -> LtlSyntaxError:
    """The error for a place where no operator, name or bracket starts."""
    rest = text[position:]
    if rest.startswith('"'):
        return error_at("this quote is never closed", text, position, 'close the name with another "')
    number = re.match(r"\d[\w.]*", rest)
    if number:
        return error_at(
            f"{number[0]!r} is neither a name nor a constant", text, position,
            f'names start with a letter: quote it, "{number[0]}"; the constants are 1 and 0',
        )
    sign = next((sign for sign in _SIGNS if rest.startswith(sign)), rest[0])
    hint = _SIGNS.get(sign, f'a name with such a character needs quotes: "a{sign}b"')
    return error_at(f"{sign!r} is not an operator", text, position, hint)


def explain_token(text: str, tokens: Sequence[Token], index: int) -> LtlSyntaxError:
    """The error for the token at `index` (or the end of the text) that does not fit what was read before."""
    if index >= len(tokens):
        return error_at("the formula ends too early", text, len(text), "")
    token = tokens[index]
    return error_at(f"unexpected {str(token)!r}", text, token.start_pos or 0, "")


def error_at(message: str, text: str, position: int, hint: str) -> LtlSyntaxError:
    before = text[:position]
    line = before.count("\n") + 1
    return LtlSyntaxError(message, text, line, position - before.rfind("\n"), hint)


def warn_of_misreadings(tokens: Sequence[Token], stacklevel: int) -> None:
    """Warns where a reading is that of other tools and may surprise a person."""
