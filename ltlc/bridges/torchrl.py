"""TorchRL: a transform that runs the automata of a task beside any environment, one or a batch.

    env = TransformedEnv(GymEnv("CartPole-v1"), LTLTransform("G F right", {"right": lambda x: x[0] > 0.1}))

Losses that estimate values with one discount honour that of each step after `with_discounts`, which writes the entry
`steps_to_next_obs` that TD(0) estimators of TorchRL read.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ltlc.automata import DFA, DRA
from ltlc.automata.finite import spoken
from ltlc.envs.labeller import Labeller, labeller_for
from ltlc.envs.labels import LabelSource
from ltlc.envs.wrapper import warn_discount_varies
from ltlc.errors import InvalidArgumentError, MissingProgramError
from ltlc.ltl import Formula
from ltlc.task import Task

try:
    import torch
    from torchrl.data import Bounded, Categorical, OneHot, Unbounded
    from torchrl.envs.transforms import TensorDictPrimer, Transform
except ImportError as error:
    raise MissingProgramError.of_library("torchrl", "torchrl", error) from error

STATE, SHOWN, DISCOUNT = "automaton_state", "automaton", "discount"
"""entries that the transform adds: the table state, the same as one-hot numbers, and the weight of what follows."""


class LTLTransform(Transform):
    """Runs the automaton of a task beside each environment, and pays the rewards of the task.

    The automata read the label of the observation at a reset and after each step, as an `LTLWrapper` does. Each
    tensordict has

    * `automaton_state`: the state of the reward tables, int64, shape (*batch, 1);
    * `automaton`: the same as one-hot numbers, float32, shape (*batch, n_states), for networks;
    * `discount`, `ltl_violated`, `ltl_accepting`: of the last step, shape (*batch, 1);

    and the reward of the task in place of that of the environment, whose episodes it can end (`terminated`).

    Args:
        task: a task, or a formula or automaton to make one of. Its rewards must leave no choice to the policy.
        labels: of one observation, as an array, see `ltlc.envs.labels`; of other sources, use an `LTLWrapper` inside.
        observation: the entry that labels look at.
        initial_label: whether the label of the first observation is read ("read") or not ("skip").
        seed: of the draws by which a task ends episodes.
        warn_discount: whether to warn where the discount of the rewards is not the same at every step; say False where
            losses weigh by it, see `with_discounts`.

    Warns:
        RewardWarning: see `warn_discount`.

    Raises:
        InvalidArgumentError: the task leaves the choice of a Rabin pair to the policy.
        UnknownNameError: a label and the formula do not go together.
        LtlSyntaxError: the task is text that is not a formula.
    """

    def __init__(
        self,
        task: Task | Formula | str | DRA | DFA,
        labels: LabelSource,
        *,
        observation: str = "observation",
        initial_label: str = "read",
        seed: int = 0,
        warn_discount: bool = True,
    ) -> None:
        super().__init__(in_keys=[observation], out_keys=[STATE, SHOWN, DISCOUNT, "ltl_violated", "ltl_accepting"])
        self.task = task if isinstance(task, Task) else Task(task)
        tables = self.task.tables
        if tables.n_choices:
            raise InvalidArgumentError(
                "the task has a choice between Rabin pairs, which is no part of an action here; take the rewards "
                '"parity"'
            )
        if warn_discount:
            warn_discount_varies(self.task)
        self.n_states, self.skip = tables.n_states, initial_label == "skip"
        self._labeller: Labeller = labeller_for(labels, spoken(tables.aps), None)
        self._random = torch.Generator().manual_seed(seed)
        for name in ("next_state", "reward", "discount", "stop", "stop_reward", "violated", "accepted", "final_value"):
            self.register_buffer(f"table_{name}", torch.from_numpy(np.array(getattr(tables, name))), persistent=False)
        self.register_buffer("letter_class", torch.from_numpy(np.array(tables.letter_class)).long(), persistent=False)

    def make_tensordict_primer(self) -> Any:
        """A primer for the state of the automaton, for modules and collectors that ask for one."""
        spec = Categorical(self.n_states, shape=(1,), dtype=torch.int64)
        return TensorDictPrimer({STATE: spec}, default_value=float(self.task.tables.initial_state))

    def _letter_classes(self, observations: Any) -> Any:
        """The class of the letter of each observation, shape (*batch, 1)."""
        width = len(self.parent.base_env.observation_spec[self.in_keys[0]].shape) - len(self.parent.batch_size)
        batch = observations.shape[: observations.ndim - width]
        rows = observations.detach().cpu().reshape(-1, *observations.shape[len(batch) :]).numpy()
        letters = torch.tensor([self._labeller.letter(row, {}) for row in rows], device=observations.device)
        return self.letter_class[letters].reshape(*batch, 1)

    def _reset(self, tensordict: Any, tensordict_reset: Any) -> Any:
        reset = tensordict.get("_reset", None)
        classes = self._letter_classes(tensordict_reset.get(self.in_keys[0]))
        start = torch.full_like(classes, self.task.tables.initial_state)
        first = start if self.skip else self.table_next_state[start, classes].long()
        before = tensordict.get(STATE, None)
        if reset is not None and before is not None:
            first = torch.where(reset.reshape(first.shape), first, before)
        self._show(tensordict_reset, first)
        nothing = torch.zeros_like(first, dtype=torch.bool)
        tensordict_reset.update({DISCOUNT: torch.ones_like(first, dtype=torch.float32), "ltl_violated": nothing,
                                 "ltl_accepting": nothing.clone()})  # fmt: skip
        return tensordict_reset

    def _step(self, tensordict: Any, next_tensordict: Any) -> Any:
        state = tensordict.get(STATE)
        at = state, self._letter_classes(next_tensordict.get(self.in_keys[0]))
        terminated = next_tensordict.get("terminated")
        chance = self.table_stop[at]
        drawn = torch.rand(chance.shape, generator=self._random, dtype=torch.float64).to(chance.device)
        stops = drawn < chance
        reward = self.table_reward[at] + stops * self.table_stop_reward[at]
        reward += (terminated & ~stops) * self.table_discount[at] * self.table_final_value[at]
        self._show(next_tensordict, self.table_next_state[at].long())
        next_tensordict.update({
            "reward": reward.to(torch.float32),
            DISCOUNT: self.table_discount[at].to(torch.float32),
            "ltl_violated": self.table_violated[at],
            "ltl_accepting": self.table_accepted[at],
            "terminated": terminated | stops,
            "done": next_tensordict.get("done") | stops,
        })  # fmt: skip
        return next_tensordict

    def _show(self, tensordict: Any, state: Any) -> None:
        shown = torch.nn.functional.one_hot(state.squeeze(-1), self.n_states).to(torch.float32)
        tensordict.update({STATE: state, SHOWN: shown})

    def transform_observation_spec(self, observation_spec: Any) -> Any:
        """Add the specs of what the transform adds."""
        batch = self.parent.batch_size
        observation_spec[STATE] = Categorical(self.n_states, shape=(*batch, 1), dtype=torch.int64)
        observation_spec[SHOWN] = OneHot(self.n_states, shape=(*batch, self.n_states), dtype=torch.float32)
        observation_spec[DISCOUNT] = Bounded(0, 1, shape=(*batch, 1), dtype=torch.float32)
        for name in ("ltl_violated", "ltl_accepting"):
            observation_spec[name] = Categorical(2, shape=(*batch, 1), dtype=torch.bool)
        return observation_spec

    def transform_input_spec(self, input_spec: Any) -> Any:
        """Say that steps need the state of the automaton, and that resets of some of a batch leave the others alone."""
        batch = self.parent.batch_size
        spec = Categorical(self.n_states, shape=(*batch, 1), dtype=torch.int64)
        input_spec["full_state_spec", STATE] = spec
        return input_spec

    def transform_reward_spec(self, reward_spec: Any) -> Any:
        """Rewards are those of the task."""
        reward_spec["reward"] = Unbounded(shape=(*self.parent.batch_size, 1), dtype=torch.float32)
        return reward_spec


def with_discounts(tensordict: Any, gamma: float) -> Any:
    """Let TD(0) estimators with the discount `gamma` weigh what follows a step by the discount of the step.

    They take gamma ** `steps_to_next_obs`, which is set so that it is the discount of the step.

    Args:
        tensordict: of steps, such as a sample of a replay buffer; changed in place.
        gamma: of the estimator, in (0, 1).

    Returns:
        The tensordict.

    Raises:
        InvalidArgumentError: gamma is 0 or 1, of which no power is anything else.
    """
    if not 0 < gamma < 1:
        raise InvalidArgumentError(f"gamma is {gamma}; give the estimator one between 0 and 1, such as 0.99")
    discount = tensordict.get(("next", DISCOUNT)).clamp(min=1e-12)
    return tensordict.set("steps_to_next_obs", discount.log() / math.log(gamma))
