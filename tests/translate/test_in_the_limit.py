"""G F and F G of any formula, by the oracle; and recurrence parts that take turns."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from formula_of_node import closure_of
from random_ltl import random_formula, random_word

from ltlc.automata import equivalent_states
from ltlc.automata.languages import can_decide_languages
from ltlc.automata.rabin_pairs import to_rabin
from ltlc.budget import NO_LIMIT
from ltlc.ltl import Always, Eventually, Formula, Next, parse, satisfies, simplify
from ltlc.translate import Options, translate
from ltlc.translate.constructions import CONSTRUCTIONS
from ltlc.translate.limits import in_the_limit


def test_the_limit_of_a_formula_means_the_same_and_is_low_in_the_hierarchy() -> None:
    rng = random.Random(31)
    changed = 0
    for _ in range(400):
        inner = random_formula(rng, rng.randint(3, 9))
        formula = simplify(Always(Eventually(inner)) if rng.random() < 0.5 else Eventually(Always(inner)))
        limit = in_the_limit(formula)
        changed += limit is not formula
        closure = closure_of(limit)
        assert closure.is_low(closure.root), f"{formula} became {limit}"
        for _ in range(8):
            word = random_word(rng)
            assert satisfies(limit, word) == satisfies(formula, word), f"{formula} on {word}"
    assert changed > 40


def test_limits_inside_a_formula_are_found_and_the_rest_stays() -> None:
    rng = random.Random(32)
    for _ in range(300):
        formula = simplify(random_formula(rng, rng.randint(5, 14)))
        limit = in_the_limit(formula)
        for _ in range(8):
            word = random_word(rng)
            assert satisfies(limit, word) == satisfies(formula, word), f"{formula} on {word}"
    plain = parse("a U (G F b & X c)")
    assert in_the_limit(plain) is plain


def test_a_limit_with_too_many_cases_stays_as_it_is() -> None:
    formula: Formula = parse("a")
    for i in range(40):
        formula = Next(formula) | parse(f"G p{i}") & parse(f"q{i} | F r{i}")
    formula = simplify(Always(Eventually(formula & parse("G x | b"))))
    assert in_the_limit(formula) is formula


@pytest.mark.parametrize(
    ("text", "states"),
    [
        # Spot 2.13 needs 42, 25 and 38 states, deterministic and with parity acceptance.
        ("GF(((c R Fd) & G(a U b)) | ((!c U G!d) & F(!a R !b)))", 2),
        ("GF((((a & b) | (!a & !b)) & FG(!c U !a)) | (((!a & b) | (a & !b)) & GF(c R a)))", 2),
        # 1024, 18 and 24.
        ("GF(a & XX b) & GF(c & XX d) & GF(e & XX i) & GF(g & XX h)", 16),
        ("FG(a | XXb) | FG(c | XXd) | FG(e | XXi)", 12),
        ("FG(a | XXb) | FG(c | XXd) | FG(e | XXi) | FG(g | XXh)", 16),
    ],
)
def test_mixtures_and_windows_stay_small(text: str, states: int) -> None:
    assert translate(parse(text), Options(acceptance="transition")).n_states <= states


@pytest.mark.parametrize("seed", range(4))
def test_parts_that_take_turns_mean_the_same(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(8):
        kind, joint = rng.choice([("G F({} & {})", " & "), ("F G({} | {})", " | ")])
        windows = [kind.format(a, "X" * rng.randint(0, 2) + " " + b) for a, b in (("a", "b"), ("c", "a"), ("b", "!c"))]
        rest = rng.choice(["F a", "G F c", "F G b", "G(a -> F b)", "a U b"])
        formula = parse(f"({joint.join(windows)}) {rng.choice('&|')} {rest}")
        automaton = translate(formula, Options(acceptance="transition", translator="product"))
        for _ in range(30):
            word = random_word(rng)
            assert automaton.accepts(word.prefix, word.cycle) == satisfies(formula, word), f"{formula} on {word}"


def test_states_that_are_known_to_be_alike_are() -> None:
    rng = random.Random(5)
    known = 0
    for _ in range(60):
        parts = [rng.choice(["G F(a & X b)", "F G(b | X c)", "F a", "G(a | X b)", "G F(c & XX a)"]) for _ in range(3)]
        closure = closure_of(parse(f"({parts[0]} | {parts[1]}) & {parts[2]}"))
        built = CONSTRUCTIONS["product"].build(closure, NO_LIMIT)
        automaton = to_rabin(built, closure.letters.aps, closure.letters.letter_class, NO_LIMIT)
        if automaton.alike is None or not can_decide_languages(automaton):
            continue
        known += 1
        blocks = equivalent_states(replace(automaton))
        assert np.array_equal(equivalent_states(automaton), blocks)
        for key in set(automaton.alike):
            assert (
                len({block for block, other in zip(blocks.tolist(), automaton.alike, strict=True) if other == key}) == 1
            )
    assert known > 10
