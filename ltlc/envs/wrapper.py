"""A Gymnasium environment that knows how far a formula has come."""

from __future__ import annotations

import warnings
from typing import Any, Literal, NamedTuple, get_args

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import RecordConstructorArgs
from gymnasium.wrappers import Autoreset

from ltlc.automata import DFA, DRA
from ltlc.automata.finite import end_letter, spoken, spoken_letters
from ltlc.envs.action_masks import ActionMasks
from ltlc.envs.declared import task_in
from ltlc.envs.json_spec import with_clear_json
from ltlc.envs.labeller import labeller_for
from ltlc.envs.labels import ExtraLabels, LabelSource, importable
from ltlc.envs.letters import NamesOfLetters
from ltlc.envs.observation import ObservationMode, observer
from ltlc.envs.pair_actions import PairActionSpace
from ltlc.envs.random_streams import RandomStream
from ltlc.envs.success import Success
from ltlc.errors import InvalidArgumentError, RewardWarning, UnknownNameError, check_type
from ltlc.ltl import Formula
from ltlc.rewards.zeta_reach import ZetaReach
from ltlc.task import Task

BaseReward = Literal["replace", "add", "info"]
InitialLabel = Literal["read", "skip"]
FLAT_INFO = {
    "ltl_state": "state",
    "ltl_accepted": "accepting",
    "ltl_violated": "violated",
    "ltl_discount": "discount",
}
"""keys beside `info["ltl"]`, on request, and the entries of it that they repeat."""


