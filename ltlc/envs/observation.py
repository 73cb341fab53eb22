"""Observations of a product: what the environment shows, together with the state of the automaton."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ltlc.errors import InvalidArgumentError, UnknownNameError

ObservationMode = Literal["dict", "flat", "index", "none"]
MODES: tuple[ObservationMode, ...] = ("dict", "flat", "index", "none")


def observer(mode: str, space: spaces.Space[Any], n_states: int) -> Observer:
    """The way of a mode to join observations of `space` with one of `n_states` states.

    * `dict`: {"observation": what the environment shows, "automaton": the state};
    * `flat`: one vector, the observation flattened as `gymnasium.spaces.flatten` does, then the state as one-hot;
    * `index`: one number, observation * n_states + state, for Discrete and MultiDiscrete spaces;
    * `none`: what the environment shows.

    Raises:
        UnknownNameError: there is no such mode.
        InvalidArgumentError: the mode does not work for this space.
    """
    kinds = {"dict": _DictObserver, "flat": _FlatObserver, "index": _IndexObserver, "none": Observer}
    if mode not in kinds:
        raise UnknownNameError("observation mode", mode, MODES)
    return kinds[mode](space, n_states)


class Observer:
    """Mode `none`, and the base of the others."""

    mode: ObservationMode = "none"

    def __init__(self, space: spaces.Space[Any], n_states: int) -> None:
        self.base = space
        self.n_states = n_states
        self.space = space

    def single(self, observation: Any, state: int) -> Any:
        """The joint observation."""
        return observation

    def batch(self, observations: Any, states: npt.NDArray[np.int64]) -> Any:
        """The joint observations of a batch; `states` is not used elsewhere and may be handed out."""
        return observations


class _DictObserver(Observer):
    mode = "dict"

    def __init__(self, space: spaces.Space[Any], n_states: int) -> None:
        super().__init__(space, n_states)
        self.space = spaces.Dict({"observation": space, "automaton": spaces.Discrete(n_states)})

    def single(self, observation: Any, state: int) -> Any:
        return {"observation": observation, "automaton": state}

    def batch(self, observations: Any, states: npt.NDArray[np.int64]) -> Any:
        # Key order as in the space, whose constructor sorts.
        return {"automaton": states, "observation": observations}


class _FlatObserver(Observer):
    mode = "flat"

    def __init__(self, space: spaces.Space[Any], n_states: int) -> None:
        super().__init__(space, n_states)
        flat = _flat_space(space)
        if not isinstance(flat, spaces.Box):
            raise InvalidArgumentError(
                f"observation mode 'flat' cannot flatten {_unflattened(space)}; use 'dict', or put a wrapper around "
                "the environment that leaves this part out or turns it into an array"
            )
        self.dtype = flat.dtype if np.issubdtype(flat.dtype, np.floating) else np.dtype(np.float32)
        self.one_hot = np.eye(n_states, dtype=self.dtype)
        self.width = flat.shape[0]
        self.start = int(space.start) if isinstance(space, spaces.Discrete) else 0
        zeros = np.zeros(n_states, dtype=self.dtype)
        self.space = spaces.Box(
            np.concatenate([flat.low.astype(self.dtype), zeros]),
            np.concatenate([flat.high.astype(self.dtype), zeros + 1]),
            dtype=self.dtype.type,
        )

    def single(self, observation: Any, state: int) -> Any:
        joint = np.zeros(self.width + self.n_states, dtype=self.dtype)
        if isinstance(self.base, spaces.Discrete):
            joint[int(observation) - self.start] = 1
        elif isinstance(self.base, spaces.Box):
            joint[: self.width] = observation.ravel()
        else:
            joint[: self.width] = spaces.flatten(self.base, observation)
        joint[self.width + state] = 1
        return joint

    def batch(self, observations: Any, states: npt.NDArray[np.int64]) -> Any:
        n = len(states)
        flat = _flatten_batch(self.base, observations, n)
        return np.concatenate((*flat, self.one_hot[states]), axis=1, dtype=self.dtype, casting="unsafe")


class _IndexObserver(Observer):
    mode = "index"

    def __init__(self, space: spaces.Space[Any], n_states: int) -> None:
        super().__init__(space, n_states)
        self.start = 0
        if isinstance(space, spaces.Discrete):
            size, self.start = int(space.n), int(space.start)
        elif isinstance(space, spaces.MultiDiscrete) and space.nvec.ndim == 1:
            size = int(np.prod(space.nvec))
        else:
            raise InvalidArgumentError(
                f"observation mode 'index' needs a Discrete or one-dimensional MultiDiscrete space, not {space}; "
                "use 'dict' or 'flat'"
            )
        self.space = spaces.Discrete(size * n_states)

    def single(self, observation: Any, state: int) -> Any:
        if isinstance(self.base, spaces.MultiDiscrete):
            return int(np.ravel_multi_index(observation - self.base.start, self.base.nvec)) * self.n_states + state
        return (int(observation) - self.start) * self.n_states + state

    def batch(self, observations: Any, states: npt.NDArray[np.int64]) -> Any:
        if isinstance(self.base, spaces.MultiDiscrete):
            index = np.ravel_multi_index(tuple((observations - self.base.start).T), self.base.nvec)
        else:
            index = observations - self.start
        return index * self.n_states + states


def _flatten_batch(space: spaces.Space[Any], observations: Any, n: int) -> list[npt.NDArray[Any]]:
    """The columns of `gymnasium.spaces.flatten`, for a batch: arrays of shape (n, width)."""
    match space:
        case spaces.Box() | spaces.MultiBinary():
            return [np.reshape(observations, (n, -1))]
        case spaces.Discrete():
            return [_one_hot(observations - space.start, int(space.n))]
        case spaces.MultiDiscrete():
            values = np.reshape(observations - space.start, (n, -1))
            return [_one_hot(values[:, i], int(size)) for i, size in enumerate(space.nvec.ravel())]
        case spaces.Dict():
            return [part for key, sub in space.items() for part in _flatten_batch(sub, observations[key], n)]
        case spaces.Tuple():
            pairs = zip(space.spaces, observations, strict=True)
            return [part for sub, values in pairs for part in _flatten_batch(sub, values, n)]
    # what Gymnasium does not batch comes as a tuple
    return [np.stack([np.asarray(spaces.flatten(space, one)) for one in observations])]


def _unflattened(space: spaces.Space[Any], name: str = "the observation") -> str:
    """The parts of a space that have no flat form, for a message."""
    if isinstance(space, spaces.Dict | spaces.Tuple):
        items = space.items() if isinstance(space, spaces.Dict) else enumerate(space)
        parts = [_unflattened(inner, f"{name}[{key!r}]") for key, inner in items]
        return " and ".join(filter(None, parts))
    return "" if isinstance(_flat_space(space), spaces.Box) else f"{name}, which is {space}"


def _flat_space(space: spaces.Space[Any]) -> spaces.Space[Any]:
    try:
        return spaces.flatten_space(space)
    except NotImplementedError:  # a space of somebody's own, such as MiniGrid's missions
        return space


def _one_hot(values: npt.NDArray[np.int64], size: int) -> npt.NDArray[np.float32]:
    one_hot = np.zeros((len(values), size), dtype=np.float32)
    one_hot[np.arange(len(values)), values] = 1
    return one_hot
