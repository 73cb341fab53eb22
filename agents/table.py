"""Q-learning where observations can be numbered: a table of values, fitted to all the experience there is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from scipy import sparse
from torch import Tensor, nn

from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

from .encoder import ObservationEncoder
from .replay import Steps

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

LARGEST = 2_000_000
"""entries of a table, at most."""
GROWTH = 1.2
"""a table is fitted anew whenever there is this many times the experience of the last fit."""
SWEEPS, LAST_SWEEPS = 2_000, 100_000
"""sweeps of a fit at most, while training and at its end."""
TOLERANCE = 1e-10
"""a fit is done when a sweep changes no value by more."""
_SWEEPS_PER_CHECK = 50


class QTable(nn.Module):
    """A value for every observation, table state and action; takes the place of a `QNetwork`.

    Attributes:
        values: shape (n_observations, n_states, n_actions), float64, in units of the reward scale.
    """

    values: Tensor

    def __init__(self, n_observations: int, n_states: int, n_actions: int) -> None:
        super().__init__()
        self.n_states, self.n_actions = n_states, n_actions
        self.register_buffer("values", torch.zeros((n_observations, n_states, n_actions), dtype=torch.float64))

    def forward(self, features: Tensor, states: Tensor | None = None) -> Tensor:
        """Values of the actions at observations given as indicator vectors; see `QNetwork.forward`."""
        row = features.argmax(dim=1)
        return self.values[row] if states is None else self.values[row, states]


class Tally:
    """Environment steps, equal ones counted: the part of a replay buffer, for a table. Nothing is forgotten.

    Args:
        encoder: of the observations, which are numbered.
        n_actions: number of actions.
        n_classes: number of letter classes.
    """

    def __init__(self, encoder: ObservationEncoder, n_actions: int, n_classes: int) -> None:
        self.encoder = encoder
        self.shape = (encoder.n_observations, n_actions, encoder.n_observations, n_classes, 2)
        self.added = 0
        """steps ever added."""
        self.fitted = 0
        """steps there were when a table was last fitted."""
        self._key: IntArray = np.zeros(0, dtype=np.int64)
        self._count: FloatArray = np.zeros(0)
        self._paid: FloatArray = np.zeros(0)
        self._new: list[tuple[IntArray, FloatArray]] = []

    def __len__(self) -> int:
        return self.added

    def add(self, steps: Steps) -> None:
        """Count steps."""
        observation, following = (
            self.encoder.index(torch.from_numpy(packed)).numpy()
            for packed in (steps.observation, steps.next_observation)
        )
        parts = (observation, steps.action, following, steps.letter_class, steps.terminated.astype(np.int64))
        self._new.append((np.ravel_multi_index(parts, self.shape).astype(np.int64), steps.base_reward))
        self.added += len(steps.action)

    def outcomes(self) -> Outcomes:
        """What was seen to follow each observation and action."""
        self._merge()
        observation, action, following, letter_class, terminated = np.unravel_index(self._key, self.shape)
        pair, row = np.unique(observation * self.shape[1] + action, return_inverse=True)
        weight = self._count / np.bincount(row, self._count)[row]
        return Outcomes(pair, row, following, letter_class, terminated == 1, weight, self._paid / self._count)

    def _merge(self) -> None:
        if not self._new:
            return
        key = np.concatenate([self._key, *(key for key, _ in self._new)])
        count = np.concatenate([self._count, np.ones(len(key) - len(self._key))])
        paid = np.concatenate([self._paid, *(paid for _, paid in self._new)])
        self._key, where = np.unique(key, return_inverse=True)
        self._count, self._paid, self._new = np.bincount(where, count), np.bincount(where, paid), []

    def state_dict(self) -> dict[str, Tensor]:
        """The counts."""
        self._merge()
        arrays = {"key": self._key, "count": self._count, "paid": self._paid}
        numbers = {"added": torch.tensor(self.added), "fitted": torch.tensor(self.fitted)}
        return {name: torch.from_numpy(array.copy()) for name, array in arrays.items()} | numbers

    def load_state_dict(self, state: dict[str, Tensor]) -> None:
        """Go back to what `state_dict` gave.

        Raises:
            InvalidArgumentError: the counts are of something else.
        """
        if "key" not in state or (state["key"].numpy() >= np.prod(self.shape)).any():
            raise InvalidArgumentError("the experience in the checkpoint is of another kind")
        self._key, self._count, self._paid = (state[name].numpy().copy() for name in ("key", "count", "paid"))
        self._new = []
        self.added, self.fitted = int(state["added"]), int(state["fitted"])


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Observations with actions that were tried, and what followed; an entry of the other arrays for each outcome."""

    pair: IntArray
    """shape (n_pairs,); observation * n_actions + action, ascending."""
    row: IntArray
    """which pair the outcome is of."""
    following: IntArray
    """the next observation."""
    letter_class: IntArray
    terminated: npt.NDArray[np.bool_]
    """whether the environment ended the episode."""
    weight: FloatArray
    """how often it followed, as a part of the times the pair was tried."""
    paid: FloatArray
    """mean reward of the environment itself."""


