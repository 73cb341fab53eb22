"""Zeta as a discount: what zeta-reach pays by chance, paid in expectation."""

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
class ZetaDiscount(RewardScheme):
    """An accepting step pays 1 and is discounted by zeta; nothing else pays or is discounted.

    Multiplying by 1 - zeta gives the values of `zeta-reach`, without its randomness.

    References:
        E. M. Hahn, M. Perez, S. Schewe, F. Somenzi, A. Trivedi, D. Wojtczak, Faithful and effective reward schemes for
        model-free reinforcement learning of omega-regular objectives, ATVA 2020, doi 10.1007/978-3-030-59152-6_6.
    """

    name: ClassVar[str] = "zeta-discount"
    citation: ClassVar[str] = "E. M. Hahn et al., ATVA 2020, doi 10.1007/978-3-030-59152-6_6"
    guarantee: ClassVar[str] = (
        "On a finite MDP there is a zeta' < 1 such that for every zeta >= zeta' optimal policies maximise the "
        "probability of satisfaction."
    )
    needs: ClassVar[str] = "Büchi form"

    zeta: float = 0.99
    """discount of accepting steps, in (0, 1)."""

    def __post_init__(self) -> None:
        check_probability(self, "zeta")

    def towards_limit(self, k: int) -> RewardScheme:
        """Zeta tends to 1."""
        return dataclasses.replace(self, zeta=nearer_to_one(self.zeta, k))

    def refinement(self, dra: RabinAutomaton) -> Refinement:
        """See `ltlc.rewards.forms.buchi_form`."""
        return buchi_form(dra)

    def steps(self, dra: RabinAutomaton) -> Steps:
        """The value of accepting for ever is 1 / (1 - zeta)."""
        accepted = buchi(self, dra)
        return Steps(
            accepted=accepted,
            reward=accepted.astype(float),
            discount=np.where(accepted, self.zeta, 1.0),
            satisfaction=1 / (1 - self.zeta),
        )
