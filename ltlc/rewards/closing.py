"""The end of the world: what it is worth to read one letter for ever.

Where an environment says that it has terminated, the word goes on with its last letter. The tables then make no more
use of the environment: from each of their states, a letter class leads into a cycle (a lasso), which is solved here.
"""

from __future__ import annotations

import dataclasses
from typing import get_args

import numpy as np
import numpy.typing as npt

from ltlc.errors import UnknownNameError
from ltlc.rewards.tables import FloatArray, OnTermination, RewardTables

_SETTLED = 1e-14
"""relative change of a value that is rounding."""


def closed(tables: RewardTables, on_termination: OnTermination) -> RewardTables:
    """The tables with what is paid where the environment terminates.

    Where some letter, read for ever, has no finite value (undiscounted pay), no state can be compared with another,
    and the episode is cut everywhere; `RewardTables.on_termination` says so.

    Args:
        tables: without closing values.
        on_termination: `repeat` or `cut`; see `RewardScheme.compile`.

    Raises:
        UnknownNameError: `on_termination` is neither.
    """
    if on_termination not in get_args(OnTermination):
        raise UnknownNameError("termination mode", on_termination, get_args(OnTermination))
    values = closing_values(tables) if on_termination == "repeat" else None
    if values is None:
        return tables
    return dataclasses.replace(tables, closing=values, on_termination="repeat")


def closing_values(tables: RewardTables) -> FloatArray | None:
    """What each table state is worth if every further letter is of one class; the best choice of a pair counts.

    Returns:
        shape (n_states, n_classes), float64; None if an entry has no finite value.
    """
    n, n_classes = tables.n_states, tables.n_classes
    following = (tables.next_state.astype(np.int64) * n_classes + np.arange(n_classes)).ravel()
    paid = tables.expected_reward.ravel()
    lost = (tables.stop + (1 - tables.stop) * (1 - tables.discount)).ravel()
    with np.errstate(over="ignore"):
        value = lasso_values(following, paid, lost).reshape(n, n_classes)
        if tables.n_choices:
            value = _with_choices(tables, value, following, paid, lost)
    return value if np.isfinite(value).all() else None


def lasso_values(following: npt.NDArray[np.int64], paid: FloatArray, lost: FloatArray) -> FloatArray:
    """Values of the nodes of a graph in which each has one successor; all arrays have shape (n_nodes,).

    A node pays `paid`, and what follows counts 1 - `lost`. Values are infinite where a cycle pays and loses nothing.
    Weights are added up as what is lost, since 1 minus little would round it. Paths of length 2^k are made of two
    halves, so that there are log2(n_nodes) rounds.
    """
    n = len(following)
    rounds, number = n.bit_length(), np.arange(n)
    smallest, node = number, following
    for _ in range(rounds):
        smallest, node = np.minimum(smallest, smallest[node]), node[node]
    head = smallest[node]  # of the cycle each node leads to, the smallest node
    # everything on the way to the head
    on_way = head != number
    node = np.where(on_way, following, number)
    total, exit_probability, pays = np.where(on_way, paid, 0.0), np.where(on_way, lost, 0.0), on_way & (paid != 0)
    for _ in range(rounds):
        total = total + (1 - exit_probability) * total[node]
        exit_probability = exit_probability + (1 - exit_probability) * exit_probability[node]
        pays, node = pays | pays[node], node[node]
    # once around the cycle, from head to head
    around = paid + (1 - lost) * total[following]
    around_lost = lost + (1 - lost) * exit_probability[following]
    endless = np.where((paid != 0) | pays[following], np.where(around > 0, np.inf, -np.inf), 0.0)
    cycle = np.divide(around, around_lost, out=endless, where=around_lost > 0)
    return total + _weighted(exit_probability, cycle[head])


def _with_choices(
    tables: RewardTables, never: FloatArray, following: npt.NDArray[np.int64], paid: FloatArray, lost: FloatArray
) -> FloatArray:
    """Values where a pair may be chosen at any time, from those for never choosing.

    To choose after the cycle has been gone round is no better than both to choose before and never to choose, so the
    best moment comes within one round.
    """
    value = never
    for _ in range(2 * tables.n_states):
        new = np.maximum(value, (paid + _weighted(lost, value.ravel()[following])).reshape(value.shape))
        for committed in tables.select_pair.T:
            can = committed >= 0
            new[can] = np.maximum(new[can], new[committed[can]])
        if np.allclose(new, value, rtol=_SETTLED, atol=0.0):
            break
        value = new
    return value


def _weighted(lost: FloatArray, value: FloatArray) -> FloatArray:
    """(1 - lost) * value, 0 where everything is lost even of an infinite value."""
    return np.multiply(1 - lost, value, out=np.zeros_like(value), where=lost < 1)
