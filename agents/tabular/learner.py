"""What every tabular learner is: it steps through an environment, plans now and then, and is kept in checkpoints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..training.contents import Content
from ..training.metrics import Row
from .config import ExplorationConfig
from .experience import Experience, IntArray

Found = tuple[npt.NDArray[Any] | None, Row]
"""A policy, and metrics but for the seconds.

The policy is an action (int, shape (n_env_states, n_q)) or probabilities of actions (float, a last axis more) for each
pair of environment state and state q of the automaton (of the reward tables, for learners that use rewards); None:
there is none, and the message of the metrics says why."""


class TabularLearner(ABC):
    """Learns with tables; `train_learner` runs it.

    Everything random is drawn from `generator`, which is a new one after each checkpoint.

    Args:
        experience: the environment, at the beginning of the training.
        config: hyperparameters.

    Attributes:
        generator: of random numbers.
    """

    def __init__(self, experience: Experience, config: Any) -> None:
        self.experience = experience
        self.config: Any = config
        self.generator = np.random.default_rng()

    @property
    def done(self) -> bool:
        """Whether no more steps are to be made."""
        return self.experience.steps >= int(self.config.total_steps)

    @abstractmethod
    def step(self) -> None:
        """Make one or more steps in each sub-environment, and learn from them."""

    @abstractmethod
    def plan(self) -> Found:
        """Plan on what has been learned so far; called where a row of metrics is due."""

    def conclude(self) -> Iterator[Found]:
        """Plan when all steps are made; the last of what is found is the result."""
        yield self.plan()

    def shortcomings(self) -> tuple[str, ...]:
        """Say what the steps lacked; nothing where the message says what the learner looks for."""
        return ()

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """Return everything that steps and plans change, as tensors and numbers."""

    @abstractmethod
    def load_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file, and go back to it; raises FileFormatError."""

    def explore(self, greedy: IntArray) -> IntArray:
        """Replace greedy actions, shape (n_envs,), by random ones with the probability epsilon."""
        config: ExplorationConfig = self.config
        random = self.generator.integers(self.experience.n_actions, size=len(greedy))
        epsilon = config.epsilon_at(self.experience.steps)
        return np.where(self.generator.random(len(greedy)) < epsilon, random, greedy)
