"""Verdicts of monitors, against what they are defined by."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
from by_definition import verdicts
from random_ltl import random_formula, random_with_past

import ltlc
from ltlc import Monitor, Verdict
from ltlc.errors import InvalidArgumentError, LtlSyntaxError, StateLimitExceeded, UnknownNameError
from ltlc.ltl import Formula
from ltlc.monitor import VERDICTS


def formulas(seed: int, n: int) -> Iterator[Formula]:
    rng = random.Random(seed)
    for _ in range(n):
        names = "abc"[: rng.randint(1, 3)]
        made = random_with_past if rng.random() < 0.5 else random_formula
        yield made(rng, rng.randint(1, 9), tuple(names))


def test_verdicts_are_those_of_the_definition() -> None:
    assert Counter(verdicts(random.Random(1), 60)) == {None: 2100}


@pytest.mark.slow
def test_many_verdicts_are_those_of_the_definition() -> None:
    assert Counter(verdicts(random.Random(2), 600)) == {None: 21_000}


def test_many_words_at_once() -> None:
    rng = np.random.default_rng(3)
    for formula in formulas(3, 40):
        monitor = Monitor(formula)
        letters = rng.integers(1 << len(monitor.aps), size=(9, 4))
        codes = monitor.run(letters)
        for word, column in zip(letters.T, codes.T, strict=True):
            assert monitor.run(word).tolist() == column.tolist()
            monitor.reset()
            names = [{name for i, name in enumerate(monitor.aps) if letter >> i & 1} for letter in word]
            assert [monitor.step(letter).code for letter in names] == column.tolist()
        if formula.size > 1:
            assert [VERDICTS[code].code for code in range(4)] == list(range(4))


def test_the_smallest_table() -> None:
    sizes = {"true": 1, "G a": 3, "F a": 2, "G F a": 2, "G(a -> F b)": 3, "a U b": 3}
    assert {text: Monitor(text).n_states for text in sizes} == sizes


def test_finite_traces() -> None:
    monitor = Monitor("F(a & last)", finite=True)
    assert [monitor.step(letter).value for letter in ([], ["a"], [])] == [
        "presumably violated",
        "presumably satisfied",
        "presumably violated",
    ]
    monitor = Monitor(ltlc.compile("a & WX b", finite=True))
    assert [monitor.step(letter) for letter in ({"a"}, {"b"})] == [Verdict.PRESUMABLY_SATISFIED, Verdict.SATISFIED]
    monitor.reset()
    assert [monitor.step(letter) for letter in ({"a"}, {"a"})] == [Verdict.PRESUMABLY_SATISFIED, Verdict.VIOLATED]


def test_before_the_first_letter() -> None:
    assert Monitor("a | !a").verdict is Verdict.SATISFIED
    assert Monitor("a & !a").verdict is Verdict.VIOLATED
    assert Monitor("G a").verdict is Verdict.PRESUMABLY_VIOLATED
    assert repr(Monitor("G a")) == "<Monitor of G a: 3 states, now presumably violated>"


def test_errors() -> None:
    monitor = Monitor("F goal & F b")
    with pytest.raises(UnknownNameError, match="Did you mean goal"):
        monitor.step({"goa1"})
    with pytest.raises(InvalidArgumentError, match="a letter is a set"):
        monitor.step("b")
    for letters in ([0.5], [[[1]]], ["a"], [True]):
        with pytest.raises(InvalidArgumentError, match="whole numbers"):
            monitor.run(letters)
    for letters in ([4], [-1]):
        with pytest.raises(InvalidArgumentError, match="from 0 to 3"):
            monitor.run(letters)
    assert monitor.run([]).shape == (0,)
    with pytest.raises(LtlSyntaxError):
        Monitor("F")
    with pytest.raises(InvalidArgumentError):
        Monitor(3)  # type: ignore[arg-type]
    with pytest.raises(StateLimitExceeded):
        Monitor("X X X X a", max_states=2)
