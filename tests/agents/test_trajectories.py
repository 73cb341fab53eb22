"""Episodes of a policy, drawn where the world can be drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.training.collect import Interface
from ltlc.agents.training.trajectories import draw_episodes, scenes_of
from ltlc.envs import LTLVectorWrapper, VectorFlatWorld
from ltlc.pictures import trajectories


class East:
    """An agent that always goes one way."""

    n_actions, action_repeat = 9, 1

    def __init__(self, env: LTLVectorWrapper) -> None:
        self.encoder = ObservationEncoder(Interface.of(env).space)

    def packed_policy(self, packed: Any, states: Any) -> Any:
        return np.zeros(len(states), dtype=np.int64)

    def reseed(self, seed: int) -> None:
        pass


def test_episodes_are_drawn_until_they_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[trajectories.Trajectory] = []
    monkeypatch.setattr(
        "ltlc.agents.training.trajectories.draw_trajectories",
        lambda path, drawn, automaton, **titles: seen.extend(drawn) or path,
    )
    for envs in (VectorFlatWorld(3, max_episode_steps=500), gym.make_vec("ltlc/FlatWorld-v0", 3, "sync")):
        seen.clear()
        env = LTLVectorWrapper(envs, "G !outside")
        east: Any = East(env)
        assert draw_episodes(east, env, tmp_path / "east.png", max_steps=60, title="") == tmp_path / "east.png"
        assert len(seen) == 3
        for one in seen:
            assert len(one.places) == len(one.states)
            assert (np.diff(one.places[:, 0]) > 0).all()
            left = one.places[-1, 0] > 2
            assert one.caption == f"{len(one.places) - 1} steps" + (", violated" if left else ", going on")
        assert any("violated" in one.caption for one in seen)


def test_what_has_no_scene_is_not_drawn(tmp_path: Path) -> None:
    env = LTLVectorWrapper(gym.make_vec("ltlc/Grid-v0", num_envs=2), "F goal")
    assert scenes_of(env) == []
    assert draw_episodes(None, env, tmp_path / "none.png", max_steps=9, title="") is None  # type: ignore[arg-type]
