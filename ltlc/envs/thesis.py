"""The worlds of the thesis' case studies."""

from __future__ import annotations

from ltlc.envs.grid import GridWorld, Observation, VectorGridWorld
from ltlc.envs.grid_map import GridMap, Miss, Slip, grid_map
from ltlc.errors import UnknownNameError

_MAPS = {
    "10x10": """
..........
..........
..C....A..
...C......
.S..C.....
..B..C....
......C...
..........
........T.
..........
""",
    "5x5": """
C...B
..CC.
..S..
.....
A.C.T
""",
}
_SEEN = {"A": 0.8, "B": 0.8, "C": 0.05, "T": 0.8}
_SLIP = 0.4
"""0.6 for the action chosen, 0.1 for each of the four others."""


def thesis_map(size: str, *, dynamic: bool = False, slip: Slip = _SLIP, miss: Miss = "empty") -> GridMap:
    """The 10x10 world of case studies I and II, or the 5x5 world of the run-time comparison.

    Args:
        size: "10x10" or "5x5". The 5x5 layout is not recorded in the thesis; this one is from code of the time.
        dynamic: whether labels are seen with probability 0.8 (A, B, T) or 0.05 (C) only.
        slip: probability that an action turns out as one of the four others.
        miss: what a label that is not seen reads as, see `grid_map`; the thesis code holds the automaton.

    Raises:
        UnknownNameError: there is no such world.

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, chapter 5.
    """
    if size not in _MAPS:
        raise UnknownNameError("thesis world", size, _MAPS)
    return grid_map(_MAPS[size], labels=_SEEN if dynamic else None, slip=slip, miss=miss)


def thesis_world(
    size: str = "10x10",
    *,
    dynamic: bool = False,
    slip: Slip = _SLIP,
    miss: Miss = "empty",
    observation: Observation = "index",
    render_mode: str | None = None,
) -> GridWorld:
    """The world of `thesis_map` as an environment."""
    layout = thesis_map(size, dynamic=dynamic, slip=slip, miss=miss)
    return GridWorld(layout, observation=observation, render_mode=render_mode)


def thesis_vector_world(
    size: str = "10x10",
    num_envs: int = 1,
    *,
    dynamic: bool = False,
    slip: Slip = _SLIP,
    miss: Miss = "empty",
    observation: Observation = "index",
    max_episode_steps: int | None = None,
    autoreset_mode: str = "NextStep",
    render_mode: str | None = None,
) -> VectorGridWorld:
    """Many copies of the world of `thesis_map`, stepped together."""
    return VectorGridWorld(
        thesis_map(size, dynamic=dynamic, slip=slip, miss=miss),
        num_envs,
        observation=observation,
        max_episode_steps=max_episode_steps,
        autoreset_mode=autoreset_mode,
        render_mode=render_mode,
    )
