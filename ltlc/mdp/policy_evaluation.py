"""The value of a given policy (thesis 2.3.2), by iteration and by solving the linear system."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp.chain import induced_chain
from ltlc.mdp.explicit import ExplicitMDP, FloatArray


def policy_evaluation(
    mdp: ExplicitMDP,
    reward: FloatArray,
    policy: npt.ArrayLike,
    *,
    discount: float = 1.0,
    tolerance: float | None = None,
    max_iterations: int = 1_000_000,
) -> FloatArray:
    """Expected sum of discounted rewards from each state, shape (n_states,).

    `reward` has shape (n_choices,). Exact (a sparse linear solve) unless `tolerance` asks for the iteration
    V(s) <- sum over s', r of p(s', r | s, policy(s)) (r + discount V(s')), which stops when no value moved by more than
    `tolerance`. Undiscounted sums that do not converge are -inf, inf or nan when solved exactly.

    Raises:
        InvalidArgumentError: the policy does not fit the MDP, or the discount is outside [0, 1].
        LimitExceeded: the iteration did not settle.

    References:
        R. Sutton, A. Barto, Reinforcement Learning, 2nd ed., MIT Press 2018, section 4.1; thesis eq. 2.25.
    """
    chain = induced_chain(mdp.reweighted(discount), policy)
    state_reward = chain.of_choices(reward)
    if tolerance is None:
        return chain.total(state_reward)
    if not tolerance > 0:
        raise InvalidArgumentError(f"tolerance is {tolerance}, expected a positive number")
    value: FloatArray = np.zeros(mdp.n_states)
    for _ in range(max_iterations):
        update: FloatArray = state_reward + chain.matrix @ value
        change = np.abs(update - value).max()
        value = update
        if change <= tolerance:
            return value
    raise LimitExceeded(f"policy evaluation still moved by {change:.3g} after {max_iterations} iterations")
