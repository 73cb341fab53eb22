"""What a step would have been worth in another state of the automaton, computed for whole batches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ltlc.envs import LTLWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

IntArray = npt.NDArray[np.int64]
Array = npt.NDArray[Any]


class Outcome(NamedTuple):
    """A step of the automaton, for a batch of n.

    Attributes:
        next_state: shape (n,), the table states after it.
        reward: shape (n,), float64, what the task pays, in the mean over whether it ends the episode.
        discount: shape (n,), float64, the weight of what follows; 0 where nothing follows.
    """

    next_state: IntArray
    reward: npt.NDArray[np.float64]
    discount: npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointObservations:
    """How the state of the automaton stands in the observations of an `LTLWrapper`, and what its task pays.

    Attributes:
        tables: of the task.
        mode: of the observations, `dict`, `flat` or `index`.
        n_base: actions of the environment itself; 0: they cannot be counted.
        then: shape (n_states, 1 + n_choices), the table state after choosing a pair, or none; -1: that cannot be.

    Example:
        >>> import gymnasium, ltlc
        >>> env = ltlc.LTLWrapper(gymnasium.make("FrozenLake-v1"), "F goal", {"goal": lambda s: s == 15},
        ...                       observation="index")
        >>> joint = JointObservations.of(env)
        >>> joint.states(np.array([0, 1, 7])).tolist(), joint.moved(np.array([7]), np.array([0])).tolist()
        ([0, 1, 1], [6])
    """

    tables: RewardTables
    mode: str
    n_base: int
    then: IntArray

    @classmethod
    def of(cls, env: Any) -> JointObservations:
        """Those of an environment, in which an `LTLWrapper` must be the outermost that changes observations.

        Raises:
            InvalidArgumentError: there is no such wrapper, or its observations do not show the state.
        """
        inner = env
        while not isinstance(inner, LTLWrapper):
            if getattr(inner, "env", inner) is inner:
                raise InvalidArgumentError(f"{env} is not wrapped in an LTLWrapper")
            inner = inner.env
        if env.observation_space != inner.observation_space:
            raise InvalidArgumentError(
                f"observations of the LTLWrapper are changed outside, to {env.observation_space}"
            )
        mode = inner.observer.mode
        if mode == "none":
            raise InvalidArgumentError(
                'observation="none" does not show the state of the automaton; let the LTLWrapper have another mode'
            )
        tables, choices = inner.task.tables, inner.choices
        stay = np.arange(tables.n_states)[:, None]
        return cls(tables, mode, choices.n_base, np.hstack((stay, tables.select_pair)).astype(np.int64))

    def states(self, observations: Any) -> IntArray:
        """The table states in a batch of observations, shape (n,)."""
        n = self.tables.n_states
        if self.mode == "dict":
            return np.asarray(observations["automaton"], dtype=np.int64).reshape(-1)
        if self.mode == "index":
            return np.asarray(observations, dtype=np.int64).reshape(-1) % n
        return np.asarray(observations[:, -n:].argmax(axis=1), dtype=np.int64)

    def moved(self, observations: Any, states: IntArray) -> Any:
        """A batch of observations with other table states, shape (n,), in it; a copy."""
        n = self.tables.n_states
        if self.mode == "dict":
            given = np.asarray(observations["automaton"])
            return {**observations, "automaton": states.astype(given.dtype).reshape(given.shape)}
        if self.mode == "index":
            given = np.asarray(observations)
            return given // n * n + states.astype(given.dtype).reshape(given.shape)
        changed = observations.copy()
        changed[:, -n:] = np.eye(n, dtype=changed.dtype)[states]
        return changed

    def step(self, states: IntArray, actions: Array, letter_classes: IntArray, ended: Array) -> Outcome:
        """What a step is worth from these table states.

        Args:
            states: shape (n,).
            actions: of the wrapped environment, shape (n, ...).
            letter_classes: read on entering the next state of the environment, shape (n,).
            ended: whether the environment ended the episode, shape (n,).
        """
        tables = self.tables
        chosen = np.maximum(self.then[states, self._choice(actions, len(states))], 0)
        at = chosen, letter_classes
        follows = tables.expected_discount[at]
        reward = tables.expected_reward[at] + ended * follows * tables.final_value[at]
        return Outcome(tables.next_state[at].astype(np.int64), reward, np.where(ended, 0.0, follows))

    def drawn(self, states: IntArray, actions: Array, random: Any) -> IntArray:
        """Other table states in which the same actions could have been taken, uniformly; shape (n,)."""
        possible = (self.then >= 0)[:, self._choice(actions, len(states))].T
        weight = np.where(possible, random.random_sample(possible.shape), -1.0)
        return np.asarray(weight.argmax(axis=1), dtype=np.int64)

    def _choice(self, actions: Array, n: int) -> IntArray:
        if self.then.shape[1] == 1:
            return np.zeros(n, dtype=np.int64)
        return np.asarray(actions, dtype=np.int64).reshape(-1) // self.n_base
