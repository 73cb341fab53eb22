"""What each scheme really optimises: the exact satisfaction probability of its optimal policy on tiny examples."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from ltlc.envs import labelled_mdp
from ltlc.mdp import (
    LabelledMDP,
    Product,
    RewardProduct,
    max_satisfaction_probability,
    optimal_return,
    satisfaction_probability,
)
from ltlc.rewards import RewardScheme, get_scheme
from ltlc.task import Task

GUARANTEED = {
    "zeta-reach": get_scheme("zeta-reach", zeta=0.999),
    "zeta-discount": get_scheme("zeta-discount", zeta=0.999),
    "two-discount": get_scheme("two-discount", gamma_accept=0.99, gamma=0.99999),
    "eventual": get_scheme("eventual", gamma=0.999),
    "frontier": get_scheme("frontier", eta=0.999),
    "parity, adaptive": get_scheme("parity", epsilon=0.001),
    "parity, terminate": get_scheme("parity", epsilon=0.001, mode="terminate"),
}


def risk_reward() -> LabelledMDP:
    """A risky and a safe way to the reward; the risky one is shorter (Hahn et al., TACAS 2019)."""
    p = np.zeros((4, 4, 4))  # risky, safe, reset, stay
    p[0, 0, [2, 3]] = 0.9, 0.1
    p[1, 0, 1] = 1
    p[2, [1, 2, 3], 0] = 1
    p[3, [0, 2, 3], [0, 2, 3]] = 1
    return LabelledMDP.from_arrays(p, aps=("g", "b"), labels={1: "g", 2: "g", 3: "b"})


def devious() -> LabelledMDP:
    """A sure loop with rare rewards against a likely one with many (Mungojerrie's example of that name)."""
    states = [(0, 0), (2, 0), (3, 0), *[(1, n) for n in range(8)]]
    index = {state: i for i, state in enumerate(states)}
    p = np.zeros((3, len(states), len(states)))
    p[0, 0, index[1, 0]] = 1
    p[1, 0, [index[2, 0], index[3, 0]]] = 0.75, 0.25
    for i in (1, 2):
        p[2, i, i] = 1
    p[0, index[1, 0], index[1, 1]] = p[0, index[1, 1], index[1, 2]] = p[1, index[1, 1], index[1, 5]] = 1
    for n in range(2, 8):
        p[0, index[1, n], index[1, (n + 1) % 5 if n <= 4 else min(n + 1, 7)]] = 1
    return LabelledMDP.from_arrays(p, aps=("g",), labels={index[s]: "g" for s in [(1, 0), (1, 5), (1, 6), (2, 0)]})


def frozen_lake() -> LabelledMDP:
    labels = {"goal": lambda s: s == 15, "hole": lambda s: s in (5, 7, 11, 12)}
    return labelled_mdp(gym.make("FrozenLake-v1"), labels)


TASKS = {
    "risk_reward": (risk_reward, "G F g & G !b", 1.0),
    "devious": (devious, "G F g", 1.0),
    "frozen_lake": (frozen_lake, "!hole U goal", 14 / 17),
}


def satisfied(name: str, scheme: RewardScheme) -> float:
    """P(sat) of a policy that is optimal for the scheme."""
    make, formula, best = TASKS[name]
    mdp, task = make(), Task(formula, scheme)
    rewarded, product = RewardProduct(mdp, task.tables), Product(mdp, task.automaton)
    assert max_satisfaction_probability(product).probability == pytest.approx(best, abs=1e-6)
    choice = {
        (s, q): a
        for s, q, a in zip(rewarded.mdp_state, task.tables.automaton_state[rewarded.machine_state],
                           optimal_return(rewarded).policy, strict=True)
    }  # fmt: skip
    anything = product.choice_action[product.choice_start[:-1]]  # where the rewarded task is over already
    pairs = zip(product.mdp_state, product.machine_state, anything, strict=True)
    return satisfaction_probability(product, np.array([choice.get((s, q), a) for s, q, a in pairs])).probability


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("scheme", GUARANTEED)
def test_schemes_with_a_guarantee_maximise_the_probability(name: str, scheme: str) -> None:
    assert satisfied(name, GUARANTEED[scheme]) == pytest.approx(TASKS[name][2], abs=1e-5)


@pytest.mark.parametrize(("name", "scheme", "probability"), [
    ("risk_reward", get_scheme("accept"), 0.9),
    ("risk_reward", get_scheme("accept", gamma=0.9999), 0.9),
    ("devious", get_scheme("accept"), 0.75),
    ("devious", get_scheme("sadigh"), 0.75),
    ("devious", get_scheme("two-discount", gamma_accept=0.99, gamma=0.999), 0.75),
])  # fmt: skip
def test_schemes_without_one_can_lose(name: str, scheme: RewardScheme, probability: float) -> None:
    assert satisfied(name, scheme) == pytest.approx(probability, abs=1e-6)


@pytest.mark.parametrize("name", TASKS)
def test_shaping_changes_no_optimal_policy(name: str) -> None:
    assert satisfied(name, get_scheme("zeta-discount", zeta=0.999, shaping=5.0)) == pytest.approx(
        TASKS[name][2], abs=1e-5
    )
