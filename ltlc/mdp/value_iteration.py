"""Value iteration (thesis 2.3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp.explicit import ExplicitMDP, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Solution:
    """Optimal values and a policy that attains them.

    Attributes:
        value: shape (n_states,).
        policy: shape (n_states,), an action per state.
        error_bound: no value is further than this from the true one, rounding aside; inf where nothing is known.
        iterations: sweeps that were made.
    """

    value: FloatArray
    policy: IntArray
    error_bound: float
    iterations: int


def value_iteration(
    mdp: ExplicitMDP,
    reward: FloatArray,
    *,
    discount: float = 1.0,
    tolerance: float = 1e-9,
    max_iterations: int = 1_000_000,
) -> Solution:
    """Optimal expected sum of discounted rewards; `reward` has shape (n_choices,).

    Where every step is discounted, values are within `tolerance` of the optimum when it stops. Otherwise it stops when
    no value moved by more than `tolerance`, which proves nothing (`error_bound` is inf): for undiscounted returns use
    `optimal_total_reward`, for probabilities `max_satisfaction_probability`.

    Raises:
        InvalidArgumentError: the discount is outside [0, 1], or the tolerance is not positive.
        LimitExceeded: it did not settle.

    References:
        M. Puterman, Markov Decision Processes, Wiley 1994, section 6.3; thesis eq. 2.23, 2.24.
    """
    if not tolerance > 0:
        raise InvalidArgumentError(f"tolerance is {tolerance}, expected a positive number")
    process = mdp.reweighted(discount)
    contraction = float(process.matrix.sum(axis=1).max())
    sound = contraction < 1
    threshold = tolerance * (1 - contraction) / contraction if 0 < contraction < 1 else tolerance
    value = np.zeros(mdp.n_states)
    for iteration in range(1, max_iterations + 1):
        choice_value = reward + process.matrix @ value
        update = process.best(choice_value)
        change = float(np.abs(update - value).max())
        value = update
        if change <= threshold:
            policy = process.choice_action[process.greedy(reward + process.matrix @ value)]
            return Solution(value, policy, change * contraction / (1 - contraction) if sound else np.inf, iteration)
    raise LimitExceeded(f"value iteration still moved by {change:.3g} after {max_iterations} iterations")
