"""How far ahead rewards look while learning."""

from __future__ import annotations

import dataclasses

from ltlc.task import Task

from ..tensor_tables import TensorTables
from .config import DQNConfig


class LookAhead:
    """The tables to learn from: discounts of a horizon that grows.

    A near horizon tells actions apart by how soon they lead on, so a network finds its way early; a far one tells them
    apart by what they lead to in the end, which is little where the way is long. What the way is like is known by then.

    Args:
        config: `initial_horizon`, `horizon` and `total_steps` are used.
        tables: of the last horizon.
        task: that is learned; None: its tables do not change.

    References:
        V. Francois-Lavet, R. Fonteneau, D. Ernst, How to discount deep reinforcement learning: towards new dynamic
        strategies, 2015, https://arxiv.org/abs/1512.02011.
    """

    def __init__(self, config: DQNConfig, tables: TensorTables, task: Task | None = None) -> None:
        self._config, self._last, self._task = config, tables, task
        self._horizon, self._tables = config.horizon, tables

    def tables_at(self, steps: int) -> TensorTables:
        """Return the tables after so many environment steps."""
        horizon = self._config.horizon_at(steps)
        if self._task is None or horizon == self._horizon:
            return self._tables
        self._horizon = horizon
        now = TensorTables.of(self._task.for_horizon(horizon).tables, self._last.scale, str(self._last.reward.device))
        self._tables = dataclasses.replace(
            self._last, reward=now.reward, discount=now.discount, final_value=now.final_value
        )
        return self._tables
