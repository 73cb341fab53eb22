"""Every hyperparameter of the Q-learning agent, in one frozen dataclass."""

from __future__ import annotations

import dataclasses
import math
import sys
from dataclasses import dataclass
from typing import Any, Literal, get_args

from ltlc.errors import InvalidArgumentError, UnknownNameError

ObservationInput = Literal["one-hot", "raw"]
StateInput = Literal["heads", "one-hot", "raw"]
Initialization = Literal["he", "thesis"]
Optimizer = Literal["adam", "sgd"]


@dataclass(frozen=True, kw_only=True)
class DQNConfig:
    """Hyperparameters of deep Q-learning on the product of an environment and an automaton.

    The defaults are double Q-learning with one set of outputs per automaton state and counterfactual replay;
    `DQNConfig.thesis()` is algorithm 1 of the thesis. Steps are environment steps, all sub-environments together.

    Where the observations can be numbered, the default is no network but a table, fitted to all experience at once (see
    `hidden`): nothing is approximated, so that rewards can be told apart that differ by a hundred thousandth, as the
    schemes that maximise the probability of satisfaction need it. Of the hyperparameters it knows `gamma`,
    `reward_scale`, `learning_starts`, `batch_size` (the first fit waits for both), `total_steps` and epsilon, which is
    then the part of the sub-environments that look for what was seldom tried; `without_effect` lists the others.

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
    """units of each hidden layer, ReLU between; thesis: (400, 300). None: a table where observations are discrete, few
    and one-hot, and replay is counterfactual; else one layer of 256."""
    observation_input: ObservationInput = "one-hot"
    """discrete observations as indicator vectors, or as plain numbers (thesis: row and column)."""
    state_input: StateInput = "heads"
    """automaton state: one set of outputs per state, so that one pass values them all (`heads`), or a further input,
    as an indicator vector or as a plain number (thesis: `raw`)."""
    initialization: Initialization = "he"
    """`he`: normal with variance 2/inputs; `thesis`: uniform on [0, 0.1], output layer [0, 0.01], biases 0."""
    batch_norm: bool = False
    """batch normalisation after each hidden layer (thesis)."""

    double: bool = True
    """the online network chooses the next action and the target network values it (van Hasselt); else the target
    network does both (thesis, algorithm 1, line 19)."""
    counterfactual: bool = True
    """each environment step teaches every automaton state at once; else only the one it was made in."""
    gamma: float = 0.99
    """discount of a step in an environment without reward tables, in [0, 1]; reward tables bring their own."""
    reward_scale: float | None = None
    """rewards are divided by this inside the network, so that values are of order 1; None: from the tables."""

    optimizer: Optimizer = "adam"
    """`adam`, or `sgd`: the plain gradient step of the thesis."""
    learning_rate: float = 1e-3
    """at the start, > 0."""
    final_learning_rate: float = 1e-5
    """at `total_steps`, linear in between; > 0."""
    l2: float = 0.0
    """C of the term C*||weights||^2 added to the loss (thesis), >= 0."""
    max_gradient_norm: float | None = None
    """longer gradients are shortened to this; None: never."""
    batch_size: int = 512
    """environment steps in a batch, >= 1 (times the automaton states, if counterfactual)."""
    buffer_size: int = 200_000
    """environment steps kept for replay, >= batch_size; of a shorter training there is room for all."""
    max_memory: float | None = None
    """gigabytes (1e9 bytes) that these may take; None: what is free on the device when training starts."""
    learning_starts: int = 1_000
    """environment steps in the buffer before the first update; at least batch_size of them are awaited."""
    train_frequency: int = 1
    """steps of the vector environment from one round of updates to the next, >= 1."""
    gradient_steps: int = 1
    """updates in a round, >= 1."""
    tau: float = 0.1
    """the target network moves this part of the way to the online network at each target update, in (0, 1]."""
    target_update_interval: int = 1
    """updates from one target update to the next, >= 1."""
    averaging: float = 0.005
    """the policy is greedy in an exponential average of the online weights that takes in this part of them at each
    update, in (0, 1]; 1: greedy in the online network itself (thesis)."""

    epsilon_start: float = 1.0
    """probability of a random action at the start, in [0, 1]."""
    epsilon_final: float = 0.3
    """probability of a random action after `epsilon_steps`, in [0, 1]; high, since what is learned is off-policy."""
    epsilon_steps: int | None = None
    """environment steps over which epsilon falls, linearly; None: a third of `total_steps`."""

    total_steps: int = 2_000_000
    """environment steps of the whole training, >= 1."""
    seed: int = 0
    """of the networks, the exploration, the replay and the environment; >= 0."""
    device: str = "cpu"
    """where the networks and the replay buffer live, such as `cpu`, `cuda`, `cuda:1`."""
    threads: int | None = 1
    """threads of PyTorch while training; None: leave them alone. Results are the same only for the same number."""
    log_every: int = 10_000
    """environment steps from one row of metrics to the next, >= 1."""
    checkpoint_every: int = 100_000
    """environment steps from one checkpoint to the next, >= 1."""

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
            _check_number(field, getattr(self, field), low, high, closed)
        for field, least in _COUNTS.items():
            _check_count(field, getattr(self, field), least)
        for units in self.hidden or ():
            _check_count("each entry of hidden", units, 1)
        for field in ("batch_norm", "double", "counterfactual"):
            if not isinstance(getattr(self, field), bool):
                raise InvalidArgumentError(f"{field} is {getattr(self, field)!r}; it must be true or false")
        for field in ("reward_scale", "max_gradient_norm", "max_memory"):
            if getattr(self, field) is not None:
                _check_number(field, getattr(self, field), 0.0, math.inf, closed=False)
        for field, least in (("threads", 1), ("epsilon_steps", 0)):
            if getattr(self, field) is not None:
                _check_count(field, getattr(self, field), least)
        if self.threads is not None and self.threads > _MAX_THREADS:
            raise InvalidArgumentError(f"threads is {self.threads}; it must be at most {_MAX_THREADS}")
        if self.buffer_size < self.batch_size:
            raise InvalidArgumentError(f"buffer_size is {self.buffer_size}, less than batch_size ({self.batch_size})")
        if self.batch_norm and self.batch_size < 2:
            raise InvalidArgumentError("batch_norm needs a batch_size of at least 2")

    def learning_rate_at(self, steps: int) -> float:
        """Learning rate after so many environment steps."""
        return _line(self.learning_rate, self.final_learning_rate, steps / self.total_steps)

    def epsilon_at(self, steps: int) -> float:
        """Probability of a random action after so many environment steps."""
        over = self.total_steps / 3 if self.epsilon_steps is None else self.epsilon_steps
        return _line(self.epsilon_start, self.epsilon_final, steps / max(over, 1))

    def without_effect(self, *, tabular: bool, rewarded: bool) -> dict[str, str]:
        """The hyperparameters that nothing asks for, and why.

        Args:
            tabular: whether the agent keeps a table of values, see `hidden`.
            rewarded: whether reward tables say what is paid.
        """
        unused = {}
        if rewarded:
            unused["gamma"] = "the reward scheme brings its own discounts; set them there"
        if tabular:
            why = (
                "observations are few and discrete here, so the agent keeps a table of values, fitted to all experience"
                " at once; give layers (hidden) for a network instead"
            )
            unused |= dict.fromkeys(_NETWORK_ONLY, why)
        return unused

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        return dataclasses.asdict(self) | {"hidden": None if self.hidden is None else list(self.hidden)}

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> DQNConfig:
        """The configuration with these fields; those not given have their default.

        Raises:
            UnknownNameError: there is no such hyperparameter.
            InvalidArgumentError: a value is out of range.
        """
        known = [field.name for field in dataclasses.fields(cls)]
        for name in values:
            if name not in known:
                raise UnknownNameError("hyperparameter", name, known)
        return cls(**values)


_MAX_THREADS = 1024
_FLAGS = ("batch_norm", "double", "counterfactual")
_CHOICES: dict[str, tuple[str, ...]] = {
    "observation_input": get_args(ObservationInput),
    "state_input": get_args(StateInput),
    "initialization": get_args(Initialization),
    "optimizer": get_args(Optimizer),
}
_RANGES = {  # lowest, highest, whether the lowest is allowed
    "gamma": (0.0, 1.0, True),
    "learning_rate": (0.0, math.inf, False),
    "final_learning_rate": (0.0, math.inf, False),
    "l2": (0.0, math.inf, True),
    "tau": (0.0, 1.0, False),
    "averaging": (0.0, 1.0, False),
    "epsilon_start": (0.0, 1.0, True),
    "epsilon_final": (0.0, 1.0, True),
}
_NETWORK_ONLY = (
    "state_input", "initialization", "batch_norm", "double", "optimizer", "learning_rate", "final_learning_rate", "l2",
    "max_gradient_norm", "buffer_size", "max_memory", "train_frequency", "gradient_steps", "tau",
    "target_update_interval", "averaging",
)  # fmt: skip
_COUNTS = {
    "batch_size": 1,
    "buffer_size": 1,
    "learning_starts": 0,
    "train_frequency": 1,
    "gradient_steps": 1,
    "target_update_interval": 1,
    "total_steps": 1,
    "seed": 0,
    "log_every": 1,
    "checkpoint_every": 1,
}


def _check_number(field: str, value: object, low: float, high: float, closed: bool) -> None:
    valid = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
    if not valid or not (low <= value <= high) or (value == low and not closed):  # type: ignore[operator]
        bounds = f"{'[' if closed else '('}{low:g}, {high:g}{')' if high == math.inf else ']'}"
        raise InvalidArgumentError(f"{field} is {value!r}; it must be a number in {bounds}")


def _check_count(field: str, value: object, least: int) -> None:
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise InvalidArgumentError(f"{field} is {value!r}; it must be a whole number, at least {least}")
    if value >= 2**63:
        raise InvalidArgumentError(f"{field} is {value}; it must be below 2^63")


def _line(start: float, end: float, part: float) -> float:
    return start + (end - start) * min(max(part, 0.0), 1.0)
