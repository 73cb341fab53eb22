"""Where an observation is, as a small number: what was tried there can be counted."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch

from ..encoder import ObservationEncoder

N_PLACES = 1 << 14
"""places that are told apart where observations are not numbered."""
_CELLS = 8
"""cells in a unit of a feature that is a floating number."""
_FEW = 32
"""features that are cut into cells one by one; of more, the signs of 14 random mixtures are taken."""
IntArray = npt.NDArray[np.int64]


class Places:
    """Numbers the places of packed observations: observations that have numbers, and buckets of a hash of others.

    Whole numbers are hashed as they are. Floating ones are cut into cells if they are few; else it is where they are of
    some random planes that counts.

    Args:
        encoder: of the observations.
        most: places that there may be.

    Attributes:
        count: how many places there are.

    References:
        H. Tang et al., #Exploration: a study of count-based exploration for deep reinforcement learning, NIPS 2017,
        https://arxiv.org/abs/1611.04717.
    """

    def __init__(self, encoder: ObservationEncoder, most: int = N_PLACES) -> None:
        self._encoder = encoder
        self.count = min(encoder.n_observations or N_PLACES, most)
        self._whole = np.dtype(encoder.dtype).kind != "f" and not encoder.n_observations
        width = encoder.width if self._whole else encoder.n_features
        source = np.random.default_rng(0)  # the same planes in every run
        self._factors = source.integers(1 << 60, size=width) | 1
        planes = N_PLACES.bit_length() - 1
        self._planes = torch.from_numpy(source.normal(size=(width, planes)).astype(np.float32))

    def __call__(self, packed: npt.NDArray[np.generic]) -> IntArray:
        """The place of each row, shape (batch,)."""
        if self.count == 1:
            return np.zeros(len(packed), dtype=np.int64)
        if self._encoder.n_observations:
            return np.asarray(self._encoder.index(torch.from_numpy(packed)).numpy() % self.count)
        if self._whole:
            return self._bucket(packed.astype(np.int64))
        features = self._encoder.features(torch.from_numpy(packed))[:, : self._encoder.n_features]
        if features.shape[1] <= _FEW:
            return self._bucket(np.floor(features.numpy() * _CELLS).astype(np.int64))
        bits = (features @ self._planes > 0).numpy().astype(np.int64)
        return np.asarray((bits << np.arange(bits.shape[1])).sum(axis=1) % self.count)

    def _bucket(self, whole: IntArray) -> IntArray:
        with np.errstate(over="ignore"):
            mixed = (whole * self._factors).sum(axis=1)
        return np.asarray((mixed >> 20) % self.count)
