"""Text to formula: the grammar is `ltlc/grammars/ltl.lark`, what goes wrong is explained in `diagnosis`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from types import SimpleNamespace
from typing import Any

from ltlc.errors import check_type
from ltlc.ltl.bounds import bounded_infix, bounded_prefix
from ltlc.ltl.context import depends_on_context, in_context
from ltlc.ltl.diagnosis import (
    check_characters,
    error_at,
    explain_character,
    explain_token,
    may_be_misread,
    warn_of_misreadings,
)
from ltlc.ltl.dialects import PAST_INFIX, PAST_PREFIX, WEAK_NEXT
from ltlc.ltl.finite import LAST, WeakNext
from ltlc.ltl.formula import (
    FALSE,
    TRUE,
    Always,
    And,
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
)
from ltlc.ltl.grammar import Grammar, Placed, Unbuildable, UnexpectedToken
from ltlc.ltl.lbt import prefix_notation
from ltlc.ltl.past import (
    Historically,
    Once,
    PastOverFutureError,
    Since,
    Triggered,
    WeakYesterday,
    Yesterday,
)
from ltlc.ltl.tables import UNKNOWN


def parse(text: str, *, finite: bool = False) -> Formula:
    """Reads one formula in infix syntax, or in the prefix notation of LBT; or in `P=? [...]`, as PRISM asks about one.

    >>> parse("F(A & F B) & G!C & FG T")
    parse('F(A & F B) & G !C & F G T')
    >>> parse("[] (request => <> granted)") is parse("G(request -> F granted)")
    True
    >>> parse("F[1:2] a & G(b -> once a)")
    parse('X(a | X a) & G(b -> O a)')

    Args:
        text: the formula.
        finite: whether it is about finite traces, where `X[!]`, `WX`, `N` and `last` have a meaning of their own.

    Raises:
        LtlSyntaxError: it is not a formula; says where, what was expected there and what may be meant.
        InvalidArgumentError: it is not even a text.

    Warns:
        LtlSyntaxWarning: what looks like a name was read as operators, as in `Goal`, which is `G oal`; or a name was
            read that other tools reserve, such as `t`.
    """
    formula, is_infix = _read(text, finite)
    if is_infix and may_be_misread(text):
        tokens = _grammar(finite).scan(text)
        warn_of_misreadings((t for t in tokens if not (finite and t[:2] == ("NAME", "last"))), stacklevel=3)
    return formula


def parse_silently(text: str, *, finite: bool = False) -> Formula:
    """`parse` without warnings, for text that is not the user's.

    Raises:
        LtlSyntaxError: it is not a formula.
        InvalidArgumentError: it is not even a text.
    """
    return _read(text, finite)[0]


def _read(text: str, finite: bool) -> tuple[Formula, bool]:
    """The formula of a text, and whether it is in infix notation."""
    check_type(text, str, "the formula", "a text")
    check_characters(text)
    question = _QUESTION.fullmatch(text)
    asked = text
    if question is not None:  # blanks around what is asked about leave every place as it is
        start, end = question.span("formula")
        asked = " " * start + question["formula"] + " " * (len(text) - end)
    grammar = _grammar(finite)
    try:
        formula: Formula = grammar.parse(asked)
    except Unbuildable as error:
        raise error_at(error.message, text, error.start, error.hint) from None
    except UnexpectedToken as unexpected:
        prefixed = prefix_notation(grammar.lexed(asked), _quoted_proposition)
        if prefixed is not None:
            return prefixed, False
        unknown = next((token for token in grammar.scan(asked) if token.kind == UNKNOWN), None)
        if unknown is not None:
            raise explain_character(text, unknown.start) from None
        raise explain_token(text, lambda: grammar.scan(asked), unexpected.index) from None
    return formula, True


def read_formulas(source: str | Iterable[str]) -> Iterator[tuple[int, str]]:
    r"""The formulas of a file, one a line, with their line numbers from 1; blank lines and comments are left out.

    A comment starts with `#` or `//`, outside quotes, and ends with the line.

    >>> list(read_formulas("# two tasks\nF a\n\nG !b  // stay safe"))
    [(2, 'F a'), (4, 'G !b')]

    Args:
        source: the text, or its lines, e.g. an open file.
    """
    lines = source.splitlines() if isinstance(source, str) else source
    for number, line in enumerate(lines, start=1):
        formula = _COMMENT.sub(lambda match: match["quoted"] or "", line).strip()
        if formula:
            yield number, formula


_COMMENT = re.compile(r"""(?P<quoted>"(?:[^"\\]++|\\.)*+"|'(?:[^'\\]++|\\.)*+')|(?:#|//).*""", re.DOTALL)


