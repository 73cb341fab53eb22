"""Numbers of observations, given in the order in which they are first seen."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from ltlc.errors import MemoryLimitExceeded

from ..training.contents import Content

IntArray = npt.NDArray[np.int64]
_WORD = 8
"""bytes of a number of 64 bits."""


class Numbering:
    """A number for each packed observation that was seen; its memory grows with those, not with the space.

    Args:
        width: columns of a packed observation that tell it from others; those after them do not count.
        dtype: of a packed observation.
        capacity: observations at most.

    Example:
        >>> seen = Numbering(1, np.int64, 10)
        >>> seen.add(np.array([[7], [3], [7]])).tolist()
        [0, 1, 0]
        >>> seen.find(np.array([[3], [4]])).tolist()
        [1, 2]
    """

    def __init__(self, width: int, dtype: npt.DTypeLike, capacity: int) -> None:
        self.width, self.dtype, self.capacity = width, np.dtype(dtype), capacity
        self._whole = width * self.dtype.itemsize == _WORD
        self._number: dict[int | bytes, int] = {}

    def __len__(self) -> int:
        return len(self._number)

    def find(self, packed: npt.NDArray[np.generic]) -> IntArray:
        """Return the number of each row, shape (batch,); `len` of the numbering for those never seen."""
        unknown = len(self._number)
        return np.array([self._number.get(key, unknown) for key in self._keys(packed)], dtype=np.int64)

    def add(self, packed: npt.NDArray[np.generic]) -> IntArray:
        """Return the number of each row, shape (batch,); those never seen get the next ones.

        Raises:
            MemoryLimitExceeded: there are more than `capacity`.
        """
        number = self._number
        found = [number.setdefault(key, len(number)) for key in self._keys(packed)]
        if len(number) > self.capacity:
            raise MemoryLimitExceeded(
                f"more than {self.capacity} different observations were seen; take the agent 'double-dqn'"
            )
        return np.array(found, dtype=np.int64)

    def rows(self, count: int | None = None) -> Tensor:
        """Return the first observations (None: all), packed, in order, shape (count, width)."""
        keys: Any = list(itertools.islice(self._number, count))
        blob = np.array(keys, dtype=np.int64).tobytes() if self._whole else b"".join(keys)
        rows = np.frombuffer(blob, dtype=self.dtype).reshape(len(keys), self.width)
        return torch.from_numpy(rows.copy())

    def load(self, rows: Tensor) -> None:
        """Number these observations, and forget all others."""
        self._number = {key: i for i, key in enumerate(self._keys(rows.numpy()))}

    def check(self, content: Content) -> int:
        """Check that something in a file is what `rows` gave; returns how many observations it has.

        Raises:
            FileFormatError: it is not, or an observation is there twice.
        """
        kind = torch.from_numpy(np.zeros(0, dtype=self.dtype)).dtype
        rows = content.tensor(kind)
        proper = rows.ndim == 2 and rows.shape[1] == self.width and len(rows) <= self.capacity
        content.check(proper, f"has the shape {tuple(rows.shape)}, which is no list of these observations")
        content.check(len(set(self._keys(rows.numpy()))) == len(rows), "has an observation twice")
        return len(rows)

    def _keys(self, packed: npt.NDArray[np.generic]) -> Iterable[int | bytes]:
        packed = packed[:, : self.width]
        if self._whole:  # the same bytes as one number, which is faster
            return np.ascontiguousarray(packed).view(np.int64).ravel().tolist()
        blob, size = np.ascontiguousarray(packed).tobytes(), self.width * self.dtype.itemsize
        return (blob[at : at + size] for at in range(0, len(blob), size))
