"""The syntax of other tools: prefix notation, questions of PRISM, names in single quotes, and names they reserve."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from random_ltl import random_formula

from ltlc.errors import LtlSyntaxError
from ltlc.ltl import parse, to_text
from ltlc.ltl.dialects import RESERVED


def hint_of(text: str) -> str:
    with pytest.raises(LtlSyntaxError) as caught:
        parse(text)
    return caught.value.hint


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
def test_prefix_notation_is_read(prefix: str, infix: str) -> None:
    assert parse(prefix) is parse(infix)


@pytest.mark.parametrize("text", ["a b", "& a", "a & & b", "U a", "a i b", "(& a b)", "& a b c", "e", "G a b"])
def test_other_mistakes_are_not_taken_for_prefix_notation(text: str) -> None:
    if text == "e":
        parse(text)
    else:
        hint_of(text)


@pytest.mark.slow
def test_prefix_notation_is_written_and_read_back() -> None:
    rng = random.Random(9)
    for _ in range(300):
        formula = random_formula(rng, rng.randint(1, 20), ("p0", "p1", "a b", "i", "t"), constants=0)
        assert parse(to_text(formula, "lbt")) is formula
    assert to_text(parse("G(a -> (p0 R p1 | true))"), "lbt") == 'G i "a" | V p0 p1 t'
    deep = parse("F & a " * 20_000 + "a")
    assert parse(to_text(deep, "lbt")) is deep


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("P=? [ F a ]", "F a"),
        ('Pmax=?[ F "a b" & G<=1 b ]', 'F "a b" & b & X b'),
        (" Pmin = ? [ G(a -> F b) ] ", "G(a -> F b)"),
        ("F 'at home' & 'it\\'s'", 'F "at home" & "it\'s"'),
    ],
)
def test_questions_of_prism_and_names_of_owl_are_read(text: str, formula: str) -> None:
    assert parse(text) is parse(formula)


def test_places_in_questions_are_those_of_the_whole_text() -> None:
    with pytest.raises(LtlSyntaxError) as caught:
        parse("P=? [ F a &\n G ]")
    assert (caught.value.line, caught.value.column) == (2, 2)


def test_every_reserved_name_is_documented() -> None:
    text = Path(__file__).parents[2].joinpath("docs", "semantics.md").read_text(encoding="utf-8")
    table = text[text.index("| name | elsewhere |") : text.index("Capital letters that only")]
    assert set(re.findall(r"`(\w+)`", table)) == set(RESERVED)