_QUESTION = re.compile(r"\s*P(?:max|min)?\s*=\s*\?\s*\[(?P<formula>.*)\]\s*", re.DOTALL)


@cache
def _grammar(finite: bool) -> Grammar:
    # Nodes are made while the text is parsed, so no tree is ever built or walked, and nesting costs no recursion.
    return Grammar(_builders(finite), depends_on_context, in_context)


def _builders(finite: bool) -> SimpleNamespace:
    """For each rule of the grammar that has a name, what its value is; given its operands."""
    builders = SimpleNamespace(**{rule: _builder(node) for rule, node in _NODES.items()})
    if finite:
        builders.proposition = lambda operands: LAST if operands[0] == "last" else Proposition(operands[0])
    builders.quoted = lambda operands: _quoted_proposition(operands[0])
    builders.true = lambda operands: TRUE
    builders.false = lambda operands: FALSE
    builders.prefix = lambda operands: _prefixed(operands[0], operands[1], finite)
    builders.infix = lambda operands: _infixed(operands[0], operands[1], operands[2], finite)
    return builders


def _quoted_proposition(text: str) -> Formula:
    return Proposition(_ESCAPE.sub(r"\1", text[1:-1]))


def _builder(node: Callable[..., Formula]) -> Callable[[list[Any]], Formula]:
    return lambda operands: node(*operands)


def _prefixed(sign: Placed, operand: Formula, finite: bool) -> Formula:
    """The formula of a prefix operator that is a word, or has a bound."""
    if sign in PAST_PREFIX:
        return _past(sign, _PAST_NODES[PAST_PREFIX[sign]], operand)
    if sign not in WEAK_NEXT and "!" not in sign:
        return _past(sign, lambda operand: bounded_prefix(sign, operand, finite), operand)
    if finite:
        return WeakNext(operand) if sign in WEAK_NEXT else Next(operand)
    raise Unbuildable(
        f"'{sign}' is the {'weak' if sign in WEAK_NEXT else 'strong'} next of finite traces", _FINITE, sign.start
    )


_FINITE = "words are infinite here, where every position has a next one: write X, or say that traces are finite"


def _infixed(left: Formula, sign: Placed, right: Formula, finite: bool) -> Formula:
    """The formula of a binary operator that is a word, or has a bound."""
    if sign in PAST_INFIX:
        return _past(sign, _PAST_NODES[PAST_INFIX[sign]], left, right)
    return _past(sign, lambda left, right: bounded_infix(left, sign, right, finite), left, right)


def _past(sign: Placed, node: Callable[..., Formula], *operands: Formula) -> Formula:
    try:
        return node(*operands)
    except PastOverFutureError as error:
        message, _, hint = str(error).partition(": ")
        raise Unbuildable(message, hint, sign.start) from None


_PAST_NODES: dict[str, Callable[..., Formula]] = {
    "yesterday": Yesterday,
    "weak_yesterday": WeakYesterday,
    "once": Once,
    "historically": Historically,
    "since": Since,
    "triggered": Triggered,
}
_NODES: dict[str, Callable[..., Formula]] = {
    "proposition": Proposition,
    "negation": Not,
    "next": Next,
    "eventually": Eventually,
    "always": Always,
    "until": Until,
    "release": Release,
    "weak_until": WeakUntil,
    "strong_release": StrongRelease,
    "conjunction": And,
    "xor": Xor,
    "disjunction": Or,
    "implies": Implies,
    "iff": Iff,
}
_ESCAPE = re.compile(r"""\\(["'\\])""")
