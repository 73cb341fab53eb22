"""What values can be: the least and the largest that any environment could give, from each state of reward tables.

An environment chooses the letters, and may end the episode with any step; so the largest value is that of the best word
and the least that of the worst, each a lasso in a finite graph. Policy iteration finds them, and stops.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ltlc import graph
from ltlc.rewards.closing import lasso_values
from ltlc.rewards.tables import FloatArray, RewardTables

_SETTLED = 1e-13
"""relative change of a value that is rounding."""
Nodes = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ValueBounds:
    """Bounds of the optimal value of an action in each table state, whatever the environment; no pair chosen with it.

    Rounding aside they are attained by some word where no pairs can be chosen between; infinite where a word could pay
    without end.

    Attributes:
        least, largest: shape (n_states,), float64.
    """

    least: FloatArray
    largest: FloatArray


@dataclass(frozen=True, eq=False)
class _Edges:
    """Steps that an environment can choose between, each an entry; what follows counts `1 - lost`."""

    source: Nodes
    target: Nodes
    paid: FloatArray
    lost: FloatArray

    def with_choices(self, select_pair: npt.NDArray[np.int32]) -> _Edges:
        """These and the choices of a pair, which are free."""
        state, choice = np.nonzero(select_pair >= 0)
        none = np.zeros(len(state))
        return _Edges(
            np.concatenate([self.source, state]),
            np.concatenate([self.target, select_pair[state, choice]]),
            np.concatenate([self.paid, none]),
            np.concatenate([self.lost, none]),
        )

    def values(self, following: FloatArray) -> FloatArray:
        """What each is worth, given the value of each node."""
        weight = 1 - self.lost
        return self.paid + np.multiply(weight, following[self.target], out=np.zeros_like(weight), where=weight > 0)


def value_bounds(tables: RewardTables) -> ValueBounds:
    """The least and the largest value of an action in each state of reward tables.

    The least is that of the worst word for a policy that chooses at each state the pair whose worst word is best.

    Args:
        tables: the reward tables; an environment that pays rewards of its own has no such bounds.

    Example:
        >>> from ltlc import Task
        >>> bounds = value_bounds(Task("F goal & G !hole").tables)
        >>> bounds.least.min(), bounds.largest.max()
        (np.float64(0.0), np.float64(1.0))
    """
    letters = _letters(tables)
    best = _largest(letters.with_choices(tables.select_pair), tables.n_states)
    worst = _with_choices(tables, letters, _least(letters, tables.n_states))
    shape = (2 * tables.n_classes, tables.n_states)
    return ValueBounds(
        letters.values(worst).reshape(shape).min(axis=0), letters.values(best).reshape(shape).max(axis=0)
    )


def _letters(tables: RewardTables) -> _Edges:
    """A step of each letter class from each state, and the same where it ends the environment; states run fastest."""
    lost = tables.stop + (1 - tables.stop) * (1 - tables.discount)
    ended = tables.expected_reward + (1 - lost) * tables.final_value
    count = tables.n_classes
    return _Edges(
        np.tile(np.arange(tables.n_states), 2 * count),
        np.tile(tables.next_state.T.ravel().astype(np.int64), 2),
        np.concatenate([tables.expected_reward.T.ravel(), ended.T.ravel()]),
        np.concatenate([lost.T.ravel(), np.ones(lost.size)]),
    )


def _least(edges: _Edges, n: int) -> FloatArray:
    return -_largest(_Edges(edges.source, edges.target, -edges.paid, edges.lost), n)


def _with_choices(tables: RewardTables, letters: _Edges, never: FloatArray) -> FloatArray:
    """The least values where pairs can be chosen, from those of never choosing; they only grow, so all are bounds."""
    value = never
    for _ in range(tables.n_states if tables.n_choices else 0):
        acting = letters.values(value).reshape(-1, tables.n_states).min(axis=0)
        chosen = np.where(tables.select_pair >= 0, value[tables.select_pair], -np.inf).max(axis=1)
        new = np.maximum(value, np.maximum(acting, chosen))
        if (new == value).all():
            break
        value = new
    return value


def _largest(edges: _Edges, n: int) -> FloatArray:
    """The largest value of each of n nodes, each with an edge.

    A cycle on which nothing is lost is worth nothing if it pays nothing, and then its nodes are as good as one another:
    they become one node that may stop there. If it pays, its value is taken to be infinite. All that is left is what a
    policy iteration settles, since no other cycle can be turned in for ever at no loss.
    """
    kept = edges.lost == 0
    component = _components(edges, kept, n)
    gains = kept & (edges.paid > 0) & (component[edges.source] == component[edges.target])
    endless = np.isin(component, component[edges.source[gains]])
    passes = edges.lost < 1
    while (new := passes & endless[edges.target] & ~endless[edges.source]).any():
        endless[edges.source[new]] = True
    free = kept & (edges.paid == 0)
    group = _components(edges, free, n)
    idle = free & (group[edges.source] == group[edges.target])
    resting = np.unique(group[edges.source[idle]])
    use = ~idle & ~endless[edges.source]
    nothing, everything = np.zeros(len(resting)), np.ones(len(resting))
    merged = _Edges(
        np.concatenate([group[edges.source[use]], resting]),
        np.concatenate([group[edges.target[use]], resting]),
        np.concatenate([edges.paid[use], nothing]),
        np.concatenate([edges.lost[use], everything]),
    )
    return np.where(endless, np.inf, _iterated(merged, n)[group])


def _iterated(edges: _Edges, n: int) -> FloatArray:
    """The largest values by policy iteration, where every cycle loses something or costs; nodes without edges get 0."""
    target, paid, lost = np.arange(n), np.zeros(n), np.ones(n)
    order = np.argsort(edges.source, kind="stable")
    nodes, first = np.unique(edges.source[order], return_index=True)
    chosen = order[first]
    while True:
        target[nodes], paid[nodes], lost[nodes] = edges.target[chosen], edges.paid[chosen], edges.lost[chosen]
        value = lasso_values(target, paid, lost)
        each = edges.values(value)
        order = np.lexsort((each, edges.source))
        best = order[np.append(np.flatnonzero(np.diff(edges.source[order])), len(order) - 1)] if len(order) else order
        finite = np.where(np.isfinite(value[nodes]), value[nodes], 0.0)
        better = each[best] > value[nodes] + _SETTLED * np.abs(finite)
        if not better.any():
            return value
        chosen = np.where(better, best, chosen)


def _components(edges: _Edges, used: npt.NDArray[np.bool_], n: int) -> Nodes:
    """Strong component of each node, by the used edges alone."""
    successors: list[set[int]] = [set() for _ in range(n)]
    for source, target in zip(edges.source[used].tolist(), edges.target[used].tolist(), strict=True):
        successors[source].add(target)
    return np.asarray(graph.strong_components([sorted(found) for found in successors]), dtype=np.int64)
