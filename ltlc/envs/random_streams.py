"""Random numbers that are the same for one environment and for the same environment inside a batch.

Each stream is a key; its t-th number is a hash of key and t. So a batch of streams is a few array operations, and a
stream draws the same numbers whatever its neighbours do.

References:
    G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014,
    doi 10.1145/2660193.2660195 (SplitMix64).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ltlc.splitmix import STEP, WORD, mix, mix_all


class RandomStream:
    """One stream of numbers in [0, 1)."""

    def __init__(self) -> None:
        self._state = fresh_keys(1).tolist()[0]

    def seed(self, seed: int | None) -> None:
        """Start over from a seed; without one, go on."""
        if seed is not None:
            self._state = mix(seed & WORD)

    def draw(self) -> float:
        """The next number."""
        self._state = (self._state + STEP) & WORD
        return (mix(self._state) >> 11) * 2.0**-53


class RandomStreams:
    """Many streams; stream i seeded with s draws what `RandomStream` seeded with s + i draws."""

    def __init__(self, n: int) -> None:
        self._state = fresh_keys(n)

    def seed(self, seed: int | Sequence[int | None] | None) -> None:
        """Start over from one seed, or from one for each stream; without one, go on."""
        if seed is None:
            return
        n = len(self._state)
        seeds = [seed + i for i in range(n)] if isinstance(seed, int | np.integer) else list(seed)
        for i, own in enumerate(seeds):
            if own is not None:
                self._state[i] = mix(own & WORD)

    def draw(self, mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
        """The next number of the masked streams, shape (mask.sum(),); the others stay where they are."""
        state = self._state[mask] + np.uint64(STEP)
        self._state[mask] = state
        return (mix_all(state) >> np.uint64(11)).astype(np.float64) * 2.0**-53

    def draw_many(self, mask: npt.NDArray[np.bool_], k: int) -> npt.NDArray[np.float64]:
        """The next k numbers of the masked streams, shape (mask.sum(), k)."""
        return (self.words(mask, k) >> np.uint64(11)).astype(np.float64) * 2.0**-53

    def words(self, mask: npt.NDArray[np.bool_], k: int) -> npt.NDArray[np.uint64]:
        """The same as `draw_many`, as 64 random bits each."""
        ahead = np.arange(1, k + 1, dtype=np.uint64) * np.uint64(STEP)
        state = self._state[mask][:, None] + ahead
        self._state[mask] = state[:, -1]
        return mix_all(state)


def fresh_keys(n: int) -> npt.NDArray[np.uint64]:
    """Keys from the entropy of the operating system."""
    return np.random.SeedSequence().generate_state(n, np.uint64).astype(np.uint64)
