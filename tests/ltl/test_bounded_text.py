"""Bounds in the text of formulas: it is read back as the same formula, and is no longer than without."""

from __future__ import annotations

import random

import pytest
from bounded import random_bounded
from random_ltl import random_formula

from ltlc.ltl import parse, to_text


@pytest.mark.parametrize(
    "text",
    [
        "F[0:3] a",
        "G[2:6](a | b)",
        "X[5] a",
        "F[1:2] a",
        "O[0:4] a & H[2:3] b",
        "X X a",
        "F[3:9] G[0:2] a",
        "a | X a",
        "F[2:5](a | b) | c",
        "Y[4] a | Z[3] b",
        "X X F a",
        'F[0:2] "O" & Y a',
        "a U X[3] b",
        "a U[2:5] b",
        "a R[0:3] b",
        "a W[1:4] b",
        "a M[0:4] b & a S[0:4] b",
        "a T[2:3] b",
        "a U[2:] b | a R[1:] b",
        "(a & b) U[0:3] (c | d)",
        "(a | b) W[0:2] (c & d)",
        "(a & b) M[1:2] (c & X d)",
        "b | a & X b",
        "F b & G[0:3] a & c",
        "a U[0:3] b | c | F[0:5] d",
        "a U[2:2] b",
        "(a U[0:2] b) U[0:2] c",
        "G(a -> c U[0:7] b)",
    ],
)
def test_known_texts(text: str) -> None:
    assert to_text(parse(text), "bounded") == text


@pytest.mark.slow
def test_random_formulas() -> None:
    rng = random.Random(0)
    shorter = 0
    for number in range(4000):
        text = str(random_bounded(rng, 3, "ab")) if number % 2 else str(random_formula(rng, rng.randint(1, 14), "ab"))
        formula = parse(text)
        bounded = to_text(formula, "bounded")
        assert parse(bounded) is formula, (text, bounded)
        assert len(bounded) <= len(str(formula))
        shorter += len(bounded) < len(str(formula))
    assert shorter > 600


def test_finite_traces() -> None:
    rng = random.Random(1)
    for _ in range(500):
        formula = parse(f"({random_bounded(rng, 2, 'ab')}) & WX a", finite=True)
        assert parse(to_text(formula, "bounded"), finite=True) is formula
    for text in ("G[0:3] a | F[1:3] b", "a R[0:3] b", "a U[1:] b & a W[2:4] b"):
        assert to_text(parse(text, finite=True), "bounded") == text


def test_many_steps() -> None:
    for text in ("F[17:5000] a", "a U[17:5000] b", "a W[3:900] b"):
        assert to_text(parse(text), "bounded") == text
