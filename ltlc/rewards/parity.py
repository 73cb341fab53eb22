"""Rewards for parity automata: higher colours weigh exponentially more."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from ltlc.automata import DRA, Refinement
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.rewards.forms import parity, parity_form
from ltlc.rewards.scheme import RewardScheme, StepRewards, check_probability

SMALLEST_WEIGHT = 1e-15
"""1 minus anything much smaller is 1 in double precision."""

Mode = Literal["terminate", "adaptive"]


@dataclass(frozen=True)
class Parity(RewardScheme):
    """A step of colour c, with n the largest colour, weighs w = epsilon^(1 + n - c).

    `terminate`: with probability w the episode ends, paying 1 if c is odd. `adaptive`: the step pays w if c is odd, -w
    if even, and is discounted by 1 - w.

    Attributes:
        epsilon: ratio between the weights of neighbouring colours, in (0, 1).
        mode: how a weight is paid.

    References:
        E. M. Hahn, M. Perez, S. Schewe, F. Somenzi, A. Trivedi, D. Wojtczak, Model-free reinforcement learning for
        stochastic parity games, CONCUR 2020, doi 10.4230/LIPIcs.CONCUR.2020.21 (`terminate`);
        A. K. Bozkurt, Y. Wang, M. M. Zavlanos, M. Pajic, Learning optimal strategies for temporal tasks in stochastic
        games, IEEE Transactions on Automatic Control 2024, doi 10.48550/arXiv.2010.04050 (`adaptive`).
    """

    name: ClassVar[str] = "parity"
    citation: ClassVar[str] = "E. M. Hahn et al., CONCUR 2020, doi 10.4230/LIPIcs.CONCUR.2020.21"
    guarantee: ClassVar[str] = (
        "On a finite MDP optimal policies maximise the probability of satisfaction for every epsilon small enough."
    )
    requires: ClassVar[str] = "parity form"

    comparisons: ClassVar[tuple[Mapping[str, Any], ...]] = ({}, {"epsilon": 0.001}, {"mode": "terminate"})

    epsilon: float = 0.01
    mode: Mode = "adaptive"

    def __post_init__(self) -> None:
        check_probability(self, "epsilon")
        if self.mode not in get_args(Mode):
            raise UnknownNameError("mode of the parity scheme", self.mode, get_args(Mode))

    def towards_limit(self, k: int) -> RewardScheme:
        """Epsilon tends to 0."""
        return dataclasses.replace(self, epsilon=self.epsilon / 10**k)

    def refinement(self, dra: DRA) -> Refinement:
        """See `ltlc.rewards.forms.parity_form`."""
        return parity_form(dra)

    def steps(self, dra: DRA) -> StepRewards:
        """Weights by colour."""
        colours = parity(self, dra)
        weight = np.power(self.epsilon, 1 + colours.max() - colours, dtype=np.float64)
        if weight.min() < SMALLEST_WEIGHT:
            n_colours = int(colours.max() - colours.min()) + 1
            raise InvalidArgumentError(
                f"reward scheme parity: {n_colours} colours with epsilon {self.epsilon:g} need weights as small as "
                f"{weight.min():.1g}, which rounding swallows; take epsilon {SMALLEST_WEIGHT ** (1 / n_colours):.2g} "
                "or larger"
            )
        odd = colours % 2 == 1
        if self.mode == "terminate":
            return StepRewards(accepted=odd, stop=weight, stop_reward=odd.astype(float), satisfaction=1.0)
        reward = np.where(odd, weight, -weight)
        return StepRewards(accepted=odd, reward=reward, discount=1 - weight, violation=-1.0, satisfaction=1.0)
