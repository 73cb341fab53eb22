"""A learned table as an agent: it acts, it is judged, it is kept in a file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces

from ltlc.envs import LTLVectorWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables
from ltlc.task import Task

from ..config import AgentConfig
from ..encoder import ObservationEncoder, n_features
from ..training.contents import Content, space_of, tables_of
from ..training.storage import plain_space, read_file, tables_to_tensors, write_file
from .experience import Experience

IntArray = npt.NDArray[np.int64]

_FILE_KIND = "table"
_ROUNDING = 1e-6
"""by which the probabilities in a file may miss 1."""


class TablePolicy:
    """An action, or probabilities of actions, for each pair of observation and state of the reward tables.

    Args:
        observation_space: of a single environment, without the automaton; discrete.
        n_actions: of the environment.
        tables: reward tables of the task.
        table: shape (n_observations, n_table_states), int; or (n_observations, n_table_states, n_actions), float.

    Attributes:
        encoder: of the observations.

    Raises:
        InvalidArgumentError: the table has another shape.
    """

    def __init__(
        self, observation_space: spaces.Space[Any], n_actions: int, tables: RewardTables, table: npt.NDArray[Any]
    ) -> None:
        self.encoder = ObservationEncoder(observation_space)
        self.n_actions, self.tables, self.table = n_actions, tables, np.ascontiguousarray(table)
        pairs = (self.encoder.n_observations, tables.n_states)
        if table.shape not in (pairs, (*pairs, n_actions)):
            raise InvalidArgumentError(f"a table of shape {table.shape} for {pairs} observations and table states")
        self.reseed(0)

    @classmethod
    def learned_task(cls, env: LTLVectorWrapper, config: AgentConfig) -> Task:
        """The task of an environment, as it is."""
        return env.task

    @classmethod
    def check(cls, env: LTLVectorWrapper, config: AgentConfig) -> None:
        """Check that a tabular learner can learn the task of an environment.

        Raises:
            InvalidArgumentError: observations are not discrete, or the rewards want more than actions.
        """
        Experience(env, config.seed)

    @property
    def action_repeat(self) -> int:
        """Steps for which an action is held: 1."""
        return 1

    def reseed(self, seed: int) -> None:
        """Let what the policy draws begin anew from a seed."""
        self._generator = np.random.default_rng(seed)

    def policy_table(self) -> npt.NDArray[Any]:
        """Return the table: actions, or their probabilities."""
        return self.table

    def packed_policy(self, packed: npt.NDArray[Any], states: IntArray) -> IntArray:
        """Actions for observations that the encoder has packed, shape (batch,)."""
        chosen = self.table[self.encoder.index(torch.from_numpy(packed)).numpy(), states]
        if self.table.ndim == 2:
            return np.asarray(chosen)
        below = chosen.cumsum(axis=1) < self._generator.random((len(chosen), 1))
        return np.asarray(np.minimum(below.sum(axis=1), self.n_actions - 1))

    def save(self, path: str | os.PathLike[str], *, run: str = "") -> Path:
        """Write the policy to a file, complete or not at all.

        Args:
            path: of the file.
            run: identity of the training run that it belongs to.

        Raises:
            OSError: the folder is missing, not writable or full; an older file is as it was.
        """
        return write_file(path, _FILE_KIND, {
            "observation_space": plain_space(self.encoder.space),
            "n_actions": self.n_actions,
            "tables": tables_to_tensors(self.tables),
            "table": torch.from_numpy(self.table),
        }, run)  # fmt: skip

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, device: str | None = None) -> TablePolicy:
        """The policy that was saved; nothing in the file is executed.

        Raises:
            FileFormatError: the file is damaged, of another kind, or a value in it is wrong.
            OSError: the file is missing or not readable.
        """
        content = read_file(path, _FILE_KIND)
        space, tables = space_of(content["observation_space"]), tables_of(content["tables"])
        n_actions, table = content["n_actions"].count(1), content["table"]
        entries = table.value
        table.check(isinstance(entries, torch.Tensor), "is not a tensor")
        table.check(n_features(space, "one-hot") <= entries.numel(), "has fewer entries than there are observations")
        pairs = (ObservationEncoder(space).n_observations, tables.n_states)
        table.check(pairs[0] > 0, "is for observations that are not numbered")
        return cls(space, n_actions, tables, table_of(table, pairs, n_actions))


def table_of(content: Content, pairs: tuple[int, int], n_actions: int) -> npt.NDArray[Any]:
    """Check the table of a policy that was read from a file.

    Args:
        content: of the file.
        pairs: numbers of observations and of table states.
        n_actions: number of actions.

    Raises:
        FileFormatError: it is of another shape, or has something else than actions or their probabilities.
    """
    entries = content.value
    content.check(isinstance(entries, torch.Tensor), "is not a tensor")
    if not entries.is_floating_point():
        return np.asarray(content.indices(entries.dtype, pairs, n_actions).numpy())
    chances = content.tensor(torch.float64, (*pairs, n_actions))
    proper = (chances >= 0).all() and ((chances.sum(dim=-1) - 1).abs() <= _ROUNDING).all()
    content.check(bool(proper), "has rows that are no probabilities")
    return np.asarray(chances.numpy())
