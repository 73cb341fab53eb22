"""Eventual discounting: only accepting steps are discounted."""

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
class Eventual(RewardScheme):
    """An accepting step pays 1 and is discounted by gamma; another pays nothing and is not discounted.

    References:
        C. Voloshin, A. Verma, Y. Yue, Eventual discounting temporal logic counterfactual experience replay, ICML 2023,
        https://proceedings.mlr.press/v202/voloshin23a.html (arXiv 2303.02135).
    """

    name: ClassVar[str] = "eventual"
    citation: ClassVar[str] = "C. Voloshin et al., ICML 2023, arXiv 2303.02135, doi 10.48550/arXiv.2303.02135"
    guarantee: ClassVar[str] = (
        "The optimal policy's probability of satisfaction is within 2 log(1/gamma) times the expected number of "
        "acceptances of non-satisfying runs (supremum over policies) of the maximum."
    )
    needs: ClassVar[str] = "Büchi form"

    gamma: float = 0.99
    """discount of accepting steps, in (0, 1)."""

    def __post_init__(self) -> None:
        check_probability(self, "gamma")

    def towards_limit(self, k: int) -> RewardScheme:
        """Gamma tends to 1."""
        return dataclasses.replace(self, gamma=nearer_to_one(self.gamma, k))

    def refinement(self, dra: RabinAutomaton) -> Refinement:
        """See `ltlc.rewards.forms.buchi_form`."""
        return buchi_form(dra)

    def steps(self, dra: RabinAutomaton) -> Steps:
        """The value of accepting for ever is 1 / (1 - gamma)."""
        accepted = buchi(self, dra)
        return Steps(
            accepted=accepted,
            reward=accepted.astype(float),
            discount=np.where(accepted, self.gamma, 1.0),
            satisfaction=1 / (1 - self.gamma),
        )
