"""Text to lasso word, and to finite trace."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ltlc.errors import LtlSyntaxError, check_type
from ltlc.ltl.diagnosis import error_at
from ltlc.ltl.formula import And, Constant, Formula, Not, Proposition
from ltlc.ltl.grammar import excerpt
from ltlc.ltl.parser import parse_silently
from ltlc.ltl.semantics import LassoWord, Letter

_PIECE = re.compile(r'(?P<mark>cycle\s*\{|[;{}])|(?:"(?:[^"\\]++|\\.)*+"|(?!cycle\s*\{)[^;{}])++', re.DOTALL)
_FORM = "a word reads: a; b & !c; cycle{d; !d}"
_EMPTY = "write 1 for a letter in which nothing holds: cycle{1}"


def parse_word(text: str) -> LassoWord:
    """Reads a lasso word: letters with `;` between them, at the end those of the cycle in `cycle{...}`.

    A letter is a conjunction of literals. Propositions that it does not mention are false; `1` or `true` mentions none.
    >>> parse_word("a; b; cycle{!a}")
    LassoWord(prefix=(frozenset({'a'}), frozenset({'b'})), cycle=(frozenset(),))

    Raises:
        LtlSyntaxError: it is not a word, or a letter is more than a conjunction of literals or contradicts itself.
        InvalidArgumentError: it is not even a text.
    """
    prefix, cycle, state = _read(text)
    if not cycle:
        raise error_at("the word ends too early: its cycle is missing", text, len(text), _FORM)
    if state != "end":
        raise error_at("the cycle is never closed", text, len(text), "end it with }")
    return LassoWord(prefix, cycle)


def parse_trace(text: str) -> tuple[Letter, ...]:
    """Reads a finite trace: letters as of `parse_word`, with `;` between them, and no cycle.

    >>> parse_trace("a; 1; b & !c")
    (frozenset({'a'}), frozenset(), frozenset({'b'}))

    Raises:
        LtlSyntaxError: it is no trace; says where.
        InvalidArgumentError: it is not even a text.
    """
    letters, _, state = _read(text, is_finite=True)
    if state == "letter":
        message = "the trace ends too early: a letter is missing" if letters else "the trace is empty"
        raise error_at(message, text, len(text), _TRACE)
    return tuple(letters)


def parse_letter(text: str) -> Letter:
    """Reads one letter, as a log or another program may write it: names with blanks, commas or `&` between them.

    Names with `!` before them do not hold, as those that are left out; `1` and `true` say nothing. Names with other
    characters than letters, digits, `_` and `.` stand in quotes.

    >>> sorted(parse_letter("b, a")), parse_letter("a & !b"), parse_letter("1")
    (['a', 'b'], frozenset({'a'}), frozenset())

    Raises:
        LtlSyntaxError: it is no letter; says where.
        InvalidArgumentError: it is not even a text.
    """
    check_type(text, str, "the letter", "a text")
    holds: dict[str, bool] = {}
    position = 0
    while match := _NAME.match(text, position):
        position = match.end()
        name = match["bare"] or (match["quoted"] and _ESCAPE.sub(r"\1", match["quoted"][1:-1]))
        if name is not None and holds.setdefault(name, not match["not"]) == bool(match["not"]):
            raise error_at(f"'{excerpt(name)}' cannot be true and false in one letter", text, match.start(), _LETTER)
    if text[position:].strip():
        rest = text[position:]
        place = position + len(rest) - len(rest.lstrip())
        raise error_at(f"'{excerpt(text[place : place + 20])}' is no name", text, place, _LETTER)
    return frozenset(name for name, value in holds.items() if value)


_LETTER = 'a letter reads: a & !b, or a b, or a, b; 1 mentions none; other names in quotes: "x>1"'
_NAME = re.compile(
    r"""[\s,&]*(?:(?:1|true)(?![\w.])|(?P<not>!?)\s*(?:(?P<bare>[^\W\d][\w.]*)|(?P<quoted>"(?:[^"\\]++|\\.)++"))(?![\w."]))[\s,&]*"""
)
_ESCAPE = re.compile(r"""\\(["'\\])""")
_TRACE = "a finite trace reads: a; b & !c; 1"


def _read(text: str, *, is_finite: bool = False) -> tuple[list[Letter], list[Letter], str]:
    """The letters before and in the cycle, and what would come next."""
    check_type(text, str, "the word", "a text")
    prefix: list[Letter] = []
    cycle: list[Letter] = []
    letters = prefix
    state = "letter"  # what comes next: a letter, a separator after one, or nothing more
    for match in _PIECE.finditer(text):
        piece = match[0].strip()
        if not piece:
            continue
        mark = (match["mark"] or "")[:1]
        position = match.start() + len(match[0]) - len(match[0].lstrip())
        if state == "letter" and not mark:
            letters.append(_letter(text, position, match.end()))
            state = "separator"
        elif mark == "c" and is_finite:
            raise error_at("a finite trace has no cycle", text, position, _TRACE)
        elif state == "letter" and mark == "c" and letters is prefix:
            letters = cycle
        elif state == "separator" and mark == ";":
            state = "letter"
        elif state == "separator" and mark == "}" and letters is cycle:
            state = "end"
        elif state == "letter" and mark in (";", "}"):
            raise error_at(f"a letter is missing before '{piece}'", text, position, _EMPTY)
        elif state == "letter" and mark == "{":
            raise error_at(
                "a letter is not a set in brackets", text, position, "join propositions by &: a & b; 1 mentions none"
            )
        elif state == "separator" and mark == "c":
            raise error_at(f"'{piece}' stands right after a letter", text, position, "put a ; before it: a; cycle{b}")
        elif state == "end":
            raise error_at(f"'{excerpt(piece)}' stands behind the cycle, which never ends", text, position, _FORM)
        else:
            raise error_at(f"unexpected '{piece}'", text, position, _FORM)
    return prefix, cycle, state


def _letter(text: str, start: int, end: int) -> Letter:
    try:
        formula = parse_silently(text[start:end])
    except LtlSyntaxError as error:
        lines = text[start:end].split("\n")[: error.line - 1]
        position = start + sum(len(line) + 1 for line in lines) + error.column - 1
        raise error_at(error.message, text, position, error.hint) from None
    holds: dict[str, bool] = {}
    for literal in _literals(formula):
        negated = isinstance(literal, Not)
        atom = literal.args[0] if negated else literal
        if isinstance(atom, Constant) and atom.value != negated:
            continue
        if not isinstance(atom, Proposition):
            raise error_at("a letter is a conjunction of literals, such as a & !b", text, start, _FORM)
        if holds.setdefault(atom.name, not negated) == negated:
            raise error_at(f"'{atom.name}' cannot be true and false in one letter", text, start, _FORM)
    return frozenset(name for name, value in holds.items() if value)


def _literals(formula: Formula) -> Iterator[Formula]:
    yield from formula.args if isinstance(formula, And) else (formula,)
