"""Steps of an environment, as they are collected, kept and learned from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from torch import Tensor

from .training.contents import Content


@dataclass(frozen=True)
class TransitionBatch:
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
    copy: Any = None
    """shape (n,), integer; the sub-environment, each at most once; None where steps were sampled."""
    ended: Any = None
    """shape (n,), bool; whether the episode is over, truncated ones included; None where steps were sampled."""


class Memory(Protocol):
    """The experience that an agent learns from."""

    def __len__(self) -> int:
        """Return how many steps there are to learn from."""
        ...

    def add(self, steps: TransitionBatch) -> None:
        """Take in steps."""
        ...

    def cut(self) -> None:
        """Take note that new episodes begin everywhere."""
        ...

    def state_dict(self) -> dict[str, Tensor]:
        """Return all of it as tensors."""
        ...

    def check_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file; raises FileFormatError."""
        ...

    def load_state_dict(self, state: dict[str, Tensor]) -> None:
        """Go back to what `state_dict` gave."""
        ...
