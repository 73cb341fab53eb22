"""A Markov decision process as rows of choices: the one form that every solver here reads.

A *choice* is a state together with one of its available actions. Choices are numbered by state, then action, so those
of a state are adjacent and a maximum over actions is one `reduceat`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.errors import InvalidArgumentError
from ltlc.splitmix import STEP, mix_all

IntArray = npt.NDArray[np.integer[Any]]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


class ExplicitMDP:
    """States, choices and where each choice leads.

    Args:
        matrix: see the attribute of that name; may also be a function that makes it, called when it is first needed.

    Attributes:
        choice_start: (n_states + 1,); the choices of state s are choice_start[s] .. choice_start[s + 1] - 1; one at
            least.
        choice_action: (n_choices,), the action of each choice.
        initial: (n_states,), distribution of the first state.
        exit_probability: (n_choices,), probability (or weight) of leaving the process; 0 exactly where nothing does.
        n_actions: number of actions, available or not.
    """

    def __init__(
        self,
        matrix: Any,
        choice_start: IntArray,
        choice_action: IntArray,
        initial: FloatArray,
        *,
        exit_probability: FloatArray | None = None,
        n_actions: int | None = None,
    ) -> None:
        self._matrix: Any | Callable[[], Any] = matrix
        self.choice_start = choice_start
        self.choice_action = choice_action
        self.initial = initial
        self.exit_probability: FloatArray = (
            np.zeros(len(choice_action)) if exit_probability is None else exit_probability
        )
        self.n_actions = int(choice_action.max()) + 1 if n_actions is None else n_actions

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.choice_start) - 1

    @property
    def n_choices(self) -> int:
        """Number of pairs of a state and an action available there."""
        return len(self.choice_action)

    @cached_property
    def matrix(self) -> Any:
        """scipy.sparse.csr_array (n_choices, n_states), entries > 0.

        Rows sum to at most 1; what is missing to 1 leaves the process (an episode that stops, a discount).
        """
        return self._matrix() if callable(self._matrix) else self._matrix

    @cached_property
    def choice_state(self) -> IntArray:
        """The state of each choice, shape (n_choices,)."""
        return np.repeat(np.arange(self.n_states, dtype=np.int32), np.diff(self.choice_start))

    @cached_property
    def support(self) -> Support:
        """The same process as a graph: where choices may lead, without how likely."""
        return _merged_by_support(self)

    @cached_property
    def columns(self) -> Any:
        """`matrix` by columns (csc_array): which choices may enter a state."""
        return self.matrix.tocsc()

    @cached_property
    def adjacency(self) -> Any:
        """Which states may follow which under some choice, csr_array of bool (n_states, n_states)."""
        matrix = self.matrix
        edges = sparse.csr_array((np.ones(matrix.nnz, dtype=np.bool_), matrix.indices, matrix.indptr), matrix.shape)
        if self.n_choices == self.n_states:
            return edges
        own = (np.ones(self.n_choices, dtype=np.bool_), np.arange(self.n_choices, dtype=np.int32), self.choice_start)
        return sparse.csr_array(own, shape=(self.n_states, self.n_choices)) @ edges

    @cached_property
    def reachable(self) -> BoolArray:
        """The states that some policy visits from an initial one, shape (n_states,)."""
        edges = self.adjacency
        seen = self.initial > 0
        frontier = np.flatnonzero(seen)
        while frontier.size:
            found = edges.indices[ranges(edges.indptr[frontier], np.diff(edges.indptr)[frontier])]
            frontier = np.unique(found[~seen[found]])
            seen[frontier] = True
        return seen

    def expect(self, value: FloatArray) -> FloatArray:
        """The mean of a quantity (n_states,) after each choice, shape (n_choices,): `matrix @ value`."""
        return np.asarray(self.matrix @ value)

    def best(self, choice_value: FloatArray) -> FloatArray:
        """The largest value among the choices of each state, shape (n_states,)."""
        return np.maximum.reduceat(choice_value, self.choice_start[:-1])

    def greedy(self, choice_value: FloatArray) -> IntArray:
        """The first choice of each state that has the largest value, shape (n_states,)."""
        is_best = choice_value >= self.best(choice_value)[self.choice_state]
        candidate = np.where(is_best, np.arange(self.n_choices, dtype=np.int32), np.int32(self.n_choices))
        return np.minimum.reduceat(candidate, self.choice_start[:-1])

    def enters(self, states: BoolArray) -> BoolArray:
        """The choices that lead into `states` with positive probability, shape (n_choices,)."""
        return row_any(self.matrix, states)

    def reweighted(self, factor: float) -> ExplicitMDP:
        """The process in which every step goes on only with weight `factor` (a discount in [0, 1])."""
        if factor == 1:
            return self
        if not 0 <= factor < 1:
            raise InvalidArgumentError(f"discount {factor} is not in [0, 1]")
        exit_probability = self.exit_probability + (1 - factor) * np.asarray(self.matrix.sum(axis=1)).ravel()
        return ExplicitMDP(
            self.matrix * factor,
            self.choice_start,
            self.choice_action,
            self.initial,
            exit_probability=exit_probability,
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


@dataclass(frozen=True, eq=False)
class Support:
    """The graph of a process: choices of a state that may lead to the same states are one choice here.

    Whether something can happen, or can be enforced with probability 0 or 1, depends on this graph alone. In a noisy
    grid world, where every action may turn out as every other, it is five times smaller than the process.

    Attributes:
        graph: its `matrix` says only which entries there are, and its `exit_probability` only whether there is one.
        of_choice: shape (n_choices,), the choice of the graph that stands for each choice of the process.
    """

    graph: ExplicitMDP
    of_choice: IntArray

    def merged(self, choices: BoolArray) -> BoolArray:
        """A set of choices of the process as one of the graph: those that stand for one of the set."""
        found = np.zeros(self.graph.n_choices, dtype=np.bool_)
        found[self.of_choice[choices]] = True
        return found


def graph_of(mdp: ExplicitMDP, choices: BoolArray) -> tuple[Support, BoolArray]:
    """A graph that can tell the given choices from all others, and the given choices in it."""
    support = mdp.support
    merged = support.merged(choices)
    if np.array_equal(merged[support.of_choice], choices):
        return support, merged
    return Support(mdp, np.arange(mdp.n_choices)), choices


def _merged_by_support(mdp: ExplicitMDP) -> Support:
    """The support of any process: equal rows are found by a hash and then compared entry by entry."""
    matrix = mdp.matrix
    if not matrix.has_sorted_indices:
        matrix = matrix.sorted_indices()
    length = np.diff(matrix.indptr)
    code = np.concatenate(([np.uint64(0)], np.cumsum(_hashed(matrix.indices), dtype=np.uint64)))
    key = code[matrix.indptr[1:]] - code[matrix.indptr[:-1]]
    order = np.lexsort((key, mdp.choice_state))  # stable: of equal ones the first comes first
    state, key = mdp.choice_state[order], key[order]
    leaks, size = mdp.exit_probability[order] > 0, length[order]
    alike = np.zeros(mdp.n_choices, dtype=np.bool_)
    alike[1:] = (state[1:] == state[:-1]) & (key[1:] == key[:-1]) & (leaks[1:] == leaks[:-1]) & (size[1:] == size[:-1])
    second = np.flatnonzero(alike)
    start = matrix.indptr[:-1]
    ours = matrix.indices[ranges(start[order[second]], size[second])]
    theirs = matrix.indices[ranges(start[order[second - 1]], size[second])]
    differs = np.repeat(second, size[second])[ours != theirs]
    alike[differs] = False
    if not alike.any():
        return Support(mdp, np.arange(mdp.n_choices, dtype=np.int32))
    group = np.cumsum(~alike) - 1
    first = order[~alike]  # of each group its first choice
    by_choice = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int32)
    rank[by_choice] = np.arange(len(first), dtype=np.int32)
    of_choice = np.empty(mdp.n_choices, dtype=np.int32)
    of_choice[order] = rank[group]
    return Support(_restricted(mdp, first[by_choice]), of_choice)


def _restricted(mdp: ExplicitMDP, rows: IntArray) -> ExplicitMDP:
    """The graph of the given choices, at least one per state, in order."""
    matrix = mdp.matrix
    length = np.diff(matrix.indptr)[rows]
    indices = matrix.indices[ranges(matrix.indptr[rows], length)]
    indptr = np.concatenate(([0], np.cumsum(length))).astype(matrix.indptr.dtype)
    graph = sparse.csr_array((np.ones(len(indices), dtype=np.bool_), indices, indptr), shape=(len(rows), mdp.n_states))
    counts = np.bincount(mdp.choice_state[rows], minlength=mdp.n_states)
    start = np.concatenate(([0], np.cumsum(counts))).astype(np.int32)
    exit_probability = (mdp.exit_probability[rows] > 0).astype(np.float64)
    return ExplicitMDP(
        graph, start, mdp.choice_action[rows], mdp.initial, exit_probability=exit_probability, n_actions=mdp.n_actions
    )


def _hashed(number: IntArray) -> npt.NDArray[np.uint64]:
    """A fixed 64-bit hash of each number."""
    return mix_all(number.astype(np.uint64) * np.uint64(STEP))


def row_any(matrix: Any, columns: BoolArray) -> BoolArray:
    """Whether each row of a csr_array has an entry in one of the marked columns, shape (n_rows,)."""
    result = np.zeros(matrix.shape[0], dtype=np.bool_)
    filled = np.flatnonzero(np.diff(matrix.indptr))
    if filled.size:
        result[filled] = np.logical_or.reduceat(columns[matrix.indices], matrix.indptr[filled])
    return result


def ranges(start: IntArray, length: IntArray) -> IntArray:
    """The numbers start[i], ..., start[i] + length[i] - 1 for every i, one after the other.

    >>> ranges(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    before = np.cumsum(length) - length
    return np.repeat(start - before, length) + np.arange(int(length.sum()))
