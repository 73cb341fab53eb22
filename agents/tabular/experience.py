"""Steps of a wrapped vector environment in numbers: environment states, actions, letter classes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import torch
from gymnasium.vector import VectorEnv

from ltlc.automata import DRA
from ltlc.envs import LTLVectorWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import LabelledMDP, Product, RewardProduct
from ltlc.rewards import OnDeadlock, RewardScheme, RewardTables
from ltlc.rewards.scheme import StepRewards
from ltlc.task import Task

from ..encoder import JOINT_LIMIT, ObservationEncoder
from ..training.collect import Collector, Interface
from ..training.contents import Content
from ..training.shortcomings import Seen

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Batch:
    """Environment steps, one entry of each array per step; all arrays have shape (n,)."""

    state: IntArray
    """environment state before the action."""
    table_state: IntArray
    """state of the reward tables before the action."""
    action: IntArray
    letter_class: IntArray
    """class of the letter read on arrival."""
    next_state: IntArray
    terminated: BoolArray
    """whether the environment itself ended the episode."""


class Experience:
    """What a tabular learner knows of an environment: it can be reset and stepped, and its states have numbers.

    Args:
        env: an `LTLVectorWrapper` (or wrappers around one) over an environment with discrete observations and actions.
        seed: of the environment.
        unrewarded: whether the rewards of the task, which may also end episodes, are left out. Learners of a model
            want to see what comes after. Episodes then end only where the environment ends them; one that has parts
            which cannot be left should have a limit on the length of episodes.

    Attributes:
        task: of the environment.
        automaton: of the task.
        tables: reward tables of the task; of one that pays nothing, where rewards are left out.
        space: of a single observation, without the automaton.
        n_states: number of environment states.
        n_actions: number of actions.
        initial_label: whether the label of the first observation is read.
        steps: environment steps so far, all sub-environments together.

    Raises:
        InvalidArgumentError: there is no `LTLVectorWrapper`, the observations are not numbered, or the rewards leave
            the choice of a Rabin pair to the policy.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], seed: int, *, unrewarded: bool = False) -> None:
        interface = Interface.of(env)
        wrapper = interface.wrapper
        if wrapper is None:
            raise InvalidArgumentError("a tabular learner needs a task; put LTLVectorWrapper around the environment")
        self.task = wrapper.task
        _check_choices(self.task)
        if unrewarded:
            wrapper = LTLVectorWrapper(
                wrapper.env,
                Task(self.task.automaton, _Unrewarded()),
                wrapper.labels,
                batch_labels=wrapper.batch_labels,
                initial_label=wrapper.initial_label,
                extra_labels="ignore",
            )
            interface = Interface.of(wrapper)
        self.space, self._encoder = interface.space, ObservationEncoder(interface.space)
        if not 0 < self._encoder.n_observations <= JOINT_LIMIT:
            raise InvalidArgumentError(
                f"tabular learning needs observations that are discrete, {JOINT_LIMIT} of them at most; this "
                f'environment shows {interface.space}. Take the agent "double-dqn"'
            )
        self._collector = Collector(interface, self._encoder)
        self._collector.reset(seed)
        self.automaton, self.tables = wrapper.task.automaton, wrapper.task.tables
        self.n_states, self.n_actions = self._encoder.n_observations, interface.n_actions
        self.n_envs = env.num_envs
        self.initial_label = wrapper.initial_label
        self.steps = 0

    @property
    def state(self) -> IntArray:
        """The environment state each sub-environment is in, shape (n_envs,)."""
        return self._number(self._collector.packed)

    @property
    def table_state(self) -> IntArray:
        """The table state each sub-environment is in, shape (n_envs,)."""
        return self._collector.states

    @property
    def seen(self) -> Seen:
        """What the steps came across."""
        return self._collector.seen

    def begin(self, seed: int) -> None:
        """Begin new episodes everywhere; those under way are dropped."""
        self._collector.reset(seed)

    def state_dict(self) -> dict[str, Any]:
        """Return how many steps were made and what they came across, as numbers."""
        return {"steps": self.steps, "seen": self._collector.seen_state()}

    def load_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file, and go back to it.

        Raises:
            FileFormatError: it is something else.
        """
        self._collector.load_seen_state(content["seen"], self.tables.n_classes)
        self.steps = content["steps"].count()

    def step(self, actions: IntArray) -> Batch:
        """Carry out one action in each sub-environment; those that only begin an episode are left out."""
        steps = self._collector.step(actions)
        self._collector.take_episodes()
        self.steps += len(steps.action)
        return Batch(
            self._number(steps.observation),
            steps.state,
            steps.action,
            np.asarray(steps.letter_class, dtype=np.int64),
            self._number(steps.next_observation),
            np.asarray(steps.terminated, dtype=np.bool_),
        )

    def product(self, mdp: LabelledMDP) -> Product:
        """The product of a model of the environment with the automaton."""
        return Product(mdp, self.automaton, initial_label=self.initial_label)

    def reward_product(self, mdp: LabelledMDP, tables: RewardTables) -> RewardProduct:
        """The product of a model of the environment with reward tables."""
        return RewardProduct(mdp, tables, initial_label=self.initial_label)

    def _number(self, packed: npt.NDArray[Any]) -> IntArray:
        return np.asarray(self._encoder.index(torch.from_numpy(packed)).numpy())


def _check_choices(task: Task) -> None:
    """Check that the rewards of a task leave nothing to the policy but actions.

    Raises:
        InvalidArgumentError: they leave the choice of a Rabin pair to it.
    """
    if task.tables.n_choices:
        raise InvalidArgumentError(
            f"the rewards {task.scheme.name!r} leave the choice of a Rabin pair to the policy, which tables cannot "
            'make; take the rewards "parity", or the agent "double-dqn"'
        )


@dataclass(frozen=True)
class _Unrewarded(RewardScheme):
    """Pays nothing and ends nothing."""

    name: ClassVar[str] = "unrewarded"
    on_deadlock: ClassVar[OnDeadlock] = "stay"

    def towards_limit(self, k: int) -> RewardScheme:
        """Itself: nobody learns from these rewards, so there is nothing to warn of."""
        return self

    def steps(self, dra: DRA) -> StepRewards:
        """No rewards."""
        return StepRewards(accepted=np.zeros(dra.delta.shape, dtype=np.bool_))
