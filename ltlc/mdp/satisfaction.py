"""How probably a run satisfies the automaton: at best, and under a given policy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ltlc.mdp.absorption import absorption
from ltlc.mdp.chain import induced_chain
from ltlc.mdp.end_components import EndComponents, accepting_choices, accepting_end_components
from ltlc.mdp.explicit import BoolArray, FloatArray, IntArray
from ltlc.mdp.max_reachability import Method, max_reachability
from ltlc.mdp.product import Product


@dataclass(frozen=True, eq=False)
class MaxSatisfaction:
    """The maximum satisfaction probability (Pmax), with bounds and an optimal policy.

    Attributes:
        probability: Pmax from the initial states.
        lower, upper: proved bounds on it.
        state_probability: shape (n_states,), Pmax from each product state.
        state_lower, state_upper: proved bounds on it.
        policy: shape (n_states,), an action per product state; memoryless, and enough to attain Pmax.
        components: for each Rabin pair its accepting end components.
    """

    probability: float
    lower: float
    upper: float
    state_probability: FloatArray
    state_lower: FloatArray
    state_upper: FloatArray
    policy: IntArray
    components: tuple[EndComponents, ...]

    @property
    def winning(self) -> BoolArray:
        """The product states in an accepting end component, shape (n_states,)."""
        won = np.zeros(len(self.policy), dtype=np.bool_)
        for accepting in self.components:
            won |= accepting.states
        return won


def max_satisfaction_probability(
    product: Product, *, method: Method = "auto", precision: float = 1e-6, max_iterations: int = 1_000_000
) -> MaxSatisfaction:
    """The largest probability, over all policies, that a run is accepted.

    It is the largest probability of reaching an accepting end component, where some policy then satisfies the condition
    surely. `method`, `precision` and `max_iterations` are those of `max_reachability`.

    Raises:
        InvalidArgumentError: an unknown method, or a precision that is not positive.
        LimitExceeded: the bounds of interval iteration are still apart after `max_iterations`.

    References:
        L. de Alfaro, Formal Verification of Probabilistic Systems, PhD thesis, Stanford 1997, chapter 4.
        C. Baier, J.-P. Katoen, Principles of Model Checking, MIT Press 2008, theorem 10.127.
    """
    components = accepting_end_components(product)
    inside = accepting_choices(product, components)
    reach = max_reachability(product, inside >= 0, method=method, precision=precision, max_iterations=max_iterations)
    lower, value, upper = _from_start(product.initial, reach.lower, reach.value, reach.upper)
    policy = product.choice_action[np.where(inside >= 0, inside, reach.choice)]
    return MaxSatisfaction(value, lower, upper, reach.value, reach.lower, reach.upper, policy, components)


@dataclass(frozen=True, eq=False)
class PolicySatisfaction:
    """The probability that a run under one policy is accepted, with bounds.

    Attributes:
        probability: from the initial states.
        lower, upper: proved bounds on it.
        state_probability: shape (n_states,), from each product state; 0 and 1 are exact.
        state_lower, state_upper: proved bounds on it.
        accepting: shape (n_states,), the recurrent states of accepting bottom components.
    """

    probability: float
    lower: float
    upper: float
    state_probability: FloatArray
    state_lower: FloatArray
    state_upper: FloatArray
    accepting: BoolArray


def satisfaction_probability(product: Product, policy: npt.ArrayLike) -> PolicySatisfaction:
    """The probability that a run under `policy` is accepted, by bottom components and sparse linear systems.

    `policy` is on product states (`Product.lift` helps): int (n_states,) or float (n_states, n_actions).

    Raises:
        InvalidArgumentError: the policy does not fit the product.

    References:
        C. Baier, J.-P. Katoen, Principles of Model Checking, MIT Press 2008, theorem 10.56.
    """
    chain = induced_chain(product, policy)
    bottom = chain.bottom_component
    inside = np.flatnonzero(bottom >= 0)
    number = bottom[inside]
    accepted = np.zeros(int(bottom.max()) + 1, dtype=np.bool_)
    for fin, inf in zip(product.choice_fin, product.choice_inf, strict=True):
        sees_fin = np.bincount(number, chain.of_choices(fin.astype(np.float64))[inside]) > 0
        sees_inf = np.bincount(number, chain.of_choices(inf.astype(np.float64))[inside]) > 0
        accepted |= sees_inf & ~sees_fin
    accepting = np.zeros(product.n_states, dtype=np.bool_)
    accepting[inside] = accepted[number]
    reach = absorption(chain, accepting)
    lower, value, upper = _from_start(product.initial, reach.lower, reach.value, reach.upper)
    return PolicySatisfaction(value, lower, upper, reach.value, reach.lower, reach.upper, accepting)


def _from_start(
    initial: FloatArray, lower: FloatArray, value: FloatArray, upper: FloatArray
) -> tuple[float, float, float]:
    """The means over the first state, the bounds rounded outwards; exact where all values are alike."""
    bounds = np.stack((lower, value, upper))[:, initial > 0]
    if (bounds == bounds[:, :1]).all():  # a mean of equal ones must stay what they are
        least, mean, most = bounds[:, 0].tolist()
        return least, mean, most
    slack = float((bounds.shape[1] + 8) * np.finfo(np.float64).eps)
    least, mean, most = (float(initial @ bound) for bound in (lower, value, upper))
    return least * (1 - slack), mean, min(most * (1 + slack), 1.0)
