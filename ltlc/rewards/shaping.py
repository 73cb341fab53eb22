"""Potential-based shaping by distance to acceptance, on top of any scheme."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.automata import DRA, Refinement
from ltlc.errors import InvalidArgumentError
from ltlc.rewards.scheme import OnDeadlock, RewardScheme, StepRewards
from ltlc.rewards.tables import FloatArray, OnTermination, RewardTables


def shape(tables: RewardTables, potential: FloatArray) -> RewardTables:
    """The tables with r + discount * potential(q') - potential(q) for r, and potential 0 after the episode.

    The per-step discount is that of the step, so bootstrapping from a truncated episode stays right, and every policy
    keeps its value up to the constant `potential[q]` of where it starts: optimal policies are the same. Where the
    environment terminates, the potential of the state then goes out of the closing value, whatever that is.

    Args:
        tables: what to shape.
        potential: shape (n_states,), float64, finite; equal before and after a choice of a pair.

    References:
        A. Y. Ng, D. Harada, S. Russell, Policy invariance under reward transformations, ICML 1999,
        https://dl.acm.org/doi/10.5555/645528.657613; M. Grzes, Reward shaping in episodic reinforcement learning,
        AAMAS 2017 (the potential after the episode must be 0).
    """
    after = tables.discount * potential[tables.next_state]
    surely = tables.stop == 1  # such a step has no successor to speak of
    return dataclasses.replace(
        tables,
        reward=tables.reward + np.where(surely, 0.0, after) - potential[:, None],
        stop_reward=tables.stop_reward - np.where(surely, 0.0, after),
        closing=tables.closing - potential[:, None],
    )


@dataclass(frozen=True)
class Shaped(RewardScheme):
    """Another scheme, shaped with the potential `weight` times the progress to acceptance.

    Attributes:
        scheme: the scheme underneath.
        weight: potential of a state on an accepting cycle; a deadlock has 0.

    References:
        A. Camacho, R. Toro Icarte, T. Q. Klassen, R. Valenzano, S. A. McIlraith, LTL and beyond: formal languages for
        reward function specification in reinforcement learning, IJCAI 2019, doi 10.24963/ijcai.2019/840.
    """

    name: ClassVar[str] = "shaped"
    citation: ClassVar[str] = "A. Y. Ng et al., ICML 1999; A. Camacho et al., IJCAI 2019, doi 10.24963/ijcai.2019/840"
    guarantee: ClassVar[str] = (
        "The same optimal policies as the scheme underneath, unless an episode can go on for ever undiscounted."
    )
    requires: ClassVar[str] = "what the scheme underneath needs"

    scheme: RewardScheme
    weight: float = 1.0

    def __post_init__(self) -> None:
        if not math.isfinite(self.weight):
            raise InvalidArgumentError(f"shaping weight is {self.weight!r}; it must be a finite number")

    def towards_limit(self, k: int) -> RewardScheme | None:
        """As the scheme underneath; shaping changes no optimal policy."""
        nearer = self.scheme.towards_limit(k)
        return None if nearer is None else dataclasses.replace(self, scheme=nearer)

    def for_horizon(self, steps: int) -> RewardScheme:
        """As the scheme underneath."""
        return dataclasses.replace(self, scheme=self.scheme.for_horizon(steps))

    def refinement(self, dra: DRA) -> Refinement:
        """That of the scheme underneath."""
        return self.scheme.refinement(dra)

    def steps(self, dra: DRA) -> StepRewards:
        """The steps of the scheme underneath; shaping needs the compiled tables."""
        return self.scheme.steps(dra)

    def compile(
        self,
        dra: DRA,
        on_deadlock: OnDeadlock | None = None,
        on_termination: OnTermination = "repeat",
    ) -> RewardTables:
        """The tables of the scheme underneath, shaped; see `RewardScheme.compile`."""
        tables = self.scheme.compile(dra, on_deadlock, on_termination)
        return shape(tables, self.weight * tables.progress)
