"""The limit-deterministic form: its words, its size, and its worth in random Markov decision processes."""

from __future__ import annotations

import numpy as np
import pytest
from random_automata import random_automata, random_lassos
from random_models import random_automaton, random_mdp

from ltlc import compile
from ltlc.automata import DRA, Refinement, limit_deterministic, parity_colours, to_parity
from ltlc.mdp import Product, max_satisfaction_probability, satisfaction_probability


def some_choice_accepts(form: Refinement, prefix: tuple[int, ...], cycle: tuple[int, ...]) -> bool:
    """Whether the word is accepted without a choice, or with one made at some moment of the run."""
    automaton = form.automaton

    def accepted(state: int, letters: tuple[int, ...]) -> bool:
        """From a state in the middle of the word, where `letters` are left before the cycle begins anew."""
        marks = automaton.edge_inf[0]
        for letter in letters:
            state = int(automaton.delta[state, automaton.letter_class[letter]])
        entered: dict[int, int] = {}
        seen: list[bool] = []
        while state not in entered:
            entered[state] = len(seen)
            for letter in cycle:
                c = automaton.letter_class[letter]
                seen.append(bool(marks[state, c]))
                state = int(automaton.delta[state, c])
        return any(seen[entered[state] :])

    state = automaton.initial_state
    word = prefix + cycle * (automaton.n_states + 1)
    if accepted(state, prefix):
        return True
    for i, letter in enumerate(word):
        left = word[i : len(prefix)] if i < len(prefix) else cycle[(i - len(prefix)) % len(cycle) :]
        if any(then >= 0 and accepted(int(then), tuple(left)) for then in form.select_pair[state]):
            return True
        state = int(automaton.delta[state, automaton.letter_class[letter]])
    return False


@pytest.mark.slow
def test_some_choice_accepts_exactly_the_words_of_the_automaton() -> None:
    rng = np.random.default_rng(0)
    accepted = 0
    for automaton in random_automata(150):
        form = limit_deterministic(automaton)
        for prefix, cycle in random_lassos(rng, 2 ** len(automaton.aps), 8):
            truth = automaton.accepts_letters(prefix, cycle)
            assert some_choice_accepts(form, prefix, cycle) == truth
            accepted += truth
    assert accepted > 200


@pytest.mark.slow
def test_there_are_choices_only_where_the_automaton_is_not_of_buchi_type() -> None:
    with_choice = 0
    for automaton in random_automata(250):
        form = limit_deterministic(automaton)
        colours = parity_colours(automaton)
        buchi = colours is not None and colours.max() <= 1
        assert (form.select_pair.shape[1] == 0) == buchi
        assert (form.origin[: automaton.n_states] == np.arange(automaton.n_states)).all()
        with_choice += not buchi
        if not buchi:
            assert form.origin[-1] == -1
            assert not (form.select_pair[automaton.n_states :] >= 0).any()
            made = form.select_pair[form.select_pair >= 0]
            assert sorted(made.tolist()) == list(range(automaton.n_states, form.automaton.n_states - 1))
            assert (form.origin[form.select_pair] == np.arange(len(form.select_pair))[:, None])[
                form.select_pair >= 0
            ].all()
    assert with_choice > 30


@pytest.mark.parametrize("seed", range(60))
def test_pmax_is_that_of_the_rabin_automaton(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mdp, automaton = random_mdp(rng, 6, 2), random_automaton(rng, 4, 1 + seed % 3)
    best = max_satisfaction_probability(Product(mdp, automaton))
    form = limit_deterministic(automaton)
    chosen = Product(mdp, form.automaton, select_pair=form.select_pair)
    found = max_satisfaction_probability(chosen)
    assert found.probability == pytest.approx(best.probability, abs=1e-6)
    assert satisfaction_probability(chosen, found.policy).probability == pytest.approx(best.probability, abs=1e-6)
    parity = Product(mdp, to_parity(automaton).automaton)
    assert max_satisfaction_probability(parity).probability == pytest.approx(best.probability, abs=1e-6)


@pytest.mark.slow
def test_no_policy_with_choices_beats_pmax() -> None:
    for seed in range(30):
        rng = np.random.default_rng(seed)
        mdp, automaton = random_mdp(rng, 5, 2), random_automaton(rng, 3, 2)
        best = max_satisfaction_probability(Product(mdp, automaton)).probability
        form = limit_deterministic(automaton)
        product = Product(mdp, form.automaton, select_pair=form.select_pair)
        for _ in range(5):
            policy = [int(rng.choice(product.actions_in(s))) for s in range(product.n_states)]
            assert satisfaction_probability(product, np.array(policy)).probability <= best + 1e-9


def test_choices_are_few() -> None:
    """Parts that accept by themselves are not copied, and one pair needs one choice."""
    form = limit_deterministic(compile("FG a", acceptance="transition"))
    assert (form.automaton.n_states, form.select_pair.shape) == (3, (3, 1))
    assert limit_deterministic(compile("GF a & G !b")).select_pair.shape[1] == 0
    two: DRA = compile("(FG a | FG b) & G !c", acceptance="transition")
    assert limit_deterministic(two).select_pair.shape[1] == 2
