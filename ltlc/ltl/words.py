"""Text to lasso word."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ltlc.errors import LtlSyntaxError
from ltlc.ltl.diagnosis import error_at
from ltlc.ltl.formula import And, Constant, Formula, Not, Proposition
from ltlc.ltl.parser import parse_tokens
from ltlc.ltl.semantics import LassoWord, Letter

_PIECE = re.compile(r'(?P<mark>cycle\s*\{|[;{}])|(?:"(?:[^"\\]|\\.)*"|(?!cycle\s*\{)[^;{}])+', re.DOTALL)
_FORM = "a word reads: a; b & !c; cycle{d; !d}"


def parse_word(text: str) -> LassoWord:
    """Reads a lasso word: letters with `;` between them, at the end those of the cycle in `cycle{...}`.

    A letter is a conjunction of literals. Propositions that it does not mention are false; `1` or `true` mentions none.
    In words, t and f are propositions like any other.

    >>> parse_word("a; b; cycle{!a}")
    LassoWord(prefix=(frozenset({'a'}), frozenset({'b'})), cycle=(frozenset(),))

    Raises:
        LtlSyntaxError: it is not a word, or a letter is more than a conjunction of literals or contradicts itself.
    """
    prefix: list[Letter] = []
    cycle: list[Letter] = []
    letters = prefix
    pieces = [match for match in _PIECE.finditer(text) if match[0].strip()]
    state = "letter"  # what comes next: a letter, a separator after one, or nothing more
    for match in pieces:
        mark = (match["mark"] or "")[:1]
        position = match.start() + len(match[0]) - len(match[0].lstrip())
        if state == "letter" and not mark:
            letters.append(_letter(text, position, match.end()))
            state = "separator"
        elif state == "letter" and mark == "c" and letters is prefix:
            letters = cycle
        elif state == "separator" and mark == ";":
            state = "letter"
        elif state == "separator" and mark == "}" and letters is cycle:
            state = "end"
        else:
            raise error_at(f"unexpected '{match[0].strip()}'", text, position, _FORM)
    if state != "end":
        raise error_at("the word ends too early", text, len(text), _FORM)
    return LassoWord(prefix, cycle)


def _letter(text: str, start: int, end: int) -> Letter:
    try:
        formula, _ = parse_tokens(text[start:end])
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
