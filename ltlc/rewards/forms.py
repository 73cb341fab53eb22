"""Which acceptance form a deterministic Rabin automaton has, whatever pairs it is written with.

Marks are on edges (state, letter class) here, as `RabinAutomaton.edge_fin` and `edge_inf` give them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ltlc import graph
from ltlc.automata import RabinAutomaton
from ltlc.rewards.tables import BoolArray, IntArray


def relevant_marks(dra: RabinAutomaton) -> tuple[BoolArray, BoolArray]:
    """Fin and Inf marks that can matter, each of shape (n_pairs, n_states, n_classes).

    A mark of a pair is kept only inside a strong component that has an accepting cycle of that pair: elsewhere it is
    seen finitely often, or the pair cannot accept anyway. The language stays the same. Where marks are on states, the
    edge on which a run comes into such a component keeps the Inf mark of the state it enters.
    """
    everywhere = np.ones_like(dra.delta, dtype=np.bool_)
    whole = _component(dra, everywhere)
    fin, inf = np.zeros_like(dra.edge_fin), np.zeros_like(dra.edge_inf)
    for i in range(dra.n_pairs):
        allowed = ~dra.edge_fin[i]
        on_cycle = _inside(dra, allowed) & dra.edge_inf[i]
        live = np.isin(whole, whole[on_cycle.any(axis=1)])
        here = _inside(dra, everywhere) & live[:, None]
        fin[i] = dra.edge_fin[i] & here
        inf[i] = dra.edge_inf[i] & (live[dra.delta] if dra.acceptance == "state" else here)
    return fin, inf


def buchi_marks(dra: RabinAutomaton) -> BoolArray | None:
    """Edges that make the automaton a deterministic Büchi automaton for its own language, or None if there are none.

    Where one pair has Inf marks only (after `relevant_marks`), these are the edges. Otherwise an edge is taken iff it
    lies on no rejecting cycle; that makes a Büchi automaton for the same language iff any choice of edges does.

    Returns:
        shape (n_states, n_classes), bool, or None.

    References:
        S. Krishnan, A. Puri, R. Brayton, Deterministic omega-automata vis-a-vis deterministic Büchi automata,
        ISAAC 1994, doi 10.1007/3-540-58325-4_202; here for marks on edges.
    """
    fin, inf = relevant_marks(dra)
    used = np.flatnonzero(inf.any(axis=(1, 2)))
    if not used.size:
        return np.zeros_like(dra.delta, dtype=np.bool_)
    if used.size == 1 and not fin[used[0]].any():
        return np.asarray(inf[used[0]])
    final = _inside(dra, np.ones_like(dra.delta, dtype=np.bool_)) & ~_on_rejecting_cycle(dra)
    for i in range(dra.n_pairs):
        if (_inside(dra, ~final & ~dra.edge_fin[i]) & dra.edge_inf[i]).any():
            return None  # an accepting cycle without a final edge
    return final


def parity_colours(dra: RabinAutomaton) -> IntArray | None:
    """Colours that make the automaton a parity automaton (max odd) for its own language, or None.

    Found for Büchi-type automata, for one pair, and for pairs that form a chain; other automata need a product with a
    record of pairs.

    Returns:
        shape (n_states, n_classes), int32: a run is accepted iff the largest colour it sees infinitely often is odd.

    References:
        A. Mostowski, Regular expressions for infinite trees and a standard form of automata, 1984,
        doi 10.1007/3-540-16066-3_15 (Rabin chain condition).
    """
    buchi = buchi_marks(dra)
    if buchi is not None:
        return buchi.astype(np.int32)
    fin, inf = relevant_marks(dra)
    inf |= fin  # a cycle that sees Fin of a pair is rejected by it, so its Inf mark there says nothing
    colours = np.zeros_like(dra.delta)
    outer = np.ones_like(dra.delta, dtype=np.bool_)
    order = sorted(np.flatnonzero(inf.any(axis=(1, 2))).tolist(), key=lambda i: (-int(inf[i].sum()), i))
    for i in order:
        if (inf[i] & ~outer).any():
            return None
        colours += inf[i].astype(np.int32) + fin[i]
        outer = fin[i]
    return colours


def _on_rejecting_cycle(dra: RabinAutomaton) -> BoolArray:
    """Edges on a cycle that no pair accepts: the maximal ones are found by taking Inf marks without Fin away."""
    rejecting = np.zeros_like(dra.delta, dtype=np.bool_)
    todo = [np.ones_like(dra.delta, dtype=np.bool_)]
    while todo:
        allowed = todo.pop()
        component = _component(dra, allowed)
        inside = allowed & (component[:, None] == component[dra.delta])
        for c in np.unique(component[inside.any(axis=1)]):
            here = inside & (component == c)[:, None]
            accepting = (dra.edge_inf & here).any(axis=(1, 2)) & ~(dra.edge_fin & here).any(axis=(1, 2))
            if accepting.any():
                todo.append(here & ~dra.edge_inf[accepting].any(axis=0))
            else:
                rejecting |= here
    return rejecting


def _inside(dra: RabinAutomaton, allowed: BoolArray) -> BoolArray:
    """The allowed edges that lie on a cycle of allowed edges."""
    component = _component(dra, allowed)
    return np.asarray(allowed & (component[:, None] == component[dra.delta]))


def _component(dra: RabinAutomaton, allowed: BoolArray) -> npt.NDArray[np.int64]:
    """Strong component of each state, by the allowed edges alone."""
    successors = [np.unique(row[keep]).tolist() for row, keep in zip(dra.delta, allowed, strict=True)]
    return np.asarray(graph.strong_components(successors), dtype=np.int64)
