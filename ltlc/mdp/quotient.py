"""Collapsing end components to single states, so that Bellman equations have one solution only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ltlc.mdp.end_components import EndComponents
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, IntArray
from ltlc.mdp.reachability import attractor


@dataclass(frozen=True, eq=False)
class Quotient:
    """An MDP with every given end component collapsed to one state, which keeps the choices that may leave it.

    References:
        F. Ciesinski, C. Baier, M. Groesser, J. Klein, Reduction techniques for model checking Markov decision
        processes, QEST 2008, DOI 10.1109/QEST.2008.45.
    """

    mdp: ExplicitMDP
    """the collapsed process; entering a state that was not kept counts as leaving it."""
    block: IntArray
    """shape (n original states,), the collapsed state, -1 for states that were not kept."""
    original: IntArray
    """shape (n_choices,), the original choice; -1 for the added choice to stay in a component for ever."""

    def expand(self, chosen: IntArray, source: ExplicitMDP, components: EndComponents) -> IntArray:
        """A policy of the collapsed process as one choice per original state (-1 where not kept).

        Inside a component it walks to the state that owns the chosen exit, or stays inside for ever.
        """
        choice = np.full(source.n_states, -1)
        exits = self.original[chosen]
        exits = exits[exits >= 0]
        choice[source.choice_state[exits]] = exits
        walk = attractor(source, choice >= 0, components.choices)
        inner = np.flatnonzero(components.choices)[::-1]
        stay = np.full(source.n_states, -1)
        stay[source.choice_state[inner]] = inner
        choice = np.where(choice < 0, walk, choice)
        return np.where((choice < 0) & (self.block >= 0), stay, choice)


def collapse(
    mdp: ExplicitMDP, components: EndComponents, keep: BoolArray | None = None, *, may_stay: bool = False
) -> Quotient:
    """The quotient on the states in `keep` (n_states,); None means all.

    With `may_stay` a component gets one more choice, which leaves the process: to stay inside for ever.
    Components must lie inside `keep` or outside of it, and each kept one needs a choice that leaves it, or `may_stay`.
    """
    kept = np.ones(mdp.n_states, dtype=np.bool_) if keep is None else keep
    label = np.where(components.states, mdp.n_states + components.component, np.arange(mdp.n_states))
    _, first, inverse = np.unique(label[kept], return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    block = np.full(mdp.n_states, -1)
    block[kept] = rank[inverse]
    n_blocks = len(first)

    rows = np.flatnonzero(kept[mdp.choice_state] & ~components.choices)
    staying = np.unique(block[components.states & kept]) if may_stay else np.zeros(0, dtype=np.int64)
    owner = np.concatenate((block[mdp.choice_state[rows]], staying))
    order = np.argsort(owner, kind="stable")
    original = np.concatenate((rows, np.full(len(staying), -1)))[order]

    inside = np.flatnonzero(kept)
    group = sparse.csr_array((np.ones(len(inside)), (inside, block[inside])), shape=(mdp.n_states, n_blocks))
    outside = np.asarray(mdp.matrix[rows] @ (~kept).astype(np.float64))
    exit_probability = np.concatenate((mdp.exit_probability[rows] + outside, np.ones(len(staying))))[order]
    stays_empty = sparse.csr_array((len(staying), n_blocks))
    matrix = sparse.vstack((mdp.matrix[rows] @ group, stays_empty), format="csr")[order]
    start = np.concatenate(([0], np.cumsum(np.bincount(owner, minlength=n_blocks))))
    action = np.where(original >= 0, mdp.choice_action[original], -1)
    initial = np.bincount(block[inside], mdp.initial[inside], minlength=n_blocks).astype(np.float64)
    explicit = ExplicitMDP(matrix, start, action, initial, exit_probability=exit_probability, n_actions=mdp.n_actions)
    return Quotient(explicit, block, original)
