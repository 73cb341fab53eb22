"""What has been learned, beside what can be: exact where the environment is known, sampled elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from ltlc.envs import LTLVectorWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.faithful import Shortfall
from ltlc.mdp import LabelledMDP
from ltlc.mdp.estimate import Estimate
from ltlc.mdp.figures import Line, exact_lines, plain, verdict_values
from ltlc.mdp.verdict import Judge, PolicyVerdict

from ..agent import Agent
from .evaluate import Rollouts, rollout


@dataclass(frozen=True)
class Report:
    """The verdict on a policy."""

    verdict: PolicyVerdict | None
    """exact figures of the policy; None where they were sampled."""
    judge: Judge | None
    rollouts: Rollouts | None
    shortfall: Shortfall | None = None
    """what the optimum of the rewards misses of the maximum satisfaction probability, where that is known."""

    @property
    def exact(self) -> bool:
        """Whether the figures are exact."""
        return self.verdict is not None

    @property
    def regret(self) -> float | None:
        """Loss in discounted return as a part of the optimum, where it is known."""
        if self.verdict is None or self.judge is None or self.judge.value is None:
            return None
        return (self.judge.value - self.verdict.discounted_return) / (abs(self.judge.value) or 1.0)

    def lines(self) -> list[Line]:
        """The figures in reading order."""
        if self.rollouts is not None:
            return sampled_lines(self.rollouts)
        assert self.verdict is not None and self.judge is not None
        return exact_lines(self.verdict, self.judge.optimum)

    def to_dict(self) -> dict[str, Any]:
        """The figures as JSON values; infinities as text."""
        values: dict[str, Any] = {"exact": self.exact}
        if self.verdict is not None and self.judge is not None:
            maximum = self.judge.maximum
            values["learned"] = verdict_values(self.verdict)
            values["optimal"] = None if self.judge.optimum is None else verdict_values(self.judge.optimum)
            values["maximum_satisfaction"] = [maximum.lower, maximum.probability, maximum.upper]
            values["shortfall"] = None if self.shortfall is None else self.shortfall.to_dict()
            values["regret"] = plain(self.regret)
        if self.rollouts is not None:
            values["learned"] = {
                name: {"value": value.value, "low": value.low, "high": value.high, "confidence": value.confidence}
                for name, (_, value) in _estimates(self.rollouts).items()
            }
            values["episodes"] = len(self.rollouts.episodes)
        return values


def report(agent: Agent, judge: Judge | None, env: LTLVectorWrapper, *, episodes: int = 100, seed: int = 0) -> Report:
    """Judge an agent: exactly with a judge, else by so many episodes in the environment."""
    if judge is None:
        return Report(None, None, rollout(agent, env, episodes, seed=seed))
    return Report(judge.judge(tabular_policy(agent, judge.rewards.mdp)), judge, None)


def tabular_policy(agent: Agent, mdp: LabelledMDP) -> npt.NDArray[Any]:
    """The action in each environment state and table state, shape (n_mdp_states, n_table_states).

    Of an agent that chooses at random, the probability of each action, float, with a last axis more.

    Raises:
        InvalidArgumentError: the agent's observations are not the states of the model.
    """
    if agent.encoder.n_observations != mdp.n_states:
        raise InvalidArgumentError(
            f"the agent sees {agent.encoder.space}, which is no numbering of the {mdp.n_states} states of the model"
        )
    return agent.policy_table()


def sampled_lines(rollouts: Rollouts) -> list[Line]:
    """The figures of episodes."""
    return [Line(title, estimate, None) for title, estimate in _estimates(rollouts).values()]


def _estimates(rollouts: Rollouts) -> dict[str, tuple[str, Estimate]]:
    return {
        "accepted_without_violation": ("P(accepting step, no violation)", rollouts.satisfied),
        "total_return": ("return, undiscounted", rollouts.episode_return),
        "steps": ("steps per episode", rollouts.episode_length),
        "violations_per_episode": ("violations per episode", rollouts.violations_per_episode),
        "violations_per_step": ("violations per step", rollouts.violations_per_step),
        "acceptances_per_step": ("acceptances per step", rollouts.acceptance_frequency),
    }
