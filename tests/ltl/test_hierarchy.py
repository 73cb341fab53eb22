"""The temporal hierarchy."""

from __future__ import annotations

import random

import pytest
from random_ltl import random_formula

from ltlc.ltl import HierarchyClass, Not, classify, parse, simplify, to_text

C = HierarchyClass


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a", C.SAFETY),
        ("X X a", C.SAFETY),
        ("true", C.SAFETY),
        ("G a", C.SAFETY),
        ("a W b", C.SAFETY),
        ("a R (b | X c)", C.SAFETY),
        ("!F a", C.SAFETY),
        ("F a", C.CO_SAFETY),
        ("a U (b & X b)", C.CO_SAFETY),
        ("a M b", C.CO_SAFETY),
        ("!G(a -> X a)", C.CO_SAFETY),
        ("F a & G b", C.OBLIGATION),
        ("G a -> G b", C.OBLIGATION),
        ("G a | b U c", C.OBLIGATION),
        ("F(a & F b) & G !c", C.OBLIGATION),
        ("a U G b", C.PERSISTENCE),
        ("G F a", C.RECURRENCE),
        ("G(a -> F b)", C.RECURRENCE),
        ("(G F a) U b", C.RECURRENCE),
        ("G F a & F b", C.RECURRENCE),
        ("F G a", C.PERSISTENCE),
        ("F(a & G b)", C.PERSISTENCE),
        ("G F a -> F b", C.PERSISTENCE),
        ("G a W F b", C.OBLIGATION),
        ("G F a -> G F b", C.REACTIVITY),
        ("F(A & F B) & G !C & F G T", C.PERSISTENCE),
    ],
)
def test_examples(text: str, expected: HierarchyClass) -> None:
    assert classify(parse(text)) is expected


DUAL = {C.SAFETY: C.CO_SAFETY, C.CO_SAFETY: C.SAFETY, C.RECURRENCE: C.PERSISTENCE, C.PERSISTENCE: C.RECURRENCE}


def test_negation_turns_the_hierarchy_around() -> None:
    rng = random.Random(1)
    for _ in range(500):
        formula = random_formula(rng, rng.randint(2, 12))
        here, there = classify(formula), classify(Not(formula))
        if here is C.SAFETY and there is C.SAFETY:
            continue  # both safety and co-safety: a property of a bounded prefix
        assert there is DUAL.get(here, here)


@pytest.mark.peer
def test_is_sound_against_spot() -> None:
    spot = pytest.importorskip("spot")
    allowed = {C.SAFETY: "BS", C.CO_SAFETY: "BG", C.OBLIGATION: "BSGO", C.RECURRENCE: "BSGOR", C.PERSISTENCE: "BSGOP"}
    rng = random.Random(2)
    for _ in range(150):
        formula = random_formula(rng, rng.randint(2, 9))
        theirs = spot.mp_class(spot.formula(to_text(formula, "spot")))
        for reading in (formula, simplify(formula)):
            assert theirs in allowed.get(classify(reading), "BSGORPT"), formula
