"""Automata of formulas with operators of the past, against the textbook's definition and against one another."""

from __future__ import annotations

import random
from collections import Counter

import pytest
from by_definition import past
from random_ltl import random_with_past, random_word
from textbook import holds

from ltlc.automata import DRA
from ltlc.automata.compare import equivalent
from ltlc.errors import InvalidArgumentError, StateLimitExceeded
from ltlc.formats import from_hoa, from_json, to_hoa, to_json
from ltlc.ltl import And, Formula, Once, Proposition, Yesterday, parse
from ltlc.translate import TRANSLATORS, Options, translate


def accepts(automaton: DRA, formula: Formula, rng: random.Random, n_words: int) -> int:
    """The number of random words that are accepted, after comparing each with the definition."""
    accepted = 0
    for _ in range(n_words):
        word = random_word(rng, automaton.aps, longest=5)
        expected = holds(formula, word.letters, len(word.prefix))
        assert automaton.accepts(word.prefix, word.cycle) == expected, f"{formula} on {word}"
        accepted += expected
    return accepted


def test_automata_agree_with_the_definition() -> None:
    assert Counter(past(random.Random(1), 60, 40)) == {None: 2400}


@pytest.mark.slow
def test_many_automata_agree_with_the_definition() -> None:
    assert Counter(past(random.Random(2), 500, 40, "fast")) == {None: 20_000}


@pytest.mark.parametrize("translator", TRANSLATORS)
def test_every_construction_composes_with_the_past(translator: str) -> None:
    rng = random.Random(3)
    applied = 0
    for _ in range(25):
        formula = random_with_past(rng, rng.randint(2, 6), "ab")
        try:
            automaton = translate(formula, Options(translator=translator, max_states=300))
        except (InvalidArgumentError, StateLimitExceeded):
            continue
        applied += 1
        accepts(automaton, formula, rng, 25)
    assert applied > 8


@pytest.mark.parametrize(
    ("past", "future", "states"),
    [
        ("G(b -> Y a)", "!b & G(X b -> a)", 3),
        ("G(b -> O a)", "!b W a", 3),
        ("G(b -> H a)", "G(!a -> G !b)", 3),
        ("G(c -> (a S b))", "(!c W b) & G(!a & !b -> (!c W b))", 3),
        ("F(goal & H !trap)", "!trap U (goal & !trap)", 3),
        ("F(b & O a)", "F(a & F b)", 3),
        ("F(c & O(b & O a))", "F(a & F(b & F c))", 4),
        ("G F(b & Y a)", "G F(a & X b)", 3),
        ("F G(a -> Z b)", "F G(X a -> b)", 3),
        ("G F(b & (!b S a))", "G F(a & b)", 2),
        ("Y a", "false", 1),
        ("X Y a", "a", 3),
        ("G Y Z a", "false", 1),
        ("O a & H b", "a & b", 3),
    ],
)
def test_small_automata(past: str, future: str | None, states: int) -> None:
    formula = parse(past)
    automaton = translate(formula)
    assert automaton.n_states == states
    assert automaton.formula == str(formula)
    assert from_hoa(to_hoa(automaton)).formula == from_json(to_json(automaton)).formula == str(formula)
    if future is not None:
        same = And(parse(future), *(~(Proposition(n) & ~Proposition(n)) for n in automaton.aps))
        assert equivalent(automaton, translate(same))


def test_the_letters_are_those_of_the_formula() -> None:
    automaton = translate(parse('G("past 0" -> O a)'))
    assert automaton.aps == ("past 0", "a")
    assert automaton.step(automaton.initial_state, {"past 0"}) in automaton.deadlocks


def test_too_many_memories_are_refused() -> None:
    wide = And(*(Once(And(Proposition(f"p{i}"), Yesterday(Proposition(f"p{i + 1}")))) for i in range(10)))
    with pytest.raises(StateLimitExceeded):
        translate(parse(f"G F({wide})"), Options(max_states=50))


def test_many_operators_at_once() -> None:
    past = " & ".join(f"G(p{i} -> O q{i})" for i in range(5))
    future = " & ".join(f"(!p{i} W q{i})" for i in range(5))
    automaton = translate(parse(past))
    assert automaton.n_states == 33
    assert equivalent(automaton, translate(parse(future)))
