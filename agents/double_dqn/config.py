"""Hyperparameters of double deep Q-learning."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, get_args

from ltlc.errors import InvalidArgumentError, UnknownNameError

from ..config import ObservationInput, OffPolicyConfig, between, check_count, check_number

StateInput = Literal["heads", "one-hot", "raw"]
Initialization = Literal["he", "thesis"]
Optimizer = Literal["adam", "sgd"]


@dataclass(frozen=True, kw_only=True)
class DQNConfig(OffPolicyConfig):
    """Hyperparameters of deep Q-learning on the product of an environment and an automaton.

    The defaults are double Q-learning with one set of outputs per automaton state and counterfactual replay;
    `DQNConfig.thesis()` is algorithm 1 of the thesis. Steps are environment steps, all sub-environments together.

    Attributes:
        hidden: units of each hidden layer, ReLU between; thesis: (400, 300). None: one layer of 256.
        observation_input: discrete observations as indicator vectors, or as plain numbers (thesis: row and column).
        state_input: automaton state: one set of outputs per state, so that one pass values them all (`heads`), or a
            further input, as an indicator vector or as a plain number (thesis: `raw`).
        initialization: `he`: normal with variance 2/inputs; `thesis`: uniform on [0, 0.1], output layer [0, 0.01],
            biases 0.
        batch_norm: batch normalisation after each hidden layer (thesis).
        double: the online network chooses the next action and the target network values it (van Hasselt); else the
            target network does both (thesis, algorithm 1, line 19).
        counterfactual: each environment step teaches every automaton state at once; else only the one it was made in.
        optimizer: `adam`, or `sgd`: the plain gradient step of the thesis.
        learning_rate: at the start, > 0.
        final_learning_rate: at `total_steps`, linear in between; > 0.
        l2: C of the term C*||weights||^2 added to the loss (thesis), >= 0.
        max_gradient_norm: longer gradients are shortened to this; None: never.
        batch_size: environment steps in a batch, >= 1 (times the automaton states, if counterfactual); the first update
            waits for so many.
        buffer_size: environment steps kept for replay, >= batch_size; of a shorter training there is room for all.
        max_memory: gigabytes (1e9 bytes) that these may take; None: what is free on the device when training starts.
        train_frequency: steps of the vector environment from one round of updates to the next, >= 1.
        gradient_steps: updates in a round, >= 1.
        tau: the target network moves this part of the way to the online network at each target update, in (0, 1].
        target_update_interval: updates from one target update to the next, >= 1.
        averaging: the policy is greedy in an exponential average of the online weights that takes in this part of them
            at each update, in (0, 1]; 1: greedy in the online network itself (thesis).
        device: where the networks and the replay buffer live, such as `cpu`, `cuda`, `cuda:1`.

    Raises:
        InvalidArgumentError: a value is out of range, or two do not fit together.

    References:
        H. van Hasselt, A. Guez, D. Silver, Deep reinforcement learning with double Q-learning, AAAI 2016,
        https://doi.org/10.1609/aaai.v30i1.10295.
        R. Toro Icarte et al., Reward machines: exploiting reward function structure in reinforcement learning, JAIR
        2022, https://doi.org/10.1613/jair.1.12440 (counterfactual replay).
        V. Mnih et al., Human-level control through deep reinforcement learning, Nature 2015,
        https://doi.org/10.1038/nature14236 (replay and target network).
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018.
    """

    hidden: tuple[int, ...] | None = None
    observation_input: ObservationInput = "one-hot"
    state_input: StateInput = "heads"
    initialization: Initialization = "he"
    batch_norm: bool = False

    double: bool = True
    counterfactual: bool = True
    optimizer: Optimizer = "adam"
    learning_rate: float = 1e-3
    final_learning_rate: float = 1e-5
    l2: float = 0.0
    max_gradient_norm: float | None = None
    batch_size: int = 512
    buffer_size: int = 200_000
    max_memory: float | None = None
    train_frequency: int = 1
    gradient_steps: int = 1
    tau: float = 0.1
    target_update_interval: int = 1
    averaging: float = 0.005

    device: str = "cpu"

    @classmethod
    def thesis(cls, **changes: Any) -> DQNConfig:
        """Algorithm 1 of the thesis; what the text leaves open is taken from the code of the time.

        Target network without van Hasselt's correction, product state (observation, automaton state) as plain numbers,
        one update per environment step (so it wants a single sub-environment), loss 1/(2m) sum + C*||weights||^2.
        """
        values: dict[str, Any] = {
            "hidden": (400, 300), "observation_input": "raw", "state_input": "raw", "initialization": "thesis",
            "batch_norm": True, "double": False, "counterfactual": False, "reward_scale": 1.0, "learning_rate": 0.0015,
            "final_learning_rate": 0.0015, "l2": 1e-4, "batch_size": 64, "buffer_size": 1_000_000,
            "learning_starts": 64, "tau": 0.001, "averaging": 1.0, "epsilon_start": 0.7, "epsilon_final": 0.02,
        }  # fmt: skip
        return cls(**(values | changes))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.hidden is not None:
            if not isinstance(self.hidden, list | tuple):
                raise InvalidArgumentError(f"hidden is {self.hidden!r}; it must be a list of whole numbers, or null")
            object.__setattr__(self, "hidden", tuple(self.hidden))
        for field in _FLAGS:
            if not isinstance(getattr(self, field), bool):
                raise InvalidArgumentError(f"{field} is {getattr(self, field)!r}; it must be true or false")
        for field, choices in _CHOICES.items():
            if getattr(self, field) not in choices:
                raise UnknownNameError(f"value of {field}", str(getattr(self, field)), choices)
        for field, (low, high, closed) in _RANGES.items():
            check_number(field, getattr(self, field), low, high, closed=closed)
        for field, least in _COUNTS.items():
            check_count(field, getattr(self, field), least)
        for units in self.hidden or ():
            check_count("each entry of hidden", units, 1)
        for field in ("max_gradient_norm", "max_memory"):
            if getattr(self, field) is not None:
                check_number(field, getattr(self, field), 0.0, math.inf, closed=False)
        if self.buffer_size < self.batch_size:
            raise InvalidArgumentError(f"buffer_size is {self.buffer_size}, less than batch_size ({self.batch_size})")
        if self.batch_norm and self.batch_size < 2:
            raise InvalidArgumentError("batch_norm needs a batch_size of at least 2")

    def learning_rate_at(self, steps: int) -> float:
        """Learning rate after so many environment steps."""
        return between(self.learning_rate, self.final_learning_rate, steps / self.total_steps)


_FLAGS = ("batch_norm", "double", "counterfactual")
_CHOICES: dict[str, tuple[str, ...]] = {
    "observation_input": get_args(ObservationInput),
    "state_input": get_args(StateInput),
    "initialization": get_args(Initialization),
    "optimizer": get_args(Optimizer),
}
_RANGES = {  # lowest, highest, whether the lowest is allowed
    "learning_rate": (0.0, math.inf, False),
    "final_learning_rate": (0.0, math.inf, False),
    "l2": (0.0, math.inf, True),
    "tau": (0.0, 1.0, False),
    "averaging": (0.0, 1.0, False),
}
_COUNTS = {
    "batch_size": 1,
    "buffer_size": 1,
    "train_frequency": 1,
    "gradient_steps": 1,
    "target_update_interval": 1,
}
