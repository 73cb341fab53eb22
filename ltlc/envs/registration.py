"""Names of the worlds in Gymnasium's registry."""

from __future__ import annotations

from typing import Any

import gymnasium as gym

_GRID = {"entry_point": "ltlc.envs.grid:GridWorld", "vector_entry_point": "ltlc.envs.grid:VectorGridWorld"}
_THESIS = {
    "entry_point": "ltlc.envs.thesis:thesis_world",
    "vector_entry_point": "ltlc.envs.thesis:thesis_vector_world",
}
_ENVS: dict[str, dict[str, Any]] = {
    "ltlc/Grid-v0": {**_GRID, "kwargs": {"map": ("S...", ".#..", "...g"), "labels": {"g": "goal"}}},
    "ltlc/Thesis10x10-v0": {**_THESIS, "kwargs": {"size": "10x10"}},
    "ltlc/Thesis10x10Dynamic-v0": {**_THESIS, "kwargs": {"size": "10x10", "dynamic": True}},
    "ltlc/Thesis5x5-v0": {**_THESIS, "kwargs": {"size": "5x5"}},
    "ltlc/Thesis5x5Dynamic-v0": {**_THESIS, "kwargs": {"size": "5x5", "dynamic": True}},
    "ltlc/FlatWorld-v0": {
        "entry_point": "ltlc.envs.flat_world:FlatWorld",
        "vector_entry_point": "ltlc.envs.flat_world:VectorFlatWorld",
        "max_episode_steps": 500,
    },
    "ltlc/LetterWorld-v0": {
        "entry_point": "ltlc.envs.letter_world:LetterWorld",
        "vector_entry_point": "ltlc.envs.letter_world:VectorLetterWorld",
        "max_episode_steps": 75,
    },
    "ltlc/Zone8-v0": {
        "entry_point": "ltlc.envs.zone_world:ZoneWorld",
        "vector_entry_point": "ltlc.envs.zone_world:VectorZoneWorld",
        "max_episode_steps": 1000,
    },
}


def register_envs() -> None:
    """Register the worlds with Gymnasium; those already there are left alone.

    Grid worlds do not limit their episodes: pass `max_episode_steps` to `gymnasium.make`.
    """
    for name, spec in _ENVS.items():
        if name not in gym.registry:
            gym.register(id=name, **spec)
