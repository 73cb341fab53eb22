"""Every construction in every output form: against the oracle on words, and against the others exactly."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from functools import cache

import numpy as np
import pytest
from random_ltl import random_formula, random_nesting, random_next_chain, random_task, random_word

from ltlc.automata import DRA
from ltlc.automata.compare import counterexample, equivalent
from ltlc.automata.rabin import AcceptanceKind
from ltlc.errors import InvalidArgumentError, StateLimitExceeded
from ltlc.formats import from_hoa, from_json, to_hoa, to_json
from ltlc.ltl import Formula, LassoWord, satisfies
from ltlc.translate import TRANSLATORS, Options, translate

FORMULAS = 26
"""per kind."""
WORDS = 200
"""per formula: 4 kinds of 26 formulas with 200 words make 20 800 pairs."""
MAX_STATES = 100
ACCEPTANCES: tuple[AcceptanceKind, ...] = ("state", "transition")


def any_formula(rng: random.Random, names: Sequence[str]) -> Formula:
    return random_formula(rng, rng.randint(2, 14), names)


KINDS: dict[str, Callable[[random.Random, Sequence[str]], Formula]] = {
    "any": any_formula,
    "next-chain": random_next_chain,
    "nesting": random_nesting,
    "task": random_task,
}


@cache
def formulas(kind: str) -> tuple[Formula, ...]:
    rng = random.Random(kind)
    return tuple(KINDS[kind](rng, "abc"[: rng.randint(1, 3)]) for _ in range(FORMULAS))


@cache
def outputs(formula: Formula) -> dict[str, DRA]:
    """The automata of all constructions that apply and stay small, one of each kind of equal ones."""
    found: dict[str, DRA] = {}
    seen: set[tuple[object, ...]] = set()
    for translator in ("auto", *TRANSLATORS):
        for acceptance in ACCEPTANCES:
            limit = 100_000 if translator == "auto" else MAX_STATES
            try:
                a = translate(formula, Options(translator=translator, acceptance=acceptance, max_states=limit))
            except (InvalidArgumentError, StateLimitExceeded):
                assert translator != "auto"
                continue
            key = (acceptance, a.delta.shape, *(x.tobytes() for x in (a.delta, a.letter_class, a.fin, a.inf)))
            if key not in seen:
                seen.add(key)
                found[f"{translator}, {acceptance}"] = a
    for acceptance in ACCEPTANCES:
        a = found[f"auto, {acceptance}"]
        found[f"JSON, {acceptance}"] = from_json(to_json(a))
        found[f"HOA, {acceptance}"] = from_hoa(to_hoa(a))
    return found


def words(formula: Formula, names: Sequence[str]) -> Iterator[LassoWord]:
    rng = random.Random(str(formula))
    return (random_word(rng, names) for _ in range(WORDS))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_output_form_agrees_with_the_oracle(kind: str) -> None:
    pairs = 0
    for formula in formulas(kind):
        automata = outputs(formula)
        for word in words(formula, automata["JSON, state"].aps):
            truth = satisfies(formula, word)
            for name, automaton in automata.items():
                assert automaton.accepts(word.prefix, word.cycle) == truth, f"{name}: {formula} on {word}"
            pairs += 1
    assert pairs * len(KINDS) >= 20_000


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_all_output_forms_are_equivalent(kind: str) -> None:
    for formula in formulas(kind):
        (first, reference), *others = outputs(formula).items()
        for name, automaton in others:
            same = equivalent(reference, automaton)
            assert same, f"{first} and {name}: {formula} on {counterexample(reference, automaton)}"


@pytest.mark.slow
def test_no_construction_is_always_left_out() -> None:
    """The limit on states leaves most formulas to each construction, and most of its results are equal to others."""
    applied = dict.fromkeys(TRANSLATORS, 0)
    sample = [formula for kind in KINDS for formula in formulas(kind)[:8]]
    for formula in sample:
        for translator in TRANSLATORS:
            try:
                translate(formula, Options(translator=translator, acceptance="transition", max_states=MAX_STATES))
            except (InvalidArgumentError, StateLimitExceeded):
                continue
            applied[translator] += 1
    assert min(applied.values()) >= len(sample) // 3, applied


def test_the_automaton_says_where_it_comes_from() -> None:
    for formula in formulas("any"):
        automaton = translate(formula)
        assert automaton.formula == str(formula)
        assert automaton.translator in TRANSLATORS
        assert automaton.initial_state == 0
        assert np.array_equal(np.unique(automaton.letter_class), np.arange(automaton.n_classes))
