"""A process cut into parts that can be solved one after the other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csgraph

from ltlc.mdp.explicit import ExplicitMDP, IntArray

SMALLEST = 10_000
"""Parts have at least so many states, the last one aside: fewer are not worth the cut."""


def topological_blocks(mdp: ExplicitMDP) -> Iterator[IntArray]:
    """Disjoint sets of states, ascending within each; no part can be entered from one that comes before it.

    They are unions of strongly connected components, so what can happen in one depends on earlier parts alone.

    References:
        P. Dai, Mausam, D. Weld, J. Goldsmith, Topological value iteration algorithms, JAIR 42, 2011,
        DOI 10.1613/jair.3390.
    """
    everything = np.arange(mdp.n_states)
    if mdp.n_states <= SMALLEST:
        yield everything
        return
    graph = mdp.support.graph
    edges = graph.adjacency
    n_labels, label = csgraph.connected_components(edges, connection="strong")
    order = _topological(edges, label, n_labels)
    if order is None:
        yield everything
        return
    rank = order[label]
    by_rank = np.argsort(rank, kind="stable")
    ends = np.cumsum(np.bincount(rank, minlength=n_labels))
    begin = 0
    while begin < mdp.n_states:
        end = int(ends[min(np.searchsorted(ends, begin + SMALLEST), n_labels - 1)])
        yield np.sort(by_rank[begin:end])
        begin = end


def _topological(edges: object, label: IntArray, n_labels: int) -> IntArray | None:
    """The place of each component in an order in which edges lead to earlier ones only; None if there is none known.

    SciPy numbers components as it finds them, which is such an order or its reverse, but does not promise it.
    """
    source = np.repeat(label, np.diff(edges.indptr))  # type: ignore[attr-defined]
    target = label[edges.indices]  # type: ignore[attr-defined]
    number = np.arange(n_labels)
    if (target <= source).all():
        return number
    if (target >= source).all():
        return number[::-1]
    return None
