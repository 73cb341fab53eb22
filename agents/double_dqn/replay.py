"""The replay buffer: environment steps, each kept once, for every automaton state to learn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from ltlc.errors import InvalidArgumentError

from ..encoder import ObservationEncoder
from ..training.contents import Content
from ..training.memory import check_memory, size_text
from ..transitions import TransitionBatch
from .config import DQNConfig

_KINDS = {"state": torch.int64, "action": torch.int64, "letter_class": torch.int64, "base_reward": torch.float32,
          "terminated": torch.bool}  # fmt: skip
"""of the columns that are not observations."""


@dataclass(frozen=True)
class ReplaySize:
    """How many steps a training keeps at once, and what that takes."""

    rows: int
    """as many as `buffer_size` says, and no more than the training makes."""
    row_bytes: int
    """of one step with both its observations."""

    @classmethod
    def of(cls, config: DQNConfig, encoder: ObservationEncoder, num_envs: int) -> ReplaySize:
        """The size for so many sub-environments, which all step once more when the last step is due."""
        observation = encoder.width * np.dtype(encoder.dtype).itemsize
        rows = min(config.buffer_size, config.total_steps + num_envs)
        return cls(rows, 2 * observation + sum(kind.itemsize for kind in _KINDS.values()))

    @property
    def bytes(self) -> int:
        """Of all rows."""
        return self.rows * self.row_bytes

    @property
    def size_text(self) -> str:
        """The size for a person."""
        return size_text(self.bytes)

    def check(self, device: str, allowed: float | None, *, copied: bool) -> None:
        """Check that it fits, see `check_memory`.

        Args:
            device: of the buffer.
            allowed: gigabytes; None: what is free.
            copied: whether it is written into checkpoints, for which there is a copy in main memory for a moment.

        Raises:
            MemoryLimitExceeded: it does not.
        """
        what = f"the replay of {self.rows} steps of {size_text(self.row_bytes)} each"
        advice = "lower buffer_size or total_steps, show the agent smaller observations, or set max_memory (gigabytes)"
        if copied and torch.device(device).type == "cpu":
            check_memory(f"{what}, with its copy for a checkpoint,", 2 * self.bytes, device, advice, allowed)
        else:
            check_memory(what, self.bytes, device, advice, allowed)


class ReplayBuffer:
    """The last `capacity` environment steps, in tensors allocated once.

    Args:
        capacity: rows.
        width: columns of a packed observation.
        dtype: of a packed observation.
        device: where the tensors live.
        limits: what the numbers of a column are below, for columns that number something.

    References:
        L.-J. Lin, Self-improving reactive agents based on reinforcement learning, planning and teaching, Machine
        Learning 1992, https://doi.org/10.1007/BF00992699.
    """

    def __init__(
        self,
        capacity: int,
        width: int,
        dtype: npt.DTypeLike,
        device: str = "cpu",
        *,
        limits: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        packed = torch.from_numpy(np.zeros(0, dtype=dtype)).dtype
        self.capacity = capacity
        self.device = device
        self.limits = limits
        self.columns: dict[str, Tensor] = {
            "observation": torch.zeros((capacity, width), dtype=packed, device=device),
            **{name: torch.zeros(capacity, dtype=kind, device=device) for name, kind in _KINDS.items()},
            "next_observation": torch.zeros((capacity, width), dtype=packed, device=device),
        }
        self.added = 0
        """rows ever added."""

    def __len__(self) -> int:
        return min(self.added, self.capacity)

    def add(self, steps: TransitionBatch) -> None:
        """Append rows; the oldest make room."""
        n = len(steps.action)
        rows = torch.from_numpy((self.added + np.arange(n))[-self.capacity :] % self.capacity).to(self.device)
        for name, column in self.columns.items():
            values = torch.from_numpy(np.ascontiguousarray(getattr(steps, name)))[-self.capacity :]
            column[rows] = values.to(self.device, column.dtype)
        self.added += n

    def sample(self, size: int, generator: torch.Generator) -> TransitionBatch:
        """Rows drawn uniformly with replacement; the generator is one of the CPU."""
        rows = torch.randint(len(self), (size,), generator=generator).to(self.device)
        return TransitionBatch(**{name: column[rows] for name, column in self.columns.items()})

    def state_dict(self) -> dict[str, Tensor]:
        """The rows in use, and `added`."""
        filled = {name: column[: len(self)] for name, column in self.columns.items()}
        return filled | {"added": torch.tensor(self.added)}

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: the rows are of another kind, or more than fit.
        """
        content.check(content.members().keys() == {*self.columns, "added"}, "is of another kind of experience")
        rows = min(int(content["added"].indices(torch.int64, (), 2**62)), self.capacity)
        for name, column in self.columns.items():
            shape = (rows, *column.shape[1:])
            content[name].tensor(column.dtype, shape)
            if name in self.limits:
                content[name].indices(column.dtype, shape, self.limits[name])

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
