"""Temporal operators pulled out of each other, by the oracle."""

from __future__ import annotations

import random

import pytest
from formula_of_node import closure_of
from random_ltl import random_formula, random_word

from ltlc.automata.rabin import AcceptanceKind
from ltlc.ltl import parse, parse_word, satisfies, simplify
from ltlc.translate import Options, translate
from ltlc.translate.limits import in_the_limit
from ltlc.translate.mixtures import without_mixtures


@pytest.mark.slow
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


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("F(F a & G(F a | b))", "a; cycle{!a & !b}"),
        ("F(F a & F a W b)", "!a; a; cycle{!a & !b}"),
    ],
)
def test_a_part_inside_of_another_operator_is_not_pulled_out(text: str, word: str) -> None:
    formula = simplify(parse(text))
    assert satisfies(without_mixtures(formula), parse_word(word)) == satisfies(formula, parse_word(word))


@pytest.mark.slow
def test_a_part_pulled_out_of_formulas_that_repeat_it() -> None:
    rng = random.Random(42)
    changed = 0
    for _ in range(300):
        for frame in (
            "F(F a & ({}) R ({}))",
            "G(G a | ({}) U ({}))",
            "(F a & X G({})) R ({})",
            "(G a | X F({})) U ({})",
        ):
            formula = in_the_limit(simplify(parse(frame.format(random_formula(rng, 3), random_formula(rng, 6)))))
            result = without_mixtures(formula)
            if result is not formula:
                changed += 1
                for _ in range(12):
                    word = random_word(rng)
                    assert satisfies(result, word) == satisfies(formula, word), f"{formula} on {word}, as {result}"
    assert changed > 100


@pytest.mark.parametrize("text", ["G(a | F b)", "a U G b", "G F a | F G b", "G a & F(b & X c)"])
def test_what_is_low_stays_as_it_is(text: str) -> None:
    formula = simplify(parse(text))
    assert without_mixtures(formula) is formula


@pytest.mark.parametrize(("limit", "value"), [("_MAX_STEPS", (1, 2)), ("_MAX_GROWTH", 1)])
@pytest.mark.slow
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


@pytest.mark.parametrize("acceptance", ["transition", pytest.param("state", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("text", "spot"),  # states of Spot 2.13, deterministic and with parity acceptance
    [
        ("F X F((X c & F !e) R ((d -> e) xor F a) R e R (a & e) U b)", 35),
        ("G(c R G(G X(b | !((!c & d) M (G a & X F b))) -> b R F c -> !((F d <-> !X b) -> d)))", 92),
    ],
)
@pytest.mark.slow
def test_what_grows_when_it_is_taken_apart_is_translated_as_it_was(
    text: str, spot: int, acceptance: AcceptanceKind
) -> None:
    formula = parse(text)
    automaton = translate(formula, Options(acceptance=acceptance))
    assert automaton.n_states <= spot
    rng = random.Random(3)
    for _ in range(200):
        word = random_word(rng, automaton.aps)
        assert automaton.accepts(word.prefix, word.cycle) == satisfies(formula, word)
