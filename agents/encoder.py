"""Observations of many spaces as rows of numbers for the replay buffer, and from there as inputs for a network."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.envs.action_masks import MASK, usable
from ltlc.errors import InvalidArgumentError

from .config import ObservationInput

JOINT_LIMIT = 4096
"""discrete numbers share one indicator vector if it has at most so many entries, else have one each."""
COUNTED = 1 << 20
"""observations are numbered if there are no more."""
_BASE = 64
"""a number of more values than `JOINT_LIMIT` is shown by its digits to this base, an indicator vector each."""
UNBOUNDED = 1e6
"""a Box with a bound beyond this is not scaled."""
EXACT = 1 << 24
"""whole numbers up to this are exact in a row of float32."""
_LONGEST = 1 << 20
"""numbers of a MultiBinary that are looked at one by one."""
Path = tuple[str | int, ...]


@dataclass(frozen=True)
class Leaf:
    """A space without parts, and where it stands in an observation, in a packed row and in a network input."""

    path: Path
    space: spaces.Space[Any]
    kind: type[np.generic]
    """of its numbers in a packed row."""
    columns: slice
    """of a packed row."""
    features: slice
    """of a network input."""
    sizes: list[int]
    """how many values each of its numbers has; empty where they are not whole numbers between bounds."""
    start: npt.NDArray[np.int64]
    """the least value of each, or of all of them."""
    scale: tuple[Tensor, Tensor] | None
    """centre and radius that its numbers are scaled by, float32; None: they are not."""


class ObservationEncoder:
    """Turns batched observations into packed rows, and packed rows into network inputs.

    Discrete and MultiDiscrete become indicator vectors (`one-hot`) or plain numbers (`raw`), MultiBinary 0 and 1. A Box
    is flattened; where it is bounded, `one-hot` also scales it to [-1, 1]. Dict and Tuple are joined part by part;
    texts in them are left out. What a network makes of images and of what has no bounds, `Trunk` says.

    An entry `action_mask` of a Dict, which says what actions are allowed, stands at the end of packed rows, and is
    neither an input nor tells observations apart.

    Args:
        space: of a single observation.
        mode: see `DQNConfig.observation_input`.

    Attributes:
        width: columns of a packed row.
        dtype: of a packed row: of the numbers if all are of one kind, else uint8, and the columns are their bytes.
        n_features: columns of a network input.
        leaves: the parts, without the mask.
        mask: the mask; None where there is none.
        discrete: whether all numbers are whole, so that observations can be told from each other by their rows.
        n_observations: how many observations there are, or 0 if they are not numbered (a part that is not discrete,
            more than `COUNTED`).
        ignored: names of the texts that are left out.

    Raises:
        InvalidArgumentError: the space has a part that is none of these.
    """

    def __init__(self, space: spaces.Space[Any], mode: ObservationInput = "one-hot") -> None:
        self.space, self.mode = space, mode
        parts = [(path, part) for path, part in _parts(space, ()) if not is_text(part)]
        parts.sort(key=lambda part: part[0] == (MASK,))  # the mask last, and all else as it was
        self.ignored = [_name(path) for path, part in _parts(space, ()) if is_text(part)]
        if not parts or parts[0][0] == (MASK,):
            raise InvalidArgumentError(f"the agent cannot take observations of {space}, which has no numbers")
        kinds = {_packed_kind(part) for _, part in parts}
        self._in_bytes = len(kinds) > 1
        self.dtype: npt.DTypeLike = np.uint8 if self._in_bytes else kinds.pop()
        self.leaves: list[Leaf] = []
        self.mask: Leaf | None = None
        self.width = self.n_features = 0
        for path, part in parts:
            kind, sizes = _packed_kind(part), _sizes(part)
            numbers = math.prod(part.shape or (1,))
            columns = slice(self.width, self.width + numbers * (np.dtype(kind).itemsize if self._in_bytes else 1))
            shown = 0 if path == (MASK,) else n_features(part, mode)
            features = slice(self.n_features, self.n_features + shown)
            self.leaves.append(Leaf(path, part, kind, columns, features, sizes, _start(part), _scale(part, mode)))
            self.width, self.n_features = columns.stop, features.stop
        if self.leaves[-1].path == (MASK,):
            self.mask = self.leaves.pop()
        self.discrete = all(leaf.sizes for leaf in self.leaves)
        self._sizes = [size for leaf in self.leaves for size in leaf.sizes] if self.discrete else []
        self.n_observations = _product(self._sizes, COUNTED) if self.discrete else 0

    def pack(self, observations: Any) -> npt.NDArray[Any]:
        """Packed rows of a batch of observations, shape (batch, width); without its mask, all actions are allowed.

        Raises:
            InvalidArgumentError: a number is not finite, or the batch does not fit the space.
        """
        parts: list[npt.NDArray[Any]] = []
        if self.mask is not None and not isinstance(observations, Mapping):
            observations = {"observation": observations}
        for leaf in self.leaves if self.mask is None else [*self.leaves, self.mask]:
            part = observations
            if leaf is self.mask and observations.get(MASK) is None:
                part = {MASK: np.ones((len(parts[0]), *(leaf.space.shape or ())))}
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
        parts = [self._leaf_features(leaf, self._numbers(leaf, packed)) for leaf in self.leaves]
        return parts[0] if len(parts) == 1 else torch.cat(parts, dim=1)

    def allowed(self, packed: Tensor) -> Tensor | None:
        """Which actions packed rows allow, shape (batch, n_actions), bool; None where there are no masks."""
        if self.mask is None:
            return None
        return usable(self._numbers(self.mask, packed) != 0)  # type: ignore[no-any-return]

    def index(self, packed: Tensor) -> Tensor:
        """Number of each row among the `n_observations`, shape (batch,), int64."""
        assert self.n_observations
        digits = [_from_zero(leaf, self._numbers(leaf, packed)) for leaf in self.leaves]
        return _joint_index(digits[0] if len(digits) == 1 else torch.cat(digits, dim=1), self._sizes)

    def all_observations(self) -> Any:
        """All `n_observations` as a batch, in the order of `index`."""
        assert self.n_observations
        digits = np.stack(np.unravel_index(np.arange(self.n_observations), self._sizes), axis=1)
        batches, first = {}, 0
        for leaf in self.leaves:
            numbers = digits[:, first : first + len(leaf.sizes)] + leaf.start
            first += len(leaf.sizes)
            dtype = leaf.space.dtype or np.int64
            batches[leaf.path] = numbers.astype(dtype).reshape(-1, *(leaf.space.shape or ()))
        return assembled(self.space, (), batches)

    def all_features(self) -> Tensor:
        """Network inputs of all `n_observations`, in the order of `index`, shape (n_observations, n_features)."""
        return self.features(torch.from_numpy(self.pack(self.all_observations())))

    def _numbers(self, leaf: Leaf, packed: Tensor) -> Tensor:
        """What the rows hold of one part."""
        columns = packed[:, leaf.columns]
        if not self._in_bytes:
            return columns
        kind = torch.from_numpy(np.zeros(0, dtype=leaf.kind)).dtype
        return columns.clone(memory_format=torch.contiguous_format).view(kind)

    def _leaf_features(self, leaf: Leaf, packed: Tensor) -> Tensor:
        if self.mode == "one-hot" and isinstance(leaf.space, spaces.Discrete | spaces.MultiDiscrete):
            return _one_hot(_from_zero(leaf, packed), leaf.sizes)
        flat = packed.to(torch.float32)
        if leaf.scale is None:
            return flat
        center, radius = (part.to(flat.device) for part in leaf.scale)
        return (flat - center) / radius


def n_features(space: spaces.Space[Any], mode: ObservationInput) -> int:
    """How many numbers describe an observation to a network, worked out without making any."""
    if isinstance(space, spaces.Dict | spaces.Tuple):
        parts = space.spaces.values() if isinstance(space, spaces.Dict) else space.spaces
        return sum(n_features(part, mode) for part in parts)
    if mode == "one-hot" and isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        sizes = _sizes(space)
        return _product(sizes, JOINT_LIMIT) or sum(sum(_bases(size)) for size in sizes)
    return 0 if is_text(space) else math.prod(space.shape or ())


def is_text(space: spaces.Space[Any]) -> bool:
    """Whether a space is one of texts, Gymnasium's or somebody's own."""
    kind = None if space.dtype is None else np.dtype(space.dtype).kind
    return isinstance(space, spaces.Text) or (space.shape is None and kind == "U")


def without_texts(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """The space with each part that is a text replaced by the same one, whoever's it was."""
    if isinstance(space, spaces.Dict):
        parts = {key: without_texts(part) for key, part in space.spaces.items()}
        return space if all(parts[key] is part for key, part in space.spaces.items()) else spaces.Dict(parts)
    if isinstance(space, spaces.Tuple):
        entries = [without_texts(part) for part in space.spaces]
        return (
            space if all(new is old for new, old in zip(entries, space.spaces, strict=True)) else spaces.Tuple(entries)
        )
    return spaces.Text(1) if is_text(space) else space


