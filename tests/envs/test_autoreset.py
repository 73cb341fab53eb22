"""Around an environment that resets itself, the automaton starts over."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium.wrappers import Autoreset, TimeLimit
from vector_rollouts import TASKS, assert_same

from ltlc.envs import LTLWrapper
from ltlc.task import Task


def stacks() -> list[Callable[[], gym.Env]]:
    return [
        lambda: Autoreset(RandomEnv()),
        lambda: TimeLimit(Autoreset(RandomEnv()), 10_000),
        lambda: Autoreset(TimeLimit(RandomEnv(), 6)),
        lambda: gym.wrappers.RecordEpisodeStatistics(Autoreset(TimeLimit(RandomEnv(), 6))),
    ]


@pytest.mark.parametrize("number", range(4))
@pytest.mark.parametrize("reward", ["replace", "add", "info"])
@pytest.mark.parametrize("task", range(len(TASKS)))
def test_around_autoreset_the_automaton_starts_over(number: int, reward: str, task: int) -> None:
    """Against a loop that resets by hand, in which nothing resets by itself."""
    arguments: dict[str, Any] = {"reward": reward, "success_key": True, "flat_info": True}
    inner = RandomEnv() if number < 2 else TimeLimit(RandomEnv(), 6)
    by_hand = LTLWrapper(inner, TASKS[task](), **arguments)
    by_itself = LTLWrapper(stacks()[number](), TASKS[task](), **arguments)
    expected, got = by_hand.reset(seed=5), by_itself.reset(seed=5)
    assert_same(expected[0], got[0])
    over, episodes = False, 0
    for _ in range(200):
        step = by_itself.step(1)
        if over:
            observation, info = by_hand.reset()
            want: Any = (observation, 0.0, False, False, info)
        else:
            want = by_hand.step(1)
        got_info = dict(step[4])
        got_info.pop("episode", None)
        assert got_info["ltl"].pop("valid") is not over
        assert_same(want[0], step[0])
        assert want[1:4] == step[1:4]
        assert_same(want[4], got_info)
        over = step[2] or step[3]
        episodes += over
    assert episodes > 10


def test_choices_of_pairs_around_autoreset() -> None:
    task = Task("FG a | FG b", "zeta-discount", acceptance="transition")
    env = LTLWrapper(Autoreset(RandomEnv(end=0.3)), task)
    env.reset(seed=0)
    over, chosen = False, 0
    for _ in range(100):
        action = int(np.flatnonzero(env.action_masks())[-1])
        _, _, terminated, truncated, info = env.step(action)
        assert info["ltl"]["valid"] is not over
        chosen += action >= 2
        over = terminated or truncated
    assert chosen
