"""Zeta as a discount: what zeta-reach pays by chance, paid in expectation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ltlc.rewards.buchi_scheme import BuchiScheme, discounted_acceptances
from ltlc.rewards.scheme import StepRewards
from ltlc.rewards.tables import BoolArray


@dataclass(frozen=True)
class ZetaDiscount(BuchiScheme):
    """An accepting step pays 1 and is discounted by zeta; nothing else pays or is discounted.

    Multiplying by 1 - zeta gives the values of `zeta-reach`, without its randomness.

    Attributes:
        zeta: discount of accepting steps, in (0, 1).

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
    limit_parameter: ClassVar[str] = "zeta"

    zeta: float = 0.99

    def payments(self, accepted: BoolArray) -> StepRewards:
        """The value of accepting for ever is 1 / (1 - zeta)."""
        return discounted_acceptances(accepted, self.zeta)
