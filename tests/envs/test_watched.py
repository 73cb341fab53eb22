"""An environment that a monitor watches is the same environment."""

from __future__ import annotations

import gymnasium as gym
import pytest

from ltlc import Verdict
from ltlc.envs import MonitorWrapper
from ltlc.errors import InvalidArgumentError

LAKE = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}


def test_nothing_changes_but_the_info() -> None:
    plain = gym.make("FrozenLake-v1")
    watched = MonitorWrapper(gym.make("FrozenLake-v1"), "F goal & G !hole", LAKE)
    verdicts = set()
    for episode in range(60):
        observation, info = plain.reset(seed=episode)
        same, more = watched.reset(seed=episode)
        assert (same, {**info, "monitor": more["monitor"]}) == (observation, more)
        over = False
        plain.action_space.seed(episode)
        while not over:
            action = plain.action_space.sample()
            *step, info = plain.step(action)
            *same_step, more = watched.step(action)
            assert same_step == step
            over = bool(step[2] or step[3])
            verdicts.add(more["monitor"])
            assert (more["monitor"] is Verdict.VIOLATED) == (step[0] in (5, 7, 11, 12))
    assert Verdict.VIOLATED in verdicts
    assert watched.observation_space == plain.observation_space


def test_it_is_made_again_from_its_arguments() -> None:
    watched = MonitorWrapper(gym.make("FrozenLake-v1"), "G !hole & F(goal & last)", LAKE, finite=True)
    assert watched._saved_kwargs["finite"] is True
    with pytest.raises(InvalidArgumentError):
        MonitorWrapper(3, "F a")  # type: ignore[arg-type]
