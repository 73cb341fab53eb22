"""What an agent has learned: exactly where the dynamics are known, by rollouts with confidence intervals elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ltlc.errors import InvalidArgumentError
from ltlc.mdp import LabelledMDP, RewardProduct, expected_return, optimal_return
from ltlc.mdp.estimate import Estimate, mean, probability, ratio
from ltlc.mdp.figures import figure_text
from ltlc.mdp.measures import from_start
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..value_agent import ValueAgent
from .collect import Collector, Episode, Interface

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
class Regret:
    """Exact expected return of a policy from the start, beside the largest one there is.

    Attributes:
        value: expected discounted return of the policy.
        optimum: of the best policy.
    """

    value: float
    optimum: float

    @property
    def relative(self) -> float:
        """What is lost, as a part of the optimum; 0 is optimal."""
        return (self.optimum - self.value) / (abs(self.optimum) or 1.0)

    def __str__(self) -> str:
        return f"return {figure_text(self.value)}, optimum {figure_text(self.optimum)}, regret {self.relative:.2%}"


class ExactJudge:
    """Exact regret of policies on one known product; what does not depend on the policy is computed once.

    Args:
        mdp: the environment, see `ltlc.envs.labelled_mdp`.
        tables: the rewards to judge by, such as `agent.tables`.
        initial_label: as in the wrapper.
    """

    def __init__(
        self, mdp: LabelledMDP, tables: RewardTables, *, initial_label: Literal["read", "skip"] = "read"
    ) -> None:
        self.product = RewardProduct(mdp, tables, initial_label=initial_label)
        self.optimum = from_start(self.product.initial, optimal_return(self.product).value)

    def regret(self, policy: IntArray) -> Regret:
        """Exact regret of a policy, shape (n_mdp_states, n_table_states)."""
        return Regret(expected_return(self.product, self.product.lift(policy)), self.optimum)


@dataclass(frozen=True)
class Rollouts:
    """Episodes under the greedy policy.

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


class Actor(Protocol):
    """What `rollout` asks of an agent."""

    @property
    def encoder(self) -> ObservationEncoder:
        """Of the observations."""
        ...

    @property
    def n_actions(self) -> int:
        """Of the environment."""
        ...

    def packed_policy(self, packed: npt.NDArray[Any], states: IntArray) -> IntArray:
        """Actions for packed observations and table states, shape (batch,)."""
        ...


def rollout(
    agent: Actor,
    env: VectorEnv[Any, Any, Any],
    n_episodes: int = 100,
    *,
    seed: int = 0,
    max_steps: int = 1_000_000,
    confidence: float = 0.95,
) -> Rollouts:
    """Run the greedy policy for a number of episodes.

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
    quota = -(-n_episodes // env.num_envs)
    episodes: list[Episode] = []
    finished = np.zeros(env.num_envs, dtype=np.int64)
    for _ in range(-(-max_steps // env.num_envs)):
        collector.step(agent.packed_policy(collector.packed, collector.states))
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
