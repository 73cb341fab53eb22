"""The agent: action-value networks of a product of environment and automaton, how they act and how they learn."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.envs import HeldActions, LTLVectorWrapper
from ltlc.rewards import RewardTables, value_bounds
from ltlc.task import Task

from ..encoder import ObservationEncoder
from ..tensor_tables import TensorTables, permitted, without_forbidden
from ..training.collect import Interface
from ..training.contents import Content, check_optimizer, numbers_in
from ..transitions import TransitionBatch
from ..trunk import Trunk
from ..value_agent import ValueAgent
from .config import DRAWN, DQNConfig
from .device import available, check_device
from .divergence import diverged
from .exploration import ExploringStarts, Whims, with_random_choices
from .fitting import fitted, fitted_horizon
from .look_ahead import LookAhead
from .networks import Follower, QNetwork, hurried, layer_widths, near_best, squashable
from .places import Places
from .replay import ReplayBuffer, ReplaySize, Segments
from .robustness import RobustEncoder
from .temperature import try_temperatures
from .traces import TraceLoss, seek
from .update import TDLoss

_MOST_TRIES = 1 << 22
"""counts of what was tried."""
_TIE = 1e-5
"""what is worth less more is as good, to curiosity; and values that differ by less are all the same."""
_NETWORKS = ("q_network", "target_network", "policy_network")


class DoubleDQN(ValueAgent):
    """Double deep Q-learning of one task; `DQNConfig` says which of its variants.

    Args:
        observation_space: see `ValueAgent`.
        n_actions: see `ValueAgent`.
        tables: see `ValueAgent`.
        config: hyperparameters.

    Attributes:
        q_network: learns, and acts while training.
        target_network: values next states; starts as a copy.
        policy_network: average of the online network over the last updates, which acts in the end.
        updates: gradient steps made.

    Raises:
        InvalidArgumentError: the agent cannot take the observation space, or PyTorch cannot use the device.

    Example:
        >>> from gymnasium.spaces import Discrete
        >>> agent = DoubleDQN(Discrete(4), 2, None, DQNConfig(hidden=(8,)))
        >>> agent.q_values([0, 3]).shape
        (2, 1, 2)

    References:
        H. van Hasselt, A. Guez, D. Silver, Deep reinforcement learning with double Q-learning, AAAI 2016,
        https://doi.org/10.1609/aaai.v30i1.10295. Q. Gao, Deep Reinforcement Learning with Temporal Logic
        Specifications, Duke University, 2018, algorithm 1. For averaged weights: B. Polyak, A. Juditsky, Acceleration
        of stochastic approximation by averaging, SIAM J. Control Optim. 1992, https://doi.org/10.1137/0330046.
    """

    name = "double-dqn"
    config_type = DQNConfig

    def __init__(
        self, observation_space: spaces.Space[Any], n_actions: int, tables: RewardTables | None, config: DQNConfig
    ) -> None:
        check_device(config.device)
        super().__init__(
            observation_space, n_actions, tables, config,
            observation_input=config.observation_input, device=config.device,
        )  # fmt: skip
        single = self.encoder.n_observations > 0 or self.encoder.mask is not None
        self._config = config = config.filled(numbered=self.encoder.n_observations > 0, single=single)
        bounds = value_bounds(self.tables) if config.output == "bounded" else None
        squashed = bounds is not None and config.traced and squashable(self.tables, bounds)
        scale = 1.0 if squashed else config.reward_scale
        self.tensor_tables = TensorTables.of(self.tables, scale, config.device, bounds)
        self._bounds = torch.stack([self.tensor_tables.least, self.tensor_tables.largest]) if squashed else None
        self._width = 1.0 if self._bounds is None else float(self._bounds[1].max() - self._bounds[0].min())
        if config.robustness:
            unit = self.tensor_tables.scale
            self.encoder = RobustEncoder(observation_space, self.tables, config, self._bounds, unit)
        self.q_network = self._network()
        self.target_network = self._network()
        self.policy_network: QNetwork = self._network()
        self.trunk: Trunk = self.q_network.trunk  # type: ignore[assignment]
        for network in (self.target_network, self.policy_network):
            network.trunk.share_statistics(self.trunk)  # type: ignore[operator]
        self._parameters = parameters = list(self.q_network.parameters())
        self._target = Follower(self.target_network, self.q_network)
        self._average = Follower(self.policy_network, self.q_network)
        kind: Any = partial(torch.optim.Adam, fused=True) if config.optimizer == "adam" else torch.optim.SGD
        self.optimizer: torch.optim.Optimizer = kind(parameters, lr=config.learning_rate)
        self.loss = TDLoss(self.encoder, self.tensor_tables, config)
        most = max(_MOST_TRIES // (self.tables.n_states * n_actions), 1) if config.curious else 1
        self._places = Places(self.encoder, most)
        counted = (self.tables.n_states, self._places.count if config.curious else 0, n_actions)
        self._tries = torch.zeros(counted, dtype=torch.int32, device=config.device)
        self.trace_loss = TraceLoss(self.encoder, self.tensor_tables, config, self._tries)
        self._ahead = LookAhead(config, self.tensor_tables)
        self._whims, self._starts = Whims(config, n_actions), ExploringStarts(config, self.tensor_tables)
        self._held = HeldActions(config.held, n_actions)

    def _network(self) -> QNetwork:
        generator = torch.Generator().manual_seed(self.config.seed)
        trunk = Trunk(self.encoder, generator)
        sizes = trunk.n_outputs, self.tables.n_states, self.n_actions
        return QNetwork(*sizes, self.config, generator, trunk, self._bounds).to(self.device)

    @classmethod
    def fitted(cls, config: DQNConfig, interface: Interface) -> tuple[DQNConfig, RewardTables | None]:
        """Fit the horizon and the outputs to an environment; see `ValueAgent`."""
        return fitted(config, interface)

    @classmethod
    def learned_task(cls, env: LTLVectorWrapper, config: DQNConfig) -> Task:
        """The task of an environment, with the discounts that are learned from."""
        return env.task.for_horizon(fitted_horizon(config, Interface.of(env)))

    @property
    def config(self) -> DQNConfig:
        """The hyperparameters."""
        return self._config

    @property
    def counterfactual(self) -> bool:
        """Whether each step teaches every automaton state."""
        return self.config.counterfactual

    @property
    def action_repeat(self) -> int:
        """Steps for which an action is held."""
        return self.config.held

    @property
    def first_update(self) -> int:
        """Environment steps that the first update waits for."""
        return max(self.config.learning_starts, self.config.rows)

    def learning_rate_at(self, steps: int) -> float:
        """Return the learning rate after so many environment steps."""
        return self.config.learning_rate_at(steps)

    def learn_in(self, interface: Interface) -> None:
        """Take note of what is learned in: its task says what a nearer horizon pays."""
        if interface.wrapper is not None:
            self._ahead = LookAhead(self.config, self.tensor_tables, interface.wrapper.task)

    def check_memory(self, num_envs: int, *, copied: bool) -> ReplaySize:
        """Check that the replay buffer of so many sub-environments fits into memory; see `ValueAgent`."""
        size = ReplaySize.of(self.config, self.encoder, num_envs)
        size.check(self.device, self.config.max_memory, copied=copied)
        return size

    def new_memory(self, num_envs: int) -> ReplayBuffer:
        """Make the replay buffer for so many sub-environments."""
        size = ReplaySize.of(self.config, self.encoder, num_envs)
        limits = {"state": self.tables.n_states, "action": self.n_actions, "letter_class": self.tables.n_classes}
        return ReplayBuffer(size, self.encoder, self._places, self.device, limits=limits)

    @torch.no_grad()
    def explore(
        self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64], epsilon: float, generator: torch.Generator
    ) -> npt.NDArray[np.int64]:
        """Choose actions for training, shape (batch,): greedy in `q_network` where there is no whim.

        See `Whims`, `HeldActions` and `ExploringStarts`. Draws the same amount from the generator whatever happens.
        """
        self.trunk.observe(self.encoder, packed)
        own = torch.from_numpy(states)
        free = self._held.deciding(len(own))
        deciding = torch.from_numpy(free)
        action, state = self._whims.draw(deciding, epsilon, generator), self._starts.states(own, generator)
        action = permitted(action, self.encoder.allowed(torch.from_numpy(packed)), generator)
        random = action.clamp(min=0)
        if self.tensor_tables.n_options > 1 and not self.config.counterfactual:
            random = with_random_choices(random, own, self.tensor_tables, self.n_actions, generator)
        ours, greedy = (action < 0) & deciding, torch.zeros_like(action)
        if ours.any():
            greedy[deciding] = self.evaluate(self.q_network, packed[free], state.numpy()[free]).argmax(dim=-1).cpu()
        self._starts.choose(torch.where(ours, greedy // self.n_actions, 0))
        greedy = torch.where(state == own, greedy, greedy % self.n_actions)  # others' choices are not ours
        chosen = torch.where(action >= 0, random, greedy)
        if self.config.curious:
            every = max(round(1 / (self.config.curiosity or 1.0)), 1)
            seekers = np.arange(every - 1, len(packed), every)
            if len(seekers):
                chosen[torch.from_numpy(seekers)] = self._seek(packed[seekers], states[seekers], generator)
        return self._held.keep(chosen.numpy(), free)

    def _seek(self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64], generator: torch.Generator) -> Tensor:
        """The actions nearest to what was little tried, shape (batch,)."""
        rows, row = torch.from_numpy(packed).to(self.device), torch.from_numpy(states).to(self.device)
        _, outputs = self.q_network.outputs_and_novelty(self.q_network.inputs(self.encoder.features(rows)))
        tries = self._tries[row, torch.from_numpy(self._places(packed)).to(self.device)]
        worth = seek(outputs[torch.arange(len(row), device=self.device), row], tries)
        worth = without_forbidden(worth, self.encoder.allowed(rows)).cpu()
        return (worth + _TIE * torch.rand(worth.shape, generator=generator)).argmax(dim=-1)

    def begin(self) -> None:
        """Forget whims, held actions and imagined automaton states, since new episodes begin everywhere."""
        for part in (self._whims, self._held, self._starts):
            part.clear()

    def evaluate(
        self, network: torch.nn.Module, packed: npt.NDArray[Any], states: npt.NDArray[np.int64] | None
    ) -> Tensor:
        """Value all actions; where a pair can be chosen at next to no loss, it is no better to wait."""
        values = super().evaluate(network, packed, states)
        return values if self.tensor_tables.n_options == 1 else hurried(values, self.n_actions, self._width)

    def chances(self, values: Tensor) -> Tensor | None:
        """Return how likely each action is, see `near_best`; None where nothing is squashed, or the temperature 0."""
        temperature = DRAWN if self.config.temperature is None else self.config.temperature
        if self._bounds is None or self._width < _TIE or not temperature:
            return None
        return near_best(values, float(self._bounds[0].min()), self._width, temperature)

    def update(self, steps: TransitionBatch | Segments, learning_rate: float) -> float:
        """Make one gradient step on a batch of sampled steps; returns the loss before it.

        Raises:
            TrainingDiverged: the loss is not a finite number; the weights are as they were.
        """
        for group in self.optimizer.param_groups:
            group["lr"] = learning_rate
        if isinstance(steps, Segments):
            loss = self.trace_loss(self.q_network, self.target_network, steps)
        else:
            self.q_network.train()
            loss = self.loss(self.q_network, self.target_network, steps)
            self.q_network.eval()
        if not np.isfinite(value := loss.item()):
            raise diverged(self.q_network, steps, self.updates, value, learning_rate, self.tensor_tables.scale)
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        if self.config.max_gradient_norm is not None:
            torch.nn.utils.clip_grad_norm_(self._parameters, self.config.max_gradient_norm)
        self.optimizer.step()
        self.updates += 1
        if self.updates % self.config.target_update_interval == 0:
            self._target.move(self.config.tau or 1.0)
        self._average.move(self.config.averaging)
        return value

    def learn(self, memory: ReplayBuffer, steps: int, rounds: int, generator: torch.Generator) -> list[float]:
        """Make the updates that are due; returns their losses."""
        config, rate = self.config, self.config.learning_rate_at(steps)
        self.loss.tables = self.trace_loss.tables = self._ahead.tables_at(steps)
        self.trace_loss.advantage_learning = config.advantage_learning_at(steps)
        self._starts.advance(*memory.latest)
        copies, _, ended = (part.numpy() for part in memory.latest)
        self._held.advance(copies, ended)
        if config.curious:
            tried = tuple(part.to(self.device) for part in memory.tried)
            self._tries.index_put_(tried, torch.ones_like(tried[0], dtype=torch.int32), accumulate=True)
        if memory.steps < max(self.first_update, memory.least):
            return []
        every = config.train_frequency or 1
        due = memory.steps // every - (memory.steps - memory.newest) // every
        return [self.update(self._batch(memory, generator), rate) for _ in range(due * config.gradient_steps)]

    def settle(self, interface: Interface, seed: int, stop: Callable[[], bool]) -> str:
        """Choose the temperature by trial, where nobody has."""
        if self.config.temperature is not None or self._bounds is None:
            return ""
        trials = try_temperatures(self._at, interface, self.config.total_steps, seed, stop)
        self._at(trials[0].temperature if trials else None).reseed(self.config.seed)
        told = f"temperature {self.config.temperature} by trial; episodes that succeeded: {', '.join(map(str, trials))}"
        return told if trials and self.config.temperature != DRAWN else ""

    def _at(self, temperature: float | None) -> DoubleDQN:
        self._config = dataclasses.replace(self._config, temperature=temperature)
        return self

    def _batch(self, memory: ReplayBuffer, generator: torch.Generator) -> TransitionBatch | Segments:
        config = self.config
        if not config.traced:
            return memory.sample(config.rows, generator)
        return memory.sample_segments(-(-config.rows // config.trace_length), config.trace_length, generator)

    def state_dict(self) -> dict[str, Any]:
        """Return everything that learning changes, as tensors and numbers."""
        networks = {name: getattr(self, name).state_dict() for name in _NETWORKS}
        counts = {"updates": self.updates, "tries": self._tries}
        return {**networks, "optimizer": self.optimizer.state_dict(), **counts}

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: it is of another agent.
        """
        for name in _NETWORKS:
            content[name].state_of(getattr(self, name))
        check_optimizer(content["optimizer"], self.optimizer)
        content["updates"].count()
        content["tries"].indices(torch.int32, tuple(self._tries.shape), 2**31 - 1)

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""
        for name in _NETWORKS:
            getattr(self, name).load_state_dict(state[name])
        self.optimizer.load_state_dict(state["optimizer"])
        self.updates = int(state["updates"])
        self._tries.copy_(state["tries"])

    @classmethod
    def check_size(
        cls, network: Content, config: DQNConfig, space: spaces.Space[Any], n_states: int, n_actions: int
    ) -> None:
        """Check that an agent has no more weights than the file, before there is one; see `ValueAgent`."""
        held, mode = numbers_in(network), config.observation_input
        trunk = Trunk(ObservationEncoder(space, mode), torch.Generator())
        widths = layer_widths(config, trunk.n_outputs, n_states, n_actions)
        needed = sum(n_in * n_out for n_in, n_out in itertools.pairwise(widths))
        network.check(needed <= held, f"has {held} weights; the hyperparameters and spaces ask for {needed}")

    @classmethod
    def placed(cls, config: DQNConfig, device: str | None) -> DQNConfig:
        """Return the configuration for a device; None: for the one it names, or the CPU if that is not there."""
        there = config.device if available(config.device) else "cpu"
        return dataclasses.replace(config, device=there if device is None else device)

    def load_policy(self, state: dict[str, Any]) -> None:
        """Take over the weights of a policy network, in all networks."""
        for name in _NETWORKS:
            getattr(self, name).load_state_dict(state)
