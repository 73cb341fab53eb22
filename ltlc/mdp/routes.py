"""The routes of a Markov chain into a set of states: its paths with the detours left out.

A run that goes in circles before it gets somewhere has a route, its path without the circles (the loop-erased path).
Many paths have one route, and the probability of a route is exact: at each state the expected number of visits, without
the states before, times the step that leaves it for good.

References:
    G. F. Lawler: Loop-erased self-avoiding random walk. Duke Mathematical Journal 47(3), 1980, doi
    10.1215/S0012-7094-80-04741-9.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np

from ltlc.budget import check_time
from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.explicit import BoolArray, FloatArray

MAX_STATES = 400
"""Routes are looked for among so many states."""
_MAX_WORK = 400_000_000
"""entries of matrices that the search may change: about a second."""


class Route(NamedTuple):
    """A path without detours.

    Attributes:
        states: of the chain, each once; the last one is in the set.
        probability: that a run enters the set, and that its path without detours is this.
    """

    states: tuple[int, ...]
    probability: float


def most_probable_routes(
    chain: MarkovChain, live: BoolArray, target: BoolArray, needed: float, max_routes: int
) -> tuple[Route, ...]:
    """The most probable routes into `target`, in decreasing order, until their probabilities add up to what is needed.

    Args:
        chain: the chain.
        live: shape (n_states,), the transient states that routes go through, `MAX_STATES` at most; else there are none.
        target: shape (n_states,).
        needed: a probability.
        max_routes: how many there may be.
    """
    members = np.flatnonzero(live)
    first = [Route((q,), float(chain.initial[q])) for q in np.flatnonzero(target & (chain.initial > 0)).tolist()]
    if not members.size or members.size > MAX_STATES:
        return tuple(first[:max_routes])
    inside = chain.matrix[members][:, members].toarray()
    outside = chain.matrix[members][:, np.flatnonzero(target)]
    leaving = np.asarray(outside.sum(axis=1)).ravel()
    fundamental = np.linalg.inv(np.eye(len(members)) - inside)
    ends: list[list[tuple[int, float]]] = [[] for _ in range(len(members))]
    table = outside.tocoo()
    for row, column, step in zip(*(axis.tolist() for axis in table.coords), table.data.tolist(), strict=True):
        ends[row].append((column, step))
    targets = np.flatnonzero(target)
    lost = fundamental @ leaving
    number = 0
    # (minus the probability of all routes that begin so, tie breaker, local states, weight, target or -1)
    queue: list[tuple[float, int, tuple[int, ...], float, int]] = []
    for route in first:
        heapq.heappush(queue, (-route.probability, number, (), route.probability, route.states[0]))
        number += 1
    for i in np.flatnonzero(chain.initial[members] > 0).tolist():
        weight = float(chain.initial[members[i]])
        heapq.heappush(queue, (-weight * float(lost[i]), number, (i,), weight, -1))
        number += 1
    found: list[Route] = []
    carried = 0.0
    work = 0
    while queue and carried < needed and len(found) < max_routes and work < _MAX_WORK:
        check_time()
        _, _, local, weight, end = heapq.heappop(queue)
        if end >= 0:
            found.append(Route((*members[list(local)].tolist(), end), weight))
            carried += weight
            continue
        here = local[-1]
        work += (len(local) + 1) * len(members) ** 2
        left = fundamental
        for state in local[:-1]:
            left = _without(left, state)
        weight *= float(left[here, here])
        for column, chance in ends[here]:
            heapq.heappush(queue, (-weight * chance, number, local, weight * chance, int(targets[column])))
            number += 1
        rest = _without(left, here)
        reached = rest @ leaving
        for i in np.flatnonzero(inside[here] * reached).tolist():
            if i not in local:
                chance = float(inside[here, i])
                heapq.heappush(queue, (-weight * chance * float(reached[i]), number, (*local, i), weight * chance, -1))
                number += 1
    return tuple(found)


def _without(fundamental: FloatArray, state: int) -> FloatArray:
    """The expected visits where runs end that come to a state."""
    changed: FloatArray = fundamental - np.outer(fundamental[:, state], fundamental[state]) / fundamental[state, state]
    changed[state] = changed[:, state] = 0.0
    return changed
