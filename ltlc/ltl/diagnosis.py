"""Why a text is not a formula, in a reader's words; and what was read although it may be meant otherwise."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence

from ltlc.errors import LtlSyntaxError
from ltlc.ltl.grammar import Token


class LtlSyntaxWarning(UserWarning):
    """A formula was read as other LTL tools read it, and perhaps not as it was meant."""


_PREFIX = {"_NOT": "negation", "_NEXT": "next", "_EVENTUALLY": "eventually", "_ALWAYS": "always"}
_BINARY = {
    "_IMPLIES": "implication",
    "_IFF": "equivalence",
    "_OR": "or",
    "_XOR": "exclusive or",
    "_AND": "and",
    "_UNTIL": "until",
    "_RELEASE": "release",
    "_WEAK_UNTIL": "weak until",
    "_STRONG_RELEASE": "strong release",
}
# What people write for an operator that is written otherwise here.
_WORDS = {
    "until": "U",
    "weakuntil": "W",
    "unless": "W",
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
_WORD = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_."
_SIGNS = {
    "==": "write <-> for equivalence, or quote a comparison: {quoted}",
    "=": "write <-> for equivalence, or quote a comparison: {quoted}",
    "!=": "write xor for exclusive or, or quote a comparison: {quoted}",
    "<": "write <> for eventually, or quote a comparison: {quoted}",
    ">": "write -> for implication, or quote a comparison: {quoted}",
    "*": "write & for conjunction",
    "+": "write | for disjunction",
    "-": "write ! for negation and -> for implication, or quote the name: {quoted}",
    "/": r"write /\ for conjunction, or quote the name: {quoted}",
    "\\": r"write \/ for disjunction, or quote the name: {quoted}",
    ";": "a formula has no sequences, words have: a; b; cycle{{c}}",
    "[": "only round brackets group, and operators have no bounds: write X X a for two steps",
    "]": "only round brackets group, and operators have no bounds: write X X a for two steps",
    "{": "only round brackets group",
    "}": "only round brackets group",
    "'": 'names are quoted with double quotes: "name"',
    "#": "comments belong into formula files",
}


def explain_character(text: str, position: int) -> LtlSyntaxError:
    """The error for a place where no operator, name or bracket starts."""
    rest = text[position:]
    if rest.startswith('"'):
        return error_at("this quote is never closed", text, position, 'end the name with another "')
    number = re.match(r"\d[\w.]*", rest)
    if number:
        hint = f'a name that starts with a digit needs quotes, "{number[0]}"; the constants are 0 and 1'
        return error_at(f"{number[0]!r} is neither a name nor a constant", text, position, hint)
    if rest.startswith("=") and text[:position].endswith("!"):
        rest, position = "!" + rest, position - 1
    sign = next((sign for sign in _SIGNS if rest.startswith(sign)), rest[0])
    hint = _SIGNS.get(sign, "a name with such a character needs quotes: {quoted}")
    return error_at(f"'{sign}' is not an operator", text, position, hint.format(quoted=_quoted(text, position, sign)))


def _quoted(text: str, position: int, sign: str) -> str:
    """The word around a stray sign in quotes, such as "x>=1", or an example of one."""
    end = position + len(sign)
    before = text[len(text[:position].rstrip(_WORD)) : position]
    after = text[end : len(text) - len(text[end:].lstrip(_WORD + "=<>+-"))]
    return f'"{before}{sign}{after}"' if before or after else f'"x{sign}1"'


def explain_token(text: str, tokens: Sequence[Token], index: int) -> LtlSyntaxError:
    """The error for the token at `index`, or for the end of the text, which does not fit what stands before it."""
    if not tokens:
        return error_at(
            "the formula is empty: expected an operand", text, 0, "the shortest formulas are names and true"
        )
    before = tokens[index - 1] if index else None
    here = tokens[index] if index < len(tokens) else None
    if before is None or before.kind in _PREFIX or before.kind in _BINARY or before.kind == "_OPEN":
        return _no_operand(text, before, here)
    opened = _unclosed(tokens[:index])
    if here is None:
        hint = "add a closing bracket, or remove this one"
        return error_at("this bracket is never closed", text, opened[-1].start, hint)
    if here.kind == "_CLOSE":
        hint = "remove it, or add an opening bracket before"
        return error_at("this bracket closes nothing: expected an operator or the end", text, here.start, hint)
    return _two_operands(text, before, here, "a closing bracket" if opened else "the end")


def _no_operand(text: str, before: Token | None, here: Token | None) -> LtlSyntaxError:
    """The error where an operand has to start and something else stands, or nothing."""
    if before is not None and before.kind in _PREFIX:
        message = f"'{before}' ({_PREFIX[before.kind]}) has no operand: expected a formula after it"
        return error_at(message, text, before.start, _reserved(before) or f"write what {before} is about: {before} a")
    if here is not None and here.kind in _BINARY:
        operator = f"'{here}' ({_BINARY[here.kind]})"
        if before is not None and before.kind in _BINARY:
            message = f"{operator} stands right after '{before}': expected an operand between them"
        else:
            message = f"{operator} has no left operand: expected a formula before it"
        return error_at(message, text, here.start, _reserved(here) or f"write {here} between two formulas: a {here} b")
    if before is not None and before.kind in _BINARY:
        message = f"'{before}' ({_BINARY[before.kind]}) has no right operand: expected a formula after it"
        hint = _reserved(before) or f"write {before} between two formulas: a {before} b"
        return error_at(message, text, before.start, hint)
    if before is not None and here is None:
        return error_at("this bracket is never closed: expected an operand", text, before.start, "write (a & b)")
    if before is not None:
        return error_at("empty brackets: expected an operand", text, before.start, "write a formula between them")
    return error_at("this bracket closes nothing: expected an operand", text, 0, "a formula starts with an operand")


def _reserved(operator: Token) -> str:
    """The hint for an operator that may have been meant as a name."""
    return (
        f'{operator} is an operator; quote a proposition of that name: "{operator}"' if operator.text.isalpha() else ""
    )


def _two_operands(text: str, before: Token, here: Token, other: str) -> LtlSyntaxError:
    """The error for an operand right after another, where an operator or `other` was expected."""
    for token in (here, before):
        operator = _WORDS.get(token.text.lower()) if token.kind == "NAME" else None
        if operator:
            message = f"'{token}' is read as a name: expected an operator or {other}"
            return error_at(message, text, token.start, f"{token} is written {operator}")
    hint = 'put an operator such as & | -> U between two formulas, and quote a name with blanks: "a b"'
    if here.kind == "NAME" and re.match(r"[URWM]\w", here.text):
        hint = f"if {here.text[0]} is the operator, put a blank after it: {here.text[0]} {here.text[1:]}"
    elif before.kind == "NAME" and re.search(r"\w[URWM]$", before.text):
        hint = f"if {before.text[-1]} is the operator, put a blank before it: {before.text[:-1]} {before.text[-1]}"
    message = f"'{here}' stands right after '{before}': expected an operator or {other}"
    return error_at(message, text, here.start, hint)


def _unclosed(tokens: Sequence[Token]) -> list[Token]:
    opened: list[Token] = []
    for token in tokens:
        if token.kind == "_OPEN":
            opened.append(token)
        elif token.kind == "_CLOSE":
            opened.pop()
    return opened


def error_at(message: str, text: str, position: int, hint: str) -> LtlSyntaxError:
    """The error for a position, counted in characters from 0."""
    before = text[:position]
    return LtlSyntaxError(message, text, before.count("\n") + 1, position - before.rfind("\n"), hint)


def may_be_misread(text: str) -> bool:
    """Whether `warn_of_misreadings` may have something to say; mostly not, and then tokens need not be looked at."""
    return _SUSPECT.search(text) is not None


# The name t or f, a name like aUb, or an operator glued to a name of two letters.
_SUSPECT = re.compile(r"[tf](?![\w.])|[a-z]\d*[URWM][a-z]|[XFG][^\W\d][\w.]")


def warn_of_misreadings(tokens: Sequence[Token], stacklevel: int) -> None:
    """Warns where a reading is that of other tools, or a guess, and may surprise a person."""
    for message in _misreadings(tokens):
        warnings.warn(message, LtlSyntaxWarning, stacklevel=stacklevel)


def _misreadings(tokens: Sequence[Token]) -> Iterator[str]:
    run = ""  # letters of operators glued to each other, up to here
    end = -1
    runs: list[tuple[str, str]] = []
    names: set[str] = set()
    for token in tokens:
        before, run = run if token.start == end else "", ""
        end = token.end
        if token.kind in _PREFIX and token.text in ("X", "F", "G"):
            run = before + token.text
        elif token.kind == "NAME":
            yield from _odd_name(token.text)
            if before:
                runs.append((before, token.text))
            else:
                names.add(token.text)
    for run, name in runs:
        # Fa and GFx1 are how formulas are written; Goal is how things are called, unless oal is a name as well.
        if len(name.rstrip("0123456789")) > 1 and name not in names:
            spaced = " ".join([*run, name])
            yield f'{run}{name} is read as {spaced}; write that, or "{run}{name}" in quotes for one proposition'


def _odd_name(name: str) -> Iterator[str]:
    if name in ("t", "f"):
        constant = "true" if name == "t" else "false"
        yield (
            f"{name} is read as a proposition, because its neighbor in the alphabet is one; "
            f'write {constant}, or "{name}" in quotes'
        )
    elif re.fullmatch(r"[a-z]\d*[URWM][a-z]\d*", name):
        spaced = re.sub(r"([URWM])", r" \1 ", name)
        yield f'{name} is read as one proposition; write {spaced}, or "{name}" in quotes'
