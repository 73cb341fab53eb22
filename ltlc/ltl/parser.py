"""Text to formula: the grammar is `ltlc/grammars/ltl.lark`, what goes wrong is explained in `diagnosis`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from types import SimpleNamespace
from typing import Any

from ltlc.errors import check_type
from ltlc.ltl.diagnosis import check_characters, explain_character, explain_token, may_be_misread, warn_of_misreadings
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
from ltlc.ltl.grammar import UNKNOWN, Grammar, Misfit


def parse(text: str) -> Formula:
    """Reads one formula in infix syntax.

    >>> parse("F(A & F B) & G!C & FG T")
    parse('F(A & F B) & G !C & F G T')
    >>> parse("[] (request => <> granted)") is parse("G(request -> F granted)")
    True

    Raises:
        LtlSyntaxError: it is not a formula; says where, what was expected there and what may be meant.
        InvalidArgumentError: it is not even a text.

    Warns:
        LtlSyntaxWarning: what looks like a name was read as operators, as in `Goal`, which is `G oal`; or a name was
            read that other tools reserve, such as `t`.
    """
    formula = parse_silently(text)
    if may_be_misread(text):
        warn_of_misreadings(_grammar().scan(text), stacklevel=3)
    return formula


def parse_silently(text: str) -> Formula:
    """`parse` without warnings, for text that is not the user's.

    Raises:
        LtlSyntaxError: it is not a formula.
        InvalidArgumentError: it is not even a text.
    """
    check_type(text, str, "the formula", "a text")
    check_characters(text)
    grammar = _grammar()
    try:
        formula: Formula = grammar.parse(text)
    except Misfit as misfit:
        unknown = next((token for token in grammar.scan(text) if token.kind == UNKNOWN), None)
        if unknown is not None:
            raise explain_character(text, unknown.start) from None
        raise explain_token(text, lambda: grammar.scan(text), misfit.index) from None
    return formula


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


_COMMENT = re.compile(r'(?P<quoted>"(?:[^"\\]++|\\.)*+")|(?:#|//).*', re.DOTALL)


@cache
def _grammar() -> Grammar:
    # Nodes are made while the text is parsed, so no tree is ever built or walked, and nesting costs no recursion.
    return Grammar(_builders())


def _builders() -> SimpleNamespace:
    """For each rule of the grammar that has a name, what its value is; given its operands."""
    builders = SimpleNamespace(**{rule: _builder(node) for rule, node in _NODES.items()})
    builders.quoted = lambda operands: Proposition(_ESCAPE.sub(r"\1", operands[0][1:-1]))
    builders.true = lambda operands: TRUE
    builders.false = lambda operands: FALSE
    return builders


def _builder(node: Callable[..., Formula]) -> Callable[[list[Any]], Formula]:
    return lambda operands: node(*operands)


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
_ESCAPE = re.compile(r'\\(["\\])')
