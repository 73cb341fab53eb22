"""Continuous actions as a list of a few: an environment for agents that choose from a list."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import ActionWrapper, Env, spaces
from gymnasium.vector import VectorActionWrapper, VectorEnv
from gymnasium.vector.utils import batch_space

from ltlc.errors import InvalidArgumentError, check_type

MOST = 4096
"""actions in a list, at most."""


def action_grid(space: spaces.Space[Any], points: int) -> npt.NDArray[Any]:
    """List the actions of a grid: so many values of each coordinate, from its least to its largest.

    Args:
        space: a bounded Box.
        points: per coordinate, at least 2.

    Returns:
        Shape (points ** n_coordinates, *space.shape), the last coordinate changing fastest.

    Raises:
        InvalidArgumentError: the space is no Box, has no bounds, or there are more than `MOST` actions.

    Example:
        >>> action_grid(spaces.Box(-1.0, 1.0, (1,)), 3).ravel().tolist()
        [-1.0, 0.0, 1.0]
    """
    if not isinstance(space, spaces.Box):
        raise InvalidArgumentError(f"only actions of a Box can be made discrete; these are {space}")
    low, high = space.low.ravel().astype(np.float64), space.high.ravel().astype(np.float64)
    if not np.isfinite([low, high]).all():
        raise InvalidArgumentError(
            f"the actions {space} have no bounds, so there is no grid of them; give a list: "
            "DiscretisedActions(env, actions=[...])"
        )
    if points < 2 or len(low) * math.log(points) > math.log(MOST):
        raise InvalidArgumentError(
            f"a grid of {points} points in each of {len(low)} coordinates; there must be 2 points at least, and "
            f"{MOST} actions at most. Give a list instead: DiscretisedActions(env, actions=[...])"
        )
    axes = [np.linspace(least, most, points) for least, most in zip(low, high, strict=True)]
    grid = np.array(list(itertools.product(*axes)))
    return grid.reshape(-1, *space.shape).astype(space.dtype)


def _listed(space: spaces.Space[Any], points: int, actions: npt.ArrayLike | None) -> npt.NDArray[Any]:
    if actions is None:
        return action_grid(space, points)
    if not isinstance(space, spaces.Box):
        raise InvalidArgumentError(f"only actions of a Box can be made discrete; these are {space}")
    listed = np.asarray(actions, dtype=space.dtype)
    if listed.shape[1:] != space.shape or not len(listed):
        raise InvalidArgumentError(
            f"actions of shape {listed.shape}; a list of actions of {space} has shape (n, *{space.shape})"
        )
    if not ((listed >= space.low) & (listed <= space.high)).all():
        raise InvalidArgumentError(f"an action in the list is outside of {space}")
    return listed


class DiscretisedActions(ActionWrapper[Any, Any, Any]):
    """Shows an environment of continuous actions as one with a list of them.

    Args:
        env: the environment; its actions are a Box.
        points: per coordinate of a grid from bound to bound.
        actions: the list itself, shape (n, *shape of an action); None: the grid.

    Raises:
        InvalidArgumentError: see `action_grid`, or the list does not fit the space.

    Example:
        >>> import gymnasium
        >>> env = DiscretisedActions(gymnasium.make("Pendulum-v1"), 5)
        >>> env.action_space, env.action(0).tolist()
        (Discrete(5), [-2.0])
    """

    def __init__(self, env: Env[Any, Any], points: int = 5, *, actions: npt.ArrayLike | None = None) -> None:
        check_type(env, Env, "env", "an environment of Gymnasium; DiscretisedVectorActions takes vector environments")
        super().__init__(env)
        self.actions = _listed(env.action_space, points, actions)
        self.action_space = spaces.Discrete(len(self.actions))

    def action(self, action: Any) -> npt.NDArray[Any]:
        """Look an action up in the list."""
        return np.asarray(self.actions[action])


class DiscretisedVectorActions(VectorActionWrapper):
    """`DiscretisedActions` for a vector environment; all sub-environments have one list.

    Args:
        env: the vector environment; its actions are a Box.
        points: see `DiscretisedActions`.
        actions: see `DiscretisedActions`.

    Raises:
        InvalidArgumentError: see `DiscretisedActions`.

    Example:
        >>> import gymnasium
        >>> envs = DiscretisedVectorActions(gymnasium.make_vec("Pendulum-v1", num_envs=2), 3)
        >>> envs.single_action_space, envs.actions([0, 2]).ravel().tolist()
        (Discrete(3), [-2.0, 2.0])
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], points: int = 5, *, actions: npt.ArrayLike | None = None) -> None:
        check_type(env, VectorEnv, "env", "a vector environment of Gymnasium")
        super().__init__(env)
        self.list = _listed(env.single_action_space, points, actions)
        self.single_action_space = spaces.Discrete(len(self.list))
        self.action_space = batch_space(self.single_action_space, env.num_envs)

    def actions(self, actions: Any) -> npt.NDArray[Any]:
        """Look the actions up in the list."""
        return np.asarray(self.list[np.asarray(actions)])