def bounds_of(space: spaces.Box) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Least and largest value of each number of a Box, and whether they are bounds to scale by; each flattened."""
    low, high = space.low.ravel().astype(np.float64), space.high.ravel().astype(np.float64)
    return low, high, (low > -UNBOUNDED) & (high < UNBOUNDED) & (high > low)


def _parts(space: spaces.Space[Any], path: Path) -> Iterator[tuple[Path, spaces.Space[Any]]]:
    if isinstance(space, spaces.Dict | spaces.Tuple):
        parts = space.spaces.items() if isinstance(space, spaces.Dict) else enumerate(space.spaces)
        for key, part in parts:
            yield from _parts(part, (*path, key))
    elif isinstance(space, spaces.Discrete | spaces.MultiDiscrete | spaces.MultiBinary | spaces.Box) or (
        path and is_text(space)
    ):
        yield path, space
    else:
        where = f" (part {path})" if path else ""
        raise InvalidArgumentError(
            f"the agent cannot take observations of {space}{where}; it takes Discrete, MultiDiscrete, MultiBinary, Box "
            "and Dict or Tuple of these. Wrap the environment in gymnasium.wrappers.TransformObservation"
        )


def _name(path: Path) -> str:
    return ".".join(map(str, path))


def assembled(space: spaces.Space[Any], path: Path, batches: dict[Path, Any]) -> Any:
    """A batch of a space, given those of its parts; without texts."""
    if isinstance(space, spaces.Dict):
        return {key: assembled(part, (*path, key), batches) for key, part in space.spaces.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(assembled(part, (*path, i), batches) for i, part in enumerate(space.spaces))
    return batches.get(path)


def _packed_kind(space: spaces.Space[Any]) -> type[np.generic]:
    """The smallest kind that holds the numbers as well as a network takes them."""
    if isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        return np.int64
    if isinstance(space, spaces.MultiBinary) or space.dtype in (np.uint8, np.bool_):
        return np.uint8
    return space.dtype.type if space.dtype in (np.int8, np.int16) else np.float32


def _sizes(space: spaces.Space[Any]) -> list[int]:
    """How many values each number of a part has; empty where they are not whole, or too large for a packed row."""
    match space:
        case spaces.Discrete():
            return [int(space.n)]
        case spaces.MultiDiscrete():
            return [int(size) for size in space.nvec.ravel()]
        case spaces.MultiBinary():
            return [2] * math.prod(space.shape) if math.prod(space.shape) <= _LONGEST else []
        case spaces.Box() if space.dtype is not None and space.dtype.kind in "iub":
            low, high, _ = bounds_of(space)
            exact = bool((low >= -EXACT).all() and (high <= EXACT).all())
            return (high - low + 1).astype(np.int64).tolist() if exact else []
    return []


def _start(space: spaces.Space[Any]) -> npt.NDArray[np.int64]:
    if isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        return np.asarray(space.start, dtype=np.int64).ravel()
    if isinstance(space, spaces.Box) and _sizes(space):
        return space.low.ravel().astype(np.int64)
    return np.zeros(1, dtype=np.int64)


def _scale(space: spaces.Space[Any], mode: ObservationInput) -> tuple[Tensor, Tensor] | None:
    if mode == "raw" or not isinstance(space, spaces.Box):
        return None
    low, high, bounded = bounds_of(space)
    if not bounded.any():
        return None
    low, high = np.where(bounded, low, -1.0), np.where(bounded, high, 1.0)
    center, radius = (low + high) / 2, (high - low) / 2
    return torch.from_numpy(center).float(), torch.from_numpy(radius).float()


def _from_zero(leaf: Leaf, packed: Tensor) -> Tensor:
    """The discrete numbers of packed rows, counted from 0."""
    return packed.to(torch.int64) - torch.as_tensor(leaf.start, device=packed.device)


def _product(sizes: list[int], most: int) -> int:
    """The product of all sizes; 0 if it is more than `most`."""
    product = 1
    for size in sizes:
        product *= size
        if product > most:
            return 0
    return product


def _joint_index(digits: Tensor, sizes: list[int]) -> Tensor:
    index = digits[:, 0]
    for column, size in enumerate(sizes[1:], start=1):
        index = index * size + digits[:, column]
    return index


def _bases(size: int) -> list[int]:
    """Sizes of the indicator vectors that show a number of so many values, the last one first."""
    if size <= JOINT_LIMIT:
        return [size]
    digits = []
    while size > 1:
        digits.append(min(size, _BASE))
        size = -(-size // _BASE)
    return digits


def _one_hot(digits: Tensor, sizes: list[int]) -> Tensor:
    """Indicator vectors of rows of digits: one of the whole row where that is small enough, else one per digit."""
    joint = _product(sizes, JOINT_LIMIT)
    if joint:
        return torch.nn.functional.one_hot(_joint_index(digits, sizes), joint).to(torch.float32)
    columns = []
    for i, size in enumerate(sizes):
        rest = digits[:, i]
        for base in _bases(size):
            columns.append(torch.nn.functional.one_hot(rest % base if size > JOINT_LIMIT else rest, base))
            rest = rest // _BASE
    return torch.cat(columns, dim=1).to(torch.float32)
