"""What an agent has learned: exactly where the dynamics are known, by rollouts with confidence intervals elsewhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ltlc.errors import InvalidArgumentError
from ltlc.mdp import expected_return
from ltlc.mdp.estimate import Estimate, mean, probability, ratio
from ltlc.mdp.verdict import Judge

from ..agent import Agent
from ..value_agent import ValueAgent
from .collect import Collector, Episode, Interface
from .metrics import Row
from .progress import Progress

IntArray = npt.NDArray[np.int64]


def greedy_policy(agent: ValueAgent, observations: Any = None) -> IntArray:
    """The greedy action in each environment state and table state, shape (n_observations, n_table_states).

    Args:
        agent: the agent.
        observations: what each environment state shows, as a batch; None: all observations of a discrete space, in
            order, which are the states of a grid world or of an environment with a transition table.

    Raises:
        InvalidArgumentError: there is no finite list of observations to take.
    """
    if observations is None:
        if not agent.encoder.n_observations:
            raise InvalidArgumentError(f"pass observations=...: there is no short list of all of {agent.encoder.space}")
        observations = agent.encoder.all_observations()
    return np.asarray(agent.q_values(observations).argmax(axis=-1))


@dataclass(frozen=True)
class Evaluation:
    """How good the policy was at a row of metrics, exactly.

    Attributes:
        row: the metrics.
        regret: what it loses of the largest expected discounted return, as a part of it; 0 is optimal. None: there is
            no largest one; inf: there is no policy yet.
        satisfaction: probability that it satisfies the formula.
        total_return: expected sum of rewards of an episode; not finite where it may go on for ever.
    """

    row: Row
    regret: float | None = math.inf
    satisfaction: float = 0.0
    total_return: float = math.nan


class EvaluationCallback:
    """Callback of `train` that judges each policy exactly; the clock of the training stands still meanwhile.

    Args:
        judge: of the task, where the observations are the states of its model.
        until: says of an evaluation whether to stop; None: never.

    Attributes:
        evaluations: one for each row of metrics.
    """

    def __init__(self, judge: Judge, until: Callable[[Evaluation], bool] | None = None) -> None:
        self.judge, self.until = judge, until
        self.evaluations: list[Evaluation] = []

    def __call__(self, progress: Progress) -> bool:
        """Evaluate what has been learned so far; whether to stop."""
        self.evaluations.append(self.evaluate(progress))
        return self.until is not None and self.until(self.evaluations[-1])

    def evaluate(self, progress: Progress) -> Evaluation:
        """Judge what has been learned so far."""
        if progress.agent is None:
            return Evaluation(progress.row)
        policy, product = progress.agent.policy_table(), self.judge.rewards
        total = expected_return(product, product.lift(policy), discount=1.0)
        return Evaluation(progress.row, self.judge.regret(policy), self.judge.satisfaction(policy), total)


@dataclass(frozen=True)
class Rollouts:
    """Episodes under a policy.

    Attributes:
        episodes: in the order in which they began.
        confidence: of the intervals, in (0, 1).
    """

    episodes: tuple[Episode, ...]
    confidence: float

    @property
    def episode_return(self) -> Estimate:
        """Mean sum of rewards of an episode, undiscounted."""
        return mean([e.reward for e in self.episodes], confidence=self.confidence)

    @property
    def episode_length(self) -> Estimate:
        """Mean steps of an episode."""
        return mean([e.length for e in self.episodes], confidence=self.confidence)

    @property
    def violations_per_episode(self) -> Estimate:
        """Mean number of violations in an episode."""
        return mean([e.violations for e in self.episodes], confidence=self.confidence)

    @property
    def violations_per_step(self) -> Estimate:
        """Violations per step."""
        return ratio(
            [e.violations for e in self.episodes], [e.length for e in self.episodes], confidence=self.confidence
        )

    @property
    def acceptance_frequency(self) -> Estimate:
        """Accepting steps per step."""
        return ratio(
            [e.acceptances for e in self.episodes], [e.length for e in self.episodes], confidence=self.confidence
        )

    @property
    def satisfied(self) -> Estimate:
        """Probability that an episode has an accepting step and no violation.

        Of a finite episode this is all there is to see; it is the satisfaction probability for formulas that finite
        words decide, and no more than a hint for others.
        """
        good = sum(e.acceptances > 0 and e.violations == 0 for e in self.episodes)
        return probability(good, len(self.episodes), confidence=self.confidence)


def rollout(
    agent: Agent,
    env: VectorEnv[Any, Any, Any],
    n_episodes: int = 100,
    *,
    seed: int = 0,
    max_steps: int = 1_000_000,
    confidence: float = 0.95,
) -> Rollouts:
    """Run the policy for a number of episodes.

    Each sub-environment contributes the same number of episodes, rounded up, so that short ones are not preferred.

    Raises:
        InvalidArgumentError: fewer than two episodes are wanted, the environment is of another kind than the agent's,
            or `max_steps` environment steps were not enough, as where episodes have no end.
    """
    interface = Interface.of(env)
    if interface.space != agent.encoder.space or interface.n_actions != agent.n_actions:
        raise InvalidArgumentError(
            f"the agent was made for {agent.encoder.space}, this environment has {interface.space}"
        )
    if n_episodes < 2:
        raise InvalidArgumentError(f"n_episodes is {n_episodes}; at least 2 are needed for an interval")
    collector = Collector(interface, agent.encoder)
    collector.reset(seed)
    agent.reseed(seed)
    quota = -(-n_episodes // env.num_envs)
    episodes: list[Episode] = []
    finished = np.zeros(env.num_envs, dtype=np.int64)
    for _ in range(-(-max_steps // env.num_envs)):
        collector.follow(agent)
        for i, episode in collector.take_episodes():
            if finished[i] < quota:
                episodes.append(episode)
                finished[i] += 1
        if (finished >= quota).all():
            return Rollouts(tuple(episodes), confidence)
    raise InvalidArgumentError(
        f"{len(episodes)} of {quota * env.num_envs} episodes ended within {max_steps} steps; give the environment a "
        "limit on the length of episodes, or raise max_steps"
    )
