"""A table of values with a row for each observation that was seen, fitted to all the experience there is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from scipy import sparse
from torch import Tensor, nn

from ltlc.rewards import RewardTables

from ..training.contents import Content
from .numbering import Numbering
from .visits import Outcomes, VisitCounts, sums_of

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

LARGEST = 50_000_000
"""entries of a table, at most."""
BYTES_PER_ENTRY = 64
"""of memory while it is fitted: values, novelty, their successors, and what follows each of them."""
SWEEPS, LAST_SWEEPS = 1_000, 100_000
"""sweeps of a fit at most, while training and at its end."""
WORK = 5e9
"""multiplications of a fit that may have more than `SWEEPS` sweeps, at most: some ten seconds."""
WORK_BETWEEN, FEWEST_SWEEPS = 5e8, 100
"""multiplications of a fit while training, at most, where that leaves so many sweeps."""
TOLERANCE = 1e-15
"""a fit is done when a sweep changes no value by more."""
FAR = 0.95
"""discount of novelty that lies ahead."""
_NOVELTY_SWEEPS = 100
_SWEEPS_PER_CHECK = 50


class QTable(nn.Module):
    """A value for every observation seen, table state and action; takes the place of a `QNetwork`.

    The last row is that of all observations that were not seen when the table was fitted: their values are 0.

    Args:
        numbering: of the observations; those that it gets later are unknown until the table is fitted.
        n_states: table states.
        n_actions: actions.

    Attributes:
        values: shape (n_rows + 1, n_states, n_actions), float64, in units of the reward scale.
        uncertainty: shape (n_rows + 1, n_actions), float64, likewise; how wrong the values may be for want of
            experience.
        exploration_bonus: shape of `values`, float64; how much that was seldom tried lies ahead.
    """

    values: Tensor
    uncertainty: Tensor
    exploration_bonus: Tensor

    def __init__(self, numbering: Numbering, n_states: int, n_actions: int) -> None:
        super().__init__()
        self.n_states, self.n_actions = n_states, n_actions
        self.numbering = numbering
        self.clear(0)

    @property
    def n_rows(self) -> int:
        """Observations that had been seen when the table was fitted."""
        return len(self.values) - 1

    def clear(self, n_rows: int) -> None:
        """Make room for so many observations; all is 0."""
        for name, shape in self._shapes(n_rows).items():
            self.register_buffer(name, torch.zeros(shape, dtype=torch.float64))

    def find(self, packed: npt.NDArray[Any]) -> IntArray:
        """Return the row of each packed observation, shape (batch,)."""
        return np.minimum(self.numbering.find(packed), self.n_rows)

    def forward(self, rows: Tensor, states: Tensor | None = None) -> Tensor:
        """Values of the actions.

        Args:
            rows: shape (batch,), int64; see `find`.
            states: shape (batch,); table state of each, or None for all of them.

        Returns:
            Shape (batch, n_actions), or (batch, n_states, n_actions) if all states were asked for.
        """
        return self.values[rows] if states is None else self.values[rows, states]

    def content(self) -> dict[str, Tensor]:
        """The table and the observations of its rows."""
        return {"observations": self.numbering.rows(self.n_rows), **self.state_dict()}

    def check_content(self, content: Content) -> dict[str, Tensor]:
        """Check and return what `content` gave, read from a file.

        Raises:
            FileFormatError: it is of another table.
        """
        shapes = self._shapes(self.numbering.check(content["observations"]))
        content.check(content.members().keys() == {"observations", *shapes}, "is of another kind of table")
        return {"observations": content["observations"].value} | {
            name: content[name].tensor(torch.float64, shape) for name, shape in shapes.items()
        }

    def load_content(self, content: dict[str, Tensor]) -> None:
        """Go back to what `content` gave."""
        self.numbering = Numbering(self.numbering.width, self.numbering.dtype, self.numbering.capacity)
        self.numbering.load(content["observations"])
        self.clear(len(content["observations"]))
        self.load_state_dict({name: content[name] for name in self._shapes(0)})

    def _shapes(self, n_rows: int) -> dict[str, tuple[int, ...]]:
        each = (n_rows + 1, self.n_states, self.n_actions)
        return {"values": each, "uncertainty": (n_rows + 1, self.n_actions), "exploration_bonus": each}


def fit(
    table: QTable, counts: VisitCounts, tables: RewardTables, learned: IntArray, scale: float, sweeps: int
) -> float:
    """Fit a table to all experience, from values of 0; returns the largest change of the last sweep that was checked.

    A sweep replaces the value of each observation, action and table state by the mean of its targets r + g V(s', q')
    over all steps that were made there, each step being taken in all table states. After n sweeps values are those of
    the best policy for n steps, so that loops that pay nothing are worth nothing, whatever the discount. What was never
    tried keeps the value 0, but for what the environment forbids, which is worth less than all else. Novelty is fitted
    alike: 1 / sqrt(times tried + 1) at each step, discounted by `FAR`.

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
    shape = (table.n_actions, len(counts.numbering), k)
    reward, steps, position = _targets(outcomes, tables, learned, shape)
    reward /= scale
    values, change = np.zeros(shape), np.inf
    forbidden = np.zeros(shape[:2], dtype=np.bool_) if counts.allowed is None else ~counts.allowed.T
    for sweep in range(_affordable(sweeps, steps.nnz)):
        best = _best(_masked(values, forbidden).max(axis=0), tables, learned, position)
        new = reward + (steps @ best.ravel()).reshape(shape)
        if sweep % _SWEEPS_PER_CHECK == 0:
            change = float(np.abs(new - values).max())
        values = new
        if change <= TOLERANCE:
            break
    rare = 1 / np.sqrt(outcomes.tries + 1).reshape(shape[:2])
    novelty = np.zeros(shape)
    rare[forbidden] = 0.0
    for _ in range(_NOVELTY_SWEEPS):
        novelty = rare[..., None] + FAR * (steps @ novelty.max(axis=0).ravel()).reshape(shape)
        novelty[rare == 1] = 1 / (1 - FAR)  # never tried: as good as anything can be
        novelty[forbidden] = 0.0
    largest = np.abs(values).max(initial=0.0)
    values[forbidden] = values.min(initial=0.0) - 1.0
    table.numbering = counts.numbering
    table.clear(shape[1])
    columns = torch.from_numpy(learned)
    table.values[:-1, columns] = torch.from_numpy(values.transpose(1, 2, 0))
    table.exploration_bonus[:-1, columns] = torch.from_numpy(novelty.transpose(1, 2, 0))
    table.exploration_bonus[-1] = 1 / (1 - FAR)
    table.uncertainty[:-1] = torch.from_numpy(largest * rare.T)
    table.uncertainty[-1] = largest
    return change


