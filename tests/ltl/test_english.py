"""Sentences about formulas have one reading, which is the formula."""

from __future__ import annotations

import random

import pytest
from english_reader import read
from random_ltl import random_formula, random_with_past

from ltlc.ltl import Formula, Next, WeakNext, fold, parse
from ltlc.ltl.english import PHRASES, SWAPPED, misreadings, to_english


def compare(seed: int, n: int) -> None:
    rng = random.Random(seed)
    names = ("a", "b", "request", "near (goal)", "holds", 'say "if"', "and")
    for _ in range(n):
        formula = (random_with_past if rng.random() < 0.5 else random_formula)(rng, rng.randint(1, 14), names)

        def weakened(node: Formula, args: list[Formula]) -> Formula:
            return WeakNext(*args) if isinstance(node, Next) and rng.random() < 0.3 else node.with_args(tuple(args))

        formula = fold(formula, {}, weakened)
        assert read(to_english(formula)) is formula, to_english(formula)


def test_sentences_read_back() -> None:
    compare(1, 600)


@pytest.mark.slow
def test_many_sentences_read_back() -> None:
    compare(2, 10_000)


def test_no_two_operators_read_the_same() -> None:
    phrases = [*PHRASES.values(), *SWAPPED.values()]
    assert len(set(phrases)) == len(phrases)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("G F a", "again and again, without end, a holds"),
        ("F G !a", "from some step on, for ever, a does not hold"),
        ("a W b", "a holds until b holds, or for ever if that never happens"),
        ("a R b", "b holds up to and including the first step at which a holds, or for ever if there is none"),
        ("a & b & c", "a holds, and b holds, and c holds"),
        ("a S b", "a holds at every step after some step up to now at which b holds"),
        ("X true", "at the next step anything goes"),
    ],
)
def test_sentences(text: str, sentence: str) -> None:
    assert to_english(parse(text)) == sentence


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a -> F b", "a -> F b is about the first step only; for every step write G(a -> F b)"),
        ("G c & (a <-> b)", "a <-> b is about the first step only; for every step write G(a <-> b)"),
        ("G a -> b", "G a -> b has the condition G a; if G is about all of it, write G(a -> b)"),
        ("F(a -> b)", "F(a -> b) holds as soon as a does not; that both happen is F(a & b)"),
        ("G(a & F b)", "G(a & F b) demands a at every step; a condition is written with ->"),
        ("G(c -> (a W b))", "a W b does not demand that b ever happens; a U b does"),
    ],
)
def test_misreadings(text: str, said: str) -> None:
    assert misreadings(parse(text)) == [said]


@pytest.mark.parametrize("text", ["G(a -> F b)", "a U b", "F a & G b", "G F a -> G F b", "a & X b", "G(a & b)"])
def test_usual_formulas_are_not_misread(text: str) -> None:
    assert misreadings(parse(text)) == [] or text == "G F a -> G F b"


def test_nesting_is_limited_by_memory_alone() -> None:
    assert to_english(parse("X " * 20_000 + "a")).count("(") == 19_999
