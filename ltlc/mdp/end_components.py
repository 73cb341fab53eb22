"""Maximal end components, and those in which a Rabin condition can be satisfied for ever."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ltlc.mdp.explicit import BoolArray, ExplicitMDP, IntArray, graph_of
from ltlc.mdp.product import Product
from ltlc.mdp.reachability import attractor, prune


@dataclass(frozen=True, eq=False)
class EndComponents:
    """Disjoint end components: sets of states in which some policy stays for ever, visiting all of it.

    Attributes:
        component: shape (n_states,), number of the component, -1 for states in none.
        choices: shape (n_choices,), the choices that stay inside.
        n_components: number of components.
    """

    component: IntArray
    choices: BoolArray
    n_components: int

    @property
    def states(self) -> BoolArray:
        """The states that are in some component, shape (n_states,)."""
        return self.component >= 0

    def restricted(self, keep: BoolArray, choice_state: IntArray) -> EndComponents:
        """Only the components for which `keep` (n_components,) holds."""
        number = np.where(keep, np.cumsum(keep) - 1, -1)
        component = np.where(self.component >= 0, number[self.component], -1) if len(keep) else self.component
        return EndComponents(component, self.choices & (component[choice_state] >= 0), int(keep.sum()))


def maximal_end_components(mdp: ExplicitMDP, choices: BoolArray | None = None) -> EndComponents:
    """The maximal end components of the MDP that has only the given choices (n_choices,); None means all.

    Components are numbered by their first state. A choice that may leave the process belongs to none. Each round finds
    the strongly connected components of what is left, and drops choices that may leave theirs and states without
    choices; components that lost nothing are final and are not looked at again.

    References:
        L. de Alfaro, Formal Verification of Probabilistic Systems, PhD thesis, Stanford 1997, section 3.3.
    """
    everything = mdp.exit_probability == 0 if choices is None else choices & (mdp.exit_probability == 0)
    support, alive = graph_of(mdp, everything)
    component, n_components = _of_graph(support.graph, alive)
    return EndComponents(component, alive[support.of_choice], n_components)


def _of_graph(mdp: ExplicitMDP, alive: BoolArray) -> tuple[IntArray, int]:
    """Component of each state and number of components; leaves in `alive` the choices that stay inside."""
    component = np.full(mdp.n_states, -1, dtype=np.int32)
    active = np.ones(mdp.n_states, dtype=np.bool_)
    found = 0
    while True:
        prune(mdp, alive)
        rows = np.flatnonzero(alive & active[mdp.choice_state])
        if not rows.size:
            break
        states, label, n_labels = _strong_components(mdp, rows)
        component[states] = found + label
        leaving = _leaving(mdp, rows, component)
        alive[leaving] = False
        broken = np.zeros(n_labels, dtype=np.bool_)
        broken[component[mdp.choice_state[leaving]] - found] = True
        active[:] = False
        active[states[broken[label]]] = True
        component[active] = -1
        found += n_labels
    return _renumbered(component)


def accepting_end_components(product: Product) -> tuple[EndComponents, ...]:
    """For each Rabin pair i, the maximal end components without Fin_i marks that have an Inf_i mark.

    References:
        C. Baier, J.-P. Katoen, Principles of Model Checking, MIT Press 2008, section 10.6.4.
    """
    everything = maximal_end_components(product)
    result = []
    for fin, inf in zip(product.choice_fin, product.choice_inf, strict=True):
        # a component for the pair lies inside one of the whole product, and that one has the Inf mark too
        around = _with_a_choice(everything, inf, product.choice_state)
        inside = maximal_end_components(product, around.choices & ~fin)
        result.append(_with_a_choice(inside, inf, product.choice_state))
    return tuple(result)


def accepting_choices(product: Product, components: tuple[EndComponents, ...]) -> IntArray:
    """A choice for each state of an accepting component that satisfies its pair surely; -1 elsewhere.

    Memoryless and deterministic: where an Inf choice is at hand it is taken, elsewhere the nearest one is approached.
    """
    choice = np.full(product.n_states, -1)
    for inf, accepting in zip(product.choice_inf, components, strict=True):
        marked = np.flatnonzero(accepting.choices & inf)[::-1]
        policy = np.full(product.n_states, -1)
        policy[product.choice_state[marked]] = marked  # reversed, so that the first one of a state stays
        approach = attractor(product, policy >= 0, accepting.choices)
        policy = np.where(policy >= 0, policy, approach)
        choice = np.where((choice < 0) & accepting.states, policy, choice)
    return choice


def _with_a_choice(components: EndComponents, marked: BoolArray, choice_state: IntArray) -> EndComponents:
    """Only the components that have a marked choice."""
    keep = np.zeros(components.n_components, dtype=np.bool_)
    keep[components.component[choice_state[components.choices & marked]]] = True
    return components.restricted(keep, choice_state)


def _strong_components(mdp: ExplicitMDP, rows: IntArray) -> tuple[IntArray, IntArray, int]:
    """The states owning the given choices, their strongly connected component, and how many there are.

    The choices must lead only to states that own one of them.
    """
    n_rows = np.bincount(mdp.choice_state[rows], minlength=mdp.n_states)
    states = np.flatnonzero(n_rows)
    local = np.zeros(mdp.n_states, dtype=np.int32)
    local[states] = np.arange(len(states), dtype=np.int32)
    if len(states) == len(rows):
        edges: Any = mdp.matrix if len(rows) == mdp.n_choices else mdp.matrix[rows]
    else:  # one row per state; the sparse product also merges parallel edges, on which csgraph would never return
        own = (np.ones(len(rows), dtype=mdp.matrix.dtype), rows, np.concatenate(([0], np.cumsum(n_rows[states]))))
        edges = sparse.csr_array(own, shape=(len(states), mdp.n_choices)) @ mdp.matrix
    graph = sparse.csr_array((edges.data, local[edges.indices], edges.indptr), shape=(len(states), len(states)))
    n_labels, label = csgraph.connected_components(graph, connection="strong")
    return states, label, n_labels


def _leaving(mdp: ExplicitMDP, rows: IntArray, component: IntArray) -> IntArray:
    """Those of the given choices that may lead out of the component of their state."""
    part: Any = mdp.matrix if len(rows) == mdp.n_choices else mdp.matrix[rows]
    entered, start, own = component[part.indices], part.indptr[:-1], component[mdp.choice_state[rows]]
    outside = (np.minimum.reduceat(entered, start) != own) | (np.maximum.reduceat(entered, start) != own)
    return np.asarray(rows[outside])


def _renumbered(component: IntArray) -> tuple[IntArray, int]:
    """Components numbered by their first state, and how many there are; -1 stays."""
    inside = np.flatnonzero(component >= 0)
    label = component[inside]
    first = np.full(int(label.max(initial=-1)) + 1, -1)
    first[label[::-1]] = inside[::-1]  # so that the first state of a component stays
    used = np.flatnonzero(first >= 0)
    rank = np.empty(len(first), dtype=np.int32)
    rank[used[np.argsort(first[used])]] = np.arange(len(used), dtype=np.int32)
    result = np.full(len(component), -1, dtype=np.int32)
    result[inside] = rank[label]
    return result, len(used)
