"""The agent: action-value networks of a product of environment and automaton, how they act and how they learn."""

from __future__ import annotations

import dataclasses
import itertools
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor

from ltlc.errors import InvalidArgumentError, TrainingDiverged
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..fitted_q.table import LARGEST, LAST_SWEEPS, SWEEPS, QTable, Tally, fit
from ..training.contents import (
    Content,
    check_optimizer,
    config_of,
    n_features,
    numbers_in,
    space_of,
    tables_of,
)
from ..training.storage import plain_space, read_file, tables_to_tensors, write_file
from .config import DQNConfig
from .networks import QNetwork, layer_widths, move_towards
from .replay import Steps
from .update import TDLoss, TensorTables

_FILE_KIND = "policy"
_TIE = 1e-12
"""values of a table that differ by less are alike, in units of the reward scale."""
_WANDERING = 0.2
"""probability of a random action of those that go where little was tried."""


class DoubleDQN:
    """Q-learning of one task, with networks or a table; `DQNConfig` says which of its variants.

    Args:
        observation_space: of a single environment, without the automaton.
        n_actions: discrete actions 0 .. n_actions - 1 of the environment; those that also choose a Rabin pair are not
            counted, since choosing a pair and then acting is worth what acting is worth in the state chosen.
        tables: reward tables of the task; None for an environment that pays its own rewards.
        config: hyperparameters.

    Attributes:
        encoder: of the observations.
        tables: the reward tables; for None those of a task that asks for nothing.
        device: where the values are; a table is on the CPU whatever the configuration says.
        q_network: learns, and acts while training; a `QTable` takes the place of all three networks.
        target_network: values next states; starts as a copy.
        policy_network: average of the online network over the last updates; its greedy policy is the result.
        updates: gradient steps, or fits of the table, made.

    Raises:
        InvalidArgumentError: the agent cannot take the observation space, or PyTorch cannot use the device.

    References:
        H. van Hasselt, A. Guez, D. Silver, Deep reinforcement learning with double Q-learning, AAAI 2016,
        https://doi.org/10.1609/aaai.v30i1.10295. Q. Gao, Deep Reinforcement Learning with Temporal Logic
        Specifications, Duke University, 2018, algorithm 1. For averaged weights: B. Polyak, A. Juditsky, Acceleration
        of stochastic approximation by averaging, SIAM J. Control Optim. 1992, https://doi.org/10.1137/0330046.
    """

    def __init__(
        self, observation_space: spaces.Space[Any], n_actions: int, tables: RewardTables | None, config: DQNConfig
    ) -> None:
        _check_device(config.device)
        self.config = config
        self.n_actions = n_actions
        self.encoder = ObservationEncoder(observation_space, config.observation_input)
        self.tables = plain_tables(config.gamma) if tables is None else tables
        tabular = _is_tabular(config, self.encoder, self.tables.n_states, n_actions)
        self.device = "cpu" if tabular else config.device
        there = dataclasses.replace(config, device=self.device)
        self.tensor_tables = TensorTables.of(self.tables, there)
        self.q_network: QNetwork | QTable
        self.target_network: QNetwork | QTable
        self.policy_network: QNetwork | QTable
        if tabular:
            table = QTable(self.encoder.n_observations, self.tables.n_states, n_actions)
            self.q_network = self.target_network = self.policy_network = table
        else:
            self.q_network = self._network(torch.Generator().manual_seed(config.seed))
            self.target_network = self._network(torch.Generator().manual_seed(config.seed))
            self.policy_network = self._network(torch.Generator().manual_seed(config.seed))
        parameters = list(self.q_network.parameters())
        self.optimizer: torch.optim.Optimizer | None = None
        if parameters and config.optimizer == "adam":
            self.optimizer = torch.optim.Adam(parameters, lr=config.learning_rate, fused=True)
        elif parameters:
            self.optimizer = torch.optim.SGD(parameters, lr=config.learning_rate)
        self.loss = TDLoss(self.encoder, self.tensor_tables, there)
        self.updates = 0

    @property
    def tabular(self) -> bool:
        """Whether the values are a table, which `fit` learns, and not networks, which `update` does."""
        return isinstance(self.q_network, QTable)

    def _network(self, generator: torch.Generator) -> QNetwork:
        network = QNetwork(self.encoder.n_features, self.tables.n_states, self.n_actions, self.config, generator)
        return network.to(self.device)

    @torch.no_grad()
    def q_values(self, observations: Any, states: npt.ArrayLike | None = None) -> npt.NDArray[np.float64]:
        """Values by the policy network, in the units of the reward.

        Args:
            observations: a batch of the environment's observations.
            states: table state of each, shape (batch,), or None for all states.

        Returns:
            Shape (batch, n_actions), or (batch, n_states, n_actions) for all states. Where the task has choices,
            the actions are those of the wrapped environment, and -inf says that one does not exist.
        """
        packed = self.encoder.pack(observations)
        chosen = None if states is None else np.asarray(states, dtype=np.int64)
        values = self._evaluate(self.policy_network, packed, chosen)
        return values.cpu().numpy().astype(np.float64) * self.tensor_tables.scale

    def policy(self, observations: Any, states: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Greedy actions of the policy network, shape (batch,)."""
        return np.asarray(self.q_values(observations, states).argmax(axis=-1))

    @torch.no_grad()
    def packed_policy(self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """`policy` for observations that the encoder has packed."""
        return self._evaluate(self.policy_network, packed, states).argmax(dim=-1).cpu().numpy()

    @torch.no_grad()
    def explore(
        self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64], epsilon: float, generator: torch.Generator
    ) -> npt.NDArray[np.int64]:
        """Actions for training, shape (batch,): random with probability `epsilon`, else greedy in the online network.

        With a table, the first `epsilon` of the batch mostly go where little was tried, and the others are greedy but
        for what the values may be wrong by. Draws the same amount from the generator whatever happens.
        """
        n = len(packed)
        if isinstance(self.q_network, QTable):
            return self._explore_by_table(self.q_network, packed, states, epsilon, generator)
        random = torch.randint(self.n_actions, (n,), generator=generator)
        chance = torch.rand(n, generator=generator, dtype=torch.float64)
        if self.tensor_tables.n_options > 1 and not self.config.counterfactual:
            random = self._with_random_choices(random, states, generator)
        if epsilon >= 1:
            return random.numpy()
        greedy = self._evaluate(self.q_network, packed, states).argmax(dim=-1).cpu()
        return torch.where(chance < epsilon, random, greedy).numpy()

    def _explore_by_table(
        self,
        table: QTable,
        packed: npt.NDArray[Any],
        states: npt.NDArray[np.int64],
        epsilon: float,
        generator: torch.Generator,
    ) -> npt.NDArray[np.int64]:
        n, row = len(packed), self.encoder.index(torch.from_numpy(packed))
        random = torch.randint(self.n_actions, (n,), generator=generator)
        chance = torch.rand(n, generator=generator, dtype=torch.float64)
        known = self._evaluate(table, packed, states) + table.doubt[row].repeat(1, self.tensor_tables.n_options)
        news = table.novelty[row, torch.from_numpy(states)]
        known, news = (v + _TIE * torch.rand(v.shape, generator=generator, dtype=v.dtype) for v in (known, news))
        seeker = torch.where(chance < _WANDERING, random, news.argmax(dim=-1))
        seeks = torch.arange(n) + 0.5 < epsilon * n
        return torch.where(seeks, seeker, known.argmax(dim=-1)).numpy()

    def _evaluate(
        self, network: QNetwork | QTable, packed: npt.NDArray[Any], states: npt.NDArray[np.int64] | None
    ) -> Tensor:
        tables, seen = self.tensor_tables, torch.from_numpy(packed).to(self.device)
        features = self.encoder.index(seen) if isinstance(network, QTable) else self.encoder.features(seen)
        if states is None:
            values: Tensor = network(features, None)
            if tables.n_options == 1:
                return values
            return tables.join_options(values[:, tables.options], tables.allowed)
        there = torch.from_numpy(states).to(self.device)
        if tables.n_options == 1:
            return network(features, there)  # type: ignore[no-any-return]
        values = network(features.repeat_interleave(tables.n_options, dim=0), tables.options[there].flatten())
        return tables.join_options(values.view(len(there), tables.n_options, -1), tables.allowed[there])

    def _with_random_choices(
        self, actions: Tensor, states: npt.NDArray[np.int64], generator: torch.Generator
    ) -> Tensor:
        """The actions, together with a choice drawn uniformly; none where that one cannot be made."""
        choice = torch.randint(self.tensor_tables.n_options, actions.shape, generator=generator)
        allowed = self.tensor_tables.allowed.cpu()[torch.from_numpy(states), choice]
        return actions + self.n_actions * torch.where(allowed, choice, 0)

    def update(self, steps: Steps, learning_rate: float) -> float:
        """One gradient step on a batch of sampled steps; returns the loss before it.

        Raises:
            TrainingDiverged: the loss is not a finite number; the weights are as they were.
        """
        assert isinstance(self.q_network, QNetwork) and isinstance(self.target_network, QNetwork)
        assert self.optimizer is not None
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

    def fit(self, tally: Tally, *, to_the_end: bool = False) -> float:
        """Fit the table to all experience; returns the largest change of the last sweep, in units of the reward scale.

        Args:
            tally: the experience.
            to_the_end: whether to go on until nothing changes any more.
        """
        assert isinstance(self.q_network, QTable)
        learned, scale = self.tensor_tables.learned.numpy(), self.tensor_tables.scale
        change = fit(self.q_network, tally, self.tables, learned, scale, LAST_SWEEPS if to_the_end else SWEEPS)
        self.updates += 1
        tally.fitted = len(tally)
        return change

    def _diagnosis(self, steps: Steps, learning_rate: float, value: float) -> str:
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
        """Everything that learning changes, as tensors and numbers."""
        return {
            "q_network": self.q_network.state_dict(),
            "target_network": self.target_network.state_dict(),
            "policy_network": self.policy_network.state_dict(),
            "optimizer": {} if self.optimizer is None else self.optimizer.state_dict(),
            "updates": self.updates,
        }

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: it is of another agent.
        """
        for name in ("q_network", "target_network", "policy_network"):
            content[name].state_of(getattr(self, name))
        if self.optimizer is not None:
            check_optimizer(content["optimizer"], self.optimizer)
        content["updates"].count()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""
        for name in ("q_network", "target_network", "policy_network"):
            getattr(self, name).load_state_dict(state[name])
        if self.optimizer is not None:
            self.optimizer.load_state_dict(state["optimizer"])
        self.updates = int(state["updates"])

    def save(self, path: str | os.PathLike[str], *, run: str = "") -> Path:
        """Write the policy to a file, complete or not at all: what `load` needs to act and to value, no more.

        Args:
            path: of the file.
            run: identity of the training run that it belongs to.

        Raises:
            OSError: the folder is missing, not writable or full; an older file is as it was.
        """
        return write_file(path, _FILE_KIND, {
            "config": self.config.to_dict(),
            "observation_space": plain_space(self.encoder.space),
            "n_actions": self.n_actions,
            "tables": tables_to_tensors(self.tables),
            "policy_network": self.policy_network.state_dict(),
        }, run)  # fmt: skip

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, device: str | None = None) -> DoubleDQN:
        """The agent whose policy was saved; nothing in the file is executed.

        Args:
            path: the file.
            device: where to put it; None: where it was trained, or the CPU if that device is not there.

        Raises:
            FileFormatError: the file is damaged, no policy, or a value in it is wrong.
            OSError: the file is missing or not readable.
        """
        content = read_file(path, _FILE_KIND)
        config, space = config_of(content["config"]), space_of(content["observation_space"])
        tables, n_actions = tables_of(content["tables"]), content["n_actions"].count(1)
        check_size(content["policy_network"], config, space, tables.n_states, n_actions)
        there = config.device if _available(config.device) else "cpu"
        agent = cls(space, n_actions, tables, dataclasses.replace(config, device=there if device is None else device))
        state = content["policy_network"].state_of(agent.policy_network)
        for network in (agent.policy_network, agent.q_network, agent.target_network):
            network.load_state_dict(state)
        return agent