def fit(table: QTable, tally: Tally, tables: RewardTables, learned: IntArray, scale: float, sweeps: int) -> float:
    """Fit a table to all experience, from values of 0; returns the largest change of the last sweep.

    A sweep replaces the value of each observation, action and table state by the mean of its targets r + g V(s', q')
    over all steps that were made there, each step being taken in all table states. After n sweeps values are those of
    the best policy for n steps, so that loops that pay nothing are worth nothing, whatever the discount. What was never
    tried keeps the value 0.

    Args:
        table: whose values are replaced.
        tally: the experience.
        tables: rewards.
        learned: the table states that an episode can be in, ascending.
        scale: unit of reward.
        sweeps: how many at most.

    References:
        D. Ernst, P. Geurts, L. Wehenkel, Tree-based batch mode reinforcement learning, JMLR 2005,
        https://www.jmlr.org/papers/v6/ernst05a.html (fitted Q iteration; here the regression is a mean per entry).
    """
    outcomes = tally.outcomes()
    n_observations, n_states, n_actions = table.values.shape
    k = len(learned)
    position = np.zeros(n_states, dtype=np.int64)
    position[learned] = np.arange(k)
    here, letter_class = learned[None, :], outcomes.letter_class[:, None]
    mean = sparse.csr_array((outcomes.weight, (outcomes.row, np.arange(len(outcomes.row)))))
    reward = mean @ ((tables.expected_reward[here, letter_class] + outcomes.paid[:, None]) / scale)
    going_on = tables.expected_discount[here, letter_class] * ~outcomes.terminated[:, None]
    target = outcomes.following[:, None] * k + position[tables.next_state[here, letter_class]]
    source = outcomes.row[:, None] * k + np.arange(k)
    weight = (outcomes.weight[:, None] * going_on).ravel()
    used = weight > 0
    shape = (len(outcomes.pair) * k, n_observations * k)
    steps = sparse.csr_array((weight[used], (source.ravel()[used], target.ravel()[used])), shape=shape)
    values = np.zeros((n_observations * n_actions, k))
    change = np.inf
    for sweep in range(sweeps):
        best = _best(values.reshape(n_observations, n_actions, k).max(axis=1), tables, learned, position)
        new = reward + (steps @ best.ravel()).reshape(-1, k)
        if sweep % _SWEEPS_PER_CHECK == 0:
            change = float(np.abs(new - values[outcomes.pair]).max(initial=0.0))
        values[outcomes.pair] = new
        if change <= TOLERANCE:
            break
    table.values.zero_()
    table.values[:, torch.from_numpy(learned)] = torch.from_numpy(
        values.reshape(n_observations, n_actions, k).transpose(0, 2, 1)
    )
    return change


def _best(values: FloatArray, tables: RewardTables, learned: IntArray, position: IntArray) -> FloatArray:
    """Values of the states after the best choice of a pair, where there is one; shape (n_observations, n_learned)."""
    if not tables.n_choices:
        return values
    best = values.copy()
    for committed in tables.commit[learned].T:
        can = committed >= 0
        best[:, can] = np.maximum(best[:, can], values[:, position[committed[can]]])
    return best
