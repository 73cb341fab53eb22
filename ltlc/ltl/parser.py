"""Text to formula: the grammar is `ltlc/grammars/ltl.lark`, what goes wrong is explained in `diagnosis`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

from ltlc.ltl.diagnosis import error_at, explain_character, explain_token, may_be_misread, warn_of_misreadings
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
from ltlc.ltl.grammar import UNKNOWN, Grammar, Misfit, Token


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
    if may_be_misread(text):
        warn_of_misreadings(tokens(), stacklevel=3)
    return formula


def parse_tokens(
    text: str, decide: Callable[[list[str], Sequence[str]], None] = lambda kinds, texts: None
) -> tuple[Formula, Callable[[], list[Token]]]:
    """The formula and the tokens it was read from, after `decide(kinds, texts)` has changed what kinds they are.

    Raises:
        LtlSyntaxError: it is not a formula.
    """
    grammar = _grammar()
    matches = grammar.scan(text)
    kinds = [match.lastgroup or "" for match in matches]
    texts = [match[0] for match in matches]

    def tokens() -> list[Token]:
        return [Token(kind, match[0], *match.span()) for kind, match in zip(kinds, matches, strict=True)]

    if UNKNOWN in kinds:
        raise explain_character(text, matches[kinds.index(UNKNOWN)].start())
    if '""' in texts:
        raise error_at("a name has at least one character", text, matches[texts.index('""')].start(), 'write "name"')
    decide(kinds, texts)
    try:
        formula: Formula = grammar.parse(kinds, texts)
    except Misfit as misfit:
        raise explain_token(text, tokens(), misfit.index) from None
    return formula, tokens


def _decide_letters(kinds: list[str], texts: Sequence[str]) -> None:
    """The letters t and f mean true and false, unless a neighbor in the alphabet is a proposition too."""
    for letter, constant, neighbors in (("t", "_TRUE", ("s", "u")), ("f", "_FALSE", ("e", "g"))):
        if letter in texts and not any(neighbor in texts for neighbor in neighbors):
            for i, text in enumerate(texts):
                if text == letter:
                    kinds[i] = constant


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
