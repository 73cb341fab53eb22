"""Continuous actions as a list."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.envs import DiscretisedActions, DiscretisedVectorActions, LTLVectorWrapper, action_grid
from ltlc.errors import InvalidArgumentError


class Moved(gym.Env[Any, Any]):
    """Shows the action that it was given."""

    observation_space = spaces.Box(-9.0, 9.0, (2,))
    action_space = spaces.Box(np.array([-1, 0], np.float32), np.array([1, 4], np.float32))

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        return np.zeros(2, np.float32), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        assert self.action_space.contains(action)
        return np.asarray(action), 0.0, False, False, {}


GRID = [[-1, 0], [-1, 2], [-1, 4], [0, 0], [0, 2], [0, 4], [1, 0], [1, 2], [1, 4]]


def test_a_grid_goes_from_bound_to_bound() -> None:
    grid = action_grid(Moved.action_space, 3)
    assert grid.tolist() == GRID and grid.dtype == np.float32
    assert action_grid(spaces.Box(0.0, 1.0, (2, 2)), 2).shape == (16, 2, 2)


def test_actions_are_looked_up() -> None:
    one = DiscretisedActions(Moved(), 3)
    one.reset()
    assert one.action_space == spaces.Discrete(9)
    assert [one.step(i)[0].tolist() for i in range(9)] == GRID
    many = DiscretisedVectorActions(SyncVectorEnv([Moved] * 3), 3)
    many.reset()
    assert many.single_action_space == spaces.Discrete(9) and many.action_space.shape == (3,)
    assert many.step(np.array([8, 0, 5]))[0].tolist() == [GRID[8], GRID[0], GRID[5]]
    listed = DiscretisedActions(Moved(), actions=[[0.5, 3.0], [0.0, 0.0]])
    listed.reset()
    assert listed.action_space == spaces.Discrete(2) and listed.step(0)[0].tolist() == [0.5, 3.0]


@pytest.mark.parametrize(
    ("space", "arguments", "message"),
    [
        (spaces.Discrete(3), {}, "only actions of a Box"),
        (spaces.Discrete(3), {"actions": [1]}, "only actions of a Box"),
        (spaces.Box(-np.inf, 1.0, (1,)), {}, "have no bounds.*actions="),
        (spaces.Box(-1.0, 1.0, (9,)), {}, "4096 actions at most"),
        (spaces.Box(-1.0, 1.0, (1,)), {"points": 1}, "2 points at least"),
        (spaces.Box(-1.0, 1.0, (2,)), {"actions": [1.0, 0.0]}, "has shape"),
        (spaces.Box(-1.0, 1.0, (1,)), {"actions": [[2.0]]}, "outside"),
    ],
)
def test_what_is_no_list_of_actions(space: spaces.Space[Any], arguments: dict[str, Any], message: str) -> None:
    env = Moved()
    env.action_space = space  # type: ignore[assignment]
    with pytest.raises(InvalidArgumentError, match=message):
        DiscretisedActions(env, **arguments)


def test_the_message_has_a_line_to_copy() -> None:
    pytest.importorskip("torch")
    from ltlc.agents import DQNConfig, train

    def envs() -> SyncVectorEnv:
        return SyncVectorEnv([lambda: gym.wrappers.TimeLimit(Moved(), 5)] * 2)

    labels = {"up": lambda seen: seen[1] > 3}
    with pytest.raises(InvalidArgumentError, match=r"env = ltlc.envs.DiscretisedVectorActions\(env, 5\)"):
        train(LTLVectorWrapper(envs(), "F up", labels))
    env = LTLVectorWrapper(DiscretisedVectorActions(envs(), 5), "F up", labels)
    assert train(env, DQNConfig(total_steps=20)).agent.n_actions == 25


@pytest.mark.slow
def test_the_command_line_says_and_does_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    pytest.importorskip("torch")
    from ltlc.cli.app import run

    (tmp_path / "swing.py").write_text("def labels(seen):\n    return {'up'} if seen[0] > 0.9 else set()\n")
    monkeypatch.chdir(tmp_path)
    words = ["train", "F up", "-e", "Pendulum-v1", "--labels", "swing:labels", "--steps", "300", "--out", "run"]
    assert run(words) == 2
    assert "--discretise 5" in capsys.readouterr().err
    assert run([*words, "--discretise", "3"]) == 0
    assert run(["evaluate", "run", "--episodes", "4"]) == 0