def check_size(network: Content, config: DQNConfig, space: spaces.Space[Any], n_states: int, n_actions: int) -> None:
    """Check that an agent has no more weights than the file, before there is one.

    Args:
        network: the weights in the file.
        config: hyperparameters in the file.
        space: of a single observation.
        n_states: number of table states.
        n_actions: number of actions.

    Raises:
        FileFormatError: it has.
    """
    held, mode = numbers_in(network), config.observation_input
    network.check(n_features(space, mode) <= held, "has fewer weights than the observations have features")
    encoder = ObservationEncoder(space, mode)
    if _is_tabular(config, encoder, n_states, n_actions):
        return  # a table is small, or there is none
    widths = layer_widths(config, encoder.n_features, n_states, n_actions)
    needed = sum(n_in * n_out for n_in, n_out in itertools.pairwise(widths))
    network.check(needed <= held, f"has {held} weights; the hyperparameters and spaces ask for {needed}")


def _is_tabular(config: DQNConfig, encoder: ObservationEncoder, n_states: int, n_actions: int) -> bool:
    size = encoder.n_observations * n_states * n_actions
    numbered = config.observation_input == "one-hot" and 0 < size <= LARGEST
    return config.hidden is None and config.counterfactual and numbered


def plain_tables(gamma: float) -> RewardTables:
    """The tables of a task that asks for nothing: one state, reward 0, one discount."""
    one, no = np.ones((1, 1)), np.zeros((1, 1), dtype=np.bool_)
    return RewardTables(
        aps=(), letter_class=np.zeros(1, dtype=np.int32), initial_state=0, next_state=np.zeros((1, 1), dtype=np.int32),
        reward=0 * one, discount=gamma * one, stop=0 * one, stop_reward=0 * one, violated=no, accepted=no,
        automaton_state=np.zeros(1, dtype=np.int32), progress=np.zeros(1),
    )  # fmt: skip


def _available(device: str) -> bool:
    try:
        torch.zeros(1, device=device).item()  # a device like `meta` has no numbers
    except (RuntimeError, AssertionError):
        return False
    return True


def _check_device(device: str) -> None:
    if not _available(device):
        raise InvalidArgumentError(f'PyTorch cannot use the device {device!r} on this machine; try device="cpu"')
