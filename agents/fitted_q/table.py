"""Q-learning where observations can be numbered: a table of values, fitted to all the experience there is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from scipy import sparse
from torch import Tensor, nn

from ltlc.errors import InvalidArgumentError, TrainingDiverged
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..training.contents import Content
from ..transitions import TransitionBatch

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

LARGEST = 500_000
"""entries of a table, at most."""
GROWTH = 1.2
"""a table is fitted anew whenever there is this many times the experience of the last fit."""
SWEEPS, LAST_SWEEPS = 1_000, 100_000
"""sweeps of a fit at most, while training and at its end."""
WORK = 5e9
"""multiplications of a fit that may have more than `SWEEPS` sweeps, at most: some ten seconds."""
TOLERANCE = 1e-15
"""a fit is done when a sweep changes no value by more."""
FAR = 0.95
"""discount of novelty that lies ahead."""
_NOVELTY_SWEEPS = 100
_SWEEPS_PER_CHECK = 50


class QTable(nn.Module):
    """A value for every observation, table state and action; takes the place of a `QNetwork`.

    Attributes:
        values: shape (n_observations, n_states, n_actions), float64, in units of the reward scale.
        uncertainty: shape (n_observations, n_actions), float64, likewise; how wrong the values may be for want of
            experience.
        exploration_bonus: shape of `values`, float64; how much that was seldom tried lies ahead.
    """

    values: Tensor
    uncertainty: Tensor
    exploration_bonus: Tensor

    def __init__(self, n_observations: int, n_states: int, n_actions: int) -> None:
        super().__init__()
        self.n_states, self.n_actions = n_states, n_actions
        shape = (n_observations, n_states, n_actions)
        self.register_buffer("values", torch.zeros(shape, dtype=torch.float64))
        self.register_buffer("uncertainty", torch.zeros((n_observations, n_actions), dtype=torch.float64))
        self.register_buffer("exploration_bonus", torch.zeros(shape, dtype=torch.float64))

    def forward(self, observations: Tensor, states: Tensor | None = None) -> Tensor:
        """Values of the actions.

        Args:
            observations: shape (batch,), int64; their numbers.
            states: shape (batch,); table state of each, or None for all of them.

        Returns:
            Shape (batch, n_actions), or (batch, n_states, n_actions) if all states were asked for.
        """
        return self.values[observations] if states is None else self.values[observations, states]


class VisitCounts:
    """Environment steps, equal ones counted; takes the place of a `ReplayBuffer`, but forgets nothing.

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

    def add(self, steps: TransitionBatch) -> None:
        """Count steps.

        Raises:
            TrainingDiverged: a reward of the environment itself is not finite.
        """
        if not np.isfinite(steps.base_reward).all():
            raise TrainingDiverged("the environment pays rewards that are NaN or infinite; repair or wrap it")
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
        pair = action * self.shape[0] + observation
        tries = _sums(pair, self._count, self.shape[0] * self.shape[1])
        weight = self._count / tries[pair]
        return Outcomes(tries, pair, following, letter_class, terminated == 1, weight, self._paid / self._count)

    def _merge(self) -> None:
        if not self._new:
            return
        key = np.concatenate([self._key, *(key for key, _ in self._new)])
        count = np.concatenate([self._count, np.ones(len(key) - len(self._key))])
        paid = np.concatenate([self._paid, *(paid for _, paid in self._new)])
        self._key, where = np.unique(key, return_inverse=True)
        self._count, self._paid = _sums(where, count, len(self._key)), _sums(where, paid, len(self._key))
        self._new = []

    def state_dict(self) -> dict[str, Tensor]:
        """The counts."""
        self._merge()
        arrays = {"key": self._key, "count": self._count, "paid": self._paid}
        numbers = {"added": torch.tensor(self.added), "fitted": torch.tensor(self.fitted)}
        return {name: torch.from_numpy(array.copy()) for name, array in arrays.items()} | numbers

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: the counts are of something else.
        """
        names = {"key", "count", "paid", "added", "fitted"}
        content.check(content.members().keys() == names, "is of another kind of experience")
        key, count = content["key"].indices(torch.int64, None, math.prod(self.shape)), content["count"]
        content["key"].check(key.ndim == 1 and bool((key.diff() > 0).all()), "is not a list in ascending order")
        for part in (count, content["paid"]):
            part.tensor(torch.float64, tuple(key.shape))
        count.check(bool((count.value >= 1).all()), "has a number below 1")
        for name in ("added", "fitted"):
            content[name].indices(torch.int64, (), 2**62)

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
    """What was seen to follow each observation and action: an entry of the arrays for each outcome."""

    tries: FloatArray
    """shape (n_actions * n_observations,); how often each action was tried at each observation."""
    pair: IntArray
    """what it is an outcome of: action * n_observations + observation."""
    following: IntArray
    """the next observation."""
    letter_class: IntArray
    terminated: npt.NDArray[np.bool_]
    """whether the environment ended the episode."""
    weight: FloatArray
    """how often it followed, as a part of the times the pair was tried."""
    paid: FloatArray
    """mean reward of the environment itself."""


def fit(
    table: QTable, counts: VisitCounts, tables: RewardTables, learned: IntArray, scale: float, sweeps: int
) -> float:
    """Fit a table to all experience, from values of 0; returns the largest change of the last sweep that was checked.

    A sweep replaces the value of each observation, action and table state by the mean of its targets r + g V(s', q')
    over all steps that were made there, each step being taken in all table states. After n sweeps values are those of
    the best policy for n steps, so that loops that pay nothing are worth nothing, whatever the discount. What was never
    tried keeps the value 0. Novelty is fitted alike: 1 / sqrt(times tried + 1) at each step, discounted by `FAR`.

    Args:
        table: whose values are replaced.
        counts: the experience.
        tables: rewards.
        learned: the table states that an episode can be in, ascending.
        scale: unit of reward.
        sweeps: how many at most.

    References:
        D. Ernst, P. Geurts, L. Wehenkel, Tree-based batch mode reinforcement learning, JMLR 2005,
        https://www.jmlr.org/papers/v6/ernst05a.html (fitted Q iteration; here the regression is a mean per entry).
        A. L. Strehl, M. L. Littman, An analysis of model-based interval estimation for Markov decision processes, JCSS
        2008, https://doi.org/10.1016/j.jcss.2007.08.009 (credit of 1 / sqrt(times tried) for exploration).
    """
    outcomes, k = counts.outcomes(), len(learned)
    n_observations, _, n_actions = table.values.shape
    shape = (n_actions, n_observations, k)
    reward, steps, position = _targets(outcomes, tables, learned, shape)
    reward /= scale
    values, change = np.zeros(shape), np.inf
    for sweep in range(min(sweeps, max(SWEEPS, int(WORK / max(steps.nnz, 1))))):
        new = reward + (steps @ _best(values.max(axis=0), tables, learned, position).ravel()).reshape(shape)
        if sweep % _SWEEPS_PER_CHECK == 0:
            change = float(np.abs(new - values).max())
        values = new
        if change <= TOLERANCE:
            break
    rare = 1 / np.sqrt(outcomes.tries + 1).reshape(shape[:2])
    novelty = np.zeros(shape)
    for _ in range(_NOVELTY_SWEEPS):
        novelty = rare[..., None] + FAR * (steps @ novelty.max(axis=0).ravel()).reshape(shape)
        novelty[rare == 1] = 1 / (1 - FAR)  # never tried: as good as anything can be
    columns = torch.from_numpy(learned)
    table.values[:, columns] = torch.from_numpy(values.transpose(1, 2, 0))
    table.exploration_bonus[:, columns] = torch.from_numpy(novelty.transpose(1, 2, 0))
    table.uncertainty[:] = torch.from_numpy(np.abs(values).max() * rare.T)
    return change


def _targets(
    outcomes: Outcomes, tables: RewardTables, learned: IntArray, shape: tuple[int, int, int]
) -> tuple[FloatArray, Any, IntArray]:
    """What `fit` repeats in each sweep.

    Returns:
        Mean rewards, what the end of the environment is worth included, shape (n_actions, n_observations, n_learned);
        mean weights of what follows, a matrix from these entries to (observation, learned state); and the position of
        each state among those learned.
    """
    k = len(learned)
    position = np.zeros(tables.n_states, dtype=np.int64)
    position[learned] = np.arange(k)
    here, letter_class = learned[None, :], outcomes.letter_class[:, None]
    source = outcomes.pair[:, None] * k + np.arange(k)
    over = outcomes.terminated[:, None]
    goes_on = tables.expected_discount[here, letter_class]
    final = np.where(over, goes_on * tables.final_value[here, letter_class], 0.0)
    paid = outcomes.weight[:, None] * (tables.expected_reward[here, letter_class] + final + outcomes.paid[:, None])
    reward = _sums(source.ravel(), paid.ravel(), math.prod(shape)).reshape(shape)
    weight = outcomes.weight[:, None] * goes_on * ~over
    target = outcomes.following[:, None] * k + position[tables.next_state[here, letter_class]]
    used = weight > 0
    entries = (weight[used], (source[used], target[used]))
    return reward, sparse.csr_array(entries, shape=(math.prod(shape), shape[1] * k)), position


def _best(values: FloatArray, tables: RewardTables, learned: IntArray, position: IntArray) -> FloatArray:
    """Values of the states after the best choice of a pair, where there is one; shape (n_observations, n_learned)."""
    if not tables.n_choices:
        return values
    best = values.copy()
    for committed in tables.commit[learned].T:
        can = committed >= 0
        best[:, can] = np.maximum(best[:, can], values[:, position[committed[can]]])
    return best


def _sums(group: IntArray, values: FloatArray, n_groups: int) -> FloatArray:
    """The sum of the values of each group, shape (n_groups,)."""
    return np.bincount(group, values, minlength=n_groups).astype(np.float64)
