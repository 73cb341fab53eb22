"""The replay buffer: environment steps, each kept once, for every automaton state to learn from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from ltlc.errors import InvalidArgumentError


@dataclass(frozen=True)
class Steps:
    """Environment steps, a row each, as NumPy arrays (collected) or tensors (sampled).

    Rewards, discounts and next states of the automaton are not kept: they follow from the letter class by table
    look-up, for the automaton state the step was made in and for all others.
    """

    observation: Any
    """shape (n, width), packed; before the action."""
    state: Any
    """shape (n,), integer; table state before the action."""
    action: Any
    """shape (n,), integer; the action that was carried out, greedy or not."""
    letter_class: Any
    """shape (n,), integer; class of the letter read on arrival."""
    base_reward: Any
    """shape (n,), floating; what the environment pays on top of the reward tables."""
    terminated: Any
    """shape (n,), bool; whether the environment itself ended the episode. Truncation does not count."""
    next_observation: Any
    """shape (n, width), packed; after the action, never that of the following episode."""


FIELDS = tuple(Steps.__dataclass_fields__)


class ReplayBuffer:
    """The last `capacity` environment steps, in tensors allocated once.

    Args:
        capacity: rows.
        width: columns of a packed observation.
        dtype: of a packed observation.
        device: where the tensors live.

    References:
        L.-J. Lin, Self-improving reactive agents based on reinforcement learning, planning and teaching, Machine
        Learning 1992, https://doi.org/10.1007/BF00992699.
    """

    def __init__(self, capacity: int, width: int, dtype: npt.DTypeLike, device: str = "cpu") -> None:
        packed = torch.from_numpy(np.zeros(0, dtype=dtype)).dtype
        self.capacity = capacity
        self.device = device
        self.columns: dict[str, Tensor] = {
            "observation": torch.zeros((capacity, width), dtype=packed, device=device),
            "state": torch.zeros(capacity, dtype=torch.int64, device=device),
            "action": torch.zeros(capacity, dtype=torch.int64, device=device),
            "letter_class": torch.zeros(capacity, dtype=torch.int64, device=device),
            "base_reward": torch.zeros(capacity, dtype=torch.float32, device=device),
            "terminated": torch.zeros(capacity, dtype=torch.bool, device=device),
            "next_observation": torch.zeros((capacity, width), dtype=packed, device=device),
        }
        self.added = 0
        """rows ever added."""

    def __len__(self) -> int:
        return min(self.added, self.capacity)

    def add(self, steps: Steps) -> None:
        """Append rows; the oldest make room."""
        n = len(steps.action)
        rows = torch.from_numpy((self.added + np.arange(n))[-self.capacity :] % self.capacity).to(self.device)
        for name, column in self.columns.items():
            values = torch.from_numpy(np.ascontiguousarray(getattr(steps, name)))[-self.capacity :]
            column[rows] = values.to(self.device, column.dtype)
        self.added += n

    def sample(self, size: int, generator: torch.Generator) -> Steps:
        """Rows drawn uniformly with replacement; the generator is one of the CPU."""
        rows = torch.randint(len(self), (size,), generator=generator).to(self.device)
        return Steps(**{name: column[rows] for name, column in self.columns.items()})

    def state_dict(self) -> dict[str, Tensor]:
        """The rows in use, and `added`."""
        filled = {name: column[: len(self)] for name, column in self.columns.items()}
        return filled | {"added": torch.tensor(self.added)}

    def load_state_dict(self, state: dict[str, Tensor]) -> None:
        """Go back to what `state_dict` gave.

        Raises:
            InvalidArgumentError: the rows are of another kind, or more than fit.
        """
        added = int(state["added"])
        rows = min(added, self.capacity)
        for name, column in self.columns.items():
            given = state[name]
            if given.shape != (rows, *column.shape[1:]) or given.dtype != column.dtype:
                raise InvalidArgumentError(f"replay buffer: {name} of the checkpoint does not fit this buffer")
            column[:rows] = given.to(self.device)
        self.added = added
