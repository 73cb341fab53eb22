"""Formulas in prefix notation, as LBT, ltl2dstar and LTL2BA's relatives write them: `U p0 ! p1` is `p0 U !p1`.

References:
    Heikki Tauriainen, LBT: LTL to Buchi conversion, https://www.tcs.hut.fi/Software/maria/tools/lbt/.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

from ltlc.budget import check_time
from ltlc.errors import InvalidArgumentError
from ltlc.ltl.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Constant,
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
from ltlc.ltl.grammar import Token
from ltlc.ltl.syntax import quote

_UNARY: Mapping[str, Callable[[Formula], Formula]] = MappingProxyType(
    {"_NOT": Not, "_NEXT": Next, "_EVENTUALLY": Eventually, "_ALWAYS": Always}
)
_BINARY: Mapping[str, Callable[[Formula, Formula], Formula]] = MappingProxyType(
    {
        "_AND": And,
        "_OR": Or,
        "_XOR": Xor,
        "_UNTIL": Until,
        "_RELEASE": Release,
        "_WEAK_UNTIL": WeakUntil,
        "_STRONG_RELEASE": StrongRelease,
        "_IMPLIES": Implies,
        "_IFF": Iff,
    }
)
_NAMED: Mapping[str, Callable[[Formula, Formula], Formula]] = MappingProxyType({"i": Implies, "e": Iff, "V": Release})
_LEAVES: Mapping[str, Formula] = MappingProxyType({"_TRUE": TRUE, "_FALSE": FALSE})
_CONSTANTS: Mapping[str, Formula] = MappingProxyType({"t": TRUE, "f": FALSE})


def prefix_notation(tokens: Iterable[Token], quoted: Callable[[str], Formula]) -> Formula | None:
    """The formula that the tokens are in prefix notation, or None if they are none.

    `i`, `e` and `V` are implication, equivalence and release where two operands follow, and `t` and `f` are constants.

    Args:
        tokens: of a text that is no formula in infix notation.
        quoted: the proposition of a name in quotes.
    """
    operands: list[Formula] = []
    for count, (kind, text, *_) in enumerate(reversed(list(tokens))):
        if not count & 255:
            check_time()
        binary = _BINARY.get(kind)
        if kind == "NAME" and len(operands) >= _PAIR:
            binary = _NAMED.get(text)
        if binary is not None:
            if len(operands) < _PAIR:
                return None
            operands.append(binary(operands.pop(), operands.pop()))
        elif kind in _UNARY:
            if not operands:
                return None
            operands.append(_UNARY[kind](operands.pop()))
        elif kind == "NAME":
            operands.append(_CONSTANTS.get(text) or Proposition(text))
        elif kind == "QUOTED":
            operands.append(quoted(text))
        elif kind in _LEAVES:
            operands.append(_LEAVES[kind])
        else:
            return None
    return operands[0] if len(operands) == 1 else None


_PAIR = 2


def to_prefix(formula: Formula) -> str:
    """The formula in prefix notation; names other than p0, p1, ... stand in double quotes.

    Raises:
        InvalidArgumentError: it has operators of the past or of finite traces.
    """
    pieces: list[str] = []
    stack = [formula]
    while stack:
        if not len(pieces) & 255:
            check_time()
        node = stack.pop()
        if isinstance(node, Constant):
            pieces.append("t" if node.value else "f")
        elif isinstance(node, Proposition):
            pieces.append(node.name if _BARE.fullmatch(node.name) else quote(node.name))
        elif type(node) not in _SIGNS:
            raise InvalidArgumentError(f"LBT has no operator {node.symbol}: give the tool the automaton of {formula}")
        else:
            pieces += [_SIGNS[type(node)]] * max(1, len(node.args) - 1)
            stack.extend(node.args[::-1])
    return " ".join(pieces)


_BARE = re.compile(r"p\d+")
_SIGNS: Mapping[type[Formula], str] = MappingProxyType(
    {
        operator: operator.symbol
        for operator in (Not, And, Or, Next, Eventually, Always, Until, WeakUntil, StrongRelease)
    }
    | {Release: "V", Implies: "i", Iff: "e", Xor: "^"}
)
