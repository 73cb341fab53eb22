"""Agents do only what an environment allows, where it says so."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from ltlc.agents import DQNConfig, FittedQConfig, train
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.training.evaluate import rollout
from ltlc.envs import LTLVectorWrapper
from ltlc.task import Task

CONFIGS = [
    FittedQConfig(total_steps=2000, learning_starts=50, checkpoint_every=2000, log_every=500),
    DQNConfig(
        total_steps=1500, learning_starts=100, checkpoint_every=1500, log_every=500, hidden=(16,), temperature=0.0
    ),
]


class Corridor(gym.Env[Any, Any]):
    """Cells 0 to 4 in a row, of which the last is the goal; running against a wall, or jumping, is an exception."""

    propositions = ("goal",)

    def __init__(self, shown: str, seen: str = "number") -> None:
        self.shown, self.seen = shown, seen
        cell = spaces.Discrete(5) if seen == "number" else spaces.Box(0, 4, (1,), np.float32)
        inside = {"cell": cell, "action_mask": spaces.MultiBinary(3)}
        self.observation_space = spaces.Dict(inside) if shown == "observation" else cell
        self.action_space = spaces.Discrete(3)

    def _see(self) -> tuple[Any, dict[str, Any]]:
        self.mask = np.array([0, self.cell > 0, self.cell < 4], dtype=np.int8)
        info = {"labels": {"goal": self.cell == 4}}
        cell: Any = self.cell if self.seen == "number" else np.array([self.cell], dtype=np.float32)
        if self.shown == "observation":
            return {"cell": cell, "action_mask": self.mask}, info
        return cell, info | {"action_mask": self.mask}

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        self.cell, self.steps = int(self.np_random.integers(3)), 0
        return self._see()

    def step(self, action: Any) -> Any:
        assert self.mask[action], f"action {action} is forbidden in cell {self.cell}"
        self.cell, self.steps = self.cell + (-1 if action == 1 else 1), self.steps + 1
        observation, info = self._see()
        return observation, 0.0, False, self.steps >= 12, info


def wrapped(make: Any, task: str = "F goal", mode: AutoresetMode = AutoresetMode.NEXT_STEP, **arguments: Any) -> Any:
    return LTLVectorWrapper(SyncVectorEnv([make] * 4, autoreset_mode=mode), Task(task), **arguments)


@pytest.mark.parametrize("shown", ["observation", "info"])
@pytest.mark.parametrize("config", CONFIGS, ids=lambda config: type(config).__name__)
@pytest.mark.slow
def test_what_is_forbidden_is_never_done(config: Any, shown: str) -> None:
    for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
        env = wrapped(partial(Corridor, shown), mode=mode)
        result = train(env, config)
        assert rollout(result.agent, env, 12).satisfied.value == 1


@pytest.mark.slow
@pytest.mark.parametrize("changed", [{}, {"trace_length": 1}, {"trace_length": 1, "state_input": "one-hot"}], ids=str)
def test_networks_of_what_is_not_numbered(changed: dict[str, Any]) -> None:
    for task in ("F goal", "FG goal | G F !goal"):  # with a choice of a pair
        env = wrapped(partial(Corridor, "info", "position"), task)
        rollout(train(env, dataclasses.replace(CONFIGS[1], **changed)).agent, env, 8)


def test_masks_are_no_part_of_what_is_seen() -> None:
    space = spaces.Dict({"observation": spaces.Discrete(5), "action_mask": spaces.MultiBinary(3)})
    encoder = ObservationEncoder(space)
    assert encoder.n_observations == encoder.n_features == 5
    packed = encoder.pack({"observation": np.array([2, 4]), "action_mask": np.array([[1, 0, 1], [0, 0, 0]])})
    rows = torch.from_numpy(packed)
    assert packed.shape == (2, encoder.width) and encoder.index(rows).tolist() == [2, 4]
    assert encoder.allowed(rows).tolist() == [[True, False, True], [True] * 3]  # where nothing is, everything is
    unmasked = torch.from_numpy(encoder.pack(np.array([2, 4])))
    assert encoder.allowed(unmasked).all() and encoder.index(unmasked).tolist() == [2, 4]
    assert encoder.index(torch.from_numpy(encoder.pack(encoder.all_observations()))).tolist() == list(range(5))


@pytest.mark.slow
def test_taxi() -> None:
    """Without its masks, five of six actions do nothing in many places."""
    aboard = {"aboard": lambda place: place // 4 % 5 == 4}
    env = LTLVectorWrapper(gym.make_vec("Taxi-v4", num_envs=8, max_episode_steps=100), Task("F aboard"), aboard)
    config = FittedQConfig(total_steps=20_000, checkpoint_every=20_000, log_every=5_000)
    result = train(env, config)
    assert result.agent.encoder.n_observations == 500
    assert rollout(result.agent, env, 100).satisfied.value > 0.95
