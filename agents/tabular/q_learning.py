"""Q-learning and double Q-learning with tables, for many environments and all automaton states at once."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from ..tensor_tables import reachable_states
from ..training.contents import Content
from ..training.metrics import Row
from ..training.shortcomings import shortcomings
from .config import QLearningConfig
from .experience import Batch, Experience, IntArray
from .learner import Found, TabularLearner
from .run import train_learner

FloatArray = npt.NDArray[np.float64]


class QLearning(TabularLearner):
    """Learns the values of the reward tables of an `LTLVectorWrapper`; the policy is over their states.

    Where nothing discounts the steps between acceptances, as in `zeta-discount` and `zeta-reach`, noise that the
    maximum picks up goes round for long: there, take `double=True`, or a smaller `horizon` and more steps.

    References:
        See `QLearningConfig`.
    """

    config: QLearningConfig

    def __init__(self, experience: Experience, config: QLearningConfig) -> None:
        super().__init__(experience, config)
        tables = experience.tables
        self.reward, self.discount = tables.expected_reward, tables.expected_discount
        self.next_state, self.final_value = tables.next_state, tables.final_value
        self.first = experience.state, experience.table_state
        self.learned_states = reachable_states(tables)
        n_tables = 2 if config.double else 1
        shape = (experience.n_states, experience.n_actions, tables.n_states)
        self.q: list[FloatArray] = [np.zeros(shape) for _ in range(n_tables)]
        self.updates: list[IntArray] = [np.zeros(shape, dtype=np.int64) for _ in range(n_tables)]
        self.average: FloatArray = np.zeros(shape)
        self.visited = np.zeros((experience.n_states, tables.n_states), dtype=np.bool_)

    def step(self) -> None:
        """Make one step in each sub-environment, epsilon-greedy in the mean of the tables, and learn from it."""
        state, q = self.experience.state, self.experience.table_state
        self.visited[state, q] = True
        value = sum(table[state, :, q] for table in self.q)
        self._update(self.experience.step(self.explore(np.argmax(value, axis=1))))

    def plan(self) -> Found:
        """Act greedily."""
        state, q = self.first
        visited = int(self.visited.sum())
        return np.asarray(self.average.argmax(axis=1)), Row(
            steps=self.experience.steps,
            value=float(self.average[state, :, q].max(axis=1).mean()),
            product_states=visited,
            message=f"{visited} product states visited",
        )

    def shortcomings(self) -> tuple[str, ...]:
        """Say what the steps lacked."""
        steps, counterfactual = self.experience.steps, self.config.counterfactual
        return tuple(shortcomings(self.experience.seen, steps, counterfactual=counterfactual))

    def state_dict(self) -> dict[str, Any]:
        """Return the tables, how often they were taught, and what was visited."""
        tables = {name: [torch.from_numpy(part) for part in getattr(self, name)] for name in ("q", "updates")}
        return {**tables, "average": torch.from_numpy(self.average), "visited": torch.from_numpy(self.visited)}

    def load_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file, and go back to it."""
        shape, n = self.average.shape, len(self.q)
        self.q = [part.tensor(torch.float64, shape).numpy() for part in content["q"].entries(n)]
        self.updates = [part.indices(torch.int64, shape, 2**53).numpy() for part in content["updates"].entries(n)]
        self.average = content["average"].tensor(torch.float64, shape).numpy()
        self.visited = content["visited"].tensor(torch.bool, self.visited.shape).numpy()

    def _update(self, batch: Batch) -> None:
        """Teach one step of each sub-environment."""
        if self.config.double:
            first = self.generator.random(len(batch.state)) < 0.5
            self._teach(_part(batch, first), 0, 1)
            self._teach(_part(batch, ~first), 1, 0)
        else:
            self._teach(batch, 0, 0)
        weight = min(len(batch.state) / self.config.averaging_steps, 1.0)
        self.average += weight * (sum(self.q) / len(self.q) - self.average)

    def _teach(self, batch: Batch, own: int, other: int) -> None:
        """Move table `own` towards targets in which `own` chooses the next action and `other` values it."""
        if not len(batch.state):
            return
        q_in = self.learned_states[None, :] if self.config.counterfactual else batch.table_state[:, None]
        letter = batch.letter_class[:, None]
        q_out = self.next_state[q_in, letter]
        after = batch.next_state[:, None]
        best = self.q[own][batch.next_state].argmax(axis=1)[np.arange(len(after))[:, None], q_out]
        following = np.where(
            batch.terminated[:, None], self.final_value[q_in, letter], self.q[other][after, best, q_out]
        )
        target = self.reward[q_in, letter] + self.discount[q_in, letter] * following
        index = np.broadcast_to(batch.state[:, None], target.shape), batch.action[:, None], q_in
        flat = np.ravel_multi_index(np.broadcast_arrays(*index), self.q[own].shape).ravel()
        place, where, count = np.unique(flat, return_inverse=True, return_counts=True)
        mean = np.bincount(where, target.ravel()) / count
        table, updates = self.q[own].reshape(-1), self.updates[own].reshape(-1)
        updates[place] += count
        # several steps from one place at once move the value as far as one after the other would
        rate = 1 - (1 - (self.config.horizon + 1) / (self.config.horizon + updates[place])) ** count
        table[place] += rate * (mean - table[place])


def _part(batch: Batch, chosen: npt.NDArray[np.bool_]) -> Batch:
    return Batch(*(getattr(batch, name)[chosen] for name in Batch.__dataclass_fields__))


train = partial(train_learner, QLearning)
"""the trainer of the registry, also of double Q-learning."""
