"""Everything exact that can be said of a policy, in one value; and the same of the best policies, to compare with."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ltlc.automata.rabin import DRA
from ltlc.errors import InvalidArgumentError
from ltlc.mdp.explicit import IntArray
from ltlc.mdp.measures import (
    acceptances_per_1000_steps,
    expected_return,
    expected_steps,
    expected_violations,
    first_acceptance,
    from_start,
    optimal_return,
    violations_per_step,
)
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.product import Product
from ltlc.mdp.product_exploration import InitialLabel, input_probability
from ltlc.mdp.reward_product import RewardColumns, RewardProduct
from ltlc.mdp.satisfaction import (
    MaxSatisfaction,
    PolicySatisfaction,
    max_satisfaction_probability,
    satisfaction_probability,
)
from ltlc.mdp.value_iteration import Solution
from ltlc.notebook import fragment

Bounds = tuple[float, float]

TOLERANCE = 1e-3
"""what a policy that is optimal for the rewards may miss of the maximum satisfaction probability, or half of that if it
is less, before `Judge.falls_short` says so: schemes with a guarantee attain it in a limit only."""

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
"""titles of the figures of a `PolicyVerdict`, in reading order."""


class RefinedColumns(RewardColumns, Protocol):
    """Reward columns whose states refine those of an automaton."""

    @property
    def automaton_state(self) -> npt.NDArray[Any]:
        """The automaton's state behind each table state, shape (n_states,)."""
        ...


class JudgedTask(Protocol):
    """What a judge reads of a task (`ltlc.Task`)."""

    @property
    def automaton(self) -> DRA:
        """What decides satisfaction."""
        ...

    @property
    def tables(self) -> RefinedColumns:
        """What is paid; their states may refine those of the automaton."""
        ...


@dataclass(frozen=True)
class PolicyVerdict:
    """What a policy does, exactly; episodes end where the task or the environment ends them.

    Attributes:
        satisfaction: probability that the word of an endless run satisfies the formula, in [0, 1]; a violation is
            final.
        satisfaction_bounds: proved bounds on it, below and above.
        discounted_return: expected return of an episode with the discounts of the reward scheme.
        total_return: expected sum of rewards of an episode; -inf or inf where it may go on for ever.
        steps: expected steps of an episode; inf where it may go on for ever.
        violations_per_episode: expected violations in an episode; inf where they may recur for ever.
        violations_per_step: violations per step in the long run.
        first_acceptance_probability: probability that an episode has an accepting step, in [0, 1].
        first_acceptance_steps: expected number of the first accepting step, counted from 1; inf where it may never
            come.
        acceptances_per_1000_steps: accepting steps per 1000 steps in the long run.
    """

    satisfaction: float
    satisfaction_bounds: Bounds
    discounted_return: float
    total_return: float
    steps: float
    violations_per_episode: float
    violations_per_step: float
    first_acceptance_probability: float
    first_acceptance_steps: float
    acceptances_per_1000_steps: float

    def _repr_html_(self) -> str:
        """The figures for a notebook."""
        return fragment("verdict", [(title, f"{getattr(self, name):.6g}") for name, title in EXACT_TITLES.items()])


