"""Words that are names or operators, by where they stand.

Tasks call their regions A, S and T, and S and T are operators of the past, too. Two operands side by side are never a
formula, so a word between two operands, or before one where an operand is expected, can be nothing but an operator:
`Y a` and `a S b` have them, `F Y` and `S & T` have names.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import chain, repeat

from ltlc.ltl.dialects import PAST_INFIX, PAST_PREFIX, STARTS_OPERAND, WEAK_NEXT
from ltlc.ltl.grammar import Token

_PREFIX = frozenset((*PAST_PREFIX, *WEAK_NEXT))
_ENDS_OPERAND = frozenset(("NAME", "QUOTED", "_TRUE", "_FALSE", "_CLOSE"))
# A word, or what may be the beginning of a bound.
_SUSPECT = re.compile(
    rf"(?<![\w.])[XFG]*(?:{'|'.join((*sorted(_PREFIX), *PAST_INFIX))})(?![\w.])|[<>=^]\s*\d|\[\s*[^\]\s]"
)


def depends_on_context(text: str) -> bool:
    """Whether there may be such words, or bounds, in a text; mostly not, and then places need not be kept."""
    return _SUSPECT.search(text) is not None


def in_context(tokens: Iterable[Token]) -> Iterator[Token]:
    """The tokens, with operators where words stand as such.

    Args:
        tokens: as the lexer finds them.
    """
    stream = chain(tokens, repeat(None, 2))
    here, after = next(stream, None), next(stream, None)
    expects_operand = True
    for later in stream:
        if here is None:
            return
        if here.kind == "NAME":
            here = here._replace(kind=_kind(here, after, later, expects_operand))
        yield here
        expects_operand = here.kind not in _ENDS_OPERAND
        here, after = after, later


def _kind(here: Token, after: Token | None, later: Token | None, expects_operand: bool) -> str:
    if expects_operand:
        return "PREFIX" if here.text in _PREFIX and _starts_operand(after) and not _is_infix(after, later) else "NAME"
    return "INFIX" if _is_infix(here, after) else "NAME"


def _is_infix(token: Token | None, after: Token | None) -> bool:
    return token is not None and token.kind == "NAME" and token.text in PAST_INFIX and _starts_operand(after)


def _starts_operand(token: Token | None) -> bool:
    return token is not None and token.kind in STARTS_OPERAND
