"""The operators of the past. What they say at a position depends on the letters up to there alone.

References:
    Orna Lichtenstein, Amir Pnueli and Lenore Zuck, The glory of the past, Logics of Programs 1985,
    doi:10.1007/3-540-15648-8_16.
"""

from __future__ import annotations

from typing import Self

from ltlc.errors import InvalidArgumentError
from ltlc.ltl.formula import Binary, Formula, Unary
from ltlc.ltl.shape import NO_FUTURE, NORMAL


class PastOverFutureError(InvalidArgumentError):
    """An operator of the past stands over one of the future."""


class _PastUnary(Unary):
    __slots__ = ()
    _flags_of_all = NORMAL
    _tense = NO_FUTURE

    def __new__(cls, operand: Formula) -> Self:
        _check(cls, operand)
        return super().__new__(cls, operand)


class _PastBinary(Binary):
    __slots__ = ()
    _flags_of_all = NORMAL
    _tense = NO_FUTURE

    def __new__(cls, left: Formula, right: Formula) -> Self:
        _check(cls, left, right)
        return super().__new__(cls, left, right)


def _check(cls: type[Formula], *operands: Formula) -> None:
    for operand in operands:
        if isinstance(operand, Formula) and not operand.flags & NO_FUTURE:
            raise PastOverFutureError(
                f"{cls.symbol} speaks about the past, so it cannot stand over {_short(operand)}, which speaks about the"
                " future: write the formula so that operators of the past stand over the past and the present alone"
            )


def _short(formula: Formula) -> str:
    return str(formula) if formula.size <= _LONGEST else f"a formula of {formula.size} operators and names"


_LONGEST = 20


class Yesterday(_PastUnary):
    """Y f: there is a position before this one, and f holds there."""

    __slots__ = ()
    symbol = "Y"


class WeakYesterday(_PastUnary):
    """Z f: f holds at the position before this one, if there is one."""

    __slots__ = ()
    symbol = "Z"


class Once(_PastUnary):
    """O f: f holds now or held before."""

    __slots__ = ()
    symbol = "O"


class Historically(_PastUnary):
    """H f: f holds now and has held at all positions before."""

    __slots__ = ()
    symbol = "H"


class Since(_PastBinary):
    """f S g: g holds now or held before, and f has held at all positions after that one, up to now."""

    __slots__ = ()
    symbol = "S"


class Triggered(_PastBinary):
    """f T g: g has held since, and including, the last position where f held; or always, if f never did."""

    __slots__ = ()
    symbol = "T"


PAST = (Yesterday, WeakYesterday, Once, Historically, Since, Triggered)
"""All of them."""
