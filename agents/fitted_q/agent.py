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
from ..tensor_tables import permitted, without_forbidden
from ..training.contents import Content
from ..training.memory import check_memory
from ..value_agent import ValueAgent
from .config import FittedQConfig
from .numbering import Numbering
from .table import BYTES_PER_ENTRY, LARGEST, LAST_SWEEPS, SWEEPS, QTable, fit
from .visits import VisitCounts

_TIE = 1e-12
"""values of a table that differ by less are alike, in units of the reward scale."""
_WANDERING = (0.0, 0.05, 0.2)
"""probability of a random action of those that go where little was tried, in turns: some never stray from the way, lest
what takes many right steps in a row is not found."""
_LAST_ROUND = 10_000
"""observations that may be seen when all sub-environments step once more."""


class FittedQ(ValueAgent):
    """Fitted Q iteration of one task with a table of values; for observations of whole numbers.

    The table has a row for each observation that was seen. Nothing is approximated, so that rewards can be told apart
    that differ by a hundred thousandth, as the schemes that maximise the probability of satisfaction need it.

    Args:
        observation_space: see `ValueAgent`; of whole numbers.
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
        obstacle = why_no_table(self.encoder, self.tables.n_states, n_actions, config.total_steps)
        if obstacle:
            raise InvalidArgumentError(f"{obstacle}; take the agent 'double-dqn'")
        self.table = QTable(self._numbering(), self.tables.n_states, n_actions)
        self.policy_network = self.table

    def _numbering(self) -> Numbering:
        most = most_observations(self.encoder, self.config.total_steps)
        mask = self.encoder.mask
        width = self.encoder.width if mask is None else mask.columns.start
        return Numbering(width, self.encoder.dtype, most)

    @property
    def config(self) -> FittedQConfig:
        """The hyperparameters."""
        return self._config

    def network_inputs(self, packed: Tensor) -> Tensor:
        """Find the rows of packed observations, shape (batch,)."""
        return torch.from_numpy(self.table.find(packed.numpy()))

    def check_memory(self, num_envs: int, *, copied: bool) -> None:
        """Check that the table fits into memory if every step shows something new; see `ValueAgent`."""
        most = most_observations(self.encoder, self.config.total_steps)
        needed = BYTES_PER_ENTRY * most * len(self.tensor_tables.learned) * self.n_actions
        check_memory(
            f"a table of up to {most} observations", needed, "cpu", "lower total_steps, or take the agent 'double-dqn'"
        )

    def new_memory(self, num_envs: int) -> VisitCounts:
        """Make the empty experience."""
        encoder = None if self.encoder.mask is None else self.encoder
        return VisitCounts(self._numbering(), self.n_actions, self.tables.n_classes, encoder)

    @torch.no_grad()
    def explore(
        self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64], epsilon: float, generator: torch.Generator
    ) -> npt.NDArray[np.int64]:
        """Choose actions for training, shape (batch,).

        The first `epsilon` of the batch go where little was tried, some of them with random steps in between, and the
        others are greedy but for what the values may be wrong by. Draws the same amount from the generator whatever
        happens.
        """
        n, row = len(packed), self.table.find(packed)
        allowed = self.encoder.allowed(torch.from_numpy(packed))
        random = permitted(torch.randint(self.n_actions, (n,), generator=generator), allowed, generator).numpy()
        chance = torch.rand(n, generator=generator, dtype=torch.float64).numpy()
        uncertainty, bonus = (t.numpy() for t in (self.table.uncertainty, self.table.exploration_bonus))
        values = self.evaluate_inputs(self.table, torch.from_numpy(row), states)
        known = without_forbidden(values, allowed).numpy() + np.tile(uncertainty[row], self.tensor_tables.n_options)
        known, bonus = (
            v + _TIE * torch.rand(v.shape, generator=generator, dtype=torch.float64).numpy()
            for v in (known, without_forbidden(torch.from_numpy(bonus[row, states]), allowed).numpy())
        )
        seeker = np.where(chance < np.resize(_WANDERING, n), random, bonus.argmax(axis=-1))
        return np.where(np.arange(n) + 0.5 < epsilon * n, seeker, known.argmax(axis=-1))

    def learn(self, memory: VisitCounts, steps: int, rounds: int, generator: torch.Generator) -> list[float]:
        """Fit the table, if there is enough new experience; returns the largest change of the last sweep."""
        return [self.fit(memory)] if len(memory) >= self.config.learning_starts and memory.due else []

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
        memory.fitted, memory.fitted_rows = len(memory), len(memory.numbering)
        return change

    def state_dict(self) -> dict[str, Any]:
        """Return everything that learning changes, as tensors and numbers."""
        return {"policy_network": self.policy_state(), "updates": self.updates}

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: it is of another agent.
        """
        self.check_policy(content["policy_network"])
        content["updates"].count()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""
        self.load_policy(state["policy_network"])
        self.updates = int(state["updates"])

    def policy_state(self) -> dict[str, Tensor]:
        """Return the table and the observations of its rows, for a file."""
        return self.table.content()

    def check_policy(self, content: Content) -> dict[str, Tensor]:
        """Check and return what `policy_state` gave, read from a file; raises FileFormatError."""
        return self.table.check_content(content)

    def load_policy(self, state: dict[str, Tensor]) -> None:
        """Go back to what `policy_state` gave."""
        self.table.load_content(state)

    @classmethod
    def check_size(
        cls, network: Content, config: FittedQConfig, space: spaces.Space[Any], n_states: int, n_actions: int
    ) -> None:
        """Check that a table can be made; an empty one is, whatever the file says. See `ValueAgent`."""
        obstacle = why_no_table(ObservationEncoder(space), n_states, n_actions, config.total_steps)
        network.check(not obstacle, f"cannot be: {obstacle}")


def why_no_table(encoder: ObservationEncoder, n_states: int, n_actions: int, steps: int | None = None) -> str:
    """Say why a table of values cannot be kept; empty if it can.

    Args:
        encoder: of the observations.
        n_states: table states.
        n_actions: actions.
        steps: environment steps that show observations; None: it is to have room for all there can be.
    """
    if not encoder.discrete or (steps is None and not encoder.n_observations):
        return f"the observations {encoder.space} cannot be numbered"
    most = encoder.n_observations if steps is None else most_observations(encoder, steps)
    entries = most * n_states * n_actions
    return f"a table would have {entries} entries, more than {LARGEST}" if entries > LARGEST else ""


def most_observations(encoder: ObservationEncoder, steps: int) -> int:
    """How many observations can be seen in so many environment steps, the first ones of episodes included."""
    shown = 2 * steps + _LAST_ROUND
    return min(encoder.n_observations or shown, shown)
