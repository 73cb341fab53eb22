"""What schemes for automata in Büchi form have in common."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.automata import DRA, Refinement
from ltlc.rewards.forms import buchi, buchi_form
from ltlc.rewards.scheme import RewardScheme, StepRewards, check_probability, nearer_to_one
from ltlc.rewards.tables import BoolArray


@dataclass(frozen=True)
class BuchiScheme(RewardScheme):
    """A scheme whose payments depend on whether a step accepts; its guarantee holds as one parameter tends to 1.

    Attributes:
        limit_parameter: the parameter that tends to 1; it lies in (0, 1).
    """

    requires: ClassVar[str] = "Büchi form"
    limit_parameter: ClassVar[str]

    def __post_init__(self) -> None:
        check_probability(self, self.limit_parameter)

    def towards_limit(self, k: int) -> RewardScheme:
        """See `RewardScheme.towards_limit`."""
        name = self.limit_parameter
        return dataclasses.replace(self, **{name: nearer_to_one(getattr(self, name), k)})

    def refinement(self, dra: DRA) -> Refinement:
        """See `ltlc.rewards.forms.buchi_form`."""
        return buchi_form(dra)

    def steps(self, dra: DRA) -> StepRewards:
        """What is paid on the accepting edges of the Büchi form, and on the others."""
        return self.payments(buchi(self, dra))

    @abstractmethod
    def payments(self, accepted: BoolArray) -> StepRewards:
        """What is paid, given which steps accept, shape (n_states, n_classes)."""


def discounted_acceptances(accepted: BoolArray, discount: float) -> StepRewards:
    """An accepting step pays 1 and is discounted; accepting for ever is worth 1 / (1 - discount)."""
    return StepRewards(
        accepted=accepted,
        reward=accepted.astype(float),
        discount=np.where(accepted, discount, 1.0),
        satisfaction=1 / (1 - discount),
    )
