"""The Markov chain that a policy induces, and the linear systems that answer questions about it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import spsolve

from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray


class MarkovChain:
    """An MDP under one policy.

    Attributes:
        weights: csr_array (n_states, n_choices), the policy: how likely each choice is in each state.
        matrix: csr_array (n_states, n_states), rows sum to at most 1.
        initial: (n_states,), distribution of the first state.
        exit_probability: (n_states,), the probability of leaving the process; exactly 0 where it never does.
    """

    def __init__(self, matrix: Any, initial: FloatArray, exit_probability: FloatArray, weights: Any) -> None:
        self.matrix = matrix
        self.initial = initial
        self.exit_probability = exit_probability
        self.weights = weights

    @classmethod
    def under(cls, mdp: ExplicitMDP, weights: Any) -> MarkovChain:
        """The chain of an MDP under a policy given as `ExplicitMDP.policy_matrix` gives it."""
        return cls(weights @ mdp.matrix, mdp.initial, np.asarray(weights @ mdp.exit_probability), weights)

    @property
    def n_states(self) -> int:
        """Number of states, reachable or not."""
        return int(self.matrix.shape[0])

    def of_choices(self, value: FloatArray) -> FloatArray:
        """The mean per state of a quantity that is given per choice."""
        return np.asarray(self.weights @ value)

    @cached_property
    def bottom_component(self) -> IntArray:
        """Number of the bottom strongly connected component of each state, -1 for transient states.

        Leaving the process is an escape: a component from which that can happen is not a bottom one.
        """
        n_labels, label = csgraph.connected_components(self.matrix, connection="strong")
        source = np.repeat(np.arange(self.n_states), np.diff(self.matrix.indptr))
        bottom = np.ones(n_labels, dtype=np.bool_)
        bottom[label[source[label[source] != label[self.matrix.indices]]]] = False
        bottom[label[self.exit_probability > 0]] = False
        number = np.where(bottom, np.cumsum(bottom) - 1, -1)
        return np.asarray(number[label])

    def reaches(self, target: BoolArray) -> BoolArray:
        """The states from which `target` is reached with positive probability, shape (n_states,)."""
        seen = target.copy()
        columns = self.matrix.tocsc()
        frontier = np.flatnonzero(seen)
        while frontier.size:
            before = columns[:, frontier].indices
            frontier = np.unique(before[~seen[before]])
            seen[frontier] = True
        return seen

    def total(self, reward: FloatArray) -> FloatArray:
        """Expected sum of a reward (n_states,) until the process is left.

        -inf or inf where the process may stay for ever in a component that only costs or only pays, nan where it may
        stay in one that does both, or in both kinds.
        """
        bottom = self.bottom_component
        forever = bottom >= 0
        costs, pays = (self.reaches(_components_with(bottom, sign * reward > 0)) for sign in (-1, 1))
        finite = np.flatnonzero(~forever & ~costs & ~pays)
        value = np.zeros(self.n_states)
        if finite.size:
            value[finite] = solve(self.matrix[finite][:, finite], reward[finite])
        value[costs], value[pays], value[costs & pays] = -np.inf, np.inf, np.nan
        return value

    @cached_property
    def stationary(self) -> FloatArray:
        """The stationary distribution of each bottom component (each sums to 1), 0 on transient states, (n_states,)."""
        bottom = self.bottom_component
        distribution = np.zeros(self.n_states)
        inside = np.flatnonzero(bottom >= 0)
        if not inside.size:
            return distribution
        # one state of each component is fixed to 1, so that the rest is a regular system; then scaled
        anchor = inside[np.unique(bottom[inside], return_index=True)[1]]
        distribution[anchor] = 1.0
        rest = np.setdiff1d(inside, anchor)
        if rest.size:
            columns = self.matrix.tocsc()[:, rest]
            inflow = np.asarray(columns.T @ distribution)
            distribution[rest] = solve(columns[rest].T, inflow)
        weight = np.bincount(bottom[inside], distribution[inside])
        distribution[inside] /= weight[bottom[inside]]
        return distribution

    def long_run_average(self, reward: FloatArray) -> float:
        """Expected average of a reward (n_states,) per step, from the initial distribution.

        Whenever the process is left, it begins anew from the initial distribution.
        """
        chain = self.restarted()
        bottom = chain.bottom_component
        inside = np.flatnonzero(bottom >= 0)
        gain = np.bincount(bottom[inside], chain.stationary[inside] * reward[inside])
        ends_in = np.flatnonzero(gain)
        if not ends_in.size:
            return 0.0
        if len(gain) == 1:
            return float(gain[0])
        value = np.zeros(self.n_states)
        value[inside] = gain[bottom[inside]]
        transient = np.flatnonzero(bottom < 0)
        if transient.size:
            part = chain.matrix[transient]
            value[transient] = solve(part[:, transient], np.asarray(part @ value))
        return float(chain.initial @ value)

    def restarted(self) -> MarkovChain:
        """The chain that, instead of leaving the process, continues from the initial distribution."""
        if not (self.exit_probability > 0).any():
            return self
        again = sparse.csr_array(self.exit_probability[:, None]) @ sparse.csr_array(self.initial[None, :])
        return MarkovChain((self.matrix + again).tocsr(), self.initial, np.zeros(self.n_states), self.weights)


def induced_chain(mdp: ExplicitMDP, policy: npt.ArrayLike) -> MarkovChain:
    """The chain under a policy: deterministic (int, one action per state) or stochastic (float, one row per state).

    Raises:
        InvalidArgumentError: the policy does not fit the MDP.
    """
    return MarkovChain.under(mdp, mdp.policy_matrix(policy))


def solve(matrix: Any, right_hand_side: FloatArray) -> FloatArray:
    """X with x = matrix @ x + right_hand_side, by sparse LU; every state must be able to leave the matrix."""
    n = matrix.shape[0]
    system = sparse.eye_array(n, format="csc") - matrix.tocsc()
    return np.asarray(spsolve(system, right_hand_side)).reshape(n)


def _components_with(component: IntArray, marked: BoolArray) -> BoolArray:
    """All states of the components (-1: none) that have a marked state."""
    inside = component >= 0
    hit = np.zeros(int(component.max(initial=-1)) + 2, dtype=np.bool_)
    hit[component[inside & marked]] = True
    return inside & hit[component]
