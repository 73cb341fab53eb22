"""Reduction of nondeterministic Buchi automata, against the words that they accept."""

from __future__ import annotations

import random

import pytest
from random_automata import random_buchi, short_lassos

from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import LetterEdge
from ltlc.automata.simulation import reduced_buchi, simulation, trimmed
from ltlc.graph import bits


@pytest.mark.slow
def test_reductions_keep_the_language() -> None:
    rng = random.Random(3)
    smaller = 0
    for _ in range(400):
        automaton = random_buchi(rng)
        forms = [trimmed(automaton), reduced_buchi(automaton)]
        assert all(form.n_states <= automaton.n_states for form in forms)
        smaller += forms[1].n_states < forms[0].n_states
        for word in short_lassos(automaton.n_letters):
            truth = automaton.accepts(*word)
            assert [form.accepts(*word) for form in forms] == [truth] * 2, (automaton, word)
    assert smaller > 40


@pytest.mark.slow
def test_what_simulates_accepts_more() -> None:
    rng = random.Random(4)
    for _ in range(200):
        automaton = random_buchi(rng)
        alone = [
            BuchiAutomaton(automaton.n_letters, (q,), automaton.edges, automaton.n_sets)
            for q in range(automaton.n_states)
        ]
        for q, above in enumerate(simulation(automaton)):
            for other in bits(above):
                for word in short_lassos(automaton.n_letters):
                    assert alone[other].accepts(*word) or not alone[q].accepts(*word), (automaton, q, other, word)


def test_only_acceptance_sets_that_decide_are_kept() -> None:
    """Set 1 contains set 0; nothing is accepted from state 2."""
    edges = (
        (LetterEdge(1, 0, 0b11), LetterEdge(2, 0, 0b10), LetterEdge(3, 1, 0), LetterEdge(2, 2, 0)),
        (LetterEdge(3, 1, 0b11),),
        (LetterEdge(3, 2, 0b10),),
    )
    smaller = trimmed(BuchiAutomaton(2, (0,), edges, 2))
    assert (smaller.n_states, smaller.n_sets) == (2, 1)


def test_states_of_equal_past_are_merged() -> None:
    """State 0 leads to both with the same letters; together they are what a subset construction would make of them."""
    edges = (
        (LetterEdge(3, 1, 0), LetterEdge(3, 2, 0)),
        (LetterEdge(1, 3, 0),),
        (LetterEdge(2, 4, 0),),
        (LetterEdge(2, 3, 1),),
        (LetterEdge(1, 4, 1),),
    )
    assert reduced_buchi(BuchiAutomaton(2, (0,), edges, 1)).n_states == 4


def test_no_simulation_is_looked_for_where_that_takes_too_long() -> None:
    """Two moves per letter set of a half of 65536 letters, to a state and its twin."""
    n_letters, n = 1 << 16, 24
    everything = (1 << n_letters) - 1
    halves = [everything // ((1 << (1 << i)) + 1) for i in range(n // 2)]

    def moves(letters: int, q: int) -> tuple[LetterEdge, ...]:
        return LetterEdge(letters, (q + 2) % n, 1), LetterEdge(letters, (q + 3) % n, 0)

    large = tuple(moves(halves[q // 2], q) for q in range(n))
    assert simulation(BuchiAutomaton(n_letters, (0, 1), large, 1)) == [1 << q for q in range(n)]
    small = tuple(moves(1, q) for q in range(n))
    assert simulation(BuchiAutomaton(1, (0, 1), small, 1)) == [(1 << n) - 1] * n
