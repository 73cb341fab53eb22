"""Environment steps of numbered observations, equal ones counted: all the experience of a table of values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from ltlc.errors import InvalidArgumentError, TrainingDiverged

from ..encoder import ObservationEncoder
from ..training.contents import Content
from ..transitions import TransitionBatch
from .numbering import Numbering

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

GROWTH = 1.2
"""a table is fitted anew whenever there is this many times the experience of the last fit."""
NEWS, SOONER = 1.05, 1.02
"""so it is where this many times the observations were seen, when there is so many times the experience."""
_NUMBERS = ("added", "fitted", "fitted_rows")
"""of the experience, that are kept in checkpoints."""


class VisitCounts:
    """Environment steps, equal ones counted; takes the place of a `ReplayBuffer`, but forgets nothing.

    Args:
        numbering: of the observations, empty.
        n_actions: number of actions.
        n_classes: number of letter classes.
        encoder: of the observations, if they carry masks.

    Attributes:
        allowed: shape (n_seen, n_actions); the actions that were ever allowed in each observation; None without masks.

    Raises:
        InvalidArgumentError: there could be more different steps than can be numbered.
    """

    def __init__(
        self, numbering: Numbering, n_actions: int, n_classes: int, encoder: ObservationEncoder | None = None
    ) -> None:
        self._encoder = encoder
        self.allowed = None if encoder is None else np.zeros((0, n_actions), dtype=np.bool_)
        self.numbering = numbering
        self.shape = (numbering.capacity, n_actions, numbering.capacity, n_classes, 2)
        if math.prod(self.shape) >= 2**63:
            raise InvalidArgumentError(
                f"{numbering.capacity} observations, {n_actions} actions and {n_classes} classes of letters are too "
                "many for a table; take the agent 'double-dqn'"
            )
        self.added = 0
        """steps ever added."""
        self.fitted = 0
        """steps there were when a table was last fitted."""
        self.fitted_rows = 0
        """observations there were then."""
        self._key: IntArray = np.zeros(0, dtype=np.int64)
        self._count: FloatArray = np.zeros(0)
        self._paid: FloatArray = np.zeros(0)
        self._new: list[tuple[IntArray, FloatArray]] = []

    def __len__(self) -> int:
        return self.added

    @property
    def due(self) -> bool:
        """Whether there is enough that is new for the table to be fitted."""
        news = len(self.numbering) > NEWS * self.fitted_rows and self.added >= SOONER * self.fitted
        return news or self.added >= GROWTH * self.fitted

    def add(self, steps: TransitionBatch) -> None:
        """Count steps.

        Raises:
            TrainingDiverged: a reward of the environment itself is not finite.
        """
        if not np.isfinite(steps.base_reward).all():
            raise TrainingDiverged("the environment pays rewards that are NaN or infinite; repair or wrap it")
        observation, following = self._number(steps.observation), self._number(steps.next_observation)
        parts = (observation, steps.action, following, steps.letter_class, steps.terminated.astype(np.int64))
        self._new.append((np.ravel_multi_index(parts, self.shape).astype(np.int64), steps.base_reward))
        self.added += len(steps.action)

    def _number(self, packed: npt.NDArray[Any]) -> IntArray:
        numbers = self.numbering.add(packed)
        if self._encoder is not None and self.allowed is not None:
            more = len(self.numbering) - len(self.allowed)
            self.allowed = np.pad(self.allowed, ((0, more), (0, 0)))
            masks: Any = self._encoder.allowed(torch.from_numpy(packed))
            np.logical_or.at(self.allowed, numbers, masks.numpy())
        return numbers

    def cut(self) -> None:
        """Nothing: steps are counted one by one."""

    def outcomes(self) -> Outcomes:
        """What was seen to follow each observation and action."""
        self._merge()
        observation, action, following, letter_class, terminated = np.unravel_index(self._key, self.shape)
        n_rows = len(self.numbering)
        pair = action * n_rows + observation
        tries = sums_of(pair, self._count, n_rows * self.shape[1])
        weight = self._count / tries[pair]
        return Outcomes(tries, pair, following, letter_class, terminated == 1, weight, self._paid / self._count)

    def _merge(self) -> None:
        if not self._new:
            return
        key = np.concatenate([self._key, *(key for key, _ in self._new)])
        count = np.concatenate([self._count, np.ones(len(key) - len(self._key))])
        paid = np.concatenate([self._paid, *(paid for _, paid in self._new)])
        self._key, where = np.unique(key, return_inverse=True)
        self._count, self._paid = sums_of(where, count, len(self._key)), sums_of(where, paid, len(self._key))
        self._new = []

    def state_dict(self) -> dict[str, Tensor]:
        """The counts, and the observations they are of."""
        self._merge()
        arrays = {"key": self._key, "count": self._count, "paid": self._paid}
        numbers = {name: torch.tensor(getattr(self, name)) for name in _NUMBERS}
        rows = {"observations": self.numbering.rows()}
        if self.allowed is not None:
            rows["allowed"] = torch.from_numpy(self.allowed.copy())
        return {name: torch.from_numpy(array.copy()) for name, array in arrays.items()} | numbers | rows

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: the counts are of something else.
        """
        names = {"key", "count", "paid", "observations", *_NUMBERS}
        names |= {"allowed"} if self.allowed is not None else set()
        content.check(content.members().keys() == names, "is of another kind of experience")
        key, count = content["key"].indices(torch.int64, None, math.prod(self.shape)), content["count"]
        seen = self.numbering.check(content["observations"])
        if self.allowed is not None:
            content["allowed"].tensor(torch.bool, (seen, self.shape[1]))
        observation, _, following, _, _ = np.unravel_index(key.numpy(), self.shape)
        known = max(observation.max(initial=-1), following.max(initial=-1)) < seen
        content["key"].check(bool(known), "has a step of an observation that is not listed")
        content["key"].check(key.ndim == 1 and bool((key.diff() > 0).all()), "is not a list in ascending order")
        for part in (count, content["paid"]):
            part.tensor(torch.float64, tuple(key.shape))
        count.check(bool((count.value >= 1).all()), "has a number below 1")
        for name in _NUMBERS:
            content[name].indices(torch.int64, (), 2**62)

    def load_state_dict(self, state: dict[str, Tensor]) -> None:
        """Go back to what `state_dict` gave.

        Raises:
            InvalidArgumentError: the counts are of something else.
        """
        if "key" not in state or state["observations"].shape[1:] != (self.numbering.width,):
            raise InvalidArgumentError("the experience in the checkpoint is of another kind")
        self.numbering.load(state["observations"])
        self._key, self._count, self._paid = (state[name].numpy().copy() for name in ("key", "count", "paid"))
        self._new = []
        if self.allowed is not None:
            self.allowed = state["allowed"].numpy().copy()
        for name in _NUMBERS:
            setattr(self, name, int(state[name]))


@dataclass(frozen=True, eq=False)
class Outcomes:
    """What was seen to follow each observation and action: an entry of the arrays for each outcome."""

    tries: FloatArray
    """shape (n_actions * n_rows,); how often each action was tried at each observation."""
    pair: IntArray
    """what it is an outcome of: action * n_rows + observation."""
    following: IntArray
    """the next observation."""
    letter_class: IntArray
    terminated: npt.NDArray[np.bool_]
    """whether the environment ended the episode."""
    weight: FloatArray
    """how often it followed, as a part of the times the pair was tried."""
    paid: FloatArray
    """mean reward of the environment itself."""


def sums_of(group: IntArray, values: FloatArray, n_groups: int) -> FloatArray:
    """The sum of the values of each group, shape (n_groups,)."""
    return np.bincount(group, values, minlength=n_groups).astype(np.float64)
