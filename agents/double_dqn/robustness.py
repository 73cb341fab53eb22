"""Values that begin with how near an observation is to the thresholds that the automaton waits for."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.envs.comparisons import Variables, comparisons
from ltlc.envs.robust_wrappers import RobustLTLVectorWrapper
from ltlc.envs.robustness import Robustness
from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder, assembled
from ..training.collect import Interface
from .config import DQNConfig
from .networks import FIRST_OUTPUT


class RobustEncoder(ObservationEncoder):
    """Inputs of a network, and behind them what its outputs begin with in each automaton state.

    To learn from rewards that are shaped with a potential, and to learn from those that are not with values that begin
    with the potential, is the same, step by step. Here values do so: they stay those of the task, with its discounts
    and within its bounds, in all automaton states at once, and a policy is judged by what it is.

    Args:
        space: see `ObservationEncoder`.
        tables: reward tables of the task.
        config: `robustness`, `robustness_scale`, `variables`, `observation_input` are used.
        bounds: what squashed values are between, shape (2, n_states); None: outputs are values.
        reward_scale: outputs that are values are in units of it.

    Raises:
        InvalidArgumentError: there is no proposition that compares numbers, or a variable is not in the observation.

    References:
        E. Wiewiora, Potential-based shaping and Q-value initialization are equivalent, JAIR 2003,
        https://doi.org/10.1613/jair.1190.
    """

    def __init__(
        self,
        space: spaces.Space[Any],
        tables: RewardTables,
        config: DQNConfig,
        bounds: Tensor | None,
        reward_scale: float,
    ) -> None:
        super().__init__(space, config.observation_input)
        own = comparisons(tables.aps, Variables(config.variables).places)
        if not own:
            names = ", ".join(map(repr, tables.aps)) or "there are none"
            raise InvalidArgumentError(f"robustness needs propositions that compare numbers; here: {names}")
        self._robustness = Robustness(tables, own, config.robustness, config.robustness_scale)
        self._beside_mask = any(path[:1] == ("observation",) for one in own.values() for path in one.variables.values())
        self._unknown = {name: False for name in tables.aps if name not in own}
        self._states, self._bounds, self._reward_scale = range(tables.n_states), bounds, reward_scale

    def features(self, packed: Tensor) -> Tensor:
        """Network inputs, and after them the first outputs, shape (batch, n_features + n_states), float32."""
        batches = {
            leaf.path: self._numbers(leaf, packed).cpu().numpy().reshape(-1, *(leaf.space.shape or ()))
            for leaf in self.leaves
        }
        observations = assembled(self.space, (), batches)
        if self.mask is not None and not self._beside_mask:
            observations = observations["observation"]  # masks come with the infos
        potential = self._robustness.potentials(observations, self._unknown, self._states)
        whole = np.broadcast_to(potential, (len(self._states), len(packed))).T.astype(np.float32)
        return torch.cat([super().features(packed), self._outputs(torch.from_numpy(whole).to(packed.device))], dim=1)

    def _outputs(self, potential: Tensor) -> Tensor:
        """What to add to outputs so that values that would be the least ones are the potential."""
        if self._bounds is None:
            return potential / self._reward_scale
        least, largest = self._bounds
        part = (potential - least) / (largest - least).clamp(min=torch.finfo(potential.dtype).tiny)
        first = torch.sigmoid(torch.tensor(FIRST_OUTPUT)).item()
        return torch.logit(part.clamp(first, 1 - first)) - FIRST_OUTPUT


def with_robustness(config: DQNConfig, interface: Interface) -> DQNConfig:
    """The hyperparameters with the potential of a `RobustLTLVectorWrapper`, if the environment has one.

    Raises:
        InvalidArgumentError: margins count on a scale for each proposition, which a network does not take.
    """
    wrapper = interface.wrapper
    if not isinstance(wrapper, RobustLTLVectorWrapper) or config.robustness:
        return config
    scales = {*wrapper.scales.values()}
    if len(scales) != 1:
        raise InvalidArgumentError("the agent takes one scale of margins for all propositions")
    places = {name: ".".join(map(str, path)) for name, path in wrapper.places.items()}
    variables = ", ".join(f"{name}={place}" for name, place in places.items())
    return dataclasses.replace(
        config, robustness=wrapper.robustness.weight, robustness_scale=scales.pop(), variables=variables
    )
