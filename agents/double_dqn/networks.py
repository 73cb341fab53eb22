"""The action-value network: observations in, one value per automaton state and action out."""

from __future__ import annotations

import itertools
import math

import torch
from torch import Tensor, nn

from ..training.memory import check_memory
from .config import DQNConfig

HIDDEN = (256,)
"""units of the hidden layers where the configuration leaves them open."""
_COPIES = 5
"""that learning needs of the weights: the target, the average, the gradient, and two moments of the gradient."""


class QNetwork(nn.Module):
    """Values Q(s, q, a) of all automaton states q and actions a at an observation s.

    With `state_input="heads"` the automaton state is an index into the outputs, so that one pass over a batch of
    observations values every automaton state. Else it is a part of the input, as in the thesis, and the pass runs over
    every pair of observation and state.

    Args:
        n_features: inputs that describe the observation.
        n_states: automaton states.
        n_actions: actions.
        config: `hidden`, `state_input`, `batch_norm`, `initialization` are used.
        generator: source of the initial weights; the global generator is not touched.
        trunk: makes the inputs of the first layer, `n_features` then, of the features; None: they are the features.

    References:
        R. Toro Icarte et al., Reward machines: exploiting reward function structure in reinforcement learning, JAIR
        2022, https://doi.org/10.1613/jair.1.12440 (all states learn from one step).
        K. He et al., Delving deep into rectifiers, ICCV 2015, https://doi.org/10.1109/ICCV.2015.123 (initialization).
    """

    def __init__(
        self,
        n_features: int,
        n_states: int,
        n_actions: int,
        config: DQNConfig,
        generator: torch.Generator,
        trunk: nn.Module | None = None,
    ) -> None:
        super().__init__()
        self.trunk = nn.Identity() if trunk is None else trunk
        self.n_states, self.n_actions, self.state_input = n_states, n_actions, config.state_input
        *widths, n_outputs = layer_widths(config, n_features, n_states, n_actions)
        weights = sum(n_in * n_out for n_in, n_out in itertools.pairwise([*widths, n_outputs]))
        what = f"a network with layers of {', '.join(map(str, widths[1:]))} units"
        check_memory(
            f"{what} and its {_COPIES} copies", 4 * weights * (1 + _COPIES), "cpu", "make them smaller (hidden)"
        )
        layers: list[nn.Module] = []
        for n_in, n_out in itertools.pairwise(widths):
            layers += [_linear(n_in, n_out), nn.ReLU()]
            layers += [nn.BatchNorm1d(n_out)] if config.batch_norm else []
        layers.append(_linear(widths[-1], n_outputs))
        self.layers = nn.Sequential(*layers)
        _initialize(self.layers, config, generator)
        self.eval()

    def forward(self, features: Tensor, states: Tensor | None = None) -> Tensor:
        """Values of the actions.

        Args:
            features: shape (batch, n_features).
            states: shape (batch,); automaton state of each row, or None for all of them.

        Returns:
            Shape (batch, n_actions), or (batch, n_states, n_actions) if all states were asked for.
        """
        features = self.trunk(features)
        if self.state_input == "heads":
            values: Tensor = self.layers(features).view(-1, self.n_states, self.n_actions)
            return values if states is None else values[torch.arange(len(states), device=states.device), states]
        if states is None:
            everywhere = torch.arange(self.n_states, device=features.device).repeat(len(features))
            inputs = self._join(features.repeat_interleave(self.n_states, dim=0), everywhere)
            return self.layers(inputs).view(-1, self.n_states, self.n_actions)  # type: ignore[no-any-return]
        return self.layers(self._join(features, states))  # type: ignore[no-any-return]

    def _join(self, features: Tensor, states: Tensor) -> Tensor:
        if self.state_input == "raw":
            return torch.cat([features, states[:, None].to(features.dtype)], dim=1)
        return torch.cat([features, nn.functional.one_hot(states, self.n_states).to(features.dtype)], dim=1)


def layer_widths(config: DQNConfig, n_features: int, n_states: int, n_actions: int) -> list[int]:
    """Units of each layer of a network, from its inputs to its outputs."""
    state_features = {"heads": 0, "one-hot": n_states, "raw": 1}[config.state_input]
    n_outputs = n_actions * (n_states if config.state_input == "heads" else 1)
    return [n_features + state_features, *(HIDDEN if config.hidden is None else config.hidden), n_outputs]


def _linear(n_in: int, n_out: int) -> nn.Module:
    # Left uninitialised: the constructor of a layer would draw from the global generator.
    return nn.utils.skip_init(nn.Linear, n_in, n_out)  # type: ignore[no-untyped-call,no-any-return]


def _initialize(layers: nn.Sequential, config: DQNConfig, generator: torch.Generator) -> None:
    linear = [layer for layer in layers if isinstance(layer, nn.Linear)]
    for layer in linear:
        last = layer is linear[-1]
        if config.initialization == "thesis":
            nn.init.uniform_(layer.weight, 0.0, 0.01 if last else 0.1, generator=generator)
        else:
            deviation = (0.1 if last else math.sqrt(2.0)) / math.sqrt(layer.in_features)
            nn.init.normal_(layer.weight, 0.0, deviation, generator=generator)
        nn.init.zeros_(layer.bias)


@torch.no_grad()
def move_towards(network: nn.Module, goal: nn.Module, part: float) -> None:
    """Move the weights of a network a part in [0, 1] of the way to those of another (thesis, equation 4.5).

    Running statistics of batch normalisation move along; integer counters are copied.
    """
    ours = [*network.parameters(), *network.buffers()]
    theirs = [*goal.parameters(), *goal.buffers()]
    floats = [i for i, tensor in enumerate(ours) if tensor.is_floating_point() and part < 1]
    if floats:
        torch._foreach_lerp_([ours[i] for i in floats], [theirs[i] for i in floats], part)
    for i in sorted(set(range(len(ours))) - set(floats)):
        ours[i].copy_(theirs[i])
