"""Values that begin with a potential of margins: what they begin with, that targets stay, and that it helps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

import ltlc
from ltlc.agents import DoubleDQN, DQNConfig, train
from ltlc.agents.training.collect import Interface
from ltlc.envs import LTLVectorWrapper, RobustLTLVectorWrapper, comparisons
from ltlc.errors import InvalidArgumentError

VARIABLES = {"x": 0}
NEAR: dict[str, Any] = {"robustness": 0.5, "robustness_scale": 5.0, "variables": "x=0"}


class Far(gymnasium.Env[Any, int]):
    """A point on a line that moves by 0.2 a step, from near 0; beside it stands a number that says nothing."""

    observation_space = spaces.Box(-10, 10, (2,), np.float32)
    action_space = spaces.Discrete(3)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.state = self.np_random.uniform(-1, 1, 2)
        return self.state.astype(np.float32), {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.state[0] = np.clip(self.state[0] + 0.2 * (action - 1), -10, 10)
        return self.state.astype(np.float32), 0.0, False, False, {}


def plain(task: ltlc.Task, n: int = 4) -> LTLVectorWrapper:
    envs = SyncVectorEnv([far()] * n)
    return LTLVectorWrapper(envs, task, batch_labels=comparisons(task.automaton, VARIABLES))


def far() -> Callable[[], Any]:
    return lambda: gymnasium.wrappers.TimeLimit(Far(), 200)


def agent(text: str, **changes: Any) -> DoubleDQN:
    values: dict[str, Any] = {"hidden": (8,), **NEAR, **changes}
    return DoubleDQN(Far.observation_space, 3, ltlc.Task(text).tables, DQNConfig(**values))


@pytest.mark.parametrize("output", ["bounded", "linear"])
def test_values_begin_with_the_potential(output: str) -> None:
    near, without = (agent('F "x > 4" | G F "x < -4"', output=output, robustness=w) for w in (0.5, 0.0))
    places = np.array([[-9.0, 0.0], [-4.5, 0.0], [0.0, 0.0], [3.0, 1.0], [3.9, -1.0]], dtype=np.float32)
    values, others = near.q_values(places).mean(axis=-1), without.q_values(places).mean(axis=-1)
    right, left = 0.5 + 0.5 * np.tanh((places[:, 0] - 4) / 5), 0.5 + 0.5 * np.tanh((-4 - places[:, 0]) / 5)
    start = near.tables.initial_state
    gain = 1 / len({*near.tables.progress[near.tables.progress > 0]})
    hoped = 0.5 * (near.tables.progress[start] + gain * np.maximum(right, left))
    assert values[:, start] == pytest.approx(hoped + (others[:, start] if output == "linear" else 0), abs=0.06)


def test_targets_do_not_know_of_it() -> None:
    near, without = (agent('F "x > 4"', robustness=w) for w in (0.5, 0.0))
    generator = torch.Generator().manual_seed(0)
    worth = torch.rand((3, 4, near.tables.n_states, 3), generator=generator)
    segments: Any = type("Segments", (), {})()
    segments.action = torch.randint(3, (3, 5), generator=generator)
    segments.letter_class = torch.randint(near.tables.n_classes, (3, 4, 1), generator=generator)
    segments.terminated = torch.rand((3, 4, 1), generator=generator) < 0.2
    segments.real = torch.ones((3, 5), dtype=torch.bool)
    segments.base_reward, segments.made = torch.zeros((3, 4, 1)), torch.ones((3, 4, 1), dtype=torch.bool)
    first, second = (learner.trace_loss.targets(segments, worth, worth) for learner in (near, without))
    assert torch.equal(first, second)


def test_a_wrapper_brings_it_along() -> None:
    task = ltlc.Task('F "x > 4"')
    wrapped = RobustLTLVectorWrapper(SyncVectorEnv([far()] * 2), task, VARIABLES, weight=0.25, scale=2.0)
    config, _ = DoubleDQN.fitted(DQNConfig(), Interface.of(wrapped))
    assert (config.robustness, config.robustness_scale, config.variables) == (0.25, 2.0, "x=0")
    options = {"total_steps": 400, "learning_starts": 100, "hidden": (8,), "log_every": 100}
    found = train(wrapped, DQNConfig(**options)).agent
    given = train(plain(task, 2), DQNConfig(**options, robustness=0.25, robustness_scale=2.0, variables="x=0")).agent
    places = np.zeros((1, 2), dtype=np.float32)
    assert found is not None
    assert given is not None
    assert np.array_equal(found.q_values(places), given.q_values(places))
    scales = {"x > 4": 2.0, "x < 1": 1.0}
    two = RobustLTLVectorWrapper(SyncVectorEnv([far()]), 'F "x > 4" & F "x < 1"', VARIABLES, scale=scales)
    with pytest.raises(InvalidArgumentError, match="one scale of margins"):
        DoubleDQN.fitted(DQNConfig(), Interface.of(two))


def test_files(tmp_path: Path) -> None:
    learner = agent('F "x > 4"')
    learner.save(tmp_path / "policy.pt")
    read = DoubleDQN.load(tmp_path / "policy.pt")
    places = np.random.default_rng(0).uniform(-9, 9, (5, 2)).astype(np.float32)
    assert np.array_equal(read.q_values(places), learner.q_values(places))


@pytest.mark.slow
def test_it_finds_what_is_far() -> None:
    task = ltlc.Task('F "x > 9.5"')
    found = {}
    for weight in (0.0, 0.5):
        learned = train(
            plain(task, 8), DQNConfig(total_steps=6000, horizon=100, **(NEAR | {"robustness": weight}))
        ).agent
        assert learned is not None
        env = ltlc.LTLWrapper(far()(), task, comparisons(task.automaton, VARIABLES), warn_discount=False)
        reached = 0
        for seed in range(10):
            observation, _ = env.reset(seed=seed)
            over = False
            while not over:
                action = learned.policy(observation["observation"][None], [observation["automaton"]])[0]
                observation, _, terminated, truncated, _ = env.step(int(action))
                over = terminated or truncated
            reached += terminated
        found[weight] = reached
        values = learned.q_values(np.array([[9.4, 0.0], [-9.0, 0.0]], dtype=np.float32))
        assert (values >= 0).all()
        assert (values <= 1.0 + 1e-6).all()
    assert found[0.0] == 0
    assert found[0.5] >= 8


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variables": ""}, "robustness needs variables"),
        ({"trace_length": 1}, "a trace_length of at least 2"),
        ({"variables": 3}, "variables is 3; it must be a text"),
        ({"robustness": -1.0}, "robustness is -1.0; it must be a number in"),
        ({"variables": "x"}, "'x' is no variable with its place"),
        ({"variables": "x=7"}, "the variable 'x' is no number at observation"),
    ],
)
def test_errors(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        agent('F "x > 4"', **changes).q_values(np.zeros((1, 2), dtype=np.float32))
    with pytest.raises(InvalidArgumentError, match="propositions that compare numbers; here: 'goal'"):
        agent("F goal")
