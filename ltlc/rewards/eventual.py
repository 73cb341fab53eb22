"""Eventual discounting: only accepting steps are discounted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ltlc.rewards.buchi_scheme import BuchiScheme, discounted_acceptances
from ltlc.rewards.scheme import StepRewards
from ltlc.rewards.tables import BoolArray


@dataclass(frozen=True)
class Eventual(BuchiScheme):
    """An accepting step pays 1 and is discounted by gamma; another pays nothing and is not discounted.

    Attributes:
        gamma: discount of accepting steps, in (0, 1).

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
    limit_parameter: ClassVar[str] = "gamma"

    gamma: float = 0.99

    def payments(self, accepted: BoolArray) -> StepRewards:
        """The value of accepting for ever is 1 / (1 - gamma)."""
        return discounted_acceptances(accepted, self.gamma)
