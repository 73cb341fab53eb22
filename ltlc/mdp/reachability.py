"""Who can get where, and who can get there surely: questions about the graph of an MDP alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from ltlc.mdp.explicit import BoolArray, ExplicitMDP, IntArray, graph_of, ranges


def distance_to(mdp: ExplicitMDP, target: BoolArray, choices: BoolArray | None = None) -> IntArray:
    """Fewest steps from each state into `target` when luck helps, shape (n_states,); -1 where it cannot be reached.

    Only the given choices are used, shape (n_choices,); None means all.
    """
    if choices is None:
        graph = mdp.support.graph
        return _distance(graph, target, np.ones(graph.n_choices, dtype=np.bool_))
    support, usable = graph_of(mdp, choices)
    return _distance(support.graph, target, usable)


def _distance(mdp: ExplicitMDP, target: BoolArray, choices: BoolArray) -> IntArray:
    columns, owner = mdp.columns, mdp.choice_state
    distance = np.where(target, np.int32(0), np.int32(-1))
    unused = choices.copy()
    ticket = np.zeros(mdp.n_states, dtype=np.int32)
    frontier = np.flatnonzero(target)
    level = 0
    while frontier.size:
        level += 1
        rows = columns.indices[_column_ranges(columns, frontier)]
        rows = rows[unused[rows]]
        unused[rows] = False
        states = owner[rows]
        states = states[distance[states] < 0]
        number = np.arange(len(states), dtype=np.int32)
        ticket[states] = number  # of equal states one wins
        frontier = states[ticket[states] == number]
        distance[frontier] = level
    return distance


def attractor(mdp: ExplicitMDP, target: BoolArray, choices: BoolArray | None = None) -> IntArray:
    """A choice per state that may bring it one step nearer to `target`, shape (n_states,); -1 where there is none.

    If the given choices never leave the states that have a distance, following it reaches the target surely. Among such
    choices the one with the least mean distance afterwards is taken, so that it does so without much delay.
    """
    usable = np.ones(mdp.n_choices, dtype=np.bool_) if choices is None else choices
    return approach(mdp, distance_to(mdp, target, choices), usable)


def approach(mdp: ExplicitMDP, distance: IntArray, choices: BoolArray) -> IntArray:
    """The attractor where the distances by the given choices are known already."""
    support, usable = graph_of(mdp, choices)
    graph = support.graph
    far = np.where(distance < 0, mdp.n_states, distance)
    own = distance[graph.choice_state]
    nearer = (own > 0) & (_row_minimum(graph.matrix, far, mdp.n_states) == own - 1) & usable
    mean = mdp.expect(far.astype(np.float64))
    nearer = nearer[support.of_choice]
    chosen = mdp.greedy(np.where(nearer, -mean, -np.inf))
    return np.where(nearer[chosen], chosen, -1)


def almost_sure_region(mdp: ExplicitMDP, target: BoolArray) -> tuple[BoolArray, BoolArray, IntArray, BoolArray]:
    """Where some policy reaches `target` surely, the choices that stay there, distances by those, and where it may.

    The first and the last have shape (n_states,): states from which some policy reaches it with probability 1, and with
    positive probability. `target` counts as absorbing: what its choices do is ignored. A choice that may leave the
    process is never safe.

    References:
        L. de Alfaro, Formal Verification of Probabilistic Systems, PhD thesis, Stanford 1997, section 3.4 (Prob1E).
    """
    support = mdp.support
    graph = support.graph
    owner = graph.choice_state
    distance = _distance(graph, target, np.ones(graph.n_choices, dtype=np.bool_))
    region = possible = distance >= 0
    safe = graph.exit_probability == 0
    while not (safe.all() and region.all()):
        safe &= region[owner]
        prune(graph, safe, target)
        distance = _distance(graph, target, safe)
        region = distance >= 0
        if region[owner[safe]].all():
            break
    return region, safe[support.of_choice], distance, possible


def prune(mdp: ExplicitMDP, alive: BoolArray, spared: BoolArray | None = None) -> None:
    """Drops, in place, choices that may enter a state without a live choice, until no such choice is left.

    States that are `spared`, shape (n_states,), may be entered even if they have none.
    """
    columns, owner = mdp.columns, mdp.choice_state
    left = np.bincount(owner[alive], minlength=mdp.n_states)
    if spared is not None:
        left += spared
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