class LTLWrapper(gym.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Runs the automaton of a task beside an environment, and pays the rewards of the task.

    The word of an episode is L(s0) L(s1) ...; the automaton reads the label of the first observation at `reset` and
    that of the state entered at each `step`. Each info has an entry "ltl" with

    * `state`: the state of the reward tables, after a deadlock has been dealt with (the automaton's own state is
      `task.tables.automaton_state[state]`; for most schemes they are the same);
    * `label`, `label_names`, `letter_class`: the letter read as its number (`DRA.letter`) and as the set of names that
      hold, and its class;
    * `reward`, `discount`: of the scheme, for this step; the discount is the weight of all that follows;
    * `violated`, `accepting`: whether the step entered a deadlock, or carries an acceptance mark;
    * `progress`: 1 on an accepting cycle, less the more letters away, 0 in a deadlock;
    * `base_reward`: the reward of the environment, if `reward="info"`;
    * `base_terminated`: after a step, whether the environment ended the episode, whatever the task did;
    * `valid`: only around a wrapper `Autoreset`, False where the step only began a new episode;
    * `success`: only if `success_key=True`, see below.

    Where the reward scheme leaves the choice of a Rabin pair to the policy, the environment has more actions: of n
    actions, a + n * (1 + i) chooses pair i and then does a. Not all of them exist all the time: `action_masks()` and
    `action_mask` in `info["ltl"]` say which do now. Masks of the environment itself, in `info["action_mask"]` or in an
    entry `action_mask` of its observation, are passed on in the same places.

    Reaching acceptance does not end the episode, except in an accepting sink or where the scheme says so. Where the
    environment ends it (`terminated`), the last reward includes what reading the last letter for ever is worth, unless
    the task says `on_termination="cut"`; nothing of value follows, so learners need not know.

    Args:
        env: the environment.
        task: a task, or a formula or automaton to make one of.
        labels: a function of (observation), (observation, info) or (observation, info, env), a dict of such
            predicates, the text `module:name` of either (which specs and pickles can hold), or None for
            `info["labels"]`; see `ltlc.envs.labels`.
        observation: how the state of the automaton joins the observation: `dict`, `flat`, `index`, `none`; see
            `ltlc.envs.observation.observer`.
        reward: what becomes of the environment's own reward: it is replaced (`replace`), the task's is added to it
            (`add`), or it is put into the info (`info`).
        initial_label: whether the label of the first observation is read (`read`) or not (`skip`, as the thesis does).
        extra_labels: whether labels that the formula does not mention are an error or ignored; no error are those
            that the function or the environment declares, or that a dict has besides all those of the formula.
        warn_discount: whether to warn, at the first reset, where the discount of the rewards is not the same at every
            step: say False where the agent weighs what follows a step by `info["ltl"]["discount"]`.
        success_key: whether infos have an entry `is_success`, as Stable-Baselines3 reads it: whether the word so far,
            continued by its last letter for ever, satisfies the formula. Where an episode is cut before its end, that
            decides formulas that finite words decide, and says little about others.
        flat_info: whether infos have the entries `ltl_state`, `ltl_accepted`, `ltl_violated` and `ltl_discount`, for
            readers that do not look into nested dicts.

    Warns:
        RewardWarning: see `warn_discount`.

    Attributes:
        stops: whether the task may end episodes; False while somebody looks at words alone, as a judge does.

    Raises:
        UnknownNameError: a label and the formula do not go together, or a mode does not exist.
        InvalidArgumentError: the observation mode does not work for this environment; its actions are not discrete
            and the task has choices; or `labels` cannot be imported or takes other arguments.
        LtlSyntaxError: the task is text that is not a formula.
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        task: Task | Formula | str | DRA | DFA,
        labels: LabelSource = None,
        *,
        observation: ObservationMode = "dict",
        reward: BaseReward = "replace",
        initial_label: InitialLabel = "read",
        extra_labels: ExtraLabels = "error",
        warn_discount: bool = True,
        success_key: bool = False,
        flat_info: bool = False,
    ) -> None:
        RecordConstructorArgs.__init__(
            self,
            task=str(task) if isinstance(task, Formula) else task,
            labels=importable(labels),
            observation=observation,
            reward=reward,
            initial_label=initial_label,
            extra_labels=extra_labels,
            warn_discount=warn_discount,
            success_key=success_key,
            flat_info=flat_info,
        )
        check_type(env, gym.Env, "env", "an environment of Gymnasium; LTLVectorWrapper takes vector environments")
        super().__init__(env)
        check_modes(reward, initial_label, extra_labels)
        self.task = task_in(env, task)
        tables = self.task.tables
        self.labels, self.warn_discount = labels, warn_discount
        self.stops = True
        numbers = spoken_letters(tables.aps, tables.possible)
        self.labeller = labeller_for(labels, spoken(tables.aps), env, extra_labels, numbers)
        self.observer = observer(observation, env.observation_space, tables.n_states)
        self.observation_space = self.observer.space
        self.choices = PairActionSpace(tables, env.action_space)
        if self.choices.active:
            self.action_space = self.choices.space
        self.masks = ActionMasks(env.observation_space, env.action_space)
        self._base_reward = reward
        self.initial_label, self._skip = initial_label, initial_label == "skip"
        self._classes: list[int] = tables.letter_class.tolist()
        self._n_classes = tables.n_classes
        self._rows: dict[int, _Row] = {}
        self._names = NamesOfLetters(tables.aps, tables.possible)
        self._end = end_letter(tables.aps, tables.letter_class)
        self._stream = RandomStream()
        self._state = tables.initial_state
        self._success = Success(self.task.automaton, self._skip) if success_key else None
        self._flat_info = flat_info
        self._tells_more = success_key or flat_info
        self._autoreset = _autoreset_within(env)

    @property
    def automaton_state(self) -> int:
        """The automaton's state after the last letter."""
        return int(self.task.tables.automaton_state[self._state])

    def action_masks(self) -> npt.NDArray[np.bool_]:
        """Which actions there are now, shape (n_actions,), as maskable agents ask for.

        Where the environment shows masks or has such a method of its own, only actions that it allows.

        Raises:
            InvalidArgumentError: the actions are not discrete.
        """
        if self.choices.mask is None:
            raise InvalidArgumentError(f"actions of {self.action_space} cannot be masked")
        mask: npt.NDArray[np.bool_] = self.choices.mask[self._state].copy()
        if self.env.has_wrapper_attr("action_masks"):
            inner = np.asarray(self.env.get_wrapper_attr("action_masks")(), dtype=np.bool_)
            mask &= np.tile(inner, len(mask) // len(inner))
        return self.masks.within(mask)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the automaton reads the label of the first observation."""
        if self.warn_discount:
            self.warn_discount = False
            warn_discount_varies(self.task)
        observation, info = self.env.reset(seed=seed, options=options)
        self._stream.seed(seed)
        return self._first(observation, info)

    def _first(self, observation: Any, info: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Read the first letter of an episode; the observation and info of a reset."""
        info = dict(info)
        self.masks.see(observation, info)
        letter = self.labeller.letter(observation, info)
        initial = self.task.tables.initial_state
        row = self._row(initial * self._n_classes + self._classes[letter])
        self._state = initial if self._skip else row.next_state
        ltl = {**row.info, "state": self._state, "label": letter, "reward": 0.0, "discount": 1.0}
        if self._skip:
            ltl |= {"violated": False, "accepting": False, "progress": float(self.task.tables.progress[initial])}
        if self._base_reward == "info":
            ltl["base_reward"] = 0.0
        if self.choices.active or self.masks.allowed is not None:
            ltl["action_mask"] = self.action_masks()
        if self._autoreset is not None:
            ltl["valid"] = False
        ltl["label_names"] = self._names[letter]
        info["ltl"] = ltl
        if self._tells_more:
            self._tell_more(info, ltl, letter, begun=True)
        return self.observer.single(observation, self._state), info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Step the environment, then the automaton with the label of the state entered.

        Raises:
            InvalidArgumentError: the action chooses a pair that cannot be chosen now.
        """
        if self._autoreset is not None and self._autoreset.autoreset:
            return self._begin_instead(action)
        if self.choices.active:
            action, self._state = self.choices.split(action, self._state)
        observation, base_reward, terminated, truncated, info = self.env.step(action)
        self.masks.see(observation, info)
        letter = self.labeller.letter(observation, info)
        if terminated:
            letter += self._end
        index = self._state * self._n_classes + self._classes[letter]
        self._state, reward, stop, stop_reward, final, entries = self._rows.get(index) or self._row(index)
        ltl = entries.copy()
        ltl["label"] = letter
        ltl["base_terminated"] = terminated
        if stop and self.stops and (stop == 1 or self._stream.draw() < stop):
            terminated = True
            reward += stop_reward
            ltl["reward"] = reward
            if self._autoreset is not None:
                self._autoreset.autoreset = True
        elif terminated:
            reward += final
            ltl["reward"] = reward
        if self._base_reward == "add":
            reward += float(base_reward)
        elif self._base_reward == "info":
            ltl["base_reward"] = float(base_reward)
        if self.choices.active or self.masks.allowed is not None:
            ltl["action_mask"] = self.action_masks()
        if self._autoreset is not None:
            ltl["valid"] = True
        ltl["label_names"] = self._names[letter]
        info["ltl"] = ltl
        if self._tells_more:
            self._tell_more(info, ltl, letter)
        return self.observer.single(observation, self._state), reward, terminated, truncated, info

    def _begin_instead(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """The step in which a wrapper `Autoreset` within begins a new episode, whatever the action."""
        if self.choices.active:
            action = int(action) % self.choices.n_base
        observation, base_reward, terminated, truncated, info = self.env.step(action)
        observation, info = self._first(observation, info)
        reward = float(base_reward) if self._base_reward == "add" else 0.0
        return observation, reward, terminated, truncated, info

    def _tell_more(self, info: dict[str, Any], ltl: dict[str, Any], letter: int, begun: bool = False) -> None:
        """Put into the info what was asked for beyond `info["ltl"]`."""
        if self._success is not None:
            ltl["success"] = bool(self._success.read(letter, begun))
            info["is_success"] = ltl["success"]
        if self._flat_info:
            info |= {key: ltl[entry] for key, entry in FLAT_INFO.items()}

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override]
        """What `gymnasium.make` makes this environment from, if that is known."""
        return with_clear_json(super().spec)

    def _row(self, index: int) -> _Row:
        """One entry of the reward tables as plain numbers, kept for the next time."""
        if index not in self._rows:
            tables = self.task.tables
            at = divmod(index, self._n_classes)
            next_state = int(tables.next_state[at])
            info = {
                "state": next_state,
                "label": 0,
                "letter_class": at[1],
                "reward": float(tables.reward[at]),
                "discount": float(tables.discount[at]),
                "violated": bool(tables.violated[at]),
                "accepting": bool(tables.accepted[at]),
                "progress": float(tables.progress[next_state]),
            }
            final = float(tables.discount[at] * tables.closing[next_state, at[1]])
            self._rows[index] = _Row(
                next_state, info["reward"], float(tables.stop[at]), float(tables.stop_reward[at]), final, info
            )
        return self._rows[index]


def _autoreset_within(env: gym.Env[Any, Any]) -> Autoreset[Any, Any] | None:
    """The outermost wrapper that begins new episodes by itself."""
    while isinstance(env, gym.Wrapper):
        if isinstance(env, Autoreset):
            return env
        env = env.env
    return None


class _Row(NamedTuple):
    next_state: int
    reward: float
    stop: float
    stop_reward: float
    final: float
    """paid on top where the environment ends the episode, and the task does not."""
    info: dict[str, Any]


def warn_discount_varies(task: Task) -> None:
    """Warn where an agent that knows one discount for all steps would learn something else than the task."""
    if task.discount is None:
        text = (
            f"the rewards {task.scheme.name!r} have a discount for each step, in info['ltl']['discount']; an agent "
            "that has one for all steps learns another task. Let it use that, and say warn_discount=False, or take "
            f"rewards without a discount, such as {ZetaReach.name!r}, and an agent with gamma = 1"
        )
        warnings.warn(RewardWarning(text), stacklevel=3)


def check_modes(reward: str, initial_label: str, extra_labels: str) -> None:
    """Check the modes that both wrappers have.

    Raises:
        UnknownNameError: one does not exist.
    """
    if reward not in get_args(BaseReward):
        raise UnknownNameError("treatment of the environment's reward", reward, get_args(BaseReward))
    if initial_label not in get_args(InitialLabel):
        raise UnknownNameError("treatment of the first label", initial_label, get_args(InitialLabel))
    if extra_labels not in get_args(ExtraLabels):
        raise UnknownNameError("treatment of extra labels", extra_labels, get_args(ExtraLabels))
