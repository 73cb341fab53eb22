"""Batched observations and infos, as Gymnasium's vector environments nest them: dicts and tuples of arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

BoolArray = npt.NDArray[np.bool_]


def select(tree: Any, chosen: Any) -> Any:
    """The chosen sub-environments of a batched observation or info; entries that are no arrays stay as they are."""
    if isinstance(tree, dict):
        return {key: select(value, chosen) for key, value in tree.items()}
    if isinstance(tree, tuple):
        return tuple(select(value, chosen) for value in tree)
    return tree[chosen] if isinstance(tree, np.ndarray) else tree


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
