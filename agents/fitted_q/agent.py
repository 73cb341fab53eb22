"""Fitted Q iteration: values of numbered observations, fitted to all experience at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..training.contents import Content, n_features, numbers_in
from ..value_agent import ValueAgent
from .config import FittedQConfig
from .table import GROWTH, LARGEST, LAST_SWEEPS, SWEEPS, QTable, VisitCounts, fit

_TIE = 1e-12
"""values of a table that differ by less are alike, in units of the reward scale."""
_WANDERING = 0.2
"""probability of a random action of those that go where little was tried."""


class FittedQ(ValueAgent):
    """Fitted Q iteration of one task with a table of values; for observations that can be numbered.

    Nothing is approximated, so that rewards can be told apart that differ by a hundred thousandth, as the schemes that
    maximise the probability of satisfaction need it.

    Args:
        observation_space: see `ValueAgent`; discrete.
        n_actions: see `ValueAgent`.
        tables: see `ValueAgent`.
        config: hyperparameters.

    Attributes:
        table: the values; they are on the CPU, and act while training and afterwards.
        updates: fits made.

    Raises:
        InvalidArgumentError: observations cannot be numbered, or the table would be too large.

    Example:
        >>> from gymnasium.spaces import Discrete
        >>> FittedQ(Discrete(4), 2, None, FittedQConfig()).q_values([0, 3]).shape
        (2, 1, 2)

    References:
        See `FittedQConfig`.
    """

    name = "fitted-q"
    config_type = FittedQConfig

    def __init__(
        self, observation_space: spaces.Space[Any], n_actions: int, tables: RewardTables | None, config: FittedQConfig
    ) -> None:
        super().__init__(observation_space, n_actions, tables, config)
        self._config = config
        obstacle = why_no_table(self.encoder, self.tables.n_states, n_actions)
        if obstacle:
            raise InvalidArgumentError(f"{obstacle}; take the agent 'double-dqn'")
        self.table = QTable(self.encoder.n_observations, self.tables.n_states, n_actions)
        self.policy_network = self.table

    @property
    def config(self) -> FittedQConfig:
        """The hyperparameters."""
        return self._config

    def network_inputs(self, packed: Tensor) -> Tensor:
        """Number packed observations, shape (batch,)."""
        return self.encoder.index(packed)

    def new_memory(self, num_envs: int) -> VisitCounts:
        """Make the empty experience."""
        return VisitCounts(self.encoder, self.n_actions, self.tables.n_classes)

    @torch.no_grad()
    def explore(
        self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64], epsilon: float, generator: torch.Generator
    ) -> npt.NDArray[np.int64]:
        """Choose actions for training, shape (batch,).

        The first `epsilon` of the batch mostly go where little was tried, and the others are greedy but for what the
        values may be wrong by. Draws the same amount from the generator whatever happens.
        """
        n, row = len(packed), self.encoder.index(torch.from_numpy(packed))
        random = torch.randint(self.n_actions, (n,), generator=generator)
        chance = torch.rand(n, generator=generator, dtype=torch.float64)
        uncertainty = self.table.uncertainty[row].repeat(1, self.tensor_tables.n_options)
        known = self.evaluate(self.table, packed, states) + uncertainty
        bonus = self.table.exploration_bonus[row, torch.from_numpy(states)]
        known, bonus = (v + _TIE * torch.rand(v.shape, generator=generator, dtype=v.dtype) for v in (known, bonus))
        seeker = torch.where(chance < _WANDERING, random, bonus.argmax(dim=-1))
        seeks = torch.arange(n) + 0.5 < epsilon * n
        return torch.where(seeks, seeker, known.argmax(dim=-1)).numpy()

    def learn(self, memory: VisitCounts, steps: int, rounds: int, generator: torch.Generator) -> list[float]:
        """Fit the table, if there is enough new experience; returns the largest change of the last sweep."""
        due = len(memory) >= max(self.config.learning_starts, GROWTH * memory.fitted)
        return [self.fit(memory)] if due else []

    def finish(self, memory: VisitCounts) -> None:
        """Fit the table until nothing changes any more."""
        if len(memory):
            self.fit(memory, to_the_end=True)

    def fit(self, memory: VisitCounts, *, to_the_end: bool = False) -> float:
        """Fit the table to all experience; returns the largest change of the last sweep, in units of the reward scale.

        Args:
            memory: the experience.
            to_the_end: whether to go on until nothing changes any more.
        """
        learned, scale = self.tensor_tables.learned.numpy(), self.tensor_tables.scale
        change = fit(self.table, memory, self.tables, learned, scale, LAST_SWEEPS if to_the_end else SWEEPS)
        self.updates += 1
        memory.fitted = len(memory)
        return change

    def state_dict(self) -> dict[str, Any]:
        """Return everything that learning changes, as tensors and numbers."""
        return {"policy_network": self.table.state_dict(), "updates": self.updates}

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: it is of another agent.
        """
        content["policy_network"].state_of(self.table)
        content["updates"].count()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""
        self.table.load_state_dict(state["policy_network"])
        self.updates = int(state["updates"])

    @classmethod
    def check_size(
        cls, network: Content, config: FittedQConfig, space: spaces.Space[Any], n_states: int, n_actions: int
    ) -> None:
        """Check that a table can be made, and has no more entries than the file; see `ValueAgent`."""
        held = numbers_in(network)
        network.check(n_features(space, "one-hot") <= held, "has fewer entries than there are observations")
        obstacle = why_no_table(ObservationEncoder(space), n_states, n_actions)
        network.check(not obstacle, f"cannot be: {obstacle}")


def why_no_table(encoder: ObservationEncoder, n_states: int, n_actions: int) -> str:
    """Say why a table of values cannot be kept; empty if it can."""
    if not encoder.n_observations:
        return f"the observations {encoder.space} cannot be numbered"
    entries = encoder.n_observations * n_states * n_actions
    return f"a table would have {entries} entries, more than {LARGEST}" if entries > LARGEST else ""
