"""Observations of many spaces as rows of numbers for the replay buffer, and from there as inputs for a network."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.errors import InvalidArgumentError

from .config import ObservationInput

JOINT_LIMIT = 4096
"""the numbers of a MultiDiscrete share one indicator vector if it has at most so many entries, else have one each."""
UNBOUNDED = 1e6
"""a Box with a bound beyond this is not scaled."""


@dataclass(frozen=True)
class _Leaf:
    """A space without parts, and where it stands in an observation and in a packed row."""

    path: tuple[str | int, ...]
    space: spaces.Space[Any]
    kind: type[np.generic]
    """of its numbers in a packed row."""
    columns: slice


class ObservationEncoder:
    """Turns batched observations into packed rows, and packed rows into network inputs.

    Discrete and MultiDiscrete become indicator vectors (`one-hot`) or plain numbers (`raw`), MultiBinary 0 and 1. A Box
    is flattened; where it is bounded, `one-hot` also scales it to [-1, 1]. Dict and Tuple are joined part by part.

    Args:
        space: of a single observation.
        mode: see `DQNConfig.observation_input`.

    Attributes:
        width: columns of a packed row.
        dtype: of a packed row: of the numbers if all are of one kind, else uint8, and the columns are their bytes.
        n_features: columns of a network input.
        n_observations: how many observations there are, or 0 if they are not numbered (parts, numbers that are not
            discrete, more than `JOINT_LIMIT`).

    Raises:
        InvalidArgumentError: the space has a part that is none of these.
    """

    def __init__(self, space: spaces.Space[Any], mode: ObservationInput = "one-hot") -> None:
        self.space, self.mode = space, mode
        parts = [(path, part, _packed_kind(part)) for path, part in _parts(space, ())]
        kinds = {kind for _, _, kind in parts}
        self._in_bytes = len(kinds) > 1
        self.dtype: npt.DTypeLike = np.uint8 if self._in_bytes else kinds.pop()
        self._leaves, self.width = [], 0
        for path, part, kind in parts:
            start = self.width
            self.width += math.prod(part.shape or (1,)) * (np.dtype(kind).itemsize if self._in_bytes else 1)
            self._leaves.append(_Leaf(path, part, kind, slice(start, self.width)))
        self.n_features = int(self.features(torch.from_numpy(self.pack(_example(space)))).shape[1])
        self._digits = self._leaves[0].space if len(self._leaves) == 1 else None
        countable = isinstance(self._digits, spaces.Discrete | spaces.MultiDiscrete)
        size = math.prod(_sizes(self._digits)) if countable and self._digits is not None else 0
        self.n_observations = size if size <= JOINT_LIMIT else 0

    def pack(self, observations: Any) -> npt.NDArray[Any]:
        """Packed rows of a batch of observations, shape (batch, width).

        Raises:
            InvalidArgumentError: a number is not finite, or the batch does not fit the space.
        """
        parts = []
        for leaf in self._leaves:
            part = observations
            for key in leaf.path:
                part = part[key]
            array = np.asarray(part)
            size = math.prod(leaf.space.shape or (1,))
            if array.ndim == 0 or array.size != len(array) * size:
                name = f" (part {leaf.path})" if leaf.path else ""
                raise InvalidArgumentError(f"observations of shape {array.shape}{name} do not fit {leaf.space}")
            if array.dtype.kind == "f" and not np.isfinite(array).all():
                raise InvalidArgumentError(
                    f"an observation has an entry that is NaN or infinite, in part {leaf.path or 'all'}; "
                    "repair the environment, or clip its observations with a wrapper"
                )
            rows = np.ascontiguousarray(array.reshape(len(array), size), dtype=leaf.kind)
            parts.append(rows.view(np.uint8) if self._in_bytes else rows)
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    def features(self, packed: Tensor) -> Tensor:
        """Network inputs of packed rows, shape (batch, n_features), float32."""
        parts = [self._leaf_features(leaf.space, self._numbers(leaf, packed)) for leaf in self._leaves]
        return parts[0] if len(parts) == 1 else torch.cat(parts, dim=1)

    def index(self, packed: Tensor) -> Tensor:
        """Number of each row among the `n_observations`, shape (batch,), int64."""
        assert self.n_observations and self._digits is not None
        return _joint_index(_from_zero(self._digits, packed), _sizes(self._digits))

    def all_observations(self) -> Any:
        """All `n_observations` as a batch, in the order of `index`."""
        assert self.n_observations and self._digits is not None
        digits = np.stack(np.unravel_index(np.arange(self.n_observations), _sizes(self._digits)), axis=1)
        start = np.asarray(self._digits.start)  # type: ignore[attr-defined]
        batch: Any = np.asarray(digits.reshape(-1, *(self._digits.shape or ())) + start)
        for key in reversed(self._leaves[0].path):
            batch = {key: batch}
        return batch

    def all_features(self) -> Tensor:
        """Network inputs of all `n_observations`, in the order of `index`, shape (n_observations, n_features)."""
        return self.features(torch.from_numpy(self.pack(self.all_observations())))

    def _numbers(self, leaf: _Leaf, packed: Tensor) -> Tensor:
        """What the rows hold of one part."""
        columns = packed[:, leaf.columns]
        if not self._in_bytes:
            return columns
        kind = torch.from_numpy(np.zeros(0, dtype=leaf.kind)).dtype
        return columns.clone(memory_format=torch.contiguous_format).view(kind)

    def _leaf_features(self, space: spaces.Space[Any], packed: Tensor) -> Tensor:
        if isinstance(space, spaces.Box):
            flat = packed.to(torch.float32)
            low, high = space.low.ravel().astype(np.float64), space.high.ravel().astype(np.float64)
            bounded = (low > -UNBOUNDED) & (high < UNBOUNDED) & (high > low)
            if self.mode == "raw" or not bounded.any():
                return flat
            low, high = np.where(bounded, low, -1.0), np.where(bounded, high, 1.0)
            center, radius = (low + high) / 2, (high - low) / 2
            return (flat - _like(center, flat)) / _like(radius, flat)
        if isinstance(space, spaces.MultiBinary) or self.mode == "raw":
            return packed.to(torch.float32)
        return _one_hot(_from_zero(space, packed), _sizes(space))


def _parts(
    space: spaces.Space[Any], path: tuple[str | int, ...]
) -> Iterator[tuple[tuple[str | int, ...], spaces.Space[Any]]]:
    if isinstance(space, spaces.Dict | spaces.Tuple):
        parts = space.spaces.items() if isinstance(space, spaces.Dict) else enumerate(space.spaces)
        for key, part in parts:
            yield from _parts(part, (*path, key))
    elif isinstance(space, spaces.Discrete | spaces.MultiDiscrete | spaces.MultiBinary | spaces.Box):
        yield path, space
    else:
        where = f" (part {path})" if path else ""
        raise InvalidArgumentError(
            f"the agent cannot take observations of {space}{where}; it takes Discrete, MultiDiscrete, MultiBinary, Box "
            "and Dict or Tuple of these. Wrap the environment in gymnasium.wrappers.TransformObservation"
        )


def _packed_kind(space: spaces.Space[Any]) -> type[np.generic]:
    """The smallest kind that holds the numbers as well as a network takes them."""
    if isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        return np.int64
    if isinstance(space, spaces.MultiBinary) or space.dtype in (np.uint8, np.bool_):
        return np.uint8
    return space.dtype.type if space.dtype in (np.int8, np.int16) else np.float32


def _sizes(space: spaces.Space[Any]) -> list[int]:
    return [int(space.n)] if isinstance(space, spaces.Discrete) else np.ravel(space.nvec).tolist()  # type: ignore[attr-defined]


def _from_zero(space: spaces.Space[Any], packed: Tensor) -> Tensor:
    """The discrete numbers of packed rows, counted from 0."""
    start = torch.as_tensor(np.asarray(space.start).ravel(), device=packed.device)  # type: ignore[attr-defined]
    return packed.to(torch.int64) - start


def _joint_index(digits: Tensor, sizes: list[int]) -> Tensor:
    index = digits[:, 0]
    for column, size in enumerate(sizes[1:], start=1):
        index = index * size + digits[:, column]
    return index


def _one_hot(digits: Tensor, sizes: list[int]) -> Tensor:
    """Indicator vectors of rows of digits: one of the whole row where that is small enough, else one per digit."""
    if math.prod(sizes) <= JOINT_LIMIT:
        return torch.nn.functional.one_hot(_joint_index(digits, sizes), math.prod(sizes)).to(torch.float32)
    columns = [torch.nn.functional.one_hot(digits[:, i], size) for i, size in enumerate(sizes)]
    return torch.cat(columns, dim=1).to(torch.float32)


def _like(values: npt.NDArray[np.float64], tensor: Tensor) -> Tensor:
    return torch.as_tensor(values, dtype=tensor.dtype, device=tensor.device)


def _example(space: spaces.Space[Any]) -> Any:
    """A batch of one valid observation, made without drawing random numbers."""
    if isinstance(space, spaces.Dict):
        return {key: _example(part) for key, part in space.spaces.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(_example(part) for part in space.spaces)
    if isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        return np.asarray(space.start)[None]
    return np.zeros((1, *(space.shape or ())), dtype=space.dtype)
