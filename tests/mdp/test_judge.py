"""The judge: its signature, what one verdict computes, and that a chain answers as a policy does."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ltlc
from ltlc.envs import labelled_mdp
from ltlc.mdp import Judge, expected_return, induced_chain
from ltlc.mdp.explicit import ExplicitMDP
from ltlc.rewards import SCHEMES, get_scheme

LAKE = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}


def lake_judge(reward: str = "zeta-discount", formula: str = "F goal & G !hole") -> Judge:
    return Judge(labelled_mdp(gym.make("FrozenLake-v1"), LAKE), ltlc.Task(formula, get_scheme(reward)))


def test_the_judge_is_a_name_of_the_package() -> None:
    assert ltlc.Judge is Judge


def test_one_verdict_induces_one_chain_of_episodes_and_one_of_endless_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    judge = lake_judge()
    policy = np.zeros(judge.reached.shape, dtype=np.int64)
    judge.judge(policy)  # what does not depend on the policy is computed once
    induced: list[ExplicitMDP] = []
    original = ExplicitMDP.policy_matrix

    def counted(self: ExplicitMDP, given: Any) -> Any:
        induced.append(self)
        return original(self, given)

    monkeypatch.setattr(ExplicitMDP, "policy_matrix", counted)
    monkeypatch.setattr(type(judge.rewards), "discounted", None)  # no product is made again
    judge.judge(policy)
    assert sorted(map(id, induced)) == sorted(map(id, (judge.rewards, judge.words)))


@pytest.mark.filterwarnings("ignore::ltlc.errors.RewardWarning")
@pytest.mark.parametrize("reward", sorted(SCHEMES))
def test_chains_of_a_policy_are_those_of_its_processes(reward: str) -> None:
    judge = lake_judge(reward, "G F goal & G !hole")
    product, random = judge.rewards, np.random.default_rng(7)
    mixed = random.random((product.n_states, product.n_actions))
    offered = np.zeros_like(mixed, dtype=np.bool_)
    offered[product.choice_state, product.choice_action] = True
    mixed = np.where(offered, mixed, 0)
    mixed /= mixed.sum(axis=1, keepdims=True)
    for policy in (mixed, mixed.argmax(axis=1)):
        chain = product.under(policy)
        for made, discount in ((chain, 1.0), (chain.discounted(), None), (chain.discounted(0.9), 0.9)):
            slow = induced_chain(product.discounted(discount), policy)
            assert abs(made.matrix - slow.matrix).max() < 1e-15
            assert np.abs(made.exit_probability - slow.exit_probability).max() < 1e-15
        given = expected_return(product, policy), expected_return(product, policy, discount=0.9)
        assert given == (expected_return(product, chain), expected_return(product, chain, discount=0.9))
        with pytest.raises(ltlc.LtlcError, match="not in"):
            chain.discounted(1.5)
