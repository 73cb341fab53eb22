"""A Markov decision process as rows of choices: the one form that every solver here reads.

A *choice* is a state together with one of its available actions. Choices are numbered by state, then action, so those
of a state are adjacent and a maximum over actions is one `reduceat`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.errors import InvalidArgumentError

IntArray = npt.NDArray[np.integer[Any]]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


class ExplicitMDP:
    """States, choices and where each choice leads.

    Attributes:
        matrix: scipy.sparse.csr_array (n_choices, n_states), entries > 0. Rows sum to at most 1; what is missing to 1
            leaves the process (an episode that stops, a discount).
        choice_start: (n_states + 1,); the choices of state s are choice_start[s] .. choice_start[s + 1] - 1; one at
            least.
        choice_action: (n_choices,), the action of each choice.
        initial: (n_states,), distribution of the first state.
        leak: (n_choices,), the probability (or weight) that leaves the process; exactly 0 where nothing does.
        n_actions: number of actions, available or not.
    """

    def __init__(
        self,
        matrix: Any,
        choice_start: IntArray,
        choice_action: IntArray,
        initial: FloatArray,
        *,
        leak: FloatArray | None = None,
        n_actions: int | None = None,
    ) -> None:
        self.matrix = matrix
        self.choice_start = choice_start
        self.choice_action = choice_action
        self.initial = initial
        self.leak: FloatArray = np.zeros(matrix.shape[0]) if leak is None else leak
        self.n_actions = int(choice_action.max()) + 1 if n_actions is None else n_actions

    @property
    def n_states(self) -> int:
        """Number of states."""
        return int(self.matrix.shape[1])

    @property
    def n_choices(self) -> int:
        """Number of pairs of a state and an action available there."""
        return int(self.matrix.shape[0])

    @cached_property
    def choice_state(self) -> IntArray:
        """The state of each choice, shape (n_choices,)."""
        return np.repeat(np.arange(self.n_states), np.diff(self.choice_start))

    @cached_property
    def columns(self) -> Any:
        """`matrix` by columns (csc_array): which choices may enter a state."""
        return self.matrix.tocsc()

    @cached_property
    def reachable(self) -> BoolArray:
        """The states that some policy visits from an initial one, shape (n_states,)."""
        entries = self.matrix.indptr[self.choice_start]
        seen = self.initial > 0
        frontier = np.flatnonzero(seen)
        while frontier.size:
            found = self.matrix.indices[ranges(entries[frontier], entries[frontier + 1] - entries[frontier])]
            frontier = np.unique(found[~seen[found]])
            seen[frontier] = True
        return seen

    def best(self, choice_value: FloatArray) -> FloatArray:
        """The largest value among the choices of each state, shape (n_states,)."""
        return np.maximum.reduceat(choice_value, self.choice_start[:-1])

    def greedy(self, choice_value: FloatArray) -> IntArray:
        """The first choice of each state that has the largest value, shape (n_states,)."""
        is_best = choice_value >= self.best(choice_value)[self.choice_state]
        candidate = np.where(is_best, np.arange(self.n_choices), self.n_choices)
        return np.minimum.reduceat(candidate, self.choice_start[:-1])

    def enters(self, states: BoolArray) -> BoolArray:
        """The choices that lead into `states` with positive probability, shape (n_choices,)."""
        return np.asarray(self.matrix @ states.astype(np.float64) > 0)

    def reweighted(self, factor: float) -> ExplicitMDP:
        """The process in which every step goes on only with weight `factor` (a discount in [0, 1])."""
        if factor == 1:
            return self
        if not 0 <= factor < 1:
            raise InvalidArgumentError(f"discount {factor} is not in [0, 1]")
        leak = self.leak + (1 - factor) * np.asarray(self.matrix.sum(axis=1)).ravel()
        return ExplicitMDP(
            self.matrix * factor,
            self.choice_start,
            self.choice_action,
            self.initial,
            leak=leak,
            n_actions=self.n_actions,
        )

    def choices_of(self, policy: npt.ArrayLike) -> IntArray:
        """The choice of each state under a deterministic policy: actions, shape (n_states,).

        Raises:
            InvalidArgumentError: wrong shape, or an action that its state does not offer.
        """
        actions = np.asarray(policy)
        if actions.shape != (self.n_states,) or not np.issubdtype(actions.dtype, np.integer):
            raise InvalidArgumentError(f"a deterministic policy is one action (int) for each of {self.n_states} states")
        chosen = np.flatnonzero(self.choice_action == actions[self.choice_state])
        if len(chosen) != self.n_states:
            missing = np.setdiff1d(np.arange(self.n_states), self.choice_state[chosen])[0]
            raise InvalidArgumentError(
                f"the policy takes action {actions[missing]} in state {self.describe(missing)}, "
                f"which offers {self.actions_in(missing).tolist()}"
            )
        return chosen

    def policy_matrix(self, policy: npt.ArrayLike) -> Any:
        """A policy as csr_array (n_states, n_choices): how likely each choice is in each state.

        `policy` is deterministic (int, shape (n_states,)) or stochastic (float, shape (n_states, n_actions), rows sum
        to 1 within 1e-9, no weight on an action that is not available).

        Raises:
            InvalidArgumentError: it is neither.
        """
        given = np.asarray(policy)
        if given.ndim == 1:
            return self.choice_matrix(self.choices_of(given))
        if given.shape != (self.n_states, self.n_actions):
            raise InvalidArgumentError(
                f"a policy has shape ({self.n_states},) or ({self.n_states}, {self.n_actions}), not {given.shape}"
            )
        weight = given[self.choice_state, self.choice_action].astype(np.float64)
        total = np.add.reduceat(weight, self.choice_start[:-1])
        wrong = ~(np.abs(total - 1) <= 1e-9) | ~(given >= 0).all(axis=1)
        if wrong.any():
            state = np.flatnonzero(wrong)[0]
            raise InvalidArgumentError(
                f"the policy in state {self.describe(state)} is {given[state].tolist()}: not a probability "
                f"distribution over its actions {self.actions_in(state).tolist()}"
            )
        given_rows = (weight / total[self.choice_state], np.arange(self.n_choices), self.choice_start.copy())
        matrix = sparse.csr_array(given_rows)  # of a copy, since zeros are taken out in place
        matrix.eliminate_zeros()
        return matrix

    def choice_matrix(self, choices: IntArray) -> Any:
        """`policy_matrix` of a policy given as one choice per state."""
        n = self.n_states
        return sparse.csr_array((np.ones(n), choices, np.arange(n + 1)), shape=(n, self.n_choices))

    def actions_in(self, state: int | np.integer[Any]) -> IntArray:
        """The actions that a state offers."""
        return self.choice_action[self.choice_start[state] : self.choice_start[state + 1]]

    def describe(self, state: int | np.integer[Any]) -> str:
        """The state for a message."""
        return str(state)


def ranges(start: IntArray, length: IntArray) -> IntArray:
    """The numbers start[i], ..., start[i] + length[i] - 1 for every i, one after the other.

    >>> ranges(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    before = np.cumsum(length) - length
    return np.repeat(start - before, length) + np.arange(int(length.sum()))
