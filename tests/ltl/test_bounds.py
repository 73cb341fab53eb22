"""Operators with bounds, against what they say step by step."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Sequence

import pytest
from by_definition import bounded
from random_ltl import random_word

from ltlc.errors import LtlSyntaxError
from ltlc.ltl import LassoWord, parse, satisfies
from ltlc.ltl.bounds import MAX_STEPS

BOUNDS = [
    ("[0,3]", 0, 3),
    ("<=2", 0, 2),
    (" <= 2", 0, 2),
    ("<2", 0, 1),
    ("[<=2]", 0, 2),
    ("[2:4]", 2, 4),
    ("[ 1 , 2 ]", 1, 2),
    ("[2..4]", 2, 4),
    ("=2", 2, 2),
    ("[:2]", 0, 2),
    ("[2:]", 2, None),
    ("[2:$]", 2, None),
    ("[1,inf]", 1, None),
    (">=2", 2, None),
    (">1", 2, None),
    ("[0002:04]", 2, 4),
]


def by_definition(operator: str, first: int, last: int | None, a: Sequence[bool], b: Sequence[bool]) -> bool:
    distances = range(first, len(a) if last is None else last + 1)
    return {
        "F": lambda: any(a[i] for i in distances),
        "G": lambda: all(a[i] for i in distances),
        "U": lambda: any(b[i] and all(a[:i]) for i in distances),
        "R": lambda: all(b[i] or any(a[:i]) for i in distances),
        "W": lambda: all(a[i] or b[i] or any(b[:i]) for i in distances),
        "M": lambda: any(a[i] and b[i] and all(b[:i]) for i in distances),
    }[operator]()


@pytest.mark.parametrize(("bound", "first", "last"), BOUNDS)
@pytest.mark.parametrize("operator", "FGURWM")
def test_meaning(operator: str, bound: str, first: int, last: int | None) -> None:
    formula = parse(f"{operator}{bound} a" if operator in "FG" else f"a {operator}{bound} b")
    rng = random.Random(f"{operator}{bound}")
    for _ in range(150):
        word = random_word(rng, ("a", "b"))
        unrolled = word.prefix + 12 * word.cycle
        a, b = ([name in letter for letter in unrolled] for name in "ab")
        assert satisfies(formula, word) == by_definition(operator, first, last, a, b), (str(formula), str(word))


def back_by_definition(
    operator: str, first: int, last: int | None, a: Sequence[bool], b: Sequence[bool], now: int
) -> bool:
    """`by_definition` for the letters up to now, from the last to the first; distances end where the word begins."""
    a, b = ([*letters[now::-1]] for letters in (a, b))
    distances = range(first, min(len(a), len(a) if last is None else last + 1))
    return {
        "O": lambda: any(a[i] for i in distances),
        "H": lambda: all(a[i] for i in distances),
        "S": lambda: any(b[i] and all(a[:i]) for i in distances),
        "T": lambda: all(b[i] or any(a[:i]) for i in distances),
    }[operator]()


@pytest.mark.parametrize(("bound", "first", "last"), BOUNDS)
@pytest.mark.parametrize("operator", "OHST")
def test_meaning_of_bounds_on_the_past(operator: str, bound: str, first: int, last: int | None) -> None:
    name = {"O": "once", "H": "historically", "S": "since", "T": "triggered"}[operator]
    rng = random.Random(f"{operator}{bound}")
    for _ in range(60):
        sign = rng.choice((operator, name))
        now, word = rng.randrange(6), random_word(rng, ("a", "b"))
        formula = parse(f"X[{now}] ({f'{sign}{bound} a' if operator in 'OH' else f'a {sign}{bound} b'})")
        unrolled = word.prefix + 12 * word.cycle
        a, b = ([name in letter for letter in unrolled] for name in "ab")
        assert satisfies(formula, word) == back_by_definition(operator, first, last, a, b, now), (str(formula), word)


def test_steps_back() -> None:
    assert parse("G(Y[2] a | Z^2 a)") is parse("G(Y Y a | Z Z a)")
    assert parse("yesterday[1] a & weak_yesterday=1 b") is parse("Y a & Z b")
    with pytest.raises(LtlSyntaxError, match="cannot stand over F a, which speaks about the future"):
        parse("O[1:2] F a")
    with pytest.raises(LtlSyntaxError, match="'O\\[3\\]' has a bound of one number"):
        parse("O[3] a")


def test_nested_bounds() -> None:
    assert Counter(bounded(random.Random(1), 150, 8, automata=False)) == {None: 2400}


@pytest.mark.slow
def test_many_nested_bounds() -> None:
    assert Counter(bounded(random.Random(2), 1000, 8)) == {None: 16_000}


@pytest.mark.parametrize(
    ("text", "written_out"),
    [
        ("X[3] a", "X X X a"),
        ("X^2 a", "X X a"),
        ("X=1 a", "X a"),
        ("X[0] a", "a"),
        ("[][<=1] a", "a & X a"),
        ("<>[1:2] a", "X(a | X a)"),
        ("GF<=1 a", "G(a | X a)"),
        ("G[1:2] F a & b", "X(F a & X F a) & b"),
        ("a U[1:2] b", "a & X(b | a & X b)"),
        ("a R[1:2] b", "a | X(b & (a | X b))"),
        ("a U[2:] b", "a & X(a & X(a U b))"),
        ("F<=0 a", "a"),
        ("F[1:1] a U<=1 b", "X a & X b | b"),
    ],
)
def test_writing_out(text: str, written_out: str) -> None:
    assert parse(text) is parse(written_out) or text == "F[1:1] a U<=1 b"
    assert parse(str(parse(text))) is parse(text)


def test_large_bounds_are_quick_and_larger_ones_refused() -> None:
    formula = parse(f"F<={MAX_STEPS} a")
    word = LassoWord([[]] * 50, [["a"]])
    assert satisfies(formula, word)
    with pytest.raises(LtlSyntaxError, match="looks further than"):
        parse(f"F<={MAX_STEPS + 1} a")
    with pytest.raises(LtlSyntaxError, match="stands for a formula of more than"):
        parse("G<=1000 " * 4 + "a")
