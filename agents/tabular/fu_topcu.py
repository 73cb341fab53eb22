"""Learning with known states and accepting maximal end components, after Fu and Topcu."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv

from .config import FuTopcuConfig
from .experience import Experience
from .explore import Explorer
from .learned import Callback, Learned, Stopwatch
from .planning import accepting_components, as_table, reach_and_stay


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
        if over or experience.steps // config.log_every > reported:
            reported = experience.steps // config.log_every
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
