"""Reachability with parameter zeta: each acceptance may be the last one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.rewards.buchi_scheme import BuchiScheme
from ltlc.rewards.scheme import StepRewards
from ltlc.rewards.tables import BoolArray


@dataclass(frozen=True)
class ZetaReach(BuchiScheme):
    """On each accepting step the episode ends with probability 1 - zeta, and only then 1 is paid; no discount.

    Attributes:
        zeta: probability of going on after an acceptance, in (0, 1).

    References:
        E. M. Hahn, M. Perez, S. Schewe, F. Somenzi, A. Trivedi, D. Wojtczak, Omega-regular objectives in model-free
        reinforcement learning, TACAS 2019, doi 10.1007/978-3-030-17462-0_27.
    """

    name: ClassVar[str] = "zeta-reach"
    citation: ClassVar[str] = "E. M. Hahn et al., TACAS 2019, doi 10.1007/978-3-030-17462-0_27"
    guarantee: ClassVar[str] = (
        "On a finite MDP there is a zeta' < 1 such that for every zeta >= zeta' optimal policies maximise the "
        "probability of satisfaction."
    )
    limit_parameter: ClassVar[str] = "zeta"

    zeta: float = 0.99

    def payments(self, accepted: BoolArray) -> StepRewards:
        """The value of accepting for ever is 1."""
        stop = np.where(accepted, 1 - self.zeta, 0.0)
        return StepRewards(accepted=accepted, stop=stop, stop_reward=1.0, satisfaction=1.0)
