"""The replay buffer: environment steps in the order they were made, each observation once, for all automaton states."""

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
from .places import Places

_KINDS = {"state": torch.int64, "action": torch.int64, "letter_class": torch.int64, "base_reward": torch.float32,
          "terminated": torch.bool, "real": torch.bool,
          "place": torch.int64, "phase": torch.uint8}  # fmt: skip
"""of the columns that are not observations; a row that is not `real` holds the last observation of an episode."""
_BESIDE = ("real", "place", "phase")
"""of these, what is no part of a step as it was collected."""


_MOST_BYTES = 4_000_000_000
"""of all rows, where nobody says how much memory there is for them."""


@dataclass(frozen=True)
class ReplaySize:
    """How many steps a training keeps at once, and what that takes."""

    rows: int
    """as many as `buffer_size` says, and no more than the training makes."""
    row_bytes: int
    """of one step with its observation."""
    num_envs: int
    """sub-environments, each with a ring of its own."""
    repeat: int = 1
    """steps for which an action is held."""

    @classmethod
    def of(cls, config: DQNConfig, encoder: ObservationEncoder, num_envs: int) -> ReplaySize:
        """The size for so many sub-environments, which all step once more when the last step is due."""
        observation = encoder.width * np.dtype(encoder.dtype).itemsize
        row_bytes = observation + sum(kind.itemsize for kind in _KINDS.values())
        rows = min(config.buffer_size, config.total_steps + num_envs)
        if config.max_memory is None:
            rows = min(rows, max(_MOST_BYTES // row_bytes, config.rows))
        return cls(rows, row_bytes, num_envs, config.held)

    @property
    def length(self) -> int:
        """Rows of each ring: its share, of one action at least, and one for the observation after the last step."""
        return max(-(-self.rows // self.num_envs), 2 * self.repeat) + 1

    @property
    def bytes(self) -> int:
        """Of all rows."""
        return self.num_envs * self.length * self.row_bytes

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


@dataclass(frozen=True)
class Segments:
    """Actions that followed one another, as tensors: `count` rows of `length` actions, each held for `repeat` steps."""

    observation: Tensor
    """shape (count, length + 1, width), packed; where actions were chosen, and after the last step."""
    action: Tensor
    """shape (count, length + 1), int64; the last belongs to no step of the segment."""
    letter_class: Tensor
    """shape (count, length, repeat), int64; of each step."""
    base_reward: Tensor
    """shape (count, length, repeat), float32; of each step."""
    terminated: Tensor
    """shape (count, length, repeat), bool; of each step."""
    made: Tensor
    """shape (count, length, repeat), bool; whether the step was made before the episode was over. If not, it says
    nothing, and the next observation is the last one of the episode."""
    real: Tensor
    """shape (count, length + 1), bool; whether the row is an action, and not the last observation of an episode or what
    comes after it."""
    place: Tensor
    """shape (count, length + 1), int64; see `Places`."""


class ReplayBuffer:
    """The last steps of each sub-environment, in rings allocated once; an observation is kept once.

    The observation after a step stands in the next row, which is the next step of the episode or, at its end, a row of
    its own.

    Args:
        size: of the rings.
        encoder: of the observations.
        places: of the observations.
        device: where the tensors live.
        limits: what the numbers of a column are below, for columns that number something.

    Attributes:
        steps: that were ever added.
        newest: that were added last.
        least: of them that segments can be drawn from.
        tried: table state, place and action of these, int64, shape (newest,) each.
        latest: their sub-environment and letter class, int64, and whether they ended an episode; shape (newest,) each.

    References:
        L.-J. Lin, Self-improving reactive agents based on reinforcement learning, planning and teaching, Machine
        Learning 1992, https://doi.org/10.1007/BF00992699.
    """

    def __init__(
        self,
        size: ReplaySize,
        encoder: ObservationEncoder,
        places: Places,
        device: str = "cpu",
        *,
        limits: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        packed = torch.from_numpy(np.zeros(0, dtype=encoder.dtype)).dtype
        self._places, self._repeat = places, size.repeat
        limits = {**limits, "place": places.count, "phase": size.repeat}
        rows = (size.num_envs, size.length)
        self.length, self.device, self.limits = size.length, device, limits
        self.columns: dict[str, Tensor] = {
            "observation": torch.zeros((*rows, encoder.width), dtype=packed, device=device),
            **{name: torch.zeros(rows, dtype=kind, device=device) for name, kind in _KINDS.items()},
        }
        self._written = np.zeros(size.num_envs, dtype=np.int64)
        """rows ever begun in each ring, so that the next step goes to row `written % length`."""
        self._age = np.zeros(size.num_envs, dtype=np.int64)
        """steps of the episode under way."""
        self.steps, self.newest, self._most = 0, 0, size.rows
        self.least = size.num_envs * size.repeat if size.repeat > 1 else 1
        self.tried: tuple[Tensor, ...] = ()
        self.latest: tuple[Tensor, ...] = ()

    def __len__(self) -> int:
        return min(self.steps, self._most)

    def add(self, steps: TransitionBatch) -> None:
        """Append a step of each of some sub-environments; the oldest make room."""
        copies, there = steps.copy, self._written[steps.copy]
        rows, following = self._rows(copies, there), self._rows(copies, there + 1)
        for name, column in self.columns.items():
            if name not in _BESIDE:
                column[rows] = self._tensor(getattr(steps, name), column.dtype)
        self.columns["real"][rows] = True
        self.columns["phase"][rows] = self._tensor(self._age[copies] % self._repeat, torch.uint8)
        self.columns["phase"][following] = self._repeat - 1  # what comes behind it begins an episode
        place = self._places(steps.observation)
        self.columns["place"][rows] = self._tensor(place, torch.int64)
        self.columns["place"][following] = self._tensor(self._places(steps.next_observation), torch.int64)
        self.columns["observation"][following] = self._tensor(steps.next_observation, self.columns["observation"].dtype)
        self.columns["real"][following] = False
        self._written[copies] = there + 1 + steps.ended
        self._age[copies] = np.where(steps.ended, 0, self._age[copies] + 1)
        self.steps, self.newest = self.steps + len(copies), len(copies)
        self.latest = tuple(
            torch.from_numpy(np.asarray(part)) for part in (copies, steps.letter_class.astype(np.int64), steps.ended)
        )
        self.tried = tuple(torch.from_numpy(np.asarray(part)) for part in (steps.state, place, steps.action))

    def cut(self) -> None:
        """End what is under way in all sub-environments, since new episodes begin."""
        last = self.columns["real"].cpu().numpy()[np.arange(len(self._written)), (self._written - 1) % self.length]
        self._written += last & (self._written > 0)
        self._age[:] = 0

    def sample(self, size: int, generator: torch.Generator) -> TransitionBatch:
        """Steps drawn uniformly with replacement, of each sub-environment alike; the generator is one of the CPU."""
        copies, rows = np.zeros(0, np.int64), np.zeros(0, np.int64)
        while len(rows) < size:
            drawn = self._draw(size, 1, generator)
            real = self.columns["real"][self._rows(*drawn)].cpu().numpy()
            copies = np.concatenate([copies, drawn[0][real]])[:size]
            rows = np.concatenate([rows, drawn[1][real]])[:size]
        at, following = self._rows(copies, rows), self._rows(copies, rows + 1)
        columns = {name: column[at] for name, column in self.columns.items() if name not in _BESIDE}
        return TransitionBatch(**columns, next_observation=self.columns["observation"][following])

    def sample_segments(self, count: int, length: int, generator: torch.Generator) -> Segments:
        """Segments that begin with any action, of each copy alike; shorter ones as long as there are no longer."""
        begun, repeat = self._written[self._written > 0], self._repeat
        length = max(min(length, int(np.minimum(begun, self.length - 1).min()) // repeat), 1)
        copies, first = self._draw(count, (length + 1) * repeat - 1, generator)
        phase = self.columns["phase"][self._rows(copies, first)].cpu().numpy().astype(np.int64)
        first += -phase % repeat
        made = self.columns["real"][self._rows(copies[:, None], first[:, None] + np.arange(length * repeat + 1))]
        made = made.cumprod(dim=1).bool() if repeat > 1 else torch.ones_like(made)
        last = made.sum(dim=1).cpu().numpy()[:, None]  # where the episode is over
        starts = repeat * np.arange(length + 1)
        at = self._rows(copies[:, None], first[:, None] + np.minimum(starts, last))
        each = self._rows(copies[:, None, None], first[:, None, None] + starts[:-1, None] + np.arange(repeat))
        found = {name: self.columns[name][at] for name in ("observation", "action", "place", "real")}
        found |= {name: self.columns[name][each] for name in ("letter_class", "base_reward", "terminated")}
        found["real"] &= self.columns["phase"][at] == 0
        return Segments(**found, made=made[:, :-1].view(count, length, repeat))

    def _draw(self, count: int, length: int, generator: torch.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Sub-environments that have steps, and first rows after which there are so many more."""
        known = np.flatnonzero(self._written > 0)
        copies = known[torch.randint(len(known), (count,), generator=generator).numpy()]
        written = self._written[copies]
        oldest = np.maximum(written - (self.length - 1), 0)
        room = np.maximum(written - length + 1 - oldest, 1)  # what is not there yet is not real
        chance = torch.rand(count, generator=generator, dtype=torch.float64).numpy()
        return copies, oldest + np.minimum((chance * room).astype(np.int64), room - 1)

    def _rows(self, copies: np.ndarray, rows: np.ndarray) -> tuple[Tensor, Tensor]:
        copies, rows = np.broadcast_arrays(copies, rows % self.length)
        return torch.from_numpy(copies.copy()).to(self.device), torch.from_numpy(rows.copy()).to(self.device)

    def _tensor(self, values: npt.NDArray[np.generic], kind: torch.dtype) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(values)).to(self.device, kind)

    @property
    def _filled(self) -> int:
        """Rows that are in use in any ring."""
        return min(int(self._written.max(initial=0)) + 1, self.length)

    def state_dict(self) -> dict[str, Tensor]:
        """The rows in use, and how many there have been."""
        filled = {name: column[:, : self._filled] for name, column in self.columns.items()}
        return filled | {"written": torch.from_numpy(self._written.copy()), "steps": torch.tensor(self.steps)}

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: the rows are of another kind, or more than fit.
        """
        content.check(
            content.members().keys() == {*self.columns, "written", "steps"}, "is of another kind of experience"
        )
        written = content["written"].indices(torch.int64, self._written.shape, 2**62)
        steps = int(content["steps"].indices(torch.int64, (), 2**62))
        content["steps"].check(steps <= int(written.sum()), "are more than there are rows")
        filled = min(int(written.max()) + 1, self.length)
        for name, column in self.columns.items():
            shape = (len(written), filled, *column.shape[2:])
            content[name].tensor(column.dtype, shape)
            if name in self.limits:
                content[name].indices(column.dtype, shape, self.limits[name])

    def load_state_dict(self, state: dict[str, Tensor]) -> None:
        """Go back to what `state_dict` gave.

        Raises:
            InvalidArgumentError: the rows are of another kind, or more than fit.
        """
        self._written, self.steps = state["written"].numpy().copy(), int(state["steps"])
        for name, column in self.columns.items():
            given = state[name]
            if given.shape != (len(column), self._filled, *column.shape[2:]) or given.dtype != column.dtype:
                raise InvalidArgumentError(f"replay buffer: {name} of the checkpoint does not fit this buffer")
            column[:, : self._filled] = given.to(self.device)
