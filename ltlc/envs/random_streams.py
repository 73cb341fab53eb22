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

_STEP = 0x9E3779B97F4A7C15
_FIRST, _SECOND = 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
_WORD = (1 << 64) - 1


class RandomStream:
    """One stream of numbers in [0, 1)."""

    def __init__(self) -> None:
        self._state = fresh_keys(1).tolist()[0]

    def seed(self, seed: int | None) -> None:
        """Start over from a seed; without one, go on."""
        if seed is not None:
            self._state = _mix(seed & _WORD)

    def draw(self) -> float:
        """The next number."""
        self._state = (self._state + _STEP) & _WORD
        return (_mix(self._state) >> 11) * 2.0**-53


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
                self._state[i] = _mix(own & _WORD)

    def draw(self, mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
        """The next number of the masked streams, shape (mask.sum(),); the others stay where they are."""
        state = self._state[mask] + np.uint64(_STEP)
        self._state[mask] = state
        state = (state ^ (state >> np.uint64(30))) * np.uint64(_FIRST)
        state = (state ^ (state >> np.uint64(27))) * np.uint64(_SECOND)
        state = state ^ (state >> np.uint64(31))
        return (state >> np.uint64(11)).astype(np.float64) * 2.0**-53


def fresh_keys(n: int) -> npt.NDArray[np.uint64]:
    """Keys from the entropy of the operating system."""
    return np.random.SeedSequence().generate_state(n, np.uint64).astype(np.uint64)


def _mix(word: int) -> int:
    word = ((word ^ (word >> 30)) * _FIRST) & _WORD
    word = ((word ^ (word >> 27)) * _SECOND) & _WORD
    return word ^ (word >> 31)
