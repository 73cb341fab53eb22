"""What has been learned, beside what can be: exact where the environment is known, sampled elsewhere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy.typing as npt

from ltlc.envs import LTLVectorWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import LabelledMDP
from ltlc.mdp.estimate import Estimate
from ltlc.mdp.verdict import Judge, PolicyVerdict

from .evaluate import Rollouts, greedy_policy, rollout
from .systems import Agent
from .tabular.policy import TablePolicy


class Line(NamedTuple):
    """One figure of a report."""

    title: str
    learned: float | Estimate
    optimum: float | None
    """of the policy that is optimal for the rewards; None where it is not known."""


@dataclass(frozen=True)
class Report:
    """The verdict on a policy."""

    verdict: PolicyVerdict | None
    """exact figures of the policy; None where they were sampled."""
    judge: Judge | None
    rollouts: Rollouts | None

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
            values["regret"] = _plain(self.regret)
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
    """The greedy action in each environment state and table state, shape (n_mdp_states, n_table_states).

    Of a tabular learner that chooses at random, the probability of each action, float, with a last axis more.

    Raises:
        InvalidArgumentError: the agent's observations are not the states of the model.
    """
    if agent.encoder.n_observations != mdp.n_states:
        raise InvalidArgumentError(
            f"the agent sees {agent.encoder.space}, which is no numbering of the {mdp.n_states} states of the model"
        )
    return agent.table if isinstance(agent, TablePolicy) else greedy_policy(agent)


def exact_lines(verdict: PolicyVerdict, optimum: PolicyVerdict | None) -> list[Line]:
    """The figures of a policy, beside those of the one that is optimal for the rewards."""
    return [
        Line(title, getattr(verdict, name), None if optimum is None else getattr(optimum, name))
        for name, title in EXACT_TITLES.items()
    ]


EXACT_TITLES = {
    "satisfaction": "P(formula satisfied)",
    "discounted_return": "expected return, discounted",
    "total_return": "expected return, undiscounted",
    "steps": "steps per episode",
    "violations_per_episode": "violations per episode",
    "violations_per_step": "violations per step",
    "first_acceptance_probability": "P(an accepting step in the episode)",
    "first_acceptance_steps": "steps to the first acceptance",
    "acceptances_per_1000_steps": "acceptances per 1000 steps",
}


def sampled_lines(rollouts: Rollouts) -> list[Line]:
    """The figures of episodes."""
    return [Line(title, estimate, None) for title, estimate in _estimates(rollouts).values()]


def verdict_values(verdict: PolicyVerdict) -> dict[str, Any]:
    """The figures as JSON values; infinities as text."""
    return {name: _plain(getattr(verdict, name)) for name in EXACT_TITLES}


def _estimates(rollouts: Rollouts) -> dict[str, tuple[str, Estimate]]:
    return {
        "accepted_without_violation": ("P(accepting step, no violation)", rollouts.satisfied),
        "total_return": ("return, undiscounted", rollouts.episode_return),
        "steps": ("steps per episode", rollouts.episode_length),
        "violations_per_episode": ("violations per episode", rollouts.violations_per_episode),
        "violations_per_step": ("violations per step", rollouts.violations_per_step),
        "acceptances_per_step": ("acceptances per step", rollouts.acceptance_frequency),
    }


def _plain(value: float | None) -> float | str | None:
    return value if value is None or math.isfinite(value) else str(value)
