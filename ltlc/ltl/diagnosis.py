"""Why a text is not a formula, in a reader's words; and what was read although it may be meant otherwise."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Container, Iterable, Iterator
from itertools import chain, islice

from ltlc.errors import LtlSyntaxError
from ltlc.ltl.dialects import RESERVED, Foreign, foreign_operator, foreign_syntax
from ltlc.ltl.grammar import Token, excerpt


class LtlSyntaxWarning(UserWarning):
    """A formula was read as other LTL tools read it, and perhaps not as it was meant."""


_PREFIX = {"_NOT": "negation", "_NEXT": "next", "_EVENTUALLY": "eventually", "_ALWAYS": "always"}
_PREFIX["PREFIX"] = "with a bound"
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
    "INFIX": "with a bound",
}
# What people write for an operator that is written otherwise here.
_WORDS = {
    "until": "U",
    "weakuntil": "W",
    "stronguntil": "U",
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
    "equivalent": "<->",
    "equals": "<->",
    "and": "&",
    "or": "|",
    "not": "!",
    "never": "G !",
}
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
    "[": "only round brackets group, and bounds are numbers: F[2:5] a",
    "]": "only round brackets group, and bounds are numbers: F[2:5] a",
    "{": "only round brackets group",
    "}": "only round brackets group",
    "'": 'names are quoted with double quotes: "name"',
    "#": "comments belong into formula files",
}


def explain_character(text: str, position: int) -> LtlSyntaxError:
    """The error for a place where no operator, name or bracket starts."""
    foreign = foreign_syntax(text, position)
    if foreign:
        return _foreign(text, foreign)
    rest = text[position : position + _LONGEST_SIGN]
    if rest.startswith('""'):
        return error_at("a name has at least one character", text, position, 'write "name"')
    if rest.startswith('"'):
        return error_at("this quote is never closed", text, position, 'end the name with another "')
    number = re.match(r"\d[\w.]*", rest)
    if number:
        hint = f'a name that starts with a digit needs quotes, "{number[0]}"; the constants are 0 and 1'
        return error_at(f"{number[0]!r} is neither a name nor a constant", text, position, hint)
    if not rest[0].isprintable():
        character = f"U+{ord(rest[0]):04X}"
        hint = "remove it; a name may hold any character in quotes"
        return error_at(f"the invisible character {character} is not an operator", text, position, hint)
    if rest.startswith("=") and text.endswith("!", 0, position):
        rest, position = "!" + rest, position - 1
    sign = next((sign for sign in _SIGNS if rest.startswith(sign)), rest[0])
    hint = _SIGNS.get(sign, "a name with such a character needs quotes: {quoted}")
    return error_at(f"'{sign}' is not an operator", text, position, hint.format(quoted=_quoted(text, position, sign)))


_LONGEST_SIGN = 60
"""characters that are looked at behind and before a sign that is none; a message needs no more."""


def check_characters(text: str) -> None:
    """Raise LtlSyntaxError if there is half a character in the text: no file could hold it."""
    try:
        text.encode("utf-8")
    except UnicodeEncodeError as error:
        message = f"the text has half a character, U+{ord(text[error.start]):04X}, here"
        raise error_at(message, text, error.start, "give the formula as valid UTF-8 text") from None


def _foreign(text: str, foreign: Foreign) -> LtlSyntaxError:
    return error_at(foreign.message, text, foreign.start, foreign.hint)


def _quoted(text: str, position: int, sign: str) -> str:
    """The word around a stray sign in quotes, such as "x>=1", or an example of one."""
    end = position + len(sign)
    before = re.findall(r"[\w.]*\Z", text[max(0, position - _LONGEST_SIGN) : position])[0]
    after = re.findall(r"\A[\w.=<>+-]*", text[end : end + _LONGEST_SIGN])[0]
    return f'"{before}{sign}{after}"' if before or after else f'"x{sign}1"'


def explain_token(text: str, scan: Callable[[], Iterator[Token]], index: int) -> LtlSyntaxError:
    """The error for a token that does not fit what stands before it.

    Args:
        text: the formula.
        scan: starts to read its tokens.
        index: of the token that does not fit; the number of tokens if the text ends too early.
    """
    tokens = scan()
    before: Token | None = None
    opened: list[int] = []
    for before in islice(tokens, index):
        if before.kind == "_OPEN":
            opened.append(before.start)
        elif before.kind == "_CLOSE":
            opened.pop()
    here = next(tokens, None)
    if before is None and here is None:
        hint = "the shortest formulas are names and true"
        return error_at("the formula is empty: expected an operand", text, 0, hint)
    foreign = None
    if here and here.kind not in ("PREFIX", "INFIX"):
        foreign = foreign_syntax(text, here.start)
    if before and here and not foreign:
        foreign = foreign_operator(before, here)
    if foreign:
        return _foreign(text, foreign)
    if before is None or before.kind in _PREFIX or before.kind in _BINARY or before.kind == "_OPEN":
        return _no_operand(text, before, here)
    if here is None:
        hint = "add a closing bracket, or remove this one"
        return error_at("this bracket is never closed", text, opened[-1], hint)
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
        operators = re.search(r"[!~XFGYZOH]*$", text[: before.start].rstrip())
        hint = f"write a formula behind it and close it: {operators[0] if operators else ''}(a)"
        return error_at("this bracket is never closed: expected an operand", text, before.start, hint)
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
        hint = f"if {here.text[0]} is the operator, put a blank after it: {here.text[0]} {excerpt(here.text[1:])}"
    elif before.kind == "NAME" and re.search(r"\w[URWM]$", before.text):
        name, operator = excerpt(before.text[:-1]), before.text[-1]
        hint = f"if {operator} is the operator, put a blank before it: {name} {operator}"
    message = f"'{here}' stands right after '{before}': expected an operator or {other}"
    return error_at(message, text, here.start, hint)


def error_at(message: str, text: str, position: int, hint: str) -> LtlSyntaxError:
    """The error for a position, counted in characters from 0."""
    line = text.count("\n", 0, position) + 1
    return LtlSyntaxError(message, text, line, position - text.rfind("\n", 0, position), hint)


def may_be_misread(text: str) -> bool:
    """Whether `warn_of_misreadings` may have something to say; mostly not, and then tokens need not be looked at."""
    return _SUSPECT.search(text) is not None


# A name that others reserve, alone or behind operators; a name like aUb; one like Oa; an operator glued to two letters.
_SUSPECT = re.compile(
    rf"(?<![\w.])[XFG]*(?:{'|'.join(RESERVED)})(?![\w.])|[a-z]\d*[URWM][a-z]|(?<![\w.])[XFG]*[OHYZN][^\W\d]"
    r"|(?<![\w.])[XFG]++(?:[\w.]{2}|\.)"
)


def warn_of_misreadings(tokens: Iterable[Token], stacklevel: int) -> None:
    """Warns where a reading is that of other tools, or is not, and may surprise a person."""
    for message in _misreadings(tokens):
        warnings.warn(message, LtlSyntaxWarning, stacklevel=stacklevel)


def _misreadings(tokens: Iterable[Token]) -> Iterator[str]:
    names: dict[str, None] = {}
    glued: dict[tuple[str, str], None] = {}  # runs of operators with the name behind them
    run: list[str] = []
    end = -1
    for token in tokens:
        if token.start != end:
            run.clear()
        end = token.end
        if token.kind in _PREFIX and token.text in ("X", "F", "G"):
            run.append(token.text)
        elif token.kind == "NAME":
            if run:
                glued[excerpt("".join(run)), token.text] = None
            else:
                names[token.text] = None
            run.clear()
        else:
            run.clear()
    for name in dict.fromkeys(chain(names, (name for _, name in glued))):
        yield from _odd_name(name, names)
    for letters, name in glued:
        # Fa and GFx1 are how formulas are written; Goal is how things are called, unless oal is a name as well.
        if len(name.rstrip("0123456789")) > 1 and name not in names:
            word, spaced = letters + excerpt(name), " ".join([*letters, excerpt(name)])
            yield f'{word} is read as {spaced}; write that, or "{word}" in quotes for one proposition'


def _odd_name(name: str, names: Container[str]) -> Iterator[str]:
    if name in RESERVED:
        yield f'{name} is read as a proposition; {RESERVED[name]}; write "{name}" in quotes to say that a name is meant'
    elif re.fullmatch(r"[a-z]\d*[URWM][a-z]\d*", name):
        spaced = re.sub(r"([URWM])", r" \1 ", name)
        yield f'{excerpt(name)} is read as one proposition; write {excerpt(spaced)}, or "{excerpt(name)}" in quotes'
    elif name[0] in "OHYZN" and name[1:] in names:
        what = RESERVED[name[0]].replace(" read", f" read {name[0]} before {excerpt(name[1:])} as", 1)
        yield f'{excerpt(name)} is read as one proposition; {what}; write "{excerpt(name)}" in quotes'
