"""Actor-critic learning of how to reach accepting maximal end components, after Wang et al."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import linalg

from ..training.metrics import Row
from .config import WangConfig
from .experience import IntArray
from .explore import Explorer
from .learner import Found
from .planning import Components, as_table, cut
from .run import train_learner

FloatArray = npt.NDArray[np.float64]


class Wang(Explorer):
    """Learns the transition probabilities, then a randomised policy that reaches accepting components.

    1. Exploration as by Fu and Topcu, until every state that can be reached is known.
    2. The accepting maximal end components of the learned product, and a policy that satisfies the formula inside.
    3. Outside, a softmax policy with a parameter for each product state and action. The critic is least-squares
       temporal differences with a feature for each state, which is the value function of the learned model, so it is
       solved for. The actor follows the natural gradient, which is the advantage.

    Where the learned product has no accepting component, no policy is returned. Rewards of the task are not used.

    References:
        See `WangConfig`; there, both features of the critic and parameters of the policy are few, and values come from
        sample paths. J. Boyan, Technical update: least-squares temporal difference learning, Machine Learning 49,
        2002, doi 10.1023/A:1017936530646 (with tables it is the model's value). S. Kakade, A natural policy gradient,
        NeurIPS 2001.
    """

    config: WangConfig

    def plan(self) -> Found:
        """Say how much is known; there is no policy before exploration is over."""
        return None, Row(steps=self.experience.steps, value=0.0, product_states=0, message=self.progress)

    def conclude(self) -> Iterator[Found]:
        """Make the rounds of critic and actor."""
        components = self.components()

        def found(table: npt.NDArray[Any] | None, value: float, message: str) -> Found:
            return table, Row(
                steps=self.experience.steps,
                value=value,
                product_states=components.product.n_states,
                accepting_components=components.n_components,
                message=message,
            )

        if not components.n_components:
            yield found(None, 0.0, self.failure)
            return
        actor_critic = _ActorCritic(components, self.config)
        for iteration in range(1, self.config.iterations + 1):
            value = actor_critic.improve()
            if iteration == self.config.iterations or iteration % self.config.report_rounds == 0:
                table = as_table(components.product, actor_critic.policy())
                yield found(table, value, f"{iteration} rounds of critic and actor")


train = partial(train_learner, Wang)
"""the trainer of the registry."""


class _ActorCritic:
    def __init__(self, components: Components, config: WangConfig) -> None:
        self.product, self.components, self.config = components.product, components, config
        self.process = cut(self.product, ~components.states[self.product.choice_state])
        self.reward = np.asarray(self.process.matrix @ components.value)
        self.parameter: FloatArray = np.zeros(self.product.n_choices)

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
