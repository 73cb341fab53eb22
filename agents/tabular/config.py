"""What the hyperparameters of every tabular learner have in common."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from ltlc.errors import InvalidArgumentError

from ..config import AgentConfig, between


@dataclass(frozen=True, kw_only=True)
class LearnerConfig(AgentConfig):
    """Hyperparameters of a tabular learner.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.
    """

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            check_kind(field.name, getattr(self, field.name), str(field.type))
        super().__post_init__()


def check_kind(name: str, value: object, kind: str) -> None:
    """Check a value against an annotation made of `bool`, `int`, `float` and `None`.

    Raises:
        InvalidArgumentError: it does not fit.
    """
    kinds = kind.split(" | ")
    match value:
        case None:
            fits = "None" in kinds
        case bool():
            fits = "bool" in kinds
        case int():
            fits = "int" in kinds or "float" in kinds
        case float():
            fits = "float" in kinds and math.isfinite(value)
        case _:
            fits = False
    if not fits:
        wanted = {"bool": "true or false", "int": "a whole number", "float": "a number", "None": "null"}
        raise InvalidArgumentError(f"{name} is {value!r}; it must be {' or '.join(wanted[one] for one in kinds)}")


def check_open(config: LearnerConfig, *names: str) -> None:
    """Check that hyperparameters, where they are not None, lie strictly between 0 and 1.

    Raises:
        InvalidArgumentError: one does not.
    """
    for name in names:
        value = getattr(config, name)
        if value is not None and not 0 < value < 1:
            raise InvalidArgumentError(f"{name} is {value}; it must lie strictly between 0 and 1")


def check_positive(config: LearnerConfig, *names: str) -> None:
    """Check that hyperparameters are positive.

    Raises:
        InvalidArgumentError: one is not.
    """
    for name in names:
        if not getattr(config, name) > 0:
            raise InvalidArgumentError(f"{name} is {getattr(config, name)}; it must be positive")


def check_probability(config: LearnerConfig, *names: str) -> None:
    """Check that hyperparameters are probabilities.

    Raises:
        InvalidArgumentError: one is not.
    """
    for name in names:
        if not 0 <= getattr(config, name) <= 1:
            raise InvalidArgumentError(f"{name} is {getattr(config, name)}; it must be a probability")


@dataclass(frozen=True, kw_only=True)
class ExplorationConfig(LearnerConfig):
    """Hyperparameters of a learner that explores by random actions.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.
    """

    epsilon_start: float = 1.0
    """probability of a random action at the start, in [0, 1]."""
    epsilon_final: float = 0.3
    """probability of a random action after half of the steps, in [0, 1]; linear in between."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_probability(self, "epsilon_start", "epsilon_final")

    def epsilon_at(self, steps: int) -> float:
        """Return the probability of a random action after so many environment steps."""
        return between(self.epsilon_start, self.epsilon_final, 2 * steps / self.total_steps)


