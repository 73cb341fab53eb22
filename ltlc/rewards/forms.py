"""Which acceptance form a deterministic Rabin automaton has, whatever pairs it is written with, and how to get one.

Marks are on edges (state, letter class) here, as `DRA.edge_fin` and `edge_inf` give them.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from ltlc import automata, graph
from ltlc.automata import DRA, Refinement, limit_deterministic, to_parity
from ltlc.errors import InvalidArgumentError
from ltlc.rewards.scheme import RewardScheme
from ltlc.rewards.tables import BoolArray, IntArray


def relevant_marks(dra: DRA) -> tuple[BoolArray, BoolArray]:
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


def buchi_marks(dra: DRA) -> BoolArray | None:
    """Edges that make the automaton a deterministic Büchi automaton for its own language, or None if there are none.

    Where one pair has Inf marks only (after `relevant_marks`), these are the edges; else those of
    `ltlc.automata.buchi_edges`.

    Returns:
        shape (n_states, n_classes), bool, or None.
    """
    fin, inf = relevant_marks(dra)
    used = np.flatnonzero(inf.any(axis=(1, 2)))
    if not used.size:
        return np.zeros_like(dra.delta, dtype=np.bool_)
    if used.size == 1 and not fin[used[0]].any():
        return np.asarray(inf[used[0]])
    return automata.buchi_edges(dra)


def parity_colours(dra: DRA) -> IntArray | None:
    """Colours that make the automaton a parity automaton (max odd) for its own language, or None where none do.

    Those of its Büchi form if it has one, else the fewest; see `ltlc.automata.parity_colours`.

    Returns:
        shape (n_states, n_classes), int32: a run is accepted iff the largest colour it sees infinitely often is odd.
    """
    buchi = buchi_marks(dra)
    return automata.parity_colours(dra) if buchi is None else buchi.astype(np.int32)


def buchi_form(dra: DRA) -> Refinement:
    """The automaton itself if it is of Büchi type; else one with a choice of the pair to satisfy."""
    return limit_deterministic(dra) if buchi_marks(dra) is None else Refinement.trivial(dra)


def parity_form(dra: DRA) -> Refinement:
    """The automaton itself if it is of parity type; else its product with a record of pairs."""
    return to_parity(dra) if parity_colours(dra) is None else Refinement.trivial(dra)


def one_pair_form(dra: DRA) -> Refinement:
    """The automaton itself if it has one pair; else its Büchi form, written with one pair."""
    if dra.n_pairs == 1:
        return Refinement.trivial(dra)
    marks = buchi_marks(dra)
    return limit_deterministic(dra) if marks is None else Refinement.trivial(with_buchi_marks(dra, marks))


def with_buchi_marks(dra: DRA, edges: BoolArray) -> DRA:
    """The automaton with Inf marks on these edges as its only marks."""
    return dataclasses.replace(dra, fin=np.zeros_like(edges[None]), inf=edges[None], acceptance="transition")


def buchi(scheme: RewardScheme, dra: DRA) -> BoolArray:
    """Accepting edges of the automaton as a Büchi automaton.

    Raises:
        InvalidArgumentError: it is none.
    """
    marks = buchi_marks(dra)
    if marks is None:
        raise lacks_form(scheme, dra)
    return marks


def buchi_or_one_pair(scheme: RewardScheme, dra: DRA) -> BoolArray:
    """Accepting edges as a Büchi automaton, or else the Inf edges (without Fin) of the only pair.

    Raises:
        InvalidArgumentError: there are several pairs, and no Büchi form.
    """
    marks = buchi_marks(dra)
    if marks is not None:
        return marks
    if dra.n_pairs == 1:
        return np.asarray(dra.edge_inf[0] & ~dra.edge_fin[0])
    raise lacks_form(scheme, dra)


def parity(scheme: RewardScheme, dra: DRA) -> IntArray:
    """Colours of the automaton as a parity automaton (max odd).

    Raises:
        InvalidArgumentError: it is none.
    """
    colours = parity_colours(dra)
    if colours is None:
        raise lacks_form(scheme, dra)
    return colours


def lacks_form(scheme: RewardScheme, dra: DRA) -> InvalidArgumentError:
    """The error for an automaton without the form that the steps of a scheme are about."""
    pairs = "1 Rabin pair" if dra.n_pairs == 1 else f"{dra.n_pairs} Rabin pairs"
    return InvalidArgumentError(
        f"reward scheme {scheme.name!r} needs {scheme.requires}, and the automaton of {dra.formula or 'this language'} "
        f"({dra.n_states} states, {pairs}) has not; `compile` brings it into that form, `steps` does not"
    )


def _inside(dra: DRA, allowed: BoolArray) -> BoolArray:
    """The allowed edges that lie on a cycle of allowed edges."""
    component = _component(dra, allowed)
    return np.asarray(allowed & (component[:, None] == component[dra.delta]))


def _component(dra: DRA, allowed: BoolArray) -> npt.NDArray[np.int64]:
    """Strong component of each state, by the allowed edges alone."""
    successors = [np.unique(row[keep]).tolist() for row, keep in zip(dra.delta, allowed, strict=True)]
    return np.asarray(graph.strong_components(successors), dtype=np.int64)
