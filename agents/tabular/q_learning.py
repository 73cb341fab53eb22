"""Q-learning and double Q-learning with tables, for many environments and all automaton states at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ..tensor_tables import reachable_states
from .config import QLearningConfig
from .experience import Batch, Experience, IntArray
from .learned import Callback, Learned, Stopwatch

FloatArray = npt.NDArray[np.float64]


def train_q_learning(
    env: VectorEnv[Any, Any, Any],
    config: QLearningConfig | None = None,
    *,
    callback: Callback | None = None,
) -> Learned:
    """Learn the values of the reward tables of an `LTLVectorWrapper`; the policy is over their states.

    Where nothing discounts the steps between acceptances, as in `zeta-discount` and `zeta-reach`, noise that the
    maximum picks up goes round for long: there, take `double=True`, or a smaller `horizon` and more steps.

    Raises:
        InvalidArgumentError: see `Experience`; or the task leaves the choice of a Rabin pair to the policy.

    References:
        See `QLearningConfig`.
    """
    config = config or QLearningConfig()
    watch = Stopwatch()
    experience, generator = Experience(env, config.seed), np.random.default_rng([config.seed, 1])
    learner = _QLearner(experience, config, generator)
    reported = 0
    while True:
        done = experience.steps / config.total_steps
        epsilon = config.epsilon_start + (config.epsilon_final - config.epsilon_start) * min(2 * done, 1)
        learner.update(experience.step(learner.explore(epsilon)))
        over = experience.steps >= config.total_steps
        if over or experience.steps // config.log_every > reported:
            reported = experience.steps // config.log_every
            learned = learner.learned(watch)
            if watch.report(callback, learned) or over:
                return learned


class _QLearner:
    def __init__(self, experience: Experience, config: QLearningConfig, generator: np.random.Generator) -> None:
        self.experience, self.config, self.generator = experience, config, generator
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

    def explore(self, epsilon: float) -> IntArray:
        """Epsilon-greedy actions, in the mean of the tables."""
        state, q = self.experience.state, self.experience.table_state
        self.visited[state, q] = True
        value = sum(table[state, :, q] for table in self.q)
        random = self.generator.integers(self.experience.n_actions, size=len(state))
        return np.where(self.generator.random(len(state)) < epsilon, random, np.argmax(value, axis=1))

    def update(self, batch: Batch) -> None:
        """Teach one step of each sub-environment."""
        if self.config.double:
            first = self.generator.random(len(batch.state)) < 0.5
            self._teach(_part(batch, first), 0, 1)
            self._teach(_part(batch, ~first), 1, 0)
        else:
            self._teach(batch, 0, 0)
        weight = min(len(batch.state) / self.config.averaging_steps, 1.0)
        self.average += weight * (sum(self.q) / len(self.q) - self.average)

    def learned(self, watch: Stopwatch) -> Learned:
        """The greedy policy."""
        state, q = self.first
        visited = int(self.visited.sum())
        return Learned(
            policy=np.asarray(self.average.argmax(axis=1)),
            message=f"{visited} product states visited",
            steps=self.experience.steps,
            seconds=watch.seconds,
            product_states=visited,
            accepting_components=None,
            value=float(self.average[state, :, q].max(axis=1).mean()),
            seen=self.experience.seen,
            counterfactual=self.config.counterfactual,
        )

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
