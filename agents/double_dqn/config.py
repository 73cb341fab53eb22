"""Hyperparameters of double deep Q-learning."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

from ltlc.errors import InvalidArgumentError

from ..config import ObservationInput, OffPolicyConfig, between, check_count
from .ranges import Initialization, Optimizer, Output, StateInput, check_values

_LEAST_FREQUENCY, _UNHURRIED = 8, 4_000
"""environment steps for a round of updates, and part of a training whose root they may also be, where nobody says."""
_BATCH, _NUMBERED_BATCH = 128, 512
"""environment steps in a batch, where nobody says."""
DRAWN = 0.1
"""the temperature where there is no reason for another."""
_NEAR, _GROWS, _STAGES = 100, (0.1, 0.7), 20
"""steps to look ahead in the beginning, and parts of the training between which they become more, in so many stages."""


@dataclass(frozen=True, kw_only=True)
class DQNConfig(OffPolicyConfig):
    """Hyperparameters of deep Q-learning on the product of an environment and an automaton.

    The defaults are double Q-learning with one set of outputs per automaton state and counterfactual replay;
    `DQNConfig.thesis()` is algorithm 1 of the thesis. Steps are environment steps, all sub-environments together.

    Attributes:
        hidden: units of each hidden layer, ReLU between; thesis: (400, 300). None: two layers of 256.
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
        final_learning_rate: at `total_steps`, linear in between; > 0. Low, since greedy policies jump as long as values
            do.
        l2: C of the term C*||weights||^2 added to the loss (thesis), >= 0.
        max_gradient_norm: longer gradients are shortened to this; None: never.
        batch_size: actions in a batch, >= 1 (times the automaton states, if counterfactual); the first update
            waits for so many. None: 512 where observations are numbered, since each of them passes the network but
            once, and else 128.
        buffer_size: environment steps kept for replay, >= batch_size; of a shorter training there is room for all.
        max_memory: gigabytes (1e9 bytes) that these may take; None: what is free on the device when training starts,
            and 4 gigabytes at most, which is less than `buffer_size` steps where observations are large.
        train_frequency: environment steps from one round of updates to the next, >= 1, whatever the number of
            sub-environments. None: 8, or the root of `total_steps` / 4000 where that is more, four times the steps
            making twice the updates; of `total_steps` * `action_repeat` / 4000, where actions are held.
        gradient_steps: updates in a round, >= 1.
        tau: the target network moves this part of the way to the online network at each target update, in (0, 1].
            None: 0.1 where observations are numbered, and else 0.005, since what is learned of one place there moves
            the values of others.
        target_update_interval: updates from one target update to the next, >= 1.
        averaging: the policy is greedy in an exponential average of the online weights that takes in this part of them
            at each update, in (0, 1]; 1: greedy in the online network itself (thesis).
        layer_norm: layer normalisation before each ReLU, unless there is batch normalisation; it keeps inputs of every
            scale learnable, and values from running off.
        waves: sines and cosines of so many random mixtures of the features join the inputs, where there are at most 32,
            >= 0: plain layers first learn what is smooth;
            0: none (thesis).
        output: `bounded`: outputs are squashed into what values can be, and learned by cross entropy, which tells small
            probabilities apart; needs segments and rewards that are never negative. Elsewhere, and with `linear`,
            outputs are values (thesis).
        horizon: steps that the discount of the recommended scheme looks ahead: gamma = 1 - 1/horizon, gamma_accept = 1
            - sqrt((1 - gamma) / 2). A network cannot tell values apart that differ by less than its error, so it takes
            shorter horizons than a table. None: a fifth of an episode, two fifths where acceptance is to recur, from 20
            to 200, and 2000 where observations are numbered. 0: the parameters of the scheme as they are, as always
            where somebody has set them.
        initial_horizon: steps that are looked ahead in the first tenth of the training; until 70 % of it they become
            `horizon`, each time by the same factor. None: 100 at most where observations are numbered, else `horizon`.
            0: `horizon` from the beginning.
        trace_length: consecutive steps that are drawn together and through which targets go back as long as actions
            were greedy, >= 1; 1: steps are drawn one by one, and the loss is the square of the error (thesis). Longer
            than 1 needs `counterfactual`, heads and no batch normalisation, and is 1 without.
        trace_decay: part of what the next step is worth that comes from the segment, in [0, 1]; the rest is
            bootstrapped.
        advantage_learning: part, in [0, 0.9999], of what an action is behind the best one by which its target is
            lowered, so that errors of a network, small as they are, do not choose between actions; needs segments.
            Values of the best actions stay what they are, those of others become lower bounds. 0: none (thesis). None:
            0.95 where observations are numbered, since horizons are long there, and else 0.9.
        final_advantage_learning: the same at `total_steps`; in the second half, what distances are multiplied by grows
            to there. A large part keeps a policy as it is, for good and ill. None: 0.985 where observations are
            numbered and else 0.97, `advantage_learning` where that is more, and 0 where that is 0.
        temperature: the policy that is learned chooses with probability proportional to exp(output / temperature),
            without what is less than a thousandth as likely as the best action, >= 0. Where a network is wrong about
            what is nearly alike, the greedy policy may run in a circle for ever; this one leaves it, and since
            advantage learning keeps outputs apart, little is lost. 0, and where outputs are not squashed: the best
            action (thesis). None: 0.1; where observations are not numbered and episodes fail at that when the training
            is over, 0 and 0.3 are tried, too, in the training's environment, and the one that surely does better is
            taken. Each is tried for a fifth of `total_steps` at most, and these steps are not counted.
        ladder: sub-environment i of n explores with probability epsilon^(1 + ladder * i / (n - 1)), so that some follow
            the policy to where it leads and others stray, >= 0; 0: all with epsilon (thesis).
        persistence: in every second sub-environment an exploring action is kept for a random number of steps, n of them
            with probability about 1/n^2, at most so many: that goes somewhere where a step does little, and brings down
            what has to be kept in balance. 1: for one step everywhere (thesis).
        exploring_starts: part of the episodes, in [0, 1], in which a sub-environment acts as if the automaton had
            started in a random state, so that all parts of a task are practised; needs `counterfactual`. 0: none
            (thesis).
        action_repeat: steps for which an action is held while learning, >= 1. Values are then those of actions that are
            held, which differ more than those of single steps where a step does little; what is learned holds them,
            too, as `ltlc.envs.HeldActions` does. Needs segments, and is 1 without. None: a 250th of the steps after
            which random actions have brought half of the copies to an end of the world or a violation, or of an
            episode, from 1 to 4; and 1 where observations are numbered, actions are masked, episodes have no limit, or
            a tenth of `total_steps` is too few to try. 1: none (thesis).
        curiosity: part of the sub-environments, in [0, 1], that go where little was tried, counted by place, automaton
            state and action, as a second set of outputs has learned to; needs segments (`trace_length`). 0: none
            (thesis). None: 0.25 where observations are numbered, so that counts are exact, and else none.
        robustness: weight of the potential that values begin with, in [0, inf): in each automaton state how far it has
            come, and how near numbers are to the thresholds that it waits for (`ltlc.envs.robustness`); needs segments,
            and comparisons as propositions. It takes the place of rewards on the way; see `RobustEncoder`. 0: none.
        robustness_scale: margin at which a comparison counts as three quarters true and more, > 0.
        variables: where the names in comparisons stand in an observation, such as `x=0, speed=1`, for `robustness`.
        device: where the networks and the replay buffer live, such as `cpu`, `cuda`, `cuda:1`.

    Raises:
        InvalidArgumentError: a value is out of range, or two do not fit together.

    References:
        H. van Hasselt, A. Guez, D. Silver, Deep reinforcement learning with double Q-learning, AAAI 2016,
        https://doi.org/10.1609/aaai.v30i1.10295.
        N. Vieillard, O. Pietquin, M. Geist, Munchausen reinforcement learning, NeurIPS 2020,
        https://arxiv.org/abs/2007.14430 (what advantage learning and a temperature have to do with each other).
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
    layer_norm: bool = True
    waves: int = 64
    output: Output = "bounded"
    horizon: int | None = None
    initial_horizon: int | None = None

    double: bool = True
    counterfactual: bool = True
    optimizer: Optimizer = "adam"
    learning_rate: float = 1e-3
    final_learning_rate: float = 1e-5
    l2: float = 0.0
    max_gradient_norm: float | None = 10.0
    batch_size: int | None = None
    trace_length: int = 8
    trace_decay: float = 0.95
    advantage_learning: float | None = None
    final_advantage_learning: float | None = None
    temperature: float | None = None
    buffer_size: int = 1_000_000
    max_memory: float | None = None
    train_frequency: int | None = None
    gradient_steps: int = 1
    tau: float | None = None
    target_update_interval: int = 1
    averaging: float = 0.005
    ladder: float = 3.0
    persistence: int = 20
    exploring_starts: float = 0.5
    action_repeat: int | None = None

    curiosity: float | None = None
    robustness: float = 0.0
    robustness_scale: float = 1.0
    variables: str = ""
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
            "layer_norm": False, "max_gradient_norm": None, "train_frequency": 1, **_PLAIN,
        }  # fmt: skip
        return cls(**(values | changes))

    @classmethod
    def one_step(cls, num_envs: int, **changes: Any) -> DQNConfig:
        """Double Q-learning from single steps with plain outputs, an update for each round of so many environments.

        It is as good where rewards are dense and observations few, as in the worlds of the thesis.
        """
        values: dict[str, Any] = {
            "hidden": (256,), "layer_norm": False, "max_gradient_norm": None, "batch_size": 512,
            "train_frequency": num_envs, "tau": 0.1, **_PLAIN,
        }  # fmt: skip
        return cls(**(values | changes))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.hidden is not None:
            if not isinstance(self.hidden, list | tuple):
                raise InvalidArgumentError(f"hidden is {self.hidden!r}; it must be a list of whole numbers, or null")
            object.__setattr__(self, "hidden", tuple(self.hidden))
        check_values(self)
        for units in self.hidden or ():
            check_count("each entry of hidden", units, 1)
        if self.buffer_size < self.rows:
            raise InvalidArgumentError(f"buffer_size is {self.buffer_size}, less than batch_size ({self.rows})")
        if self.curiosity and (self.action_repeat or 1) > 1:
            raise InvalidArgumentError("curiosity counts single steps; set it to 0, or action_repeat to 1")
        for field in ("horizon", "initial_horizon"):
            if getattr(self, field) == 1:
                raise InvalidArgumentError(f"{field} is 1; it must be 0 (see there) or at least 2")
        if not isinstance(self.variables, str):
            raise InvalidArgumentError(f"variables is {self.variables!r}; it must be a text such as 'x=0, speed=1'")
        if self.robustness and not (self.traced and self.variables):
            raise InvalidArgumentError("robustness needs variables (such as 'x=0'), and a trace_length of at least 2")
        if self.batch_norm and self.rows < 2:
            raise InvalidArgumentError("batch_norm needs a batch_size of at least 2")

    @property
    def rows(self) -> int:
        """Actions in a batch."""
        return self.batch_size or _BATCH

    @property
    def traced(self) -> bool:
        """Whether segments of steps are learned from."""
        return self.trace_length > 1 and self.counterfactual and self.state_input == "heads" and not self.batch_norm

    @property
    def held(self) -> int:
        """Steps for which an action is held."""
        return (self.action_repeat or 1) if self.traced else 1

    @property
    def curious(self) -> bool:
        """Whether what little was tried is looked for."""
        return bool(self.curiosity) and self.traced

    def filled(self, *, numbered: bool, single: bool = False) -> DQNConfig:
        """Return the configuration with what depends on whether observations are numbered filled in.

        Args:
            numbered: whether they are.
            single: whether an action cannot be held, since they are, or since actions may be forbidden.

        Raises:
            InvalidArgumentError: it is to be held all the same.
        """
        if (numbered or single) and self.held > 1:
            raise InvalidArgumentError(
                "no actions are held where observations are numbered or actions are forbidden; set action_repeat to 1"
            )
        if numbered:
            tau, curiosity, first, last, rows = 0.1, 0.25, 0.95, 0.985, min(_NUMBERED_BATCH, self.buffer_size)
        else:
            tau, curiosity, first, last, rows = 0.005, 0.0, 0.9, 0.97, _BATCH
        first = first if self.advantage_learning is None else self.advantage_learning
        horizon = self.horizon or 0
        values = {
            "train_frequency": max(_LEAST_FREQUENCY, round(math.sqrt(self.total_steps * self.held / _UNHURRIED))),
            "batch_size": rows, "tau": tau, "curiosity": curiosity, "advantage_learning": first,
            "final_advantage_learning": max(first, last) if first else 0.0,
            "initial_horizon": min(_NEAR, horizon) if numbered else horizon,
            "action_repeat": 1 if numbered else None,
            "temperature": DRAWN if numbered else None,
        }  # fmt: skip
        left_open: dict[str, Any] = {name: value for name, value in values.items() if getattr(self, name) is None}
        return dataclasses.replace(self, **left_open)

    def horizon_at(self, steps: int) -> int:
        """Steps that the discount looks ahead after so many environment steps."""
        last = self.horizon or 0
        if not last or not self.initial_horizon:
            return last
        part = between(0.0, 1.0, (steps / self.total_steps - _GROWS[0]) / (_GROWS[1] - _GROWS[0]))
        return round(self.initial_horizon * math.pow(last / self.initial_horizon, int(_STAGES * part) / _STAGES))

    def advantage_learning_at(self, steps: int) -> float:
        """Part of what an action is behind by which its target is lowered, after so many environment steps."""
        first = self.advantage_learning or 0.0
        last = first if self.final_advantage_learning is None else self.final_advantage_learning
        return 1 - 1 / between(1 / (1 - first), 1 / (1 - last), 2 * steps / self.total_steps - 1)

    def learning_rate_at(self, steps: int) -> float:
        """Learning rate after so many environment steps."""
        return between(self.learning_rate, self.final_learning_rate, steps / self.total_steps)


_PLAIN: dict[str, Any] = {
    "waves": 0, "output": "linear", "horizon": 0, "trace_length": 1, "advantage_learning": 0.0, "temperature": 0.0,
    "ladder": 0.0, "persistence": 1, "exploring_starts": 0.0, "action_repeat": 1,
    "curiosity": 0.0,
}  # fmt: skip
"""without what has come since 2018."""
