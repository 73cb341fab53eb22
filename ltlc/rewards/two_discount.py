"""Two discounts: one for accepting steps, one for the others."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.automata import RabinAutomaton, Refinement
from ltlc.rewards.forms import buchi_form
from ltlc.rewards.need import buchi
from ltlc.rewards.scheme import RewardScheme, Steps, check_probability, nearer_to_one


@dataclass(frozen=True)
class TwoDiscount(RewardScheme):
    """An accepting step pays 1 - gamma_accept and is discounted by gamma_accept; another pays 0, discounted by gamma.

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
    needs: ClassVar[str] = "Büchi form"

    gamma_accept: float = 0.99
    """discount of accepting steps, in (0, 1)."""
    gamma: float = 0.99999
    """discount of the other steps, in (0, 1]."""

    def __post_init__(self) -> None:
        check_probability(self, "gamma_accept")
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

    def refinement(self, dra: RabinAutomaton) -> Refinement:
        """See `ltlc.rewards.forms.buchi_form`."""
        return buchi_form(dra)

    def steps(self, dra: RabinAutomaton) -> Steps:
        """The value of accepting for ever is 1."""
        accepted = buchi(self, dra)
        return Steps(
            accepted=accepted,
            reward=np.where(accepted, 1 - self.gamma_accept, 0.0),
            discount=np.where(accepted, self.gamma_accept, self.gamma),
            satisfaction=1.0,
        )