@dataclass(frozen=True, kw_only=True)
class ExplorerConfig(LearnerConfig):
    """Hyperparameters of a learner that explores until the transition probabilities are known.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.
    """

    accuracy: float | None = 0.03
    """error of a transition probability at which it counts as known, in (0, 1)."""
    delta: float = 0.05
    """probability with which each estimate may be wrong, in (0, 1)."""
    discount: float = 0.99
    """of a step, in (0, 1)."""
    total_steps: int = 2_000_000
    """environment steps at most, >= 1."""
    refresh_every: int = 32
    """steps of each sub-environment from one look at what is known to the next, >= 1."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_open(self, "accuracy", "delta", "discount")
        check_positive(self, "refresh_every")


@dataclass(frozen=True, kw_only=True)
class QLearningConfig(ExplorationConfig):
    """Hyperparameters of tabular Q-learning.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.

    References:
        C. Watkins, P. Dayan, Q-learning, Machine Learning 8, 1992, doi 10.1007/BF00992698.
        H. van Hasselt, Double Q-learning, NeurIPS 2010.
        C. Jin, Z. Allen-Zhu, S. Bubeck, M. Jordan, Is Q-learning provably efficient?, NeurIPS 2018, arXiv 1807.03765.
        R. Toro Icarte et al., Reward machines: exploiting reward function structure in reinforcement learning, JAIR
        2022, doi 10.1613/jair.1.12440 (counterfactual updates).
    """

    double: bool = False
    """two tables: each step teaches one of them, by the other's value of the action that it thinks best itself."""
    counterfactual: bool = True
    """each step teaches every automaton state at once; else only the one it was made in."""
    horizon: float = 100.0
    """H of the learning rate (H + 1) / (H + n) of the n-th visit (Jin et al.), > 0: larger forgets early estimates
    faster and averages over fewer late ones."""
    total_steps: int = 1_000_000
    """environment steps, >= 1."""
    averaging_steps: float = 25_000
    """the policy is greedy in an exponential average of the table over about so many environment steps, > 0; 1: in the
    table itself."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive(self, "horizon", "averaging_steps")


@dataclass(frozen=True, kw_only=True)
class FuTopcuConfig(ExplorerConfig):
    """Hyperparameters of PAC learning with temporal logic constraints.

    Policies that are equally likely to satisfy are compared by the discount, the quickest first; the paper counts to T
    instead. With an accuracy of None it is epsilon / (n_states * T), with which the bound of the paper holds and which
    takes more steps than anyone has.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.

    References:
        J. Fu, U. Topcu, Probably approximately correct MDP learning and control with temporal logic constraints, RSS
        2014, doi 10.15607/RSS.2014.X.039, which leaves all values open.
    """

    epsilon: float = 0.01
    """probability of satisfaction that may be lost, in (0, 1)."""
    time_horizon: int = 1000
    """T, steps within which the formula should be decided, >= 1."""
    log_every: int = 50_000
    """environment steps from one product, its plan and call back to the next, >= 1."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_open(self, "epsilon")
        check_positive(self, "time_horizon")

    def accuracy_for(self, n_states: int) -> float:
        """The accuracy that is asked for in an environment of so many states."""
        return self.accuracy if self.accuracy is not None else self.epsilon / (n_states * self.time_horizon)


@dataclass(frozen=True, kw_only=True)
class SadighConfig(ExplorationConfig):
    """Hyperparameters of model-based temporal differences with Rabin weights.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.

    References:
        D. Sadigh, E. S. Kim, S. Coogan, S. S. Sastry, S. A. Seshia, A learning based approach to control synthesis of
        Markov decision processes for linear temporal logic specifications, CDC 2014, doi 10.1109/CDC.2014.7039527.
    """

    weight_inf: float = 1.0
    """reward on an Inf mark, > 0."""
    weight_fin: float = 10.0
    """penalty on a Fin mark and on a violation, > 0."""
    gamma: float = 0.99
    """discount of every step, in (0, 1)."""
    learning_rate: float = 1.0
    """how far a temporal difference moves a value, in (0, 1]; a model's differences have no noise to average out."""
    sweeps: int = 200
    """sweeps of temporal differences over the learned product after each batch of steps, >= 1."""
    total_steps: int = 400_000
    """environment steps, >= 1."""
    log_every: int = 10_000
    """environment steps from one product, its sweeps and call back to the next, >= 1."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_open(self, "gamma")
        check_positive(self, "weight_inf", "weight_fin", "learning_rate", "sweeps")
        check_probability(self, "learning_rate")


@dataclass(frozen=True, kw_only=True)
class WangConfig(ExplorerConfig):
    """Hyperparameters of the actor-critic method.

    The discount is that of a step until the first Inf mark in a component; the paper has none, and is then indifferent
    between all policies where every one reaches a component at last.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.

    References:
        J. Wang, X. Ding, M. Lahijanian, I. Paschalidis, C. Belta, Temporal logic motion control using actor-critic
        methods, International Journal of Robotics Research 34(10), 2015, doi 10.1177/0278364915581505.
        R. Moazzez Estanjini, X. Ding, M. Lahijanian, J. Wang, C. Belta, I. Paschalidis, Least squares temporal
        difference actor-critic methods with applications to robot motion control, CDC 2011,
        doi 10.1109/CDC.2011.6160892.
    """

    accuracy: float = 0.03
    """error of a transition probability at which it counts as known, in (0, 1)."""
    step_size: float = 3.0
    """of the actor, in units of the largest advantage, > 0."""
    iterations: int = 200
    """rounds of critic and actor, >= 1."""
    report_rounds: int = 10
    """rounds from one call back to the next, once exploration is over, >= 1."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive(self, "step_size", "iterations", "report_rounds")
