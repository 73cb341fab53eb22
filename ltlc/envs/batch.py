"""Batched observations and infos, as Gymnasium's vector environments nest them: dicts and tuples of arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import VectorWrapper

BoolArray = npt.NDArray[np.bool_]

if TYPE_CHECKING:
    AnyVectorWrapper = VectorWrapper[Any, Any, Any, Any, Any]
else:  # generic from gymnasium 1.4 on only
    AnyVectorWrapper = VectorWrapper


def part(space: spaces.Space[Any], observations: Any, chosen: Any) -> Any:
    """The observations of the chosen sub-environments, or that of one.

    Args:
        space: of a single observation; spaces that Gymnasium cannot batch come as tuples.
        observations: the batch.
        chosen: an array of indices, or one index.
    """
    if isinstance(space, spaces.Dict):
        return {key: part(inner, observations[key], chosen) for key, inner in space.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(part(inner, batch, chosen) for inner, batch in zip(space, observations, strict=True))
    if isinstance(observations, np.ndarray) or np.ndim(chosen) == 0:
        return observations[chosen]
    return tuple(observations[i] for i in chosen)


def joined(space: spaces.Space[Any], batches: Sequence[Any]) -> Any:
    """Batches of observations one after the other, as one batch.

    Args:
        space: of a single observation.
        batches: at least one.
    """
    if isinstance(space, spaces.Dict):
        return {key: joined(inner, [batch[key] for batch in batches]) for key, inner in space.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(joined(inner, [batch[i] for batch in batches]) for i, inner in enumerate(space))
    if isinstance(batches[0], np.ndarray):
        return np.concatenate(batches)
    return tuple(observation for batch in batches for observation in batch)


def joined_infos(parts: Sequence[dict[str, Any]], sizes: Sequence[int]) -> dict[str, Any]:
    """Batched infos one after the other, as one; what some lack is 0, False or None there.

    Args:
        parts: infos of some sub-environments each.
        sizes: how many they are.
    """
    whole: dict[str, Any] = {}
    for key in dict.fromkeys(key for infos in parts for key in infos):
        values = [infos.get(key) for infos in parts]
        first = next(value for value in values if value is not None)
        if isinstance(first, dict):
            whole[key] = joined_infos([value or {} for value in values], sizes)
        elif isinstance(first, np.ndarray) and first.ndim:
            kinds = {value.dtype for value in values if value is not None}
            kind = kinds.pop() if len(kinds) == 1 else np.dtype(object)
            missing = [np.zeros((size, *first.shape[1:]), dtype=kind) for size in sizes]
            for blank in missing if kind.hasobject else ():
                blank[:] = None
            pairs = zip(values, missing, strict=True)
            whole[key] = np.concatenate([blank if value is None else value.astype(kind) for value, blank in pairs])
        else:
            whole[key] = first
    return whole


def select(infos: Any, chosen: Any) -> Any:
    """The infos of the chosen sub-environments; entries that are no arrays stay as they are."""
    if isinstance(infos, dict):
        return {key: select(value, chosen) for key, value in infos.items()}
    return infos[chosen] if isinstance(infos, np.ndarray) else infos


class SubInfo(Mapping[str, Any]):
    """The info of one sub-environment: a view of batched infos, so that only what is asked for is taken apart.

    Args:
        infos: of all sub-environments; the array `_key` says which of them have an entry `key`.
        index: of the sub-environment.
    """

    def __init__(self, infos: dict[str, Any], index: int) -> None:
        self._infos, self._index = infos, index

    def __getitem__(self, key: str) -> Any:
        if not self._has(key):
            raise KeyError(key)
        value = self._infos[key]
        if isinstance(value, dict):
            return SubInfo(value, self._index)
        return value[self._index] if isinstance(value, np.ndarray) else value

    def __iter__(self) -> Iterator[str]:
        return (key for key in self._infos if self._has(key))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return repr(dict(self))

    def _has(self, key: str) -> bool:
        infos = self._infos
        if key not in infos or (key.startswith("_") and key[1:] in infos):
            return False
        has = infos.get(f"_{key}")
        return has is None or bool(has[self._index])


def merge(into: dict[str, Any], new: dict[str, Any], mask: BoolArray) -> None:
    """Replace the masked entries of batched infos by those of others; arrays are replaced, never written into."""
    for key, value in new.items():
        old = into.get(key)
        if isinstance(value, dict):
            inner = old if isinstance(old, dict) else {}
            merge(inner, value, mask)
            into[key] = inner
        elif isinstance(value, np.ndarray) and value.shape[:1] == mask.shape:
            mixed = np.zeros_like(value)
            if isinstance(old, np.ndarray) and old.shape == value.shape and old.dtype == value.dtype:
                mixed[:] = old
            mixed[mask] = value[mask]
            into[key] = mixed
        else:
            into[key] = value


def copied(observation: Any) -> Any:
    """A copy that shares no array with the original."""
    if isinstance(observation, dict):
        return {key: copied(value) for key, value in observation.items()}
    if isinstance(observation, tuple):
        return tuple(copied(value) for value in observation)
    return observation.copy() if isinstance(observation, np.ndarray) else observation
