"""Masks of an environment's own: both wrappers pass them on, together with those of the choice of a pair."""

from __future__ import annotations

from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv, newest
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from vector_rollouts import RESETS, TASKS, N, run

from ltlc.envs import LTLVectorWrapper, LTLWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.task import Task


class Masked(RandomEnv):
    """Draws a mask at each step, and shows it in the observation or the info."""

    def __init__(self, where: str = "info") -> None:
        super().__init__("dict")
        self.where = where
        if where == "observation":
            self.observation_space["action_mask"] = spaces.MultiBinary(2)

    def _see(self) -> tuple[Any, dict[str, Any]]:
        observation, info = super()._see()
        self.mask = self.np_random.integers(0, 2, 2).astype(np.int8)
        shown = observation if self.where == "observation" else info
        return observation, info | (shown.update(action_mask=self.mask) or {})


def _wrapped(where: str, task: Task) -> LTLWrapper:
    return LTLWrapper(Masked(where), task)


@pytest.mark.parametrize("where", ["observation", "info"])
@pytest.mark.parametrize("mode", RESETS)
def test_masks_are_the_same_in_both_wrappers(mode: AutoresetMode, where: str) -> None:
    for task in (TASKS[0](), TASKS[3](), Task("FG a | FG b", "zeta-discount", acceptance="transition")):
        one_by_one = SyncVectorEnv([partial(_wrapped, where, task)] * N, autoreset_mode=mode)
        together = LTLVectorWrapper(SyncVectorEnv([partial(Masked, where)] * N, autoreset_mode=mode), task)
        assert run(one_by_one, together, 60, mode)["begun" if mode == AutoresetMode.NEXT_STEP else "terminated"]


def test_a_mask_is_that_of_the_environment_and_of_the_pairs() -> None:
    for where in ("observation", "info"):
        task = Task("FG a | FG b", "zeta-discount", acceptance="transition")
        env = LTLWrapper(Masked(where), task)
        _, info = env.reset(seed=3)
        for step in range(60):
            inner = env.unwrapped.mask.astype(bool)
            expected = env.choices.mask[info["ltl"]["state"]] & np.tile(inner if inner.any() else [True] * 2, 3)
            assert info["ltl"]["action_mask"].tolist() == env.action_masks().tolist() == expected.tolist()
            *_, over, cut, info = env.step(int(np.flatnonzero(expected)[step % expected.sum()]))
            if over or cut:
                _, info = env.reset()


def test_taxi_shows_its_masks() -> None:
    task = Task("F there", "eventual")
    env = LTLWrapper(gym.make(newest("Taxi")), task, {"there": lambda place: place == 0})
    vector = LTLVectorWrapper(gym.make_vec(newest("Taxi"), num_envs=3), task, {"there": lambda place: place == 0})
    infos, info = vector.reset(seed=5)[1], env.reset(seed=5)[1]
    for action in (0, 1, 3, 4):
        assert info["ltl"]["action_mask"].tolist() == info["action_mask"].tolist()
        assert infos["ltl"]["action_mask"][0].tolist() == info["action_mask"].tolist()
        infos, info = vector.step(np.full(3, action))[4], env.step(action)[4]


def test_masks_of_another_shape_are_refused() -> None:
    env = Masked()
    env.action_space = spaces.Discrete(3)
    with pytest.raises(InvalidArgumentError, match=r"'action_mask' .* has shape \(2,\); it must be \(3,\)"):
        LTLWrapper(env, "F a").reset(seed=0)
