"""Where the environment terminates, its last letter goes on for learners, too."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import pytest
from gymnasium.vector import SyncVectorEnv
from mdp_cases import GOAL_OR_DOCK, goal_or_dock

from ltlc.agents import FittedQConfig, Progress, greedy_policy, train
from ltlc.agents.tabular.config import FuTopcuConfig, QLearningConfig, SadighConfig, WangConfig
from ltlc.envs import LTLVectorWrapper
from ltlc.mdp import (
    Judge,
)
from ltlc.rewards import get_scheme
from ltlc.task import Task


class Gamble(gym.Env[Any, Any]):
    """`goal_or_dock`: the goal ends the world, the dock and the loss do not."""

    observation_space, action_space = gym.spaces.Discrete(4), gym.spaces.Discrete(2)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.state, self.time = 0, 0
        return 0, {"labels": set()}

    def step(self, action: Any) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.time += 1
        if self.state == 0:
            won, chance = ((1, 0.9), (2, 0.5))[int(action)]
            self.state = won if self.np_random.random() < chance else 3
        label = {1: {"goal"}, 2: {"dock"}}.get(self.state, set())
        return self.state, 0.0, self.state == 1, self.time == 20, {"labels": label}


def gambles(task: Task, n: int = 4) -> LTLVectorWrapper:
    return LTLVectorWrapper(SyncVectorEnv([Gamble] * n), task, observation="none")


@pytest.mark.slow
@pytest.mark.parametrize(("on_termination", "probability"), [("repeat", 0.9), ("cut", 0.5)])
@pytest.mark.parametrize("formula", GOAL_OR_DOCK[:2])
def test_the_table_learns_it(formula: str, on_termination: Any, probability: float) -> None:
    task = Task(formula, acceptance="transition", on_termination=on_termination)
    config = FittedQConfig(total_steps=4_000, epsilon_steps=1_000, log_every=1_000, checkpoint_every=4_000)
    agent = train(gambles(task), config).agent
    judge = Judge(goal_or_dock(1), task)
    assert judge.satisfaction(greedy_policy(agent)) == pytest.approx(probability)


@pytest.mark.slow
@pytest.mark.parametrize(("on_termination", "probability"), [("repeat", 0.9), ("cut", 0.5)])
@pytest.mark.parametrize("double", [False, True])
def test_q_learning_learns_it(double: bool, on_termination: Any, probability: float) -> None:
    scheme = get_scheme("two-discount", gamma_accept=0.9, gamma=0.9999)
    task = Task(GOAL_OR_DOCK[0], scheme, on_termination=on_termination)
    config = QLearningConfig(total_steps=30_000, averaging_steps=1_000, double=double)
    seen: list[Progress] = []
    agent = train(gambles(task), config, callback=seen.append).agent
    judge = Judge(goal_or_dock(1), task)
    assert judge.satisfaction(agent.policy_table()) == pytest.approx(probability)
    if on_termination == "repeat":
        assert seen[-1].row.value == pytest.approx(0.9, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("config", [
    FuTopcuConfig(total_steps=40_000, accuracy=0.05), WangConfig(total_steps=40_000, accuracy=0.05),
    SadighConfig(total_steps=20_000),
])  # fmt: skip
def test_learners_of_a_model_learn_it(config: Any) -> None:
    task = Task("G F goal | G F dock")
    judge = Judge(goal_or_dock(1), task)
    agent = train(gambles(task), config).agent
    assert judge.satisfaction(agent.policy_table()) == pytest.approx(0.9, abs=0.01)
