"""Reachability with parameter zeta: each acceptance may be the last one."""

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
class ZetaReach(RewardScheme):
    """On each accepting step the episode ends with probability 1 - zeta, and only then 1 is paid; no discount.

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
    needs: ClassVar[str] = "Büchi form"

    zeta: float = 0.99
    """probability of going on after an acceptance, in (0, 1)."""

    def __post_init__(self) -> None:
        check_probability(self, "zeta")

    def towards_limit(self, k: int) -> RewardScheme:
        """Zeta tends to 1."""
        return dataclasses.replace(self, zeta=nearer_to_one(self.zeta, k))

    def refinement(self, dra: RabinAutomaton) -> Refinement:
        """See `ltlc.rewards.forms.buchi_form`."""
        return buchi_form(dra)

    def steps(self, dra: RabinAutomaton) -> Steps:
        """The value of accepting for ever is 1."""
        accepted = buchi(self, dra)
        return Steps(accepted=accepted, stop=np.where(accepted, 1 - self.zeta, 0.0), stop_reward=1.0, satisfaction=1.0)
