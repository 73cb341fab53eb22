"""What the hyperparameters of every tabular learner have in common."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from ltlc.errors import InvalidArgumentError, UnknownNameError


@dataclass(frozen=True, kw_only=True)
class LearnerConfig:
    """Hyperparameters of a tabular learner.

    Raises:
        InvalidArgumentError: a value is of the wrong kind or out of range.
    """

    total_steps: int = 1_000_000
    """environment steps at most, >= 1."""
    report_every: int = 20_000
    """environment steps from one call back to the next, >= 1."""
    seed: int = 0
    """of the exploration and the environment; >= 0."""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            check_kind(field.name, getattr(self, field.name), str(field.type))
        if min(self.total_steps, self.report_every) < 1:
            raise InvalidArgumentError("total_steps and report_every must be at least 1")
        if self.seed < 0:
            raise InvalidArgumentError(f"seed is {self.seed}; it must not be negative")

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        return dataclasses.asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """The configuration with these fields; those not given have their default.

        Raises:
            UnknownNameError: there is no such hyperparameter.
            InvalidArgumentError: a value is of the wrong kind or out of range.
        """
        known = [field.name for field in dataclasses.fields(cls)]
        for name in values:
            if name not in known:
                raise UnknownNameError("hyperparameter", name, known)
        return cls(**values)


def check_kind(name: str, value: object, kind: str) -> None:
    """Check a value against an annotation made of `bool`, `int`, `float` and `None`.

    Raises:
        InvalidArgumentError: it does not fit.
    """
    kinds = kind.split(" | ")
    match value:
        case None:
            fits = "None" in kinds
        case bool():
            fits = "bool" in kinds
        case int():
            fits = "int" in kinds or "float" in kinds
        case float():
            fits = "float" in kinds and math.isfinite(value)
        case _:
            fits = False
    if not fits:
        wanted = {"bool": "true or false", "int": "a whole number", "float": "a number", "None": "null"}
        raise InvalidArgumentError(f"{name} is {value!r}; it must be {' or '.join(wanted[one] for one in kinds)}")


def check_open(config: LearnerConfig, *names: str) -> None:
    """Check that hyperparameters, where they are not None, lie strictly between 0 and 1.

    Raises:
        InvalidArgumentError: one does not.
    """
    for name in names:
        value = getattr(config, name)
        if value is not None and not 0 < value < 1:
            raise InvalidArgumentError(f"{name} is {value}; it must lie strictly between 0 and 1")


def check_positive(config: LearnerConfig, *names: str) -> None:
    """Check that hyperparameters are positive.

    Raises:
        InvalidArgumentError: one is not.
    """
    for name in names:
        if not getattr(config, name) > 0:
            raise InvalidArgumentError(f"{name} is {getattr(config, name)}; it must be positive")


def check_probability(config: LearnerConfig, *names: str) -> None:
    """Check that hyperparameters are probabilities.

    Raises:
        InvalidArgumentError: one is not.
    """
    for name in names:
        if not 0 <= getattr(config, name) <= 1:
            raise InvalidArgumentError(f"{name} is {getattr(config, name)}; it must be a probability")
