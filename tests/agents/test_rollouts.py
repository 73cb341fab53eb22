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


def test_the_policy_of_the_network_is_drawn_as_its_chances_say() -> None:
    env = grid()
    space, tables = env.single_observation_space, Task("!C U (A & (!C U B))").tables
    agent = DoubleDQN(space, 5, tables, DQNConfig(hidden=(4,), temperature=0.5))
    table = agent.policy_table()
    assert table.shape == (9, tables.n_states, 5) and table.dtype == np.float64
    assert np.allclose(table.sum(axis=-1), 1, atol=1e-12)
    shown, n = np.full(20_000, 3), 20_000
    seen = np.bincount(agent.policy(shown, np.full(n, tables.initial_state)), minlength=5) / n
    assert np.abs(seen - table[3, tables.initial_state]).max() < 5 * 0.5 / np.sqrt(n)
    agent.reseed(1)
    first = agent.policy(shown, np.full(n, tables.initial_state))
    agent.reseed(1)
    assert (agent.policy(shown, np.full(n, tables.initial_state)) == first).all()
    greedy = DoubleDQN(space, 5, tables, DQNConfig(hidden=(4,), temperature=0.0))
    assert (greedy.policy_table() == agent.q_values(np.arange(9)).argmax(axis=-1)).all()
    judge = Judge(labelled_mdp(GridWorld(MAP, slip=0.05)), Task("!C U (A & (!C U B))"))
    assert 0 < judge.satisfaction(table) < judge.maximum.probability


def test_rollouts_of_a_random_policy_are_the_same_again() -> None:
    task = Task("F(A & F B) & G !C")
    env = LTLVectorWrapper(VectorGridWorld(MAP, 4, slip=0.05, max_episode_steps=50), task, observation="none")
    agent = DoubleDQN(env.single_observation_space, 5, task.tables, DQNConfig(hidden=(4,), temperature=0.5))
    assert rollout(agent, env, 20, seed=3) == rollout(agent, env, 20, seed=3)
    assert rollout(agent, env, 20, seed=3) != rollout(agent, env, 20, seed=4)


@pytest.mark.parametrize("formula", ["A | !A", "A & !A", "FG A | GF !A"])
def test_where_all_policies_are_as_good_the_first_best_action_is_taken(formula: str) -> None:
    tables = Task(formula).tables
    agent = DoubleDQN(spaces.Discrete(9), 5, tables, DQNConfig(hidden=(4,), temperature=0.5))
    assert agent.policy_table().dtype == np.int64
    assert agent.policy(np.arange(9), np.full(9, tables.initial_state)).shape == (9,)
