"""Episodes of a learned policy in worlds that can be drawn."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv

from ltlc.envs import DrawnEnv, LTLVectorWrapper
from ltlc.pictures.trajectories import Trajectory, draw_trajectories
from ltlc.scene import Scene

from ..agent import Agent
from .collect import Collector, Episode, Interface


def draw_episodes(
    agent: Agent,
    env: LTLVectorWrapper,
    path: str | os.PathLike[str],
    *,
    max_steps: int,
    title: str,
    subtitle: str = "",
    seed: int = 0,
) -> Path | None:
    """Draw an episode of each sub-environment under the policy.

    Args:
        agent: the agent.
        env: the environments with the task.
        path: of the picture.
        max_steps: steps after which an episode is drawn as far as it has come.
        title: what stands above.
        subtitle: below it.
        seed: of the environments.

    Returns:
        The path that was written, or None where the environment has no method `scene`.

    Raises:
        OSError: the file cannot be written.
    """
    if not scenes_of(env):
        return None
    collector = Collector(Interface.of(env), agent.encoder)
    collector.reset(seed)
    agent.reseed(seed)
    scenes = scenes_of(env)
    places, states = [[scene.position for scene in scenes]], [env.automaton_state]
    ended: dict[int, Episode] = {}
    for _ in range(max_steps):
        collector.follow(agent)
        places.append([scene.position for scene in scenes_of(env)])
        states.append(env.automaton_state)
        for i, episode in collector.take_episodes():
            ended.setdefault(i, episode)
        if len(ended) == env.num_envs:
            break
    drawn = []
    for i, scene in enumerate(scenes):
        length = ended[i].length if i in ended else len(places) - 1
        trail = np.array([place[i] for place in places[: length + 1]])
        visited = np.array([state[i] for state in states[: length + 1]])
        drawn.append(Trajectory(scene, trail, visited, _caption(ended.get(i), length)))
    return draw_trajectories(path, drawn, env.task.automaton, title=title, subtitle=subtitle)


def scenes_of(env: VectorEnv[Any, Any, Any]) -> list[Scene]:
    """What there is to draw of all sub-environments now; empty where they cannot be drawn."""
    base: Any = env.unwrapped
    inner = getattr(base, "envs", None)
    if inner is not None:
        worlds = [one.unwrapped for one in inner]
        return [world.scene() for world in worlds] if all(isinstance(world, DrawnEnv) for world in worlds) else []
    return [base.scene(copy) for copy in range(env.num_envs)] if isinstance(base, DrawnEnv) else []


def _caption(episode: Episode | None, length: int) -> str:
    if episode is None:
        return f"{length} steps, going on"
    ending = ", violated" if episode.violations else f", {episode.acceptances} accepting" if episode.acceptances else ""
    return f"{length} steps{ending}"
