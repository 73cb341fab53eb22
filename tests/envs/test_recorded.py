"""The automata, worlds and rewards of the thesis against its recorded and exact figures."""

from __future__ import annotations

import numpy as np
import pytest

from ltlc.automata.compare import equivalent
from ltlc.envs import RECORDED, labelled_mdp, recorded_automaton, thesis_world
from ltlc.errors import UnknownNameError
from ltlc.ltl import parse
from ltlc.mdp import RewardProduct, expected_return, expected_steps, expected_violations, optimal_return
from ltlc.task import Task
from ltlc.translate import translate

SIZES = {"phi_1": (6, 81), "phi_2": (16, 241), "phi_3": (4, 25), "phi_4": (15, 120)}
PHI_2_ON_SINGLE_LETTERS = """
3: 4 5 4 4; 4: 4 7 4 4; 5: 5 7 6 5; 6: 6 8 6 9; 7: 7 7 8 7; 8: 8 8 8 10; 0: 13 1 13 13; 1: 14 14 13 14;
9: 9 11 9 9; 10: 10 11 10 10; 11: 11 11 12 11; 12: 15 14 15 15; 13: 13 1 13 13; 14: 14 14 13 14; 15: 15 14 15 15
"""


@pytest.mark.parametrize("name", RECORDED)
def test_states_and_edges_are_as_recorded(name: str) -> None:
    dra = recorded_automaton(name)
    sinks = int((dra.delta == np.arange(dra.n_states)[:, None]).all(axis=1).sum())
    assert (dra.n_states, (dra.n_states - sinks) * 2 ** len(dra.aps) + sinks) == SIZES[name]
    assert dra.n_pairs == 1


@pytest.mark.parametrize("name", RECORDED)
def test_each_automaton_accepts_the_words_of_its_formula(name: str) -> None:
    dra = recorded_automaton(name)
    assert equivalent(dra, translate(parse(dra.formula or "")))


def test_single_letter_transitions_of_phi_2() -> None:
    dra = recorded_automaton("phi_2")
    for line in PHI_2_ON_SINGLE_LETTERS.replace("\n", " ").split(";"):
        state, targets = line.split(":")
        for letter, target in zip(((), {"A"}, {"B"}, {"T"}), targets.split(), strict=True):
            assert dra.step(int(state), letter) == int(target)
        assert dra.step(int(state), {"C"}) == 2


def test_phi_4_is_phi_2_without_its_sink() -> None:
    small, large = recorded_automaton("phi_4"), recorded_automaton("phi_2")
    number = [q - (q > 2) for q in range(16)]
    for q in set(range(16)) - {2}:
        for letter in ("", "A", "B", "AB", "T", "AT", "BT", "ABT"):
            assert small.step(number[q], set(letter)) == number[large.step(q, set(letter))]


def test_unknown_name() -> None:
    with pytest.raises(UnknownNameError, match=r"'phi1'. Did you mean phi_1"):
        recorded_automaton("phi1")


@pytest.mark.parametrize(("name", "size", "dynamic", "miss", "value", "steps", "violations"), [
    ("phi_1", "10x10", False, "empty", -792.4, 72.8, 0.81),
    ("phi_1", "10x10", True, "empty", -604.6, 59.4, 0.21),
    ("phi_1", "10x10", True, "hold", -598.5, 58.8, 0.21),
    ("phi_2", "10x10", False, "empty", -1391.7, 234.3, 1.19),
    ("phi_2", "10x10", True, "empty", -979.2, 156.0, 0.43),
    ("phi_3", "5x5", False, "empty", -32.2, 32.2, 0),
    ("phi_3", "10x10", False, "empty", -52.5, 52.5, 0),
    ("phi_4", "5x5", False, "empty", -605.5, 101.0, 0),
    ("phi_4", "10x10", False, "empty", -892.1, 134.8, 0),
])  # fmt: skip
def test_worlds_automata_and_rewards_of_the_thesis_meet_its_exact_optima(
    name: str, size: str, dynamic: bool, miss: str, value: float, steps: float, violations: float
) -> None:
    """Return, steps and entries into C of the optimal policy (discount 0.99), undiscounted."""
    world = thesis_world(size, dynamic=dynamic, miss=miss)
    task = Task(recorded_automaton(name), reward="thesis", hold="hold" if miss == "hold" else None)
    product = RewardProduct(labelled_mdp(world), task.tables, initial_label="skip")
    policy = optimal_return(product).policy
    assert expected_return(product, policy, discount=1) == pytest.approx(value, abs=0.05)
    assert expected_steps(product, policy) == pytest.approx(steps, abs=0.06)
    assert expected_violations(product, policy) == pytest.approx(violations, abs=0.005)


@pytest.mark.parametrize(("name", "size", "value"), [("phi_3", "5x5", -16), ("phi_3", "10x10", -25),
                                                     ("phi_4", "5x5", -304), ("phi_4", "10x10", -424)])  # fmt: skip
def test_optima_without_noise(name: str, size: str, value: float) -> None:
    product = RewardProduct(
        labelled_mdp(thesis_world(size, slip=0.0)),
        Task(recorded_automaton(name), reward="thesis").tables,
        initial_label="skip",
    )
    assert expected_return(product, optimal_return(product).policy, discount=1) == pytest.approx(value)


def test_the_best_noise_free_episode_of_the_code_earns_what_it_logged() -> None:
    """31 steps at -10 and 100 at the end: -210 with the code's rewards, the last step being paid 100."""
    task = Task(recorded_automaton("phi_1"), reward="thesis-code")
    product = RewardProduct(labelled_mdp(thesis_world(slip=0.0)), task.tables, initial_label="skip")
    assert expected_return(product, optimal_return(product).policy, discount=1) == pytest.approx(-210)
