"""Weights for the two sets of one Rabin pair."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ltlc.automata import DRA, Refinement
from ltlc.errors import InvalidArgumentError
from ltlc.rewards.forms import lacks_form, one_pair_form
from ltlc.rewards.scheme import RewardScheme, StepRewards, check_probability


@dataclass(frozen=True)
class Sadigh(RewardScheme):
    """Pays `weight_inf` on Inf marks and takes `weight_fin` on Fin marks of one pair; Fin wins where both are.

    Attributes:
        weight_inf: reward on an Inf mark.
        weight_fin: penalty on a Fin mark.
        violation: penalty on entering a deadlock; None: `weight_fin`. The paper knows no deadlocks: there it is what
            the Fin marks of the deadlock cost, for ever if there are any, else nothing.
        gamma: discount of every step, in (0, 1].
        pair: index of the pair that is rewarded; None: the only one, or that which the policy chooses.

    References:
        D. Sadigh, E. S. Kim, S. Coogan, S. S. Sastry, S. A. Seshia, A learning based approach to control synthesis of
        Markov decision processes for linear temporal logic specifications, CDC 2014, doi 10.1109/CDC.2014.7039527.
    """

    name: ClassVar[str] = "sadigh"
    citation: ClassVar[str] = "D. Sadigh et al., CDC 2014, doi 10.1109/CDC.2014.7039527"
    guarantee: ClassVar[str] = (
        "If some policy satisfies the chosen pair almost surely, then for gamma near enough to 1 and weight_fin large "
        "enough an optimal policy does; below probability 1 it promises nothing."
    )
    requires: ClassVar[str] = "one Rabin pair, or several of which `pair` names one; otherwise policies choose one"

    comparisons: ClassVar[tuple[Mapping[str, Any], ...]] = ({}, {"gamma": 0.9999})

    weight_inf: float = 1.0
    weight_fin: float = 10.0
    violation: float | None = None
    gamma: float = 0.99
    pair: int | None = None

    def __post_init__(self) -> None:
        check_probability(self, "gamma", one=True)

    def refinement(self, dra: DRA) -> Refinement:
        """The automaton itself where the pair is known; see `ltlc.rewards.forms.one_pair_form`."""
        return one_pair_form(dra) if self.pair is None else Refinement.trivial(dra)

    def steps(self, dra: DRA) -> StepRewards:
        """Weights of the chosen pair."""
        if self.pair is None and dra.n_pairs != 1:
            raise lacks_form(self, dra)
        pair = self.pair or 0
        if not 0 <= pair < dra.n_pairs:
            raise InvalidArgumentError(f"reward scheme sadigh: pair {pair} of an automaton with {dra.n_pairs}")
        fin, inf = dra.edge_fin[pair], dra.edge_inf[pair]
        return StepRewards(
            accepted=inf & ~fin,
            reward=np.select([fin, inf], [-self.weight_fin, self.weight_inf], 0.0),
            discount=self.gamma,
            violation=-(self.weight_fin if self.violation is None else self.violation),
            satisfaction=None if self.gamma == 1 else self.weight_inf / (1 - self.gamma),
        )
