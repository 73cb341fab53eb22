"""Temporal operators pulled out of each other, by the oracle."""

from __future__ import annotations

import random

import pytest
from formula_of_node import closure_of
from random_ltl import random_formula, random_word

from ltlc.ltl import parse, satisfies, simplify
from ltlc.translate import Options, translate
from ltlc.translate.limits import in_the_limit
from ltlc.translate.mixtures import without_mixtures


def test_formulas_without_mixtures_mean_the_same_and_are_low_in_the_hierarchy() -> None:
    rng = random.Random(41)
    changed = 0
    for _ in range(1200):
        formula = in_the_limit(simplify(random_formula(rng, rng.randint(6, 14))))
        result = without_mixtures(formula)
        if result is formula:
            continue
        changed += 1
        closure = closure_of(result)
        assert closure.is_low(closure.root), f"{formula} became {result}"
        for _ in range(12):
            word = random_word(rng)
            assert satisfies(result, word) == satisfies(formula, word), f"{formula} on {word}, as {result}"
    assert changed > 40


@pytest.mark.parametrize("text", ["G(a | F b)", "a U G b", "G F a | F G b", "G a & F(b & X c)"])
def test_what_is_low_stays_as_it_is(text: str) -> None:
    formula = simplify(parse(text))
    assert without_mixtures(formula) is formula


@pytest.mark.parametrize(("limit", "value"), [("_MAX_STEPS", (1, 2)), ("_MAX_GROWTH", 1)])
def test_formulas_that_would_grow_too_much_stay_as_they_are(
    limit: str, value: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    formula = simplify(parse("X X p1 R X((((!p3 -> X!p0) M !p0) & X(X p3 M (p3 W (F p2 W p1)))) <-> F(p0 & G p1))"))
    assert without_mixtures(formula) is not formula
    monkeypatch.setattr(f"ltlc.translate.mixtures.{limit}", value)
    assert without_mixtures(formula) is formula


def test_a_mixture_that_alternates_ten_times_stays_small() -> None:
    # Spot 2.13 needs 12 states, deterministic and with parity acceptance.
    text = (
        "G((G!a & F((G(a & b) & F(!c R d)) | (F(!a | !b) & G(c U !d))))"
        " | (Fa & G((F(!a | !b) & F(!c R d)) | G(a & b & (c U !d)))))"
    )
    automaton = translate(parse(text), Options(acceptance="transition"))
    assert automaton.n_states <= 8
    rng = random.Random(7)
    for _ in range(200):
        word = random_word(rng, "abcd")
        assert automaton.accepts(word.prefix, word.cycle) == satisfies(parse(text), word)
