"""Who can get where, and who can get there surely: questions about the graph of an MDP alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from ltlc.mdp.explicit import BoolArray, ExplicitMDP, IntArray, ranges


def distance_to(mdp: ExplicitMDP, target: BoolArray, choices: BoolArray | None = None) -> IntArray:
    """Fewest steps from each state into `target` when luck helps, shape (n_states,); -1 where it cannot be reached.

    Only the given choices are used, shape (n_choices,); None means all.
    """
    columns, owner = mdp.columns, mdp.choice_state
    distance = np.where(target, 0, -1)
    used = np.zeros(mdp.n_choices, dtype=np.bool_) if choices is None else ~choices
    frontier = np.flatnonzero(target)
    level = 0
    while frontier.size:
        level += 1
        rows = columns.indices[_column_ranges(columns, frontier)]
        rows = rows[~used[rows]]
        used[rows] = True
        states = owner[rows]
        frontier = np.unique(states[distance[states] < 0])
        distance[frontier] = level
    return distance


def attractor(mdp: ExplicitMDP, target: BoolArray, choices: BoolArray | None = None) -> IntArray:
    """A choice per state that may bring it one step nearer to `target`, shape (n_states,); -1 where there is none.

    If the given choices never leave the states that have a distance, following it reaches the target surely. Among such
    choices the one with the least mean distance afterwards is taken, so that it does so without much delay.
    """
    distance = distance_to(mdp, target, choices)
    nearest = _row_minimum(mdp.matrix, np.where(distance < 0, mdp.n_states, distance), mdp.n_states)
    own = distance[mdp.choice_state]
    nearer = (own > 0) & (nearest == own - 1)
    if choices is not None:
        nearer &= choices
    mean = np.asarray(mdp.matrix @ np.where(distance < 0, mdp.n_states, distance))
    chosen = mdp.greedy(np.where(nearer, -mean, -np.inf))
    return np.where(nearer[chosen], chosen, -1)


def almost_sure_region(mdp: ExplicitMDP, target: BoolArray) -> tuple[BoolArray, BoolArray]:
    """The states from which some policy reaches `target` with probability 1, and the choices that stay among them.

    `target` counts as absorbing: what its choices do is ignored. A choice that may leave the process is never safe.

    References:
        L. de Alfaro, Formal Verification of Probabilistic Systems, PhD thesis, Stanford 1997, section 3.4 (Prob1E).
    """
    region = np.ones(mdp.n_states, dtype=np.bool_)
    while True:
        safe = ~mdp.enters(~region) & (mdp.leak == 0)
        reaching = distance_to(mdp, target, safe) >= 0
        if np.array_equal(reaching, region):
            return region, safe
        region = reaching


def prune(mdp: ExplicitMDP, alive: BoolArray) -> None:
    """Drops, in place, choices that may enter a state without a live choice, until no such choice is left."""
    columns, owner = mdp.columns, mdp.choice_state
    left = np.bincount(owner[alive], minlength=mdp.n_states)
    dead = np.flatnonzero(left == 0)
    while dead.size:
        rows = columns.indices[_column_ranges(columns, dead)]
        rows = np.unique(rows[alive[rows]])
        alive[rows] = False
        states, lost = np.unique(owner[rows], return_counts=True)
        left[states] -= lost
        dead = states[left[states] == 0]


def _column_ranges(columns: Any, states: IntArray) -> IntArray:
    start = columns.indptr[states].astype(np.int64)
    return ranges(start, columns.indptr[states + 1] - start)


def _row_minimum(matrix: Any, column_value: IntArray, empty: int) -> IntArray:
    """The least value among the columns of each row of a csr_array; `empty` for rows without entries."""
    result = np.full(matrix.shape[0], empty)
    filled = np.diff(matrix.indptr) > 0
    if filled.any():
        result[filled] = np.minimum.reduceat(column_value[matrix.indices], matrix.indptr[:-1][filled])
    return result
