"""Reward tables laid out for one look-up per array."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.rewards import RewardTables


class FlatTables:
    """The reward tables as one-dimensional arrays, indexed by state * n_classes + class.

    One more state, `before_episode`, reads the first letter of an episode: nothing is paid there and nothing ends.
    """

    def __init__(self, tables: RewardTables, skip: bool) -> None:
        first = tables.initial_state
        self.n_classes = tables.n_classes
        self.before_episode = tables.n_states
        self.letter_class = tables.letter_class.astype(np.int64)
        self.next_state = _flat(tables.next_state.astype(np.int64), first if skip else tables.next_state[first])
        self.reward = _flat(tables.reward, 0.0)
        self.discount = _flat(tables.discount, 1.0)
        self.violated = _flat(tables.violated, False if skip else tables.violated[first])
        self.accepted = _flat(tables.accepted, False if skip else tables.accepted[first])
        self.progress = tables.progress
        self.stop_reward = _flat(tables.stop_reward, 0.0)
        self.final = _flat(tables.discount * tables.final_value, 0.0)
        self.surely = _flat(tables.terminal, False)
        chance = _flat(np.where(tables.terminal, 0.0, tables.stop), 0.0)
        self.by_chance = chance if chance.any() else None
        self.can_stop = bool(tables.stop.any())
        self.stop_pays = bool((tables.stop_reward[tables.stop > 0] != 0).any())


def _flat(table: npt.NDArray[Any], before_episode: Any) -> npt.NDArray[Any]:
    """A table with the row of `before_episode` below it, as one line."""
    row = np.broadcast_to(before_episode, table.shape[1:])
    return np.concatenate([table.ravel(), row]).astype(table.dtype)
