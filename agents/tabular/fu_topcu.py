"""Learning with known states and accepting maximal end components, after Fu and Topcu."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv

from .config import LearnerConfig, check_open, check_positive
from .experience import Experience
from .explore import Explorer
from .learned import Callback, Learned, Stopwatch
from .planning import accepting_components, as_table, reach_and_stay


@dataclass(frozen=True, kw_only=True)
class FuTopcuConfig(LearnerConfig):
    """Hyperparameters of PAC learning with temporal logic constraints.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.

    References:
        J. Fu, U. Topcu, Probably approximately correct MDP learning and control with temporal logic constraints, RSS
        2014, doi 10.15607/RSS.2014.X.039, which leaves all values open.
    """

    epsilon: float = 0.01
    """probability of satisfaction that may be lost, in (0, 1)."""
    delta: float = 0.05
    """probability with which each estimate may be wrong, in (0, 1)."""
    time_horizon: int = 1000
    """T, steps within which the formula should be decided, >= 1."""
    accuracy: float | None = 0.03
    """error of a transition probability at which it counts as known, in (0, 1); None: epsilon / (n_states * T), with
    which the bound of the paper holds and which takes more steps than anyone has."""
    discount: float = 0.99
    """of a step, in (0, 1), to choose the quickest among policies that are equally likely to satisfy; the paper counts
    to T instead."""
    total_steps: int = 2_000_000
    """environment steps at most, >= 1."""
    refresh_every: int = 32
    """steps of each sub-environment from one look at what is known to the next, >= 1."""
    report_every: int = 50_000
    """environment steps from one product, its plan and call back to the next, >= 1."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_open(self, "epsilon", "delta", "discount", "accuracy")
        check_positive(self, "time_horizon", "refresh_every")

    def accuracy_for(self, n_states: int) -> float:
        """The accuracy that is asked for in an environment of so many states."""
        return self.accuracy if self.accuracy is not None else self.epsilon / (n_states * self.time_horizon)


def train_fu_topcu(
    env: VectorEnv[Any, Any, Any],
    config: FuTopcuConfig | None = None,
    *,
    callback: Callback | None = None,
) -> Learned:
    """Learn the transition probabilities, then reach accepting components of the learned product and stay there.

    1. Unknown states are explored by balanced wandering, known ones are crossed on the quickest way to unknown ones.
    2. The product of the known part with the automaton, its accepting maximal end components, and value iteration give
       the policy that is most likely to reach them.
    3. It ends when unknown states can be reached with probability at most epsilon only, or steps run out.

    Rewards are not used; a task with any reward scheme will do. Where the learned product has no accepting component,
    every policy satisfies the formula with probability 0 in it, and none is returned.

    Raises:
        InvalidArgumentError: see `Experience`.

    References:
        See `FuTopcuConfig`. Unlike there, the probabilities of labels are learned too, sub-environments explore in
        parallel, and policies are compared without a horizon T, ties by discount.
    """
    config = config or FuTopcuConfig()
    watch = Stopwatch()
    experience = Experience(env, config.seed, unrewarded=True)
    accuracy = config.accuracy_for(experience.n_states)
    explorer = Explorer(experience, accuracy, config.delta, config.epsilon, np.random.default_rng([config.seed, 1]))
    reported = 0
    while True:
        for _ in range(config.refresh_every):
            explorer.step()
        explorer.refresh()
        over = explorer.finished or experience.steps >= config.total_steps
        if over or experience.steps // config.report_every > reported:
            reported = experience.steps // config.report_every
            learned = _plan(experience, explorer, config, watch)
            if watch.report(callback, learned) or over:
                return learned


def _plan(experience: Experience, explorer: Explorer, config: FuTopcuConfig, watch: Stopwatch) -> Learned:
    product = experience.product(explorer.model.labelled_mdp())
    components = accepting_components(product, explorer.known, config.discount)
    policy, probability, message = None, 0.0, explorer.failure
    if components.n_components:
        plan = reach_and_stay(product, components, explorer.known, config.discount)
        policy, probability, message = as_table(product, plan.policy), plan.probability, explorer.progress
    return Learned(
        policy=policy,
        message=message,
        steps=experience.steps,
        seconds=watch.seconds,
        product_states=product.n_states,
        accepting_components=components.n_components,
        value=probability,
    )