class Judge:
    """Judges policies of one task in one known environment; what does not depend on the policy is computed once.

    A policy is an action for each pair of environment and table state, int, shape (n_mdp_states, n_table_states), or
    probabilities of actions, float, with a last axis more; where the tables have choices, those of the wrapped
    environment.

    Args:
        mdp: the environment.
        task: an `ltlc.Task`, or anything else with an automaton and reward tables.
        initial_label: whether the automaton reads the label of the first state.

    Attributes:
        initial_label: see above.
        rewards: the product with the reward tables: what an agent experiences.
        words: the product with the automaton: what decides satisfaction.

    Raises:
        UnknownNameError: the automaton has a proposition that the environment does not label.

    Example:
        >>> from ltlc import Judge, Task
        >>> from ltlc.mdp import LabelledMDP
        >>> corridor = LabelledMDP.from_arrays([[[0.5, 0.5], [0, 1]]], aps=["goal"], labels=[[], ["goal"]])
        >>> Judge(corridor, Task("F goal")).maximum.probability
        1.0
    """

    def __init__(self, mdp: LabelledMDP, task: JudgedTask, *, initial_label: InitialLabel = "read") -> None:
        tables = task.tables
        self.initial_label = initial_label
        self.rewards = RewardProduct(mdp, tables, initial_label=initial_label)
        refined = refined_automaton(task.automaton, tables)
        self.words = Product(mdp, refined, select_pair=_choices(tables), initial_label=initial_label)

    @cached_property
    def maximum(self) -> MaxSatisfaction:
        """The maximum satisfaction probability, with bounds."""
        return max_satisfaction_probability(self.words)

    @cached_property
    def value(self) -> float | None:
        """The largest expected return, discounted as the scheme says; None where it has no finite value."""
        return None if self._solution is None else from_start(self.rewards.initial, self._solution.value)

    @cached_property
    def optimal_policy(self) -> IntArray | None:
        """A policy that attains `value`; the first action there is where nothing is to be decided."""
        if self._solution is None:
            return None
        pairs = np.repeat(self._any_action[:, None], self.reached.shape[1], axis=1)
        pairs[self.rewards.mdp_state, self.rewards.machine_state] = self._solution.policy
        return pairs

    @cached_property
    def optimum(self) -> PolicyVerdict | None:
        """The verdict on `optimal_policy`."""
        return None if self.optimal_policy is None else self.judge(self.optimal_policy)

    @cached_property
    def falls_short(self) -> bool:
        """Whether `optimal_policy` surely misses `maximum` by more than `TOLERANCE`, or there is none."""
        if self.optimum is None:
            return self.maximum.lower > 0
        missed = self.maximum.lower - self.optimum.satisfaction_bounds[1]
        return missed > min(TOLERANCE, self.maximum.lower / 2)

    @cached_property
    def _solution(self) -> Solution | None:
        try:
            return optimal_return(self.rewards)
        except InvalidArgumentError:  # undiscounted pay for ever
            return None

    def satisfaction(self, policy: npt.ArrayLike) -> float:
        """The probability that the word of an endless run satisfies the formula; a violation is final.

        Raises:
            InvalidArgumentError: the policy is of another shape.
        """
        return self.policy_satisfaction(policy).probability

    def policy_satisfaction(self, policy: npt.ArrayLike) -> PolicySatisfaction:
        """`satisfaction` with proved bounds.

        Raises:
            InvalidArgumentError: the policy is of another shape.
        """
        return satisfaction_probability(self.words, self.on_words(policy))

    def on_words(self, policy: npt.ArrayLike) -> npt.NDArray[Any]:
        """A policy as one on the states of `words`.

        Where the environment has terminated, no action matters but the choice of a pair, and the best choice is made.

        Raises:
            InvalidArgumentError: the policy is of another shape.
        """
        given = np.asarray(policy)
        sink: npt.NDArray[Any] = self._any_action[:, None]  # after a violation nothing matters any more
        if given.ndim == 3:
            sink = np.eye(given.shape[2])[sink]
        lifted = self.words.lift(np.concatenate((given, sink), axis=1))
        terminal = self.words.mdp.terminal
        if terminal is None or self.words.n_actions == self.words.mdp.n_actions:
            return lifted
        over = terminal[self.words.mdp_state]
        best = self.maximum.policy if given.ndim == 2 else np.eye(given.shape[2])[self.maximum.policy]
        return np.where(over.reshape(-1, *[1] * (given.ndim - 2)), best, lifted)

    def judge(self, policy: npt.ArrayLike) -> PolicyVerdict:
        """The verdict on a policy.

        Raises:
            InvalidArgumentError: it is of another shape.
        """
        rewards = self.rewards
        episodes = rewards.under(rewards.lift(policy))
        first, satisfied = first_acceptance(rewards, episodes), self.policy_satisfaction(policy)
        return PolicyVerdict(
            satisfaction=satisfied.probability,
            satisfaction_bounds=(satisfied.lower, satisfied.upper),
            discounted_return=expected_return(rewards, episodes),
            total_return=expected_return(rewards, episodes, discount=1.0),
            steps=expected_steps(rewards, episodes),
            violations_per_episode=expected_violations(rewards, episodes),
            violations_per_step=violations_per_step(rewards, episodes),
            first_acceptance_probability=first.probability,
            first_acceptance_steps=first.steps,
            acceptances_per_1000_steps=acceptances_per_1000_steps(rewards, episodes),
        )

    def regret(self, policy: npt.ArrayLike) -> float | None:
        """What a policy loses in discounted return, as a part of the optimum; 0 is optimal, None: there is none."""
        if self.value is None:
            return None
        value = expected_return(self.rewards, self.rewards.lift(policy))
        return (self.value - value) / (abs(self.value) or 1.0)

    @property
    def _any_action(self) -> IntArray:
        """The first action that each state of the environment offers, shape (n_mdp_states,)."""
        return np.asarray(np.argmax(self.rewards.mdp.available, axis=1))

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """Which pairs some policy visits while learning, shape (n_mdp_states, n_table_states)."""
        product = self.rewards
        reached = np.zeros((product.mdp.n_states, len(np.asarray(product.tables.next_state))), dtype=np.bool_)
        reached[product.mdp_state, product.machine_state] = True
        return reached

    @property
    def letter_classes(self) -> IntArray:
        """The letter classes of the tables that can occur in the environment, ascending."""
        tables = self.rewards.tables
        inputs = input_probability(
            self.rewards.mdp, tuple(tables.aps), np.asarray(tables.letter_class), getattr(tables, "possible", None)
        )
        return np.unique(inputs.indices)


def refined_automaton(automaton: DRA, tables: RefinedColumns) -> DRA:
    """The automaton with the states of reward tables, and one more, the last, that every violation leads to.

    It accepts the same words; a policy on table states is one on its states.
    """
    behind = np.asarray(tables.automaton_state)
    violated = np.asarray(tables.violated, dtype=np.bool_)
    n, n_classes = violated.shape
    delta = np.full((n + 1, n_classes), n, dtype=np.int32)
    delta[:n] = np.where(violated, n, tables.next_state)

    def marks(edge_marks: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        table = np.zeros((len(edge_marks), n + 1, n_classes), dtype=np.bool_)
        table[:, :n] = edge_marks[:, behind] & ~violated
        return table

    return replace(
        automaton,
        delta=delta,
        letter_class=np.asarray(tables.letter_class, dtype=np.int32),
        fin=marks(automaton.edge_fin),
        inf=marks(automaton.edge_inf),
        initial_state=int(tables.initial_state),
        acceptance="transition",
        state_names=None,
    )


def _choices(tables: RefinedColumns) -> IntArray:
    """The choices of the tables, on the states of `refined_automaton`; usually there are none."""
    n = len(np.asarray(tables.automaton_state))
    select_pair = np.asarray(getattr(tables, "select_pair", np.zeros((n, 0), dtype=np.int32)))
    return np.vstack((select_pair, np.full((1, select_pair.shape[1]), -1, dtype=np.int32)))
