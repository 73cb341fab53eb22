"""What a policy earns and does in the rewarded task: exact returns, steps, violations and acceptances.

All functions take a `RewardProduct` and a policy on its states: int (n_states,), one action each, or float
(n_states, n_actions); `RewardProduct.lift` makes one from a policy on MDP states. Where several questions are asked of
one policy, give `RewardProduct.under(policy)` instead, and its chain is made once. Episodes end where the tables stop
and in terminal states of the MDP; a time limit is not part of the model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.explicit import FloatArray
from ltlc.mdp.policy_iteration import optimal_total_reward
from ltlc.mdp.reward_product import EpisodeChain, RewardProduct
from ltlc.mdp.value_iteration import Solution

Policy: TypeAlias = "npt.ArrayLike | EpisodeChain"
"""on the states of a product, or the chain that it induces there."""


def optimal_return(product: RewardProduct, *, discount: float | None = None) -> Solution:
    """The largest expected return from each state and a policy that attains it.

    `discount` is None for the tables' own discounts, or a number that replaces them on every step; 1 = undiscounted.

    Raises:
        InvalidArgumentError: the return is undiscounted where a policy can be paid for ever, or `discount` is outside
            [0, 1].

    References:
        See `optimal_total_reward`.
    """
    return optimal_total_reward(product.discounted(discount), product.reward)


def expected_return(product: RewardProduct, policy: Policy, *, discount: float | None = None) -> float:
    """Expected return of an episode; `discount` as in `optimal_return`.

    Undiscounted, it is -inf or inf where the episode may go on for ever at a cost or for pay, and nan where both occur.

    Raises:
        InvalidArgumentError: the policy does not fit the product, or `discount` is outside [0, 1].
    """
    return from_start(product.initial, state_return(product, policy, discount=discount))


def state_return(product: RewardProduct, policy: Policy, *, discount: float | None = None) -> FloatArray:
    """`expected_return` from each state, shape (n_states,)."""
    chain = _episodes(product, policy).discounted(discount)
    return chain.total(chain.of_choices(product.reward))


def expected_return_within(product: RewardProduct, policy: Policy, steps: int) -> float:
    """Expected sum of rewards of an episode that is cut after a number of steps, if it has not ended before.

    Raises:
        InvalidArgumentError: the policy does not fit the product.
    """
    chain = _episodes(product, policy)
    reward, value = chain.of_choices(product.reward), np.zeros(product.n_states)
    for _ in range(steps):
        before, value = value, reward + chain.matrix @ value
        if (value == before).all():
            break
    return from_start(product.initial, value)


def expected_steps(product: RewardProduct, policy: Policy) -> float:
    """Expected number of steps of an episode; inf where it may go on for ever."""
    return from_start(product.initial, _episodes(product, policy).total(np.ones(product.n_states)))


def expected_violations(product: RewardProduct, policy: Policy) -> float:
    """Expected number of violations in an episode; inf where they may recur for ever."""
    return expected_count(product, policy, product.violation)


def expected_count(product: RewardProduct, policy: Policy, per_choice: FloatArray) -> float:
    """Expected sum over an episode of a quantity per choice, such as `product.expected(table)` gives."""
    chain = _episodes(product, policy)
    return from_start(product.initial, chain.total(chain.of_choices(per_choice)))


def long_run_average(product: RewardProduct, policy: Policy, per_choice: FloatArray) -> float:
    """Average per step, in the long run, of a quantity per choice; an episode that ends is followed by a new one."""
    chain = _episodes(product, policy)
    return chain.long_run_average(chain.of_choices(per_choice))


def violations_per_step(product: RewardProduct, policy: Policy) -> float:
    """Long-run violations per step; an episode that ends is followed by a new one."""
    return long_run_average(product, policy, product.violation)


def acceptances_per_1000_steps(product: RewardProduct, policy: Policy) -> float:
    """Long-run accepting steps per 1000 steps; an episode that ends is followed by a new one."""
    return 1000 * long_run_average(product, policy, product.acceptance)


@dataclass(frozen=True)
class FirstAcceptance:
    """When a policy accepts for the first time in an episode.

    Attributes:
        probability: that the episode has an accepting step at all.
        steps: expected number of the first accepting step, counted from 1; inf where it may never come.
    """

    probability: float
    steps: float


def first_acceptance(product: RewardProduct, policy: Policy) -> FirstAcceptance:
    """Probability that an episode accepts, and the expected number of steps until it first does."""
    chain = _episodes(product, policy).until_acceptance()
    accepted = chain.total(chain.of_choices(product.acceptance))
    probability = min(1.0, from_start(product.initial, accepted))
    surely = not (chain.reaches(_may_fail(product, chain))[product.initial > 0]).any()
    steps = from_start(product.initial, chain.total(np.ones(chain.n_states))) if surely else np.inf
    return FirstAcceptance(1.0 if surely else probability, steps)


def _may_fail(product: RewardProduct, chain: MarkovChain) -> npt.NDArray[np.bool_]:
    """States in which the episode may end without an accepting step, or goes on for ever without one."""
    lost = chain.of_choices(product.unaccepted_end)
    return (lost > 0) | (chain.bottom_component >= 0)


def _episodes(product: RewardProduct, policy: Policy) -> EpisodeChain:
    return policy if isinstance(policy, EpisodeChain) else product.under(policy)


def from_start(initial: FloatArray, value: FloatArray) -> float:
    """The mean over the first state; states that never come first do not count, even if infinite."""
    used = initial > 0
    return float(initial[used] @ value[used])
