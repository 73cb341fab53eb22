"""Planning on a learned product: its accepting end components, and policies that reach them and stay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.mdp import ExplicitMDP, Product, Solution, max_reachability, maximal_end_components, value_iteration

from .experience import BoolArray, IntArray

FloatArray = npt.NDArray[np.float64]

TIE = 1e-9
"""choices whose probabilities of success differ by less are equally good."""
TOLERANCE = 1e-9
"""of values in value iteration; what is so many steps away that discount**steps is less is not seen."""

NOTHING_TO_REACH = "the learned product has no accepting end component, so no policy satisfies the formula in it"


@dataclass(frozen=True, eq=False)
class Components:
    """Accepting maximal end components of a product, and a policy that satisfies the formula inside them."""

    product: Product
    n_components: int
    states: BoolArray
    """shape (n_states,), the product states in one."""
    policy: IntArray
    """shape (n_states,), an action per product state; -1 outside."""
    value: FloatArray
    """shape (n_states,), in [0, 1]; what it is worth to enter a state: expected discount**steps to the next Inf mark,
    which is 1 where entering it is one; 0 outside."""


def accepting_components(product: Product, known: BoolArray, discount: float) -> Components:
    """Accepting maximal end components among the known environment states, for each Rabin pair.

    Inside, the policy takes the quickest way to the next Inf mark. It visits them infinitely often: its value is
    positive everywhere in the component, so from everywhere it may come to a mark.

    Args:
        product: learned MDP and automaton.
        known: environment states whose estimates are trusted, shape (n_mdp_states,).
        discount: in (0, 1), of a step.

    References:
        C. Baier, J.-P. Katoen, Principles of Model Checking, MIT Press 2008, section 10.6.4.
    """
    trusted = known[product.mdp_state][product.choice_state]
    policy, value = np.full(product.n_states, -1), np.zeros(product.n_states)
    total = 0
    for pair, (fin, inf) in enumerate(zip(product.choice_fin, product.choice_inf, strict=True)):
        inside = maximal_end_components(product, trusted & ~fin)
        keep = np.zeros(inside.n_components, dtype=np.bool_)
        keep[inside.component[product.choice_state[inside.choices & inf]]] = True
        inside = inside.restricted(keep, product.choice_state)
        total += inside.n_components
        new = inside.states & (policy < 0)
        if new.any():
            quickest = _to_next_mark(product, pair, inside.choices, discount)
            policy[new] = quickest.policy[new]
            entered = _marked_states(product, pair)
            value[new] = np.where(entered, 1.0, discount * quickest.value)[new]
    return Components(product, total, policy >= 0, policy, value)


def _to_next_mark(product: Product, pair: int, inside: BoolArray, discount: float) -> Solution:
    """Largest expected discount**steps to an Inf mark of a pair, by the choices `inside`; 0 steps for the next one."""
    process = cut(product, inside)
    if product.automaton.acceptance == "state":
        marked = _marked_states(product, pair)
        paid = np.asarray(process.matrix @ marked.astype(np.float64))
        process.matrix = sparse.csr_array(process.matrix @ sparse.diags_array((~marked).astype(np.float64)))
    else:  # a choice counts as a mark if one of its branches has one
        paid = product.choice_inf[pair].astype(np.float64)
        process = cut(product, inside & ~product.choice_inf[pair])
    return value_iteration(process, np.where(inside, paid, -1.0), discount=discount, tolerance=TOLERANCE)


def _marked_states(product: Product, pair: int) -> BoolArray:
    """The product states that carry an Inf mark of the pair themselves, shape (n_states,)."""
    if product.automaton.acceptance != "state":
        return np.zeros(product.n_states, dtype=np.bool_)
    return np.asarray(product.automaton.inf[pair][product.automaton_state])


@dataclass(frozen=True, eq=False)
class Plan:
    """A policy for a learned product."""

    policy: IntArray
    """shape (n_states,), an action per product state."""
    probability: float
    """with which it satisfies the formula from the start, if the learned model is right."""


def reach_and_stay(components: Components, known: BoolArray, discount: float) -> Plan:
    """Reach accepting components with the largest probability, and among all ways that do so, soon.

    Unknown environment states count as lost. Soon means the largest expected discount**steps to the first Inf mark
    inside, by value iteration.
    """
    product = components.product
    trusted = cut(product, known[product.mdp_state][product.choice_state])
    reach = max_reachability(trusted, components.states)
    entering = np.asarray(trusted.matrix @ components.value)
    best = np.asarray(trusted.matrix @ reach.value) >= reach.value[product.choice_state] - TIE
    allowed = best & ~components.states[product.choice_state]
    reward = np.where(components.states[product.choice_state], 0.0, entering - ~best)
    soon = value_iteration(cut(trusted, allowed), reward, discount=discount, tolerance=TOLERANCE)
    policy = np.where(components.states, components.policy, soon.policy)
    return Plan(policy, float(product.initial @ reach.value))


def cut(mdp: ExplicitMDP, allowed: BoolArray) -> ExplicitMDP:
    """The process in which the other choices (n_choices,) leave at once."""
    keep: Any = sparse.diags_array(allowed.astype(np.float64), format="csr")
    matrix = sparse.csr_array(keep @ mdp.matrix)
    matrix.eliminate_zeros()
    return ExplicitMDP(
        matrix,
        mdp.choice_start,
        mdp.choice_action,
        mdp.initial,
        exit_probability=np.where(allowed, mdp.exit_probability, 1.0),
        n_actions=mdp.n_actions,
    )


def as_table(product: Product, policy: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A policy on product states as one on (environment state, automaton state); action 0 where neither was seen."""
    shape = (product.mdp.n_states, product.automaton.n_states, *policy.shape[1:])
    table = np.zeros(shape, dtype=policy.dtype)
    if policy.ndim == 2:
        table[..., 0] = 1.0
    table[product.mdp_state, product.automaton_state] = policy
    return table
