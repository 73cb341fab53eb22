"""Actor-critic learning of how to reach accepting maximal end components, after Wang et al."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv
from scipy import sparse
from scipy.sparse import linalg

from ltlc.mdp import Product

from .config import WangConfig
from .experience import Experience, IntArray
from .explore import Explorer
from .learned import Callback, Learned, Stopwatch
from .planning import Components, accepting_components, as_table, cut

FloatArray = npt.NDArray[np.float64]


def train_wang(
    env: VectorEnv[Any, Any, Any],
    config: WangConfig | None = None,
    *,
    callback: Callback | None = None,
) -> Learned:
    """Learn the transition probabilities, then a randomised policy that reaches accepting components.

    1. Exploration as by Fu and Topcu, until every state that can be reached is known.
    2. The accepting maximal end components of the learned product, and a policy that satisfies the formula inside.
    3. Outside, a softmax policy with a parameter for each product state and action. The critic is least-squares
       temporal differences with a feature for each state, which is the value function of the learned model, so it is
       solved for. The actor follows the natural gradient, which is the advantage.

    Where the learned product has no accepting component, no policy is returned. Rewards of the task are not used.

    Raises:
        InvalidArgumentError: see `Experience`.

    References:
        See `WangConfig`; there, both features of the critic and parameters of the policy are few, and values come from
        sample paths. J. Boyan, Technical update: least-squares temporal difference learning, Machine Learning 49,
        2002, doi 10.1023/A:1017936530646 (with tables it is the model's value). S. Kakade, A natural policy gradient,
        NeurIPS 2001.
    """
    config = config or WangConfig()
    watch = Stopwatch()
    experience = Experience(env, config.seed, unrewarded=True)
    explorer = Explorer(experience, config.accuracy, config.delta, 0.0, np.random.default_rng([config.seed, 1]))
    reported = 0
    while not explorer.finished and experience.steps < config.total_steps:
        for _ in range(config.refresh_every):
            explorer.step()
        explorer.refresh()
        if experience.steps // config.log_every > reported:
            reported = experience.steps // config.log_every
            exploring = Learned(None, explorer.progress, experience.steps, watch.seconds, 0, None, 0.0)
            if watch.report(callback, exploring):
                return exploring
    product = experience.product(explorer.model.labelled_mdp())
    components = accepting_components(product, explorer.known, config.discount)

    def learned(policy: npt.NDArray[Any] | None, value: float, message: str) -> Learned:
        found = components.n_components
        return Learned(policy, message, experience.steps, watch.seconds, product.n_states, found, value)

    if not components.n_components:
        return learned(None, 0.0, explorer.failure)
    actor_critic = _ActorCritic(product, components, config)
    for iteration in range(1, config.iterations + 1):
        value = actor_critic.improve()
        over = iteration == config.iterations
        if over or iteration % config.report_rounds == 0:
            table = as_table(product, actor_critic.policy())
            result = learned(table, value, f"{iteration} rounds of critic and actor")
            if watch.report(callback, result) or over:
                break
    return result


class _ActorCritic:
    def __init__(self, product: Product, components: Components, config: WangConfig) -> None:
        self.product, self.components, self.config = product, components, config
        self.process = cut(product, ~components.states[product.choice_state])
        self.reward = np.asarray(self.process.matrix @ components.value)
        self.parameter: FloatArray = np.zeros(product.n_choices)

    def improve(self) -> float:
        """One round of critic and actor; the value from the start of the policy before it."""
        product, gamma = self.product, self.config.discount
        weight = self._weight()
        chain = sparse.csr_array((weight, np.arange(product.n_choices), product.choice_start)) @ self.process.matrix
        paid = np.add.reduceat(weight * self.reward, product.choice_start[:-1])
        system = sparse.csc_array(sparse.eye_array(product.n_states) - gamma * chain)
        value: FloatArray = np.asarray(linalg.spsolve(system, paid))
        advantage = self.reward + gamma * (self.process.matrix @ value) - value[product.choice_state]
        largest = np.abs(advantage[~self.components.states[product.choice_state]]).max(initial=0.0)
        if largest > 0:
            self.parameter += self.config.step_size * advantage / largest
        return float(product.initial @ np.where(self.components.states, self.components.value, value))

    def policy(self) -> FloatArray:
        """Probabilities of actions in product states, shape (n_states, n_actions)."""
        product = self.product
        policy = np.zeros((product.n_states, product.n_actions))
        policy[product.choice_state, product.choice_action] = self._weight()
        inside: IntArray = np.flatnonzero(self.components.states)
        policy[inside] = 0.0
        policy[inside, self.components.policy[inside]] = 1.0
        return policy

    def _weight(self) -> FloatArray:
        """The softmax of the parameters, per choice."""
        product = self.product
        power = np.exp(self.parameter - product.best(self.parameter)[product.choice_state])
        total = np.add.reduceat(power, product.choice_start[:-1])
        return np.asarray(power / total[product.choice_state])
