"""One reward for each acceptance: the folklore scheme."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ltlc.automata import DRA, Refinement
from ltlc.rewards.forms import buchi_or_one_pair, one_pair_form
from ltlc.rewards.scheme import RewardScheme, StepRewards, check_probability


@dataclass(frozen=True)
class Accept(RewardScheme):
    """Pays 1 on every accepting step and nothing else, discounted by gamma.

    Attributes:
        gamma: discount of every step, in (0, 1].

    References:
        E. M. Hahn, M. Perez, S. Schewe, F. Somenzi, A. Trivedi, D. Wojtczak, Omega-regular objectives in model-free
        reinforcement learning, TACAS 2019, doi 10.1007/978-3-030-17462-0_27, which shows where it goes wrong.
    """

    name: ClassVar[str] = "accept"
    citation: ClassVar[str] = "folklore; discussed in Hahn et al., TACAS 2019, doi 10.1007/978-3-030-17462-0_27"
    guarantee: ClassVar[str] = "None: many early acceptances can outweigh a larger probability of satisfaction."
    requires: ClassVar[str] = "Büchi form, or one Rabin pair"

    gamma: float = 0.99

    def __post_init__(self) -> None:
        check_probability(self, "gamma", one=True)

    def refinement(self, dra: DRA) -> Refinement:
        """See `ltlc.rewards.forms.one_pair_form`."""
        return one_pair_form(dra)

    def steps(self, dra: DRA) -> StepRewards:
        """1 on acceptance; an accepting sink is worth 1 at every step for ever."""
        accepted = buchi_or_one_pair(self, dra)
        return StepRewards(
            accepted=accepted,
            reward=accepted.astype(float),
            discount=self.gamma,
            satisfaction=None if self.gamma == 1 else 1 / (1 - self.gamma),
        )
