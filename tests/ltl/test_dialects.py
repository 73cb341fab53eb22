"""Hints that say how other tools' operators are written here: they must say the same."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from random_ltl import random_word

from ltlc.errors import LtlSyntaxError
from ltlc.ltl import parse, satisfies
from ltlc.ltl.dialects import RESERVED
from ltlc.ltl.semantics import Letter


def past(operator: str, now: int, letters: tuple[Letter, ...]) -> bool:
    """Whether O a, H a, Y a, Z a, a S b or a T b holds at a position, by definition."""
    a = [("a" in letter) for letter in letters[: now + 1]]
    b = [("b" in letter) for letter in letters[: now + 1]]
    return {
        "O": any(a),
        "H": all(a),
        "Y": now > 0 and a[now - 1],
        "Z": now == 0 or a[now - 1],
        "S": any(b[i] and all(a[i + 1 :]) for i in range(now + 1)),
        "T": all(b[i] or any(a[i + 1 :]) for i in range(now + 1)),
    }[operator]


def hint_of(text: str) -> str:
    with pytest.raises(LtlSyntaxError) as caught:
        parse(text)
    return caught.value.hint


@pytest.mark.parametrize(
    ("text", "operator"),
    [("O a", "O"), ("H a", "H"), ("Y a", "Y"), ("Z a", "Z"), ("a S b", "S"), ("a T b", "T"), ("once a", "O")],
)
def test_examples_for_the_past_are_right(text: str, operator: str) -> None:
    example = re.fullmatch(r".*; G\((\w) -> .*\), for example, says the same as (.*)", hint_of(text))
    assert example
    guard, formula = example[1], parse(example[2])
    rng = random.Random(5)
    verdicts = set()
    for _ in range(500):
        word = random_word(rng, ("a", "b", "c"))
        # What an operator of the past says about the cycle is the same from its second round on.
        letters = word.prefix + 3 * word.cycle
        holds = all(guard not in letter or past(operator, now, letters) for now, letter in enumerate(letters))
        assert satisfies(formula, word) == holds, (word, holds)
        verdicts.add(holds)
    assert verdicts == {True, False}


@pytest.mark.parametrize(
    ("text", "first", "last"),
    [
        ("F[0,3] a", 0, 3),
        ("F<=2 a", 0, 2),
        ("F<2 a", 0, 1),
        ("F[2:4] a", 2, 4),
        ("G[1,2] a", 1, 2),
        ("X[3] a", 3, 3),
        ("X^2 a", 2, 2),
        ("F=2 a", 2, 2),
        ("F[2..4] a", 2, 4),
        ("[][<=1] a", 0, 1),
    ],
)
def test_bounds_are_written_out(text: str, first: int, last: int) -> None:
    formula = parse(hint_of(text).split(" is ")[1])
    rng = random.Random(6)
    for _ in range(200):
        word = random_word(rng, ("a",))
        unrolled = word.prefix + 6 * word.cycle
        holds = [("a" in letter) for letter in unrolled[first : last + 1]]
        assert satisfies(formula, word) == (all(holds) if text[0] in "G[" else any(holds))


@pytest.mark.parametrize(
    "text", ["F[2,inf] a", "F[2..] a", "F>2 a", "F[3] a", "F[3,1] a", "F[0,99] a", "F<0 a", "X[1,2] a", "G[$] a"]
)
def test_bounds_that_are_not_clear_or_long_get_a_general_hint(text: str) -> None:
    assert text[: text.index(" a")] + " a is" not in hint_of(text)


@pytest.mark.parametrize(
    ("prefix", "infix"),
    [
        ("& F a G b", "F a & G b"),
        ("| p0 U p1 ! p2", "p0 | (p1 U !p2)"),
        ("i G p0 e p1 p2", "G p0 -> (p1 <-> p2)"),
        ("! & a ^ b c", "!(a & (b xor c))"),
        ("V | a t W b f", "(a | true) R (b W false)"),
        ("M X X a R b c", "X X a M (b R c)"),
        ('U "a b" F 1', '"a b" U F 1'),
    ],
)
def test_prefix_notation_is_turned_into_infix(prefix: str, infix: str) -> None:
    assert parse(hint_of(prefix).split(": ")[1]) is parse(infix)


@pytest.mark.parametrize("text", ["a b", "& a", "a & & b", "U a", "a i b", "(& a b)", "& a b c", "e", "G a b"])
def test_other_mistakes_are_not_taken_for_prefix_notation(text: str) -> None:
    if text == "e":
        parse(text)
    else:
        assert "infix" not in hint_of(text)
        assert "write operators between operands" not in hint_of(text)


def test_every_reserved_name_is_documented() -> None:
    text = Path(__file__).parents[2].joinpath("docs", "semantics.md").read_text(encoding="utf-8")
    table = text[text.index("| name | elsewhere |") : text.index("Capital letters that only")]
    assert set(re.findall(r"`(\w+)`", table)) == set(RESERVED)
