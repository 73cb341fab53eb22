"""What the hyperparameters of all agents have in common, and how their values are checked."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Self

from ltlc.errors import InvalidArgumentError, UnknownNameError

ObservationInput = Literal["one-hot", "raw"]
"""discrete observations as indicator vectors, or as plain numbers."""
_MAX_THREADS = 1024


@dataclass(frozen=True, kw_only=True)
class AgentConfig:
    """Hyperparameters of an agent; those of each agent are a subclass.

    Steps are environment steps, all sub-environments together.

    Attributes:
        total_steps: of the whole training, >= 1; every agent has a default of its own.
        seed: of everything random, the environment included; >= 0.
        log_every: steps from one row of metrics to the next, >= 1.
        checkpoint_every: steps from one checkpoint to the next, >= 1; new episodes begin at each.

    Raises:
        InvalidArgumentError: a value is out of range.
    """

    total_steps: int
    seed: int = 0
    log_every: int = 20_000
    checkpoint_every: int = 100_000

    def __post_init__(self) -> None:
        for field, least in (("total_steps", 1), ("seed", 0), ("log_every", 1), ("checkpoint_every", 1)):
            check_count(field, getattr(self, field), least)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as JSON values."""
        values = dataclasses.asdict(self)
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}

    def without_effect(self, *, rewarded: bool) -> dict[str, str]:
        """Name the hyperparameters that nothing asks for, and why.

        Args:
            rewarded: whether reward tables say what is paid.
        """
        return {}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Make the configuration with these fields; those not given have their default.

        Raises:
            UnknownNameError: there is no such hyperparameter.
            InvalidArgumentError: a value is of the wrong kind or out of range.
        """
        known = [field.name for field in dataclasses.fields(cls)]
        for name in values:
            if name not in known:
                raise UnknownNameError("hyperparameter", name, known)
        return cls(**values)


@dataclass(frozen=True, kw_only=True)
class OffPolicyConfig(AgentConfig):
    """Hyperparameters that every agent of the training loop has, see `ltlc.agents.train`.

    Attributes:
        gamma: discount of a step in an environment without reward tables, in [0, 1]; reward tables bring their own.
        reward_scale: rewards are divided by this, so that values are of order 1; None: from the tables.
        learning_starts: environment steps that are awaited before the agent learns.
        epsilon_start: probability of an exploring action at the start, in [0, 1].
        epsilon_final: probability of an exploring action after `epsilon_steps`, in [0, 1]; high, since what is learned
            is off-policy.
        epsilon_steps: environment steps over which epsilon falls, linearly; None: a third of `total_steps`.
        threads: of PyTorch while training; None: leave them alone. Results are the same only for the same number.

    Raises:
        InvalidArgumentError: a value is out of range.
    """

    gamma: float = 0.99
    reward_scale: float | None = None
    learning_starts: int = 1_000
    epsilon_start: float = 1.0
    epsilon_final: float = 0.3
    epsilon_steps: int | None = None
    total_steps: int = 300_000
    threads: int | None = 1
    log_every: int = 10_000

    def __post_init__(self) -> None:
        super().__post_init__()
        for field in ("gamma", "epsilon_start", "epsilon_final"):
            check_number(field, getattr(self, field), 0.0, 1.0, closed=True)
        check_count("learning_starts", self.learning_starts, 0)
        if self.reward_scale is not None:
            check_number("reward_scale", self.reward_scale, 0.0, math.inf, closed=False)
        if self.epsilon_steps is not None:
            check_count("epsilon_steps", self.epsilon_steps, 0)
        if self.threads is not None:
            check_count("threads", self.threads, 1)
            if self.threads > _MAX_THREADS:
                raise InvalidArgumentError(f"threads is {self.threads}; it must be at most {_MAX_THREADS}")

    def epsilon_at(self, steps: int) -> float:
        """Return the probability of an exploring action after so many environment steps."""
        over = self.total_steps / 3 if self.epsilon_steps is None else self.epsilon_steps
        return between(self.epsilon_start, self.epsilon_final, steps / max(over, 1))

    def without_effect(self, *, rewarded: bool) -> dict[str, str]:
        """Name the hyperparameters that nothing asks for, and why.

        Args:
            rewarded: whether reward tables say what is paid.
        """
        return {"gamma": "the reward scheme brings its own discounts; set them there"} if rewarded else {}


def check_number(field: str, value: object, low: float, high: float, *, closed: bool) -> None:
    """Check that a value is a number from `low` (if `closed`, else above it) to `high`.

    Raises:
        InvalidArgumentError: it is not.
    """
    valid = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
    if not valid or not (low <= value <= high) or (value == low and not closed):  # type: ignore[operator]
        bounds = f"{'[' if closed else '('}{low:g}, {high:g}{')' if high == math.inf else ']'}"
        raise InvalidArgumentError(f"{field} is {value!r}; it must be a number in {bounds}")


def check_count(field: str, value: object, least: int, most: int = 2**63 - 1) -> None:
    """Check that a value is a whole number, at least `least` and at most `most`, which is what a file can hold.

    Raises:
        InvalidArgumentError: it is not.
    """
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise InvalidArgumentError(f"{field} is {value!r}; it must be a whole number, at least {least}")
    if value > most:
        raise InvalidArgumentError(f"{field} is {value}; it must be at most {most}")


def between(start: float, end: float, part: float) -> float:
    """Return what is a part in [0, 1] of the way from `start` to `end`; outside, the nearer of them."""
    return start + (end - start) * min(max(part, 0.0), 1.0)
