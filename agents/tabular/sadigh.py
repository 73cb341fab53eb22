"""Learning with Rabin-weighted rewards on a learned model, after Sadigh et al."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import VectorEnv

from ltlc.errors import InvalidArgumentError
from ltlc.mdp import ExplicitMDP, RewardProduct
from ltlc.rewards import RewardTables, get_scheme

from .config import SadighConfig
from .experience import Experience, IntArray
from .learned import Callback, Learned, Stopwatch
from .model import EmpiricalModel

FloatArray = npt.NDArray[np.float64]


def train_sadigh(
    env: VectorEnv[Any, Any, Any],
    config: SadighConfig | None = None,
    *,
    callback: Callback | None = None,
) -> Learned:
    """Learn a model and, on its product with the automaton, the values of rewards given by the Rabin pairs.

    Each pair is learned for itself; the policy is that of the pair with the largest value from the start. Exploration
    is epsilon-greedy. The rewards of the environment's own task are not used.

    Raises:
        InvalidArgumentError: see `Experience`; or the automaton has no Rabin pair.

    References:
        See `SadighConfig`. Unlike there, a violation ends the episode (it is paid once, as the rewards of `sadigh`
        in `ltlc.rewards` have it), and differences are taken for all product states at once.
    """
    config = config or SadighConfig()
    watch = Stopwatch()
    experience, generator = Experience(env, config.seed, unrewarded=True), np.random.default_rng([config.seed, 1])
    model = EmpiricalModel(experience)
    pairs = [_Pair(experience, config, i) for i in range(experience.automaton.n_pairs)]
    if not pairs:
        raise InvalidArgumentError("the automaton has no Rabin pair: no word satisfies the formula")
    best = pairs[0]
    automaton_state = experience.tables.automaton_state
    while True:
        part = min(2 * experience.steps / config.total_steps, 1.0)
        epsilon = config.epsilon_start + (config.epsilon_final - config.epsilon_start) * part
        until = min(experience.steps + config.log_every, config.total_steps)
        while experience.steps < until:
            greedy = best.policy[experience.state, automaton_state[experience.table_state]]
            random = generator.integers(experience.n_actions, size=len(greedy))
            explore = generator.random(len(greedy)) < epsilon
            model.add(experience.step(np.where(explore, random, greedy)))
        learned_mdp = model.labelled_mdp()
        sizes = [pair.learn(experience.reward_product(learned_mdp, pair.tables)) for pair in pairs]
        best = max(pairs, key=lambda pair: pair.start_value)
        chosen = f"; Rabin pair {best.index} of {len(pairs)} is worth most" if len(pairs) > 1 else ""
        over = experience.steps >= config.total_steps
        learned = Learned(
            policy=best.policy.copy(),
            message=f"{max(sizes)} product states in the model{chosen}",
            steps=experience.steps,
            seconds=watch.seconds,
            product_states=max(sizes),
            accepting_components=None,
            value=best.start_value,
        )
        if watch.report(callback, learned) or over:
            return learned


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
