"""How far an observation is from the thresholds that an automaton waits for, as a potential."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.automata.alphabet import Alphabet
from ltlc.automata.guards import Guard
from ltlc.envs.comparisons import Comparison
from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

FloatArray = npt.NDArray[np.float64]


class Robustness:
    """A potential that grows as the comparisons come true that an automaton waits for.

    The potential of an observation in a state is the progress of that state, and above it up to the progress of the
    next one, by how far the guard that leads there is from holding: the margin of a comparison is the difference of its
    sides, that of a conjunction the least and that of a disjunction the largest (robustness), squashed to 0..1.

    Args:
        tables: reward tables of the task.
        comparisons: the propositions that are comparisons, by name.
        weight: potential of a state on an accepting cycle.
        scale: the margin at which a comparison counts as three quarters true and more; of all, or by proposition.

    Attributes:
        weight: see above.
        scales: of each comparison.

    Raises:
        InvalidArgumentError: weight or scale are no finite numbers, or a scale is not positive.

    References:
        A. Donze, O. Maler, Robust satisfaction of temporal logic over real-valued signals, FORMATS 2010, doi
        10.1007/978-3-642-15297-9_9.
    """

    def __init__(
        self,
        tables: RewardTables,
        comparisons: Mapping[str, Comparison],
        weight: float = 1.0,
        scale: float | Mapping[str, float] = 1.0,
    ) -> None:
        scales = dict.fromkeys(comparisons, 1.0 if isinstance(scale, Mapping) else scale)
        scales |= scale if isinstance(scale, Mapping) else {}
        numbers = [weight, *scales.values()]
        if not all(isinstance(number, int | float) and np.isfinite(number) for number in numbers):
            raise InvalidArgumentError(f"weight and scale must be finite numbers, and are {weight!r} and {scale!r}")
        if any(number <= 0 for number in scales.values()):
            raise InvalidArgumentError(f"scale is {scale!r}; it must be positive")
        self.weight, self.scales = weight, scales
        self._aps, self._progress = tables.aps, tables.progress
        self._margins = {name: (comparison, self.scales[name]) for name, comparison in comparisons.items()}
        self._guards, self._gain = _onward(tables)

    def potentials(self, observations: Any, holds: Mapping[str, Any], states: Iterable[int]) -> FloatArray:
        """The potential in some states.

        Args:
            observations: one of the environment, or a batch.
            holds: of each proposition that is no comparison, whether it holds there.
            states: of the reward tables.

        Returns:
            Shape (n_states, n_observations), without the last axis for a single observation.
        """
        truth: dict[str, Any] = {name: np.where(known, 1.0, 0.0) for name, known in holds.items()}
        for name, (comparison, scale) in self._margins.items():
            margin = np.asarray(comparison.margin(observations))
            truth[name] = np.where(np.isnan(margin), 0.5, 0.5 + 0.5 * np.tanh(margin / scale))
        truth = dict(zip(truth, np.broadcast_arrays(*truth.values()), strict=True))
        return np.stack([self._potential(state, truth) for state in states])

    def _potential(self, state: int, truth: Mapping[str, Any]) -> Any:
        guard, size = self._guards[state], np.shape(next(iter(truth.values()), 0.0))
        progress = np.full(size, self._progress[state])
        if guard is None:
            return self.weight * progress
        inner, outer = (np.minimum, np.maximum) if guard.disjunctive else (np.maximum, np.minimum)
        literals = [
            [truth[self._aps[i]] if sign else 1.0 - truth[self._aps[i]] for i, sign in term] for term in guard.terms
        ]
        parts = [inner.reduce(term) for term in literals if term]
        return self.weight * (progress + self._gain * (outer.reduce(parts) if parts else 0.0))


def _onward(tables: RewardTables) -> tuple[list[Guard | None], float]:
    """For each state the guard that leads on towards acceptance, if there is any to wait for, and what it is worth."""
    progress = tables.progress
    alphabet = Alphabet(tables.aps, tables.letter_class, tables.possible)
    guards: list[Guard | None] = []
    for state in range(tables.n_states):
        after = np.where(tables.violated[state], 0.0, progress[tables.next_state[state]])
        onward = tables.accepted[state] & (after > 0) if progress[state] == 1 else after > progress[state]
        waits = progress[state] > 0 and bool(onward.any()) and not onward.all()
        guards.append(alphabet.guard(np.flatnonzero(onward).tolist()) if waits else None)
    return guards, 1 / max(len({*progress[progress > 0].tolist()}), 1)
