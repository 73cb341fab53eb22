"""Labels of the environments of others that `deep.py` trains in, and MiniGrid worlds that show images only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym

MINIGRID = ("LavaGapS5", "DoorKey-5x5")


def cart(observation: Any) -> dict[str, bool]:
    """CartPole: where the cart is, and whether the pole stands."""
    position, _, angle, _ = observation.tolist()
    return {"left": position < -0.5, "right": position > 0.5, "upright": abs(angle) < 0.2}


def car(observation: Any) -> dict[str, bool]:
    """MountainCar: below the flag, where the episode would end, and at the bottom."""
    position = float(observation[0])
    return {"top": position > 0.4, "valley": abs(position + 0.5) < 0.1}


def robot(observation: Any, info: Mapping[str, Any], env: Any) -> dict[str, bool]:
    """MiniGrid: what the robot stands on and carries, and whether a door is open."""
    world = env.unwrapped
    below = world.grid.get(*world.agent_pos)
    kind = below.type if below is not None else "floor"
    doors = [cell for cell in world.grid.grid if cell is not None and cell.type == "door"]
    return {
        "goal": kind == "goal",
        "lava": kind == "lava",
        "key": world.carrying is not None and world.carrying.type == "key",
        "door": any(door.is_open for door in doors),
    }


def make(name: str) -> gym.Env[Any, Any]:
    """A world of MiniGrid without its mission, whose text is always the same."""
    import minigrid  # noqa: F401 - registers its worlds
    from minigrid.wrappers import ImgObsWrapper

    return ImgObsWrapper(gym.make(name))


for short in MINIGRID:
    if f"deep/{short}-v0" not in gym.registry:
        gym.register(f"deep/{short}-v0", make, kwargs={"name": f"MiniGrid-{short}-v0"}, max_episode_steps=200)
