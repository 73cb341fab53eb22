"""Operators with bounds, in the spellings of Spot and PRISM, written out with X.

A bound says at which distances from here an operator looks: `F[2:5] a` is a in two to five steps, `a U<=3 b` is a U b
where b holds in three steps at most. Operators of the past look back: `O[2:5] a` is a two to five steps ago.

References:
    Alexandre Duret-Lutz, Manipulating LTL formulas using Spot 1.0, ATVA 2013, doi:10.1007/978-3-319-02444-8_31.
    Marta Kwiatkowska, Gethin Norman and David Parker, PRISM 4.0, CAV 2011, doi:10.1007/978-3-642-22110-1_47.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from ltlc.budget import check_time
from ltlc.ltl.finite import WeakNext
from ltlc.ltl.formula import (
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    Until,
)
from ltlc.ltl.grammar import Placed, Unbuildable, excerpt
from ltlc.ltl.past import Historically, Once, Since, Triggered, WeakYesterday, Yesterday

MAX_STEPS = 10_000
"""The largest number in a bound."""
MAX_WRITTEN_OUT = 1_000_000
"""A formula with bounds has at most so many operators and names, written out."""


class Bound(NamedTuple):
    """The distances that an operator looks at."""

    first: int
    last: int | None
    """None: without end."""


def bounded_prefix(operator: Placed, operand: Formula, finite: bool) -> Formula:
    """The formula of a prefix operator with a bound, such as `F[2:5]`, `G<=3`, `X[4]` or `O[2:5]`.

    On finite traces F looks for a distance in the bound that the trace has, and G speaks about those that it has. So do
    O and H, whose distances end where the word begins.

    Args:
        operator: the operator with its bound.
        operand: what it is about.
        finite: whether the formula is about finite traces.

    Raises:
        Unbuildable: the bound is empty, too large, or none of this operator.
    """
    sign, bound = _split(operator)
    _check_size(operator, bound, operand)
    if sign in _NEXT:
        if bound.first != bound.last:
            raise _bad_bound(operator, "says no single distance", f"write {sign}[3] for three steps")
        return _repeated(bound.first, operand, _NEXT[sign])
    if sign == "O":
        inner = _nested(bound, operand, Once, lambda f: Or(operand, Yesterday(f)))
        return _repeated(bound.first, inner, Yesterday)
    if sign == "H":
        inner = _nested(bound, operand, Historically, lambda f: And(operand, WeakYesterday(f)))
        return _repeated(bound.first, inner, WeakYesterday)
    if sign in ("F", "<>"):
        inner = _nested(bound, operand, Eventually, lambda f: Or(operand, Next(f)))
        return _repeated(bound.first, inner, Next)
    weak: type[Formula] = WeakNext if finite else Next
    inner = _nested(bound, operand, Always, lambda f: And(operand, weak(f)))
    return _repeated(bound.first, inner, weak)


def bounded_infix(left: Formula, operator: Placed, right: Formula, finite: bool) -> Formula:
    """The formula of a binary operator with a bound, such as `a U[2:5] b` or `a W<=3 b`.

    `a U[m:n] b`: b holds at some distance in the bound, and a at all smaller distances. `R` is its dual, and as without
    a bound `a W b` is `b R (a | b)` and `a M b` is `b U (a & b)`. `a S[m:n] b` is U into the past, and `T` its dual.

    Args:
        left: the left operand.
        operator: the operator with its bound.
        right: the right operand.
        finite: whether the formula is about finite traces.

    Raises:
        Unbuildable: the bound is empty or too large.
    """
    sign, bound = _split(operator)
    _check_size(operator, bound, left, right)
    if sign == "W":
        left, right, sign = right, Or(left, right), "R"
    elif sign == "M":
        left, right, sign = right, And(left, right), "U"
    if sign == "U":
        inner = _nested(bound, right, lambda f: Until(left, f), lambda f: Or(right, And(left, Next(f))))
        return _repeated(bound.first, inner, lambda f: And(left, Next(f)))
    if sign == "S":
        inner = _nested(bound, right, lambda f: Since(left, f), lambda f: Or(right, And(left, Yesterday(f))))
        return _repeated(bound.first, inner, lambda f: And(left, Yesterday(f)))
    if sign == "T":
        inner = _nested(bound, right, lambda f: Triggered(left, f), lambda f: And(right, Or(left, WeakYesterday(f))))
        return _repeated(bound.first, inner, lambda f: Or(left, WeakYesterday(f)))
    weak: type[Formula] = WeakNext if finite else Next
    inner = _nested(bound, right, lambda f: Release(left, f), lambda f: And(right, Or(left, weak(f))))
    return _repeated(bound.first, inner, lambda f: Or(left, weak(f)))


def _nested(
    bound: Bound, last: Formula, unbounded: Callable[[Formula], Formula], again: Callable[[Formula], Formula]
) -> Formula:
    """What an operator says from the first distance of its bound on."""
    return unbounded(last) if bound.last is None else _repeated(bound.last - bound.first, last, again)


def _repeated(steps: int, formula: Formula, step: Callable[[Formula], Formula]) -> Formula:
    for number in range(steps):
        if not number & 255:
            check_time()
        formula = step(formula)
    return formula


_OPERATOR = re.compile(r"(?P<sign>[a-zA-Z_]+|<>|\[\])\s*(?P<bound>.*)", re.DOTALL)
_NEXT: Mapping[str, Callable[[Formula], Formula]] = MappingProxyType({"X": Next, "Y": Yesterday, "Z": WeakYesterday})
_COMPARED = re.compile(r"\[?\s*(?P<relation><=|>=|[<>=^]|)\s*(?P<steps>\d+)\s*\]?")
_INTERVAL = re.compile(r"\[\s*(?P<first>\d*)\s*(?:,|:|\.\.)\s*(?P<last>\d*|\$|inf|oo|∞)\s*\]")


_WORDS: Mapping[str, str] = MappingProxyType(
    {
        "yesterday": "Y",
        "weak_yesterday": "Z",
        "once": "O",
        "historically": "H",
        "since": "S",
        "triggered": "T",
    }
)


def _split(operator: Placed) -> tuple[str, Bound]:
    match = _OPERATOR.fullmatch(operator)
    assert match is not None
    sign, text = _WORDS.get(match["sign"], match["sign"]), match["bound"]
    compared, interval = _COMPARED.fullmatch(text), _INTERVAL.fullmatch(text)
    last: int | None
    if compared is not None:
        relation, steps = (
            compared["relation"] or ("=" if sign in _NEXT else "?"),
            int(compared["steps"].lstrip("0")[:_DIGITS] or 0),
        )
        if relation == "?":
            hint = f"write {sign}[0:{excerpt(compared['steps'])}] or {sign}<={excerpt(compared['steps'])}"
            raise _bad_bound(operator, "has a bound of one number, which tools read in different ways", hint)
        first = {"<=": 0, "<": 0, ">=": steps, ">": steps + 1, "=": steps, "^": steps}[relation]
        last = {"<=": steps, "<": steps - 1, ">=": None, ">": None, "=": steps, "^": steps}[relation]
    elif interval is not None:
        first = _number(interval["first"])
        last = _number(interval["last"]) if interval["last"].isdecimal() else None
    else:
        raise _bad_bound(operator, "has a bound that is not read", f"write {sign}[2:5], {sign}[2:] or {sign}<=5")
    if last is not None and last < first:
        raise _bad_bound(
            operator, "has an empty bound: no distance is in it", f"write the smaller number first: {sign}[2:5]"
        )
    if max(first, last or 0) > MAX_STEPS:
        raise _bad_bound(operator, f"looks further than {MAX_STEPS} steps", "take larger steps, or leave the bound out")
    return sign, Bound(first, last)


def _number(digits: str) -> int:
    return int(digits.lstrip("0")[:_DIGITS] or 0)


_DIGITS = 12
"""digits that are looked at: so large a number is too large."""


def _check_size(operator: Placed, bound: Bound, *operands: Formula) -> None:
    steps = max(bound.first, bound.last or 0) + 1
    size = sum(operand.size for operand in operands) + 3
    if steps * size > MAX_WRITTEN_OUT:
        raise _bad_bound(
            operator,
            f"stands for a formula of more than {MAX_WRITTEN_OUT} operators and names",
            "nest fewer bounds, or make them smaller",
        )


def _bad_bound(operator: Placed, what: str, hint: str) -> Unbuildable:
    return Unbuildable(f"'{excerpt(operator)}' {what}", hint, operator.start)
