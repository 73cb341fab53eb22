"""The agent: action-value networks of a product of environment and automaton, how they act and how they learn."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.errors import InvalidArgumentError, TrainingDiverged
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..training.contents import Content, check_optimizer, numbers_in
from ..transitions import TransitionBatch
from ..trunk import Trunk
from ..value_agent import ValueAgent
from .config import DQNConfig
from .networks import QNetwork, layer_widths, move_towards
from .replay import ReplayBuffer, ReplaySize
from .update import TDLoss

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
        policy_network: average of the online network over the last updates; its greedy policy is the result.
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
        _check_device(config.device)
        super().__init__(
            observation_space, n_actions, tables, config,
            observation_input=config.observation_input, device=config.device,
        )  # fmt: skip
        self._config = config
        self.q_network = self._network()
        self.target_network = self._network()
        self.policy_network: QNetwork = self._network()
        self.trunk: Trunk = self.q_network.trunk  # type: ignore[assignment]
        for network in (self.target_network, self.policy_network):
            network.trunk.share_statistics(self.trunk)  # type: ignore[operator]
        parameters = list(self.q_network.parameters())
        self.optimizer: torch.optim.Optimizer
        if config.optimizer == "adam":
            self.optimizer = torch.optim.Adam(parameters, lr=config.learning_rate, fused=True)
        else:
            self.optimizer = torch.optim.SGD(parameters, lr=config.learning_rate)
        self.loss = TDLoss(self.encoder, self.tensor_tables, config)

    def _network(self) -> QNetwork:
        generator = torch.Generator().manual_seed(self.config.seed)
        trunk = Trunk(self.encoder, generator)
        network = QNetwork(trunk.n_outputs, self.tables.n_states, self.n_actions, self.config, generator, trunk)
        return network.to(self.device)

    @property
    def config(self) -> DQNConfig:
        """The hyperparameters."""
        return self._config

    @property
    def counterfactual(self) -> bool:
        """Whether each step teaches every automaton state."""
        return self.config.counterfactual

    @property
    def first_update(self) -> int:
        """Environment steps that the first update waits for."""
        return max(self.config.learning_starts, self.config.batch_size)

    def learning_rate_at(self, steps: int) -> float:
        """Return the learning rate after so many environment steps."""
        return self.config.learning_rate_at(steps)

    def check_memory(self, num_envs: int, *, copied: bool) -> ReplaySize:
        """Check that the replay buffer of so many sub-environments fits into memory; see `ValueAgent`."""
        size = ReplaySize.of(self.config, self.encoder, num_envs)
        size.check(self.device, self.config.max_memory, copied=copied)
        return size

    def new_memory(self, num_envs: int) -> ReplayBuffer:
        """Make the replay buffer for so many sub-environments."""
        rows = ReplaySize.of(self.config, self.encoder, num_envs).rows
        limits = {"state": self.tables.n_states, "action": self.n_actions, "letter_class": self.tables.n_classes}
        return ReplayBuffer(rows, self.encoder.width, self.encoder.dtype, self.device, limits=limits)

    @torch.no_grad()
    def explore(
        self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64], epsilon: float, generator: torch.Generator
    ) -> npt.NDArray[np.int64]:
        """Choose actions for training, shape (batch,): random with probability `epsilon`, else greedy in `q_network`.

        Draws the same amount from the generator whatever happens.
        """
        self.trunk.observe(self.encoder, packed)
        n = len(packed)
        random = torch.randint(self.n_actions, (n,), generator=generator)
        chance = torch.rand(n, generator=generator, dtype=torch.float64)
        if self.tensor_tables.n_options > 1 and not self.config.counterfactual:
            random = self._with_random_choices(random, states, generator)
        if epsilon >= 1:
            return random.numpy()
        greedy = self.evaluate(self.q_network, packed, states).argmax(dim=-1).cpu()
        return torch.where(chance < epsilon, random, greedy).numpy()

    def _with_random_choices(
        self, actions: Tensor, states: npt.NDArray[np.int64], generator: torch.Generator
    ) -> Tensor:
        """The actions, together with a choice drawn uniformly; none where that one cannot be made."""
        choice = torch.randint(self.tensor_tables.n_options, actions.shape, generator=generator)
        allowed = self.tensor_tables.allowed.cpu()[torch.from_numpy(states), choice]
        return actions + self.n_actions * torch.where(allowed, choice, 0)

    def update(self, steps: TransitionBatch, learning_rate: float) -> float:
        """Make one gradient step on a batch of sampled steps; returns the loss before it.

        Raises:
            TrainingDiverged: the loss is not a finite number; the weights are as they were.
        """
        for group in self.optimizer.param_groups:
            group["lr"] = learning_rate
        self.q_network.train()
        loss = self.loss(self.q_network, self.target_network, steps)
        self.q_network.eval()
        value = loss.item()
        if not np.isfinite(value):
            raise TrainingDiverged(self._diagnosis(steps, learning_rate, value))
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        if self.config.max_gradient_norm is not None:
            torch.nn.utils.clip_grad_norm_(self.q_network.parameters(), self.config.max_gradient_norm)
        self.optimizer.step()
        self.updates += 1
        if self.updates % self.config.target_update_interval == 0:
            move_towards(self.target_network, self.q_network, self.config.tau)
        move_towards(self.policy_network, self.q_network, self.config.averaging)
        return value

    def learn(self, memory: ReplayBuffer, steps: int, rounds: int, generator: torch.Generator) -> list[float]:
        """Make the updates that are due; returns their losses."""
        config = self.config
        if len(memory) < self.first_update or rounds % config.train_frequency:
            return []
        batches = (memory.sample(config.batch_size, generator) for _ in range(config.gradient_steps))
        return [self.update(batch, config.learning_rate_at(steps)) for batch in batches]

    def _diagnosis(self, steps: TransitionBatch, learning_rate: float, value: float) -> str:
        broken = [name for name, weights in self.q_network.named_parameters() if not weights.isfinite().all()]
        rewards = steps.base_reward[~steps.base_reward.isfinite()]
        text = f"the loss is {value} at update {self.updates} (batch of {len(steps.action)} steps"
        text += f", {len(rewards)} of them with a reward that is not finite)" if len(rewards) else ")"
        text += f"; weights not finite in {', '.join(broken)}" if broken else "; the weights are finite"
        if len(rewards):
            return f"{text}. The environment pays rewards that are NaN or infinite; repair or wrap it."
        return (
            f"{text}. Try a learning_rate below {learning_rate:g}, max_gradient_norm=10, or a reward_scale above "
            f"{self.tensor_tables.scale:g}; resume from the last checkpoint, which is from before."
        )

    def state_dict(self) -> dict[str, Any]:
        """Return everything that learning changes, as tensors and numbers."""
        networks = {name: getattr(self, name).state_dict() for name in _NETWORKS}
        return {**networks, "optimizer": self.optimizer.state_dict(), "updates": self.updates}

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: it is of another agent.
        """
        for name in _NETWORKS:
            content[name].state_of(getattr(self, name))
        check_optimizer(content["optimizer"], self.optimizer)
        content["updates"].count()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""
        for name in _NETWORKS:
            getattr(self, name).load_state_dict(state[name])
        self.optimizer.load_state_dict(state["optimizer"])
        self.updates = int(state["updates"])

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
        there = config.device if _available(config.device) else "cpu"
        return dataclasses.replace(config, device=there if device is None else device)

    def load_policy(self, state: dict[str, Any]) -> None:
        """Take over the weights of a policy network, in all networks."""
        for name in _NETWORKS:
            getattr(self, name).load_state_dict(state)


def _available(device: str) -> bool:
    try:
        torch.zeros(1, device=device).item()  # a device like `meta` has no numbers
    except (RuntimeError, AssertionError):
        return False
    return True


def _check_device(device: str) -> None:
    if not _available(device):
        raise InvalidArgumentError(f'PyTorch cannot use the device {device!r} on this machine; try device="cpu"')
