"""The action-value network: observations in, one value per automaton state and action out."""

from __future__ import annotations

import itertools
import math

import numpy as np
import torch
from torch import Tensor, nn

from ltlc.rewards import RewardTables, ValueBounds

from ..training.memory import check_memory
from ..trunk import FEW
from .config import DQNConfig

HIDDEN = (256, 256)
"""units of the hidden layers where the configuration leaves them open."""
FIRST_OUTPUT = -4.0
"""where squashed outputs begin: near the least value, so that nothing is hoped for that was never seen."""
_FREQUENCY = 4.0
"""of waves, over features in [-1, 1]: circles a tenth of the world across can be told apart."""
_SURE = 1e-6
"""squashed outputs nearer to 0 or 1 cannot be told apart."""
_WAITING = 0.02
"""part of the range of values that a choice of a pair may seem to lose: where waiting is worth as much, the errors of a
network would put it off for ever."""
_NEVER = 1e-3
"""what is less likely than so many times the best action is not chosen."""
_COPIES = 5
"""that learning needs of the weights: the target, the average, the gradient, and two moments of the gradient."""


class QNetwork(nn.Module):
    """Values Q(s, q, a) of all automaton states q and actions a at an observation s.

    With `state_input="heads"` the automaton state is an index into the outputs, so that one pass over a batch of
    observations values every automaton state. Else it is a part of the input, as in the thesis, and the pass runs over
    every pair of observation and state.

    With `bounds`, outputs are squashed: a value is `low + width * sigmoid(output)`, which never leaves its bounds and
    tells small values apart by their ratio.

    Args:
        n_features: inputs that describe the observation.
        n_states: automaton states.
        n_actions: actions.
        config: `hidden`, `state_input`, `batch_norm`, `layer_norm`, `initialization`, `waves` are used.
        generator: source of the initial weights; the global generator is not touched.
        trunk: makes the inputs of the first layer, `n_features` then, of the features; None: they are the features.
        bounds: least and largest value in each automaton state, shape (2, n_states); None: outputs are values.

    References:
        R. Toro Icarte et al., Reward machines: exploiting reward function structure in reinforcement learning, JAIR
        2022, https://doi.org/10.1613/jair.1.12440 (all states learn from one step).
        K. He et al., Delving deep into rectifiers, ICCV 2015, https://doi.org/10.1109/ICCV.2015.123 (initialization).
        M. Tancik et al., Fourier features let networks learn high frequency functions in low dimensional domains,
        NeurIPS 2020, https://arxiv.org/abs/2006.10739 (waves).
    """

    def __init__(
        self,
        n_features: int,
        n_states: int,
        n_actions: int,
        config: DQNConfig,
        generator: torch.Generator,
        trunk: nn.Module | None = None,
        bounds: Tensor | None = None,
    ) -> None:
        super().__init__()
        self.trunk = nn.Identity() if trunk is None else trunk
        self.n_features = n_features if trunk is None else trunk.n_features
        self.n_states, self.n_actions, self.state_input = n_states, n_actions, config.state_input
        self.n_sets = 1 + config.curious
        *widths, n_outputs = layer_widths(config, n_features, n_states, n_actions)
        weights = sum(n_in * n_out for n_in, n_out in itertools.pairwise([*widths, n_outputs]))
        what = f"a network with layers of {', '.join(map(str, widths[1:]))} units"
        check_memory(
            f"{what} and its {_COPIES} copies", 4 * weights * (1 + _COPIES), "cpu", "make them smaller (hidden)"
        )
        layers: list[nn.Module] = []
        for n_in, n_out in itertools.pairwise(widths):
            layers.append(_linear(n_in, n_out))
            layers += [nn.LayerNorm(n_out)] if config.layer_norm and not config.batch_norm else []
            layers.append(nn.ReLU())
            layers += [nn.BatchNorm1d(n_out)] if config.batch_norm else []
        layers.append(_linear(widths[-1], n_outputs))
        self.layers = nn.Sequential(*layers)
        self.register_buffer("frequencies", _frequencies(n_features, n_waves(config, n_features), generator))
        _initialize(self.layers, config, generator, FIRST_OUTPUT if bounds is not None else 0.0)
        self.register_buffer("bounds", bounds, persistent=False)
        self.eval()

    bounds: Tensor | None
    frequencies: Tensor | None

    def forward(self, features: Tensor, states: Tensor | None = None) -> Tensor:
        """Values of the actions.

        Args:
            features: shape (batch, n_features); or with a column more for each automaton state, what is added to
                its outputs.
            states: shape (batch,); automaton state of each row, or None for all of them.

        Returns:
            Shape (batch, n_actions), or (batch, n_states, n_actions) if all states were asked for.
        """
        return self.values(self.outputs(features, states), states)

    def values(self, outputs: Tensor, states: Tensor | None = None) -> Tensor:
        """Values that outputs mean; shapes as `forward` returns them."""
        if self.bounds is None:
            return outputs
        low, high = self.bounds[..., None] if states is None else self.bounds[:, states, None]
        values: Tensor = low + (high - low) * torch.sigmoid(outputs)
        return values

    def outputs_and_novelty(self, inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Outputs of all automaton states, and those that say how near what was little tried is; see `TraceLoss`.

        Args:
            inputs: of the first layer, see `inputs`.

        Returns:
            Twice shape (batch, n_states, n_actions); the second is empty if there is no such set.
        """
        sets = self._sets(inputs)
        return sets[:, 0], sets[:, -1] if self.n_sets > 1 else sets[:0, 0]

    def outputs(self, features: Tensor, states: Tensor | None = None) -> Tensor:
        """What the last layer gives, before it is squashed; see `forward`."""
        if self.state_input == "heads":
            values = self._sets(self.inputs(features))[:, 0]
            return values if states is None else values[torch.arange(len(states), device=states.device), states]
        features = self.inputs(features)
        if states is None:
            everywhere = torch.arange(self.n_states, device=features.device).repeat(len(features))
            inputs = self._join(features.repeat_interleave(self.n_states, dim=0), everywhere)
            return self.layers(inputs).view(-1, self.n_states, self.n_actions)  # type: ignore[no-any-return]
        return self.layers(self._join(features, states))  # type: ignore[no-any-return]

    def _sets(self, inputs: Tensor) -> Tensor:
        """Outputs of all sets, shape (batch, n_sets, n_states, n_actions)."""
        n_inputs = self.layers[0].in_features
        outputs: Tensor = self.layers(inputs[:, :n_inputs])
        outputs = outputs.view(-1, self.n_sets, self.n_states, self.n_actions)
        if inputs.shape[1] == n_inputs:
            return outputs
        return torch.cat([outputs[:, :1] + inputs[:, None, n_inputs:, None], outputs[:, 1:]], dim=1)

    def inputs(self, features: Tensor) -> Tensor:
        """Inputs of the first layer: what the trunk makes of features, and their waves; and what outputs get more."""
        features, begin = self.trunk(features[:, : self.n_features]), features[:, self.n_features :]
        parts = [features]
        if self.frequencies is not None:
            angles = features @ self.frequencies
            parts += [torch.sin(angles), torch.cos(angles)]
        parts += [begin] if begin.shape[1] else []
        return parts[0] if len(parts) == 1 else torch.cat(parts, dim=1)

    def _join(self, features: Tensor, states: Tensor) -> Tensor:
        if self.state_input == "raw":
            return torch.cat([features, states[:, None].to(features.dtype)], dim=1)
        return torch.cat([features, nn.functional.one_hot(states, self.n_states).to(features.dtype)], dim=1)


def near_best(values: Tensor, low: float, width: float, temperature: float) -> Tensor:
    """How likely actions are that are chosen in proportion to exp(output / temperature), of those worth a thought.

    The least likely ones are never chosen, so nothing is risked that is known to be worse.

    Args:
        values: shape (..., n_actions); -inf of an action that there is not.
        low: least value.
        width: from there to the largest one.
        temperature: how far outputs may be apart that are nearly alike, > 0.

    Returns:
        Probabilities, float64, of the shape of `values`.
    """
    parts = ((values.double() - low) / width).clamp(_SURE, 1 - _SURE)
    outputs = torch.logit(parts).masked_fill(values == -torch.inf, -torch.inf)
    chances = torch.softmax(outputs / temperature, dim=-1)
    chances = torch.where(chances < _NEVER * chances.amax(dim=-1, keepdim=True), 0.0, chances)
    return chances / chances.sum(dim=-1, keepdim=True)


def hurried(values: Tensor, n_actions: int, width: float) -> Tensor:
    """Values of actions, where it is no better to wait if a pair can be chosen at next to no loss.

    Args:
        values: shape (..., n_options * n_actions), those of waiting first.
        n_actions: of the environment.
        width: from the least value to the largest one.
    """
    waiting, choosing = values[..., :n_actions], values[..., n_actions:]
    chosen = choosing.amax(dim=-1, keepdim=True)
    near = waiting.amax(dim=-1, keepdim=True) <= chosen + _WAITING * width
    below = torch.nextafter(chosen, torch.full_like(chosen, -torch.inf))
    return torch.cat([torch.where(near, torch.minimum(waiting, below), waiting), choosing], dim=-1)


def squashable(tables: RewardTables, bounds: ValueBounds) -> bool:
    """Whether values can be kept within bounds by squashing: they are known, and only gains are paid."""
    finite = np.isfinite(bounds.least).all() and np.isfinite(bounds.largest).all()
    return bool(finite and (tables.expected_reward >= 0).all() and (tables.final_value >= 0).all())


def n_waves(config: DQNConfig, n_features: int) -> int:
    """Directions in which features are also seen as waves: where there are so few that they cannot be indicators."""
    return config.waves if n_features <= FEW else 0


def layer_widths(config: DQNConfig, n_features: int, n_states: int, n_actions: int) -> list[int]:
    """Units of each layer of a network, from its inputs to its outputs."""
    state_features = {"heads": 0, "one-hot": n_states, "raw": 1}[config.state_input]
    n_outputs = n_actions * (n_states if config.state_input == "heads" else 1) * (1 + config.curious)
    n_inputs = n_features + 2 * n_waves(config, n_features) + state_features
    return [n_inputs, *(HIDDEN if config.hidden is None else config.hidden), n_outputs]


def _frequencies(n_features: int, count: int, generator: torch.Generator) -> Tensor | None:
    """Frequencies of waves over features that lie in [-1, 1], shape (n_features, count); None: there are no waves."""
    if not count:
        return None
    return torch.randn((n_features, count), generator=generator) * (_FREQUENCY / math.sqrt(n_features))


def _linear(n_in: int, n_out: int) -> nn.Module:
    # Left uninitialised: the constructor of a layer would draw from the global generator.
    return nn.utils.skip_init(nn.Linear, n_in, n_out)  # type: ignore[no-untyped-call,no-any-return]


def _initialize(layers: nn.Sequential, config: DQNConfig, generator: torch.Generator, output: float) -> None:
    linear = [layer for layer in layers if isinstance(layer, nn.Linear)]
    for layer in linear:
        last = layer is linear[-1]
        if config.initialization == "thesis":
            nn.init.uniform_(layer.weight, 0.0, 0.01 if last else 0.1, generator=generator)
        else:
            deviation = (0.1 if last else math.sqrt(2.0)) / math.sqrt(layer.in_features)
            nn.init.normal_(layer.weight, 0.0, deviation, generator=generator)
        nn.init.constant_(layer.bias, output if last else 0.0)
    for norm in layers:
        if isinstance(norm, nn.LayerNorm):
            norm.reset_parameters()


class Follower:
    """Moves the weights of a network a part of the way to those of another (thesis, equation 4.5).

    Running statistics of batch normalisation move along; integer counters are copied.

    Args:
        network: that moves.
        goal: that it moves to; of the same shape.
    """

    def __init__(self, network: nn.Module, goal: nn.Module) -> None:
        pairs = [
            (ours, theirs)
            for ours, theirs in zip(_tensors(network), _tensors(goal), strict=True)
            if ours is not theirs  # statistics may be shared
        ]
        self._moved = [pair for pair in pairs if pair[0].is_floating_point()]
        self._copied = [pair for pair in pairs if not pair[0].is_floating_point()]

    @torch.no_grad()
    def move(self, part: float) -> None:
        """Move a part in [0, 1] of the way."""
        ours, theirs = ([pair[side] for pair in self._moved] for side in (0, 1))
        if part < 1:
            torch._foreach_lerp_(ours, theirs, part)
        else:
            torch._foreach_copy_(ours, theirs)
        for mine, other in self._copied:
            mine.copy_(other)


def _tensors(network: nn.Module) -> list[Tensor]:
    return [*network.parameters(), *network.buffers()]
