"""Rollouts agree with the exact judge, and say where they cannot be made."""

from __future__ import annotations

import numpy as np
import pytest
from gymnasium import spaces

from ltlc.agents import DoubleDQN, DQNConfig, FittedQConfig, greedy_policy, rollout, train
from ltlc.envs import GridWorld, LTLVectorWrapper, VectorGridWorld, labelled_mdp
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import Judge, expected_return, expected_steps, expected_violations
from ltlc.task import Task

MAP = "S..\n.C.\nA.B"
TASK = Task("F(A & F B) & G !C", reward="thesis", on_deadlock="stay")


def grid() -> LTLVectorWrapper:
    return LTLVectorWrapper(VectorGridWorld(MAP, 4, slip=0.05, max_episode_steps=200), TASK, observation="none")


@pytest.mark.slow
def test_rollouts_agree_with_the_exact_judge() -> None:
    agent = train(grid(), FittedQConfig(total_steps=20_000)).agent
    seen = rollout(agent, grid(), 400, seed=3, confidence=0.999)
    assert len(seen.episodes) == 400
    judge = Judge(labelled_mdp(GridWorld(MAP, slip=0.05)), TASK)
    policy = judge.rewards.lift(greedy_policy(agent))
    for estimate, exact in (
        (seen.episode_return, expected_return(judge.rewards, policy, discount=1.0)),
        (seen.episode_length, expected_steps(judge.rewards, policy)),
        (seen.violations_per_episode, expected_violations(judge.rewards, policy)),
    ):
        assert estimate.low <= exact <= estimate.high
    assert 0 <= seen.satisfied.low <= seen.satisfied.value <= seen.satisfied.high <= 1
    assert seen.violations_per_step.value == pytest.approx(
        seen.violations_per_episode.value / seen.episode_length.value
    )
    assert 0 < seen.acceptance_frequency.value < 1


def test_rollouts_of_episodes_without_end_say_so() -> None:
    endless = LTLVectorWrapper(VectorGridWorld(MAP, 4), TASK, observation="none")
    agent = DoubleDQN(endless.single_observation_space, 5, TASK.tables, DQNConfig(hidden=(4,)))
    with pytest.raises(InvalidArgumentError, match=r"of 8 episodes ended within 40 steps"):
        rollout(agent, endless, 8, max_steps=40)
    with pytest.raises(InvalidArgumentError, match="at least 2"):
        rollout(agent, endless, 1)
    with pytest.raises(InvalidArgumentError, match="the agent was made for"):
        rollout(agent, LTLVectorWrapper(VectorGridWorld("SABC", 2), TASK, observation="none"), 4)


def test_greedy_policy_needs_a_list_of_observations() -> None:
    agent = DoubleDQN(spaces.Box(-1.0, 1.0, (2,)), 2, None, DQNConfig(hidden=(4,)))
    with pytest.raises(InvalidArgumentError, match="pass observations="):
        greedy_policy(agent)
    assert greedy_policy(agent, np.zeros((3, 2), dtype=np.float32)).shape == (3, 1)
