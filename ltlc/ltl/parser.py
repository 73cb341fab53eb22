"""Text to formula: the grammar is `ltlc/grammars/ltl.lark`, what goes wrong is explained in `diagnosis`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from ltlc.ltl.diagnosis import error_at, explain_character, explain_token, warn_of_misreadings
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

if TYPE_CHECKING:
    from lark import Lark, Token


def parse(text: str) -> Formula:
    """Reads one formula in infix syntax.

    >>> parse("F(A & F B) & G!C & FG T")
    parse('F(A & F B) & G !C & F G T')
    >>> parse("[] (request => <> granted)") is parse("G(request -> F granted)")
    True

    Raises:
        LtlSyntaxError: it is not a formula; says where, what was expected there and what may be meant.

    Warns:
        LtlSyntaxWarning: what looks like a name was read as operators, as in `Goal`, which is `G oal`.
    """
    formula, tokens = parse_tokens(text, _decide_letters)
    warn_of_misreadings(tokens, stacklevel=3)
    return formula


def parse_tokens(
    text: str, decide: Callable[[list[Token]], list[Token]] = lambda tokens: tokens
) -> tuple[Formula, list[Token]]:
    """The formula and the tokens it was read from, after `decide` has changed what they are.

    Raises:
        LtlSyntaxError: it is not a formula.
    """
    from lark import UnexpectedCharacters, UnexpectedToken

    run = _parser().parse_interactive(text)
    try:
        tokens = decide(list(run.lexer_thread.lex(run.parser_state)))  # type: ignore[no-untyped-call]
    except UnexpectedCharacters as error:
        raise explain_character(text, error.pos_in_stream or 0) from None
    unnamed = next((token for token in tokens if token.type == "QUOTED" and token == '""'), None)
    if unnamed is not None:
        raise error_at("a name has at least one character", text, unnamed.start_pos or 0, 'write "name"')
    fed = 0
    try:
        for token in tokens:
            run.feed_token(token)
            fed += 1
        formula: Formula = run.feed_eof()  # type: ignore[no-untyped-call]
    except UnexpectedToken:
        raise explain_token(text, tokens, fed) from None
    return formula, tokens


def _decide_letters(tokens: list[Token]) -> list[Token]:
    """The letters t and f mean true and false, unless a neighbor in the alphabet is a proposition too."""
    from lark import Token

    names = {str(token) for token in tokens if token.type == "NAME"}
    constants = {}
    if "t" in names and not names & {"s", "u"}:
        constants["t"] = "_TRUE"
    if "f" in names and not names & {"e", "g"}:
        constants["f"] = "_FALSE"
    if not constants:
        return tokens
    return [
        Token.new_borrow_pos(constants[token], str(token), token)
        if token.type == "NAME" and token in constants
        else token
        for token in tokens
    ]


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


_COMMENT = re.compile(r'(?P<quoted>"(?:[^"\\]|\\.)*")|(?:#|//).*', re.DOTALL)


@cache
def _parser() -> Lark:
    from lark import Lark

    # Nodes are made while the parser reduces, so no tree is ever built or walked, and nesting costs no recursion.
    builders = SimpleNamespace(**{rule: _builder(node) for rule, node in _NODES.items()})
    builders.quoted = lambda children: Proposition(_ESCAPE.sub(r"\1", children[0][1:-1]))
    builders.true = lambda children: TRUE
    builders.false = lambda children: FALSE
    return Lark.open_from_package("ltlc.grammars", "ltl.lark", parser="lalr", lexer="basic", transformer=builders)


def _builder(node: Callable[..., Formula]) -> Callable[[list[Any]], Formula]:
    return lambda children: node(*children)


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
