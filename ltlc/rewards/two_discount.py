"""Two discounts: one for accepting steps, one for the others."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.rewards.buchi_scheme import BuchiScheme
from ltlc.rewards.scheme import RewardScheme, StepRewards, check_probability, nearer_to_one
from ltlc.rewards.tables import BoolArray


@dataclass(frozen=True)
class TwoDiscount(BuchiScheme):
    """An accepting step pays 1 - gamma_accept and is discounted by gamma_accept; another pays 0, discounted by gamma.

    Attributes:
        gamma_accept: discount of accepting steps, in (0, 1).
        gamma: discount of the other steps, in (0, 1].

    References:
        A. K. Bozkurt, Y. Wang, M. M. Zavlanos, M. Pajic, Control synthesis from linear temporal logic specifications
        using model-free reinforcement learning, ICRA 2020, doi 10.1109/ICRA40945.2020.9196796.
    """

    name: ClassVar[str] = "two-discount"
    citation: ClassVar[str] = "A. K. Bozkurt et al., ICRA 2020, doi 10.1109/ICRA40945.2020.9196796"
    guarantee: ClassVar[str] = (
        "Optimal values tend to the maximum probability of satisfaction as both discounts tend to 1 with "
        "(1 - gamma) / (1 - gamma_accept) tending to 0, so gamma must be far nearer to 1."
    )
    limit_parameter: ClassVar[str] = "gamma_accept"

    gamma_accept: float = 0.99
    gamma: float = 0.99999

    def __post_init__(self) -> None:
        super().__post_init__()
        check_probability(self, "gamma", one=True)

    def towards_limit(self, k: int) -> RewardScheme:
        """Both discounts tend to 1; gamma is the first to move, and moves two steps to one of gamma_accept."""
        if k == 0:
            return self
        return dataclasses.replace(
            self,
            gamma_accept=nearer_to_one(self.gamma_accept, k - 1),
            gamma=nearer_to_one(self.gamma, 2 * k - 1),
        )

    def for_horizon(self, steps: int) -> RewardScheme:
        """1 - gamma is 1 / steps, and 1 - gamma_accept the root of half of that, as the guarantee asks."""
        if self != TwoDiscount():
            return self
        lost = 1 / steps
        return TwoDiscount(gamma_accept=1 - math.sqrt(lost / 2), gamma=1 - lost)

    def payments(self, accepted: BoolArray) -> StepRewards:
        """The value of accepting for ever is 1."""
        return StepRewards(
            accepted=accepted,
            reward=np.where(accepted, 1 - self.gamma_accept, 0.0),
            discount=np.where(accepted, self.gamma_accept, self.gamma),
            satisfaction=1.0,
        )
