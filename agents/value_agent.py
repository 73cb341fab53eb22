"""What agents with action values have in common: acting, valuing, and policy files. The training loop trains them."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor, nn

from ltlc.envs import LTLVectorWrapper
from ltlc.rewards import RewardTables
from ltlc.task import Task

from .config import ObservationInput, OffPolicyConfig
from .encoder import ObservationEncoder
from .tensor_tables import TensorTables, plain_tables, without_forbidden
from .training.collect import Interface
from .training.contents import Content, config_of, space_of, tables_of
from .training.storage import plain_space, read_file, tables_to_tensors, write_file
from .transitions import Memory

IntArray = npt.NDArray[np.int64]
_FILE_KIND = "policy"


class ValueAgent(ABC):
    """An agent that acts by action values, and learns them from the experience of the training loop.

    A subclass names its `config_type`, makes its values in `__init__` (`policy_network` is the one that acts), and
    says how it explores, learns, and goes on from a checkpoint.

    Args:
        observation_space: of a single environment, without the automaton.
        n_actions: discrete actions 0 .. n_actions - 1 of the environment; those that also choose a Rabin pair are not
            counted, since choosing a pair and then acting is worth what acting is worth in the state chosen.
        tables: reward tables of the task; None for an environment that pays its own rewards.
        config: hyperparameters.
        observation_input: how discrete observations become numbers.
        device: where the values are.

    Attributes:
        name: in policy files and checkpoints.
        config_type: class of the hyperparameters.
        encoder: of the observations.
        tables: the reward tables; for None those of a task that asks for nothing.
        tensor_tables: the same as tensors.
        policy_network: values actions for the policy that is the result.
        updates: how often it has learned.

    Raises:
        InvalidArgumentError: the agent cannot take the observation space.
    """

    name: ClassVar[str]
    config_type: ClassVar[type[OffPolicyConfig]]
    policy_network: nn.Module

    def __init__(
        self,
        observation_space: spaces.Space[Any],
        n_actions: int,
        tables: RewardTables | None,
        config: OffPolicyConfig,
        *,
        observation_input: ObservationInput = "one-hot",
        device: str = "cpu",
    ) -> None:
        self.n_actions, self.device = n_actions, device
        self.encoder = ObservationEncoder(observation_space, observation_input)
        self.tables = plain_tables(config.gamma) if tables is None else tables
        self.tensor_tables = TensorTables.of(self.tables, config.reward_scale, device)
        self.updates = 0
        self.reseed(config.seed)

    # acting

    @torch.no_grad()
    def q_values(self, observations: Any, states: npt.ArrayLike | None = None) -> npt.NDArray[np.float64]:
        """Value actions by the policy network, in the units of the reward.

        Args:
            observations: a batch of the environment's observations.
            states: table state of each, shape (batch,), or None for all states.

        Returns:
            Shape (batch, n_actions), or (batch, n_states, n_actions) for all states. Where the task has choices,
            the actions are those of the wrapped environment, and -inf says that one does not exist.
        """
        packed = self.encoder.pack(observations)
        chosen = None if states is None else np.asarray(states, dtype=np.int64)
        values = self.evaluate(self.policy_network, packed, chosen)
        return values.cpu().numpy().astype(np.float64) * self.tensor_tables.scale

    def policy(self, observations: Any, states: npt.ArrayLike) -> IntArray:
        """Choose actions, shape (batch,): the best ones of the policy network, or as `chances` says.

        Where `action_repeat` is above 1, each is to be held for so many steps: `ltlc.envs.HeldActions` does.
        """
        return self.packed_policy(self.encoder.pack(observations), np.asarray(states, dtype=np.int64))

    @torch.no_grad()
    def packed_policy(self, packed: npt.NDArray[Any], states: IntArray) -> IntArray:
        """Do as `policy` does, for observations that the encoder has packed."""
        values = self.evaluate(self.policy_network, packed, states)
        chances = self.chances(values)
        if chances is None:
            return values.argmax(dim=-1).cpu().numpy()
        return torch.multinomial(chances.cpu(), 1, generator=self._generator)[:, 0].numpy()

    @torch.no_grad()
    def policy_table(self) -> npt.NDArray[Any]:
        """Choose in each observation and table state; the observations are to be numbered.

        Returns:
            Actions, int, shape (n_observations, n_states); or their probabilities, float, with a last axis more, where
            `chances` says so.
        """
        values = self.evaluate(self.policy_network, self.encoder.pack(self.encoder.all_observations()), None)
        chances = self.chances(values)
        return (values.argmax(dim=-1) if chances is None else chances).cpu().numpy()

    def chances(self, values: Tensor) -> Tensor | None:
        """Return how likely each action is, float64, given what actions are worth; None: the best one is chosen.

        Args:
            values: shape (..., n_actions), as `evaluate` returns them.
        """
        return None

    def reseed(self, seed: int) -> None:
        """Let what the policy draws begin anew from a seed."""
        self._generator = torch.Generator().manual_seed(seed)

    def network_inputs(self, packed: Tensor) -> Tensor:
        """Turn packed observations into what the networks take, a row each."""
        return self.encoder.features(packed)

    def evaluate(self, network: nn.Module, packed: npt.NDArray[Any], states: IntArray | None) -> Tensor:
        """Value all actions by a network, those that choose a Rabin pair included; see `q_values`."""
        rows = torch.from_numpy(packed).to(self.device)
        values = self.evaluate_inputs(network, self.network_inputs(rows), states)
        return without_forbidden(values, self.encoder.allowed(rows))

    def evaluate_inputs(self, network: nn.Module, inputs: Tensor, states: IntArray | None) -> Tensor:
        """Do as `evaluate` does, for what `network_inputs` gave; what is forbidden is valued, too."""
        tables = self.tensor_tables
        if states is None:
            values: Tensor = network(inputs, None)
            if tables.n_options == 1:
                return values
            return tables.join_options(values[:, tables.options], tables.allowed)
        there = torch.from_numpy(states).to(self.device)
        if tables.n_options == 1:
            return network(inputs, there)  # type: ignore[no-any-return]
        values = network(inputs.repeat_interleave(tables.n_options, dim=0), tables.options[there].flatten())
        return tables.join_options(values.view(len(there), tables.n_options, -1), tables.allowed[there])

    # learning, as the training loop asks for it

    @property
    @abstractmethod
    def config(self) -> Any:
        """The hyperparameters, of the class `config_type`."""

    @property
    def counterfactual(self) -> bool:
        """Whether each step teaches every automaton state, so that the order of labels does not matter."""
        return True

    @property
    def first_update(self) -> int | None:
        """Environment steps that the first update waits for; None: the agent needs none to act well."""
        return None

    @property
    def action_repeat(self) -> int:
        """Steps for which an action is held."""
        return 1

    def learning_rate_at(self, steps: int) -> float | None:
        """Return the learning rate after so many environment steps; None: there is none."""
        return None

    @classmethod
    def fitted(cls, config: Any, interface: Interface) -> tuple[Any, RewardTables | None]:
        """Fill in what the hyperparameters leave open, and say which reward tables to learn from.

        Args:
            config: the hyperparameters.
            interface: of the environment.
        """
        return config, interface.tables

    def learn_in(self, interface: Interface) -> None:  # noqa: B027 - most agents need no more than the tables
        """Take note of the environment that is learned in, before the first step."""

    def begin(self) -> None:  # noqa: B027 - most agents keep nothing of an episode
        """Take note that new episodes begin everywhere."""

    def check_memory(self, num_envs: int, *, copied: bool) -> Any:
        """Check that the experience of a training fits into memory.

        Args:
            num_envs: sub-environments.
            copied: whether it is written into checkpoints.

        Returns:
            Its size, with the attributes `rows` and `size_text`; None: it is small.

        Raises:
            MemoryLimitExceeded: it does not fit.
        """
        return None

    @abstractmethod
    def new_memory(self, num_envs: int) -> Memory:
        """Make room for the experience of so many sub-environments."""

    @abstractmethod
    def explore(
        self, packed: npt.NDArray[Any], states: IntArray, epsilon: float, generator: torch.Generator
    ) -> IntArray:
        """Choose actions for training, shape (batch,); a part `epsilon` of them explores."""

    @abstractmethod
    def learn(self, memory: Any, steps: int, rounds: int, generator: torch.Generator) -> list[float]:
        """Make the updates that are due; returns their losses.

        Args:
            memory: the experience.
            steps: environment steps before the last round.
            rounds: of steps in all sub-environments, before the last one.
            generator: of what is random.
        """

    def finish(self, memory: Any) -> None:  # noqa: B027 - most agents have nothing left to do
        """Learn what is left to be learned when the steps are over."""

    def settle(self, interface: Interface, seed: int, stop: Callable[[], bool]) -> str:
        """Choose by trial what is left open of the policy, when all is learned.

        Args:
            interface: of the environment that was learned in, which may be reset.
            seed: of what is tried.
            stop: whether to give up, as on Ctrl-C.

        Returns:
            What came of it, for people; empty where there is nothing to tell.
        """
        return ""

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """Return everything that learning changes, as tensors and numbers."""

    @abstractmethod
    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file; raises FileFormatError."""

    @abstractmethod
    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""

    # files

    @classmethod
    def learned_task(cls, env: LTLVectorWrapper, config: Any) -> Task:
        """The task of an environment, with the rewards that are learned from; those may be fitted to the agent."""
        return env.task

    @classmethod
    def check(cls, env: LTLVectorWrapper, config: Any) -> Any:
        """Make the agent once for an environment, so that wrong input is found; returns what `check_memory` does.

        Raises:
            LtlcError: the environment, its task and the hyperparameters do not go together.
        """
        interface = Interface.of(env)
        config, tables = cls.fitted(config, interface)
        agent = cls(interface.space, interface.n_actions, tables, config)
        env.reset(seed=config.seed)
        return agent.check_memory(env.num_envs, copied=True)

    def save(self, path: str | os.PathLike[str], *, run: str = "") -> Path:
        """Write the policy to a file, complete or not at all: what `load` needs to act and to value, no more.

        Args:
            path: of the file.
            run: identity of the training run that it belongs to.

        Raises:
            OSError: the folder is missing, not writable or full; an older file is as it was.
        """
        return write_file(path, _FILE_KIND, {
            "agent": self.name,
            "config": self.config.to_dict(),
            "observation_space": plain_space(self.encoder.space),
            "n_actions": self.n_actions,
            "tables": tables_to_tensors(self.tables),
            "policy_network": self.policy_state(),
        }, run)  # fmt: skip

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, device: str | None = None) -> Self:
        """Read the agent whose policy was saved; nothing in the file is executed.

        Args:
            path: the file.
            device: where to put it; None: where it was trained, or the CPU if that device is not there.

        Raises:
            FileFormatError: the file is damaged, no policy of this agent, or a value in it is wrong.
            OSError: the file is missing or not readable.
        """
        content = read_file(path, _FILE_KIND)
        name = content["agent"].text()
        content["agent"].check(name == cls.name, f"is {name!r}; this is {cls.name!r}")
        config, space = config_of(content["config"], cls.config_type), space_of(content["observation_space"])
        tables, n_actions = tables_of(content["tables"]), content["n_actions"].count(1)
        cls.check_size(content["policy_network"], config, space, tables.n_states, n_actions)
        agent = cls(space, n_actions, tables, cls.placed(config, device))
        agent.load_policy(agent.check_policy(content["policy_network"]))
        return agent

    @classmethod
    @abstractmethod
    def check_size(cls, network: Content, config: Any, space: spaces.Space[Any], n_states: int, n_actions: int) -> None:
        """Check that an agent has no more numbers than the policy network in a file, before there is one.

        Args:
            network: in the file.
            config: hyperparameters in the file.
            space: of a single observation.
            n_states: number of table states.
            n_actions: number of actions.

        Raises:
            FileFormatError: it has.
        """

    @classmethod
    def placed(cls, config: Any, device: str | None) -> Any:
        """Return the configuration for a device; None: for the one it names, if it is there."""
        return config

    def policy_state(self) -> dict[str, Tensor]:
        """Return the values of the policy network, for a file."""
        return self.policy_network.state_dict()

    def check_policy(self, content: Content) -> dict[str, Tensor]:
        """Check and return what `policy_state` gave, read from a file; raises FileFormatError."""
        return content.state_of(self.policy_network)

    def load_policy(self, state: dict[str, Any]) -> None:
        """Take over the values of a policy network."""
        self.policy_network.load_state_dict(state)
