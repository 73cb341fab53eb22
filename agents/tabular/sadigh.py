"""Learning with Rabin-weighted rewards on a learned model, after Sadigh et al."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from ltlc.errors import InvalidArgumentError
from ltlc.mdp import ExplicitMDP, RewardProduct
from ltlc.rewards import RewardTables, get_scheme

from ..training.contents import Content
from ..training.metrics import Row
from .config import SadighConfig
from .experience import Experience, IntArray
from .learner import Found, TabularLearner
from .model import EmpiricalModel
from .run import train_learner

FloatArray = npt.NDArray[np.float64]


class Sadigh(TabularLearner):
    """Learns a model and, on its product with the automaton, the values of rewards given by the Rabin pairs.

    Each pair is learned for itself; the policy is that of the pair with the largest value from the start. Exploration
    is epsilon-greedy. The rewards of the environment's own task are not used.

    Raises:
        InvalidArgumentError: the automaton has no Rabin pair.

    References:
        See `SadighConfig`. Unlike there, a violation ends the episode (it is paid once, as the rewards of `sadigh`
        in `ltlc.rewards` have it), and differences are taken for all product states at once.
    """

    config: SadighConfig

    def __init__(self, experience: Experience, config: SadighConfig) -> None:
        super().__init__(experience, config)
        self.model = EmpiricalModel(experience)
        self._pairs = [_Pair(experience, config, i) for i in range(experience.automaton.n_pairs)]
        if not self._pairs:
            raise InvalidArgumentError("the automaton has no Rabin pair: no word satisfies the formula")

    @property
    def _best(self) -> _Pair:
        return max(self._pairs, key=lambda pair: pair.start_value)

    def step(self) -> None:
        """Make one step in each sub-environment, and count it."""
        state, tables = self.experience.table_state, self.experience.tables
        greedy = self._best.policy[self.experience.state, tables.automaton_state[state]]
        self.model.add(self.experience.step(self.explore(greedy)))

    def plan(self) -> Found:
        """Sweep over the learned products, one of each pair."""
        learned_mdp = self.model.labelled_mdp()
        sizes = [pair.learn(self.experience.reward_product(learned_mdp, pair.tables)) for pair in self._pairs]
        best, n_pairs = self._best, len(self._pairs)
        chosen = f"; Rabin pair {best.index} of {n_pairs} is worth most" if n_pairs > 1 else ""
        return best.policy.copy(), Row(
            steps=self.experience.steps,
            value=best.start_value,
            product_states=max(sizes),
            message=f"{max(sizes)} product states in the model{chosen}",
        )

    def state_dict(self) -> dict[str, Any]:
        """Return the counts, and of each pair its values."""
        return {"model": self.model.state_dict(), "pairs": [pair.state_dict() for pair in self._pairs]}

    def load_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file, and go back to it."""
        self.model.load_state(content["model"])
        for pair, saved in zip(self._pairs, content["pairs"].entries(len(self._pairs)), strict=True):
            pair.load_state(saved, self.experience.n_actions)


train = partial(train_learner, Sadigh)
"""the trainer of the registry."""


class _Pair:
    """Values and policy for the rewards of one Rabin pair, kept from one learned product to the next."""

    def __init__(self, experience: Experience, config: SadighConfig, index: int) -> None:
        self.index, self.config = index, config
        weights = {"weight_inf": config.weight_inf, "weight_fin": config.weight_fin, "gamma": config.gamma}
        self.tables: RewardTables = get_scheme("sadigh", pair=index, **weights).compile(experience.automaton)
        self.value: FloatArray = np.zeros((experience.n_states, self.tables.n_states))
        self.policy: IntArray = np.zeros(self.value.shape, dtype=np.int64)
        self.start_value = 0.0

    def learn(self, product: RewardProduct) -> int:
        """Sweep over a learned product; the number of its states."""
        here = product.mdp_state, product.machine_state
        process: ExplicitMDP = product.discounted()
        value = self.value[here]
        for _ in range(self.config.sweeps):
            difference = process.best(product.reward + process.matrix @ value) - value
            value = value + self.config.learning_rate * difference
        self.value[here] = value
        self.policy[here] = process.choice_action[process.greedy(product.reward + process.matrix @ value)]
        self.start_value = float(product.initial @ value)
        return product.n_states

    def state_dict(self) -> dict[str, Any]:
        tensors = {"value": torch.from_numpy(self.value), "policy": torch.from_numpy(self.policy)}
        return {**tensors, "start_value": self.start_value}

    def load_state(self, content: Content, n_actions: int) -> None:
        self.value = content["value"].tensor(torch.float64, self.value.shape).numpy()
        self.policy = content["policy"].indices(torch.int64, self.policy.shape, n_actions).numpy()
        self.start_value = content["start_value"].number()