def _masked(values: FloatArray, forbidden: npt.NDArray[np.bool_]) -> FloatArray:
    """Values of the actions, -inf for those that are forbidden."""
    return np.where(forbidden[..., None], -np.inf, values) if forbidden.any() else values


def _affordable(sweeps: int, multiplications: int) -> int:
    """How many sweeps of so many multiplications a fit may have."""
    each = max(multiplications, 1)
    if sweeps > SWEEPS:
        return min(sweeps, max(SWEEPS, int(WORK / each)))
    return min(sweeps, max(FEWEST_SWEEPS, int(WORK_BETWEEN / each)))


def _targets(
    outcomes: Outcomes, tables: RewardTables, learned: IntArray, shape: tuple[int, int, int]
) -> tuple[FloatArray, Any, IntArray]:
    """What `fit` repeats in each sweep.

    Returns:
        Mean rewards, what the end of the environment is worth included, shape (n_actions, n_rows, n_learned);
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
    reward = sums_of(source.ravel(), paid.ravel(), math.prod(shape)).reshape(shape)
    weight = outcomes.weight[:, None] * goes_on * ~over
    target = outcomes.following[:, None] * k + position[tables.next_state[here, letter_class]]
    used = weight > 0
    entries = (weight[used], (source[used], target[used]))
    return reward, sparse.csr_array(entries, shape=(math.prod(shape), shape[1] * k)), position


def _best(values: FloatArray, tables: RewardTables, learned: IntArray, position: IntArray) -> FloatArray:
    """Values of the states after the best choice of a pair, where there is one; shape (n_rows, n_learned)."""
    if not tables.n_choices:
        return values
    best = values.copy()
    for committed in tables.select_pair[learned].T:
        can = committed >= 0
        best[:, can] = np.maximum(best[:, can], values[:, position[committed[can]]])
    return best
