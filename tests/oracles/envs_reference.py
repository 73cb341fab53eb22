"""A small random environment, and a plain reading of what the wrapper has to do."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import find_highest_version

from ltlc.automata import DRA
from ltlc.rewards import RewardTables

NAMES = ("a", "b")


class RandomEnv(gym.Env):
    """Walks at random over Discrete(6) or a Box; labels a and b are drawn at each step; ends now and then."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 4}  # noqa: RUF012
    propositions = NAMES

    def __init__(self, kind: str = "discrete", end: float = 0.1, render_mode: str | None = None) -> None:
        self.kind, self.end, self.render_mode = kind, end, render_mode
        self.observation_space: spaces.Space = {
            "discrete": spaces.Discrete(6, start=2),
            "box": spaces.Box(-1, 1, (2, 2), np.float64),
            "multi": spaces.MultiDiscrete([3, 4]),
            "dict": spaces.Dict({"x": spaces.Box(0, 1, (3,), np.float32), "n": spaces.Discrete(3)}),
        }[kind]
        self.action_space = spaces.Discrete(2)
        self.options: dict[str, Any] | None = None

    def _see(self) -> tuple[Any, dict[str, Any]]:
        rng = self.np_random
        observation = {
            "discrete": lambda: int(rng.integers(2, 8)),
            "box": lambda: rng.uniform(-1, 1, (2, 2)),
            "multi": lambda: rng.integers(0, (3, 4)),
            "dict": lambda: {"x": rng.random(3, dtype=np.float32), "n": int(rng.integers(3))},
        }[self.kind]()
        letter = int(rng.integers(4))
        return observation, {"labels": frozenset(n for i, n in enumerate(NAMES) if letter >> i & 1), "coin": letter}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.options = options
        return self._see()

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        terminated = bool(self.np_random.random() < self.end)
        truncated = bool(self.np_random.random() < self.end)
        observation, info = self._see()
        return observation, float(self.np_random.random()), terminated, truncated, info

    def render(self) -> Any:
        return np.zeros((8, 8, 3), dtype=np.uint8)


def no_sink_automaton(seed: int) -> DRA:
    from rewards_reference import random_automaton

    return random_automaton(seed, n_states=5, n_pairs=1, density=0.25)


def follow(tables: RewardTables, letters: list[int], skip: bool = False) -> list[dict[str, Any]]:
    """State, reward, discount, violated, accepting of an episode without chance, letter by letter."""
    state = tables.initial_state
    if not skip:
        state = int(tables.next_state[state, tables.letter_class[letters[0]]])
    log: list[dict[str, Any]] = [{"state": state}]
    for letter in letters[1:]:
        at = state, int(tables.letter_class[letter])
        state = int(tables.next_state[at])
        log.append({
            "state": state,
            "label": letter,
            "letter_class": at[1],
            "reward": float(tables.reward[at] + (tables.stop_reward[at] if tables.stop[at] == 1 else 0)),
            "discount": float(tables.discount[at]),
            "violated": bool(tables.violated[at]),
            "accepting": bool(tables.accepted[at]),
            "progress": float(tables.progress[state]),
            "stop": tables.stop[at] == 1,
        })  # fmt: skip
    return log


def newest(name: str) -> str:
    """The name with the highest version that this release of Gymnasium has."""
    return f"{name}-v{find_highest_version(None, name)}"
