"""What an agent is: something that acts on observations and automaton states, and is kept in a file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Protocol, Self

import numpy as np
import numpy.typing as npt

from ltlc.envs import LTLVectorWrapper
from ltlc.rewards import RewardTables
from ltlc.task import Task

from .encoder import ObservationEncoder


class Agent(Protocol):
    """What judging, files and the command line ask of an agent; `ValueAgent` adds what the training loop asks for.

    Attributes:
        encoder: of the observations.
        n_actions: of the environment, without the choices of the task.
        tables: reward tables of the task.
        action_repeat: steps for which an action is held once it is chosen, see `ltlc.envs.HeldActions`.
    """

    encoder: ObservationEncoder
    n_actions: int
    tables: RewardTables

    @property
    def action_repeat(self) -> int:
        """Steps for which an action is held."""
        ...

    def packed_policy(self, packed: npt.NDArray[Any], states: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Choose actions for packed observations and table states, shape (batch,)."""
        ...

    def reseed(self, seed: int) -> None:
        """Let what the policy draws begin anew from a seed; a policy that draws nothing has nothing to do."""
        ...

    def policy_table(self) -> npt.NDArray[Any]:
        """Choose in each observation and table state, where observations are numbered.

        Returns:
            Actions, int, shape (n_observations, n_table_states); or their probabilities, float, with a last axis more.
        """
        ...

    def save(self, path: str | os.PathLike[str], *, run: str = "") -> Path:
        """Write the policy to a file, for the run of that identity."""
        ...

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, device: str | None = None) -> Self:
        """Read the policy that was saved; raises FileFormatError where it is damaged or of another agent."""
        ...

    @classmethod
    def learned_task(cls, env: LTLVectorWrapper, config: Any) -> Task:
        """The task of an environment, with the rewards that are learned from; those may be fitted to the agent."""
        ...

    @classmethod
    def check(cls, env: LTLVectorWrapper, config: Any) -> Any:
        """Check that it can learn in an environment; returns the size of its memory, None where that is small."""
        ...
