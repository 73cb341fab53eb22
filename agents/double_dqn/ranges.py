"""What the hyperparameters of double deep Q-learning may be."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, Literal, get_args

from ltlc.errors import InvalidArgumentError, UnknownNameError

from ..config import ObservationInput, check_count, check_number

StateInput = Literal["heads", "one-hot", "raw"]
Initialization = Literal["he", "thesis"]
Optimizer = Literal["adam", "sgd"]
Output = Literal["bounded", "linear"]

_MANY = 2**63 - 1
_FLAGS = ("batch_norm", "layer_norm", "double", "counterfactual")
_CHOICES: dict[str, tuple[str, ...]] = {
    "observation_input": get_args(ObservationInput),
    "state_input": get_args(StateInput),
    "initialization": get_args(Initialization),
    "optimizer": get_args(Optimizer),
    "output": get_args(Output),
}
_RANGES = {  # lowest, highest, whether the lowest is allowed
    "learning_rate": (0.0, math.inf, False),
    "final_learning_rate": (0.0, math.inf, False),
    "l2": (0.0, math.inf, True),
    "tau": (0.0, 1.0, False),
    "averaging": (0.0, 1.0, False),
    "trace_decay": (0.0, 1.0, True),
    "advantage_learning": (0.0, 0.9999, True),
    "final_advantage_learning": (0.0, 0.9999, True),
    "temperature": (0.0, math.inf, True),
    "ladder": (0.0, math.inf, True),
    "exploring_starts": (0.0, 1.0, True),
    "curiosity": (0.0, 1.0, True),
    "robustness": (0.0, math.inf, True),
    "robustness_scale": (0.0, math.inf, False),
    "max_gradient_norm": (0.0, math.inf, False),
    "max_memory": (0.0, math.inf, False),
}
_COUNTS = {  # least, most
    "batch_size": (1, _MANY),
    "buffer_size": (1, _MANY),
    "waves": (0, _MANY),
    "horizon": (0, _MANY),
    "initial_horizon": (0, _MANY),
    "trace_length": (1, _MANY),
    "train_frequency": (1, _MANY),
    "action_repeat": (1, 255),
    "persistence": (1, _MANY),
    "gradient_steps": (1, _MANY),
    "target_update_interval": (1, _MANY),
}


def check_values(config: Any) -> None:
    """Check each of the hyperparameters by itself; what is open, being None by default, or never shortened, may be so.

    Args:
        config: a `DQNConfig`.

    Raises:
        InvalidArgumentError: a value is out of range.
    """
    values = {field.name: getattr(config, field.name) for field in fields(config)}
    unset = {field.name for field in fields(config) if field.default is None or field.name == "max_gradient_norm"}
    left_open = {name for name in unset if values[name] is None}
    for name in _FLAGS:
        if not isinstance(values[name], bool):
            raise InvalidArgumentError(f"{name} is {values[name]!r}; it must be true or false")
    for name, choices in _CHOICES.items():
        if values[name] not in choices:
            raise UnknownNameError(f"value of {name}", str(values[name]), choices)
    for name, (low, high, closed) in _RANGES.items():
        if name not in left_open:
            check_number(name, values[name], low, high, closed=closed)
    for name, (least, most) in _COUNTS.items():
        if name not in left_open:
            check_count(name, values[name], least, most)
