"""The vector wrapper: one automaton per sub-environment, all stepped by the same few array look-ups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

from ltlc.automata import DFA, DRA
from ltlc.automata.finite import end_letter, spoken_letters
from ltlc.envs.action_masks import ActionMasks
from ltlc.envs.batch import AnyVectorWrapper, copied, merge, part
from ltlc.envs.declared import task_in
from ltlc.envs.flat_tables import FlatTables
from ltlc.envs.labeller import VectorLabeller
from ltlc.envs.labels import ExtraLabels, LabelSource
from ltlc.envs.letters import LabelNames
from ltlc.envs.observation import ObservationMode, observer
from ltlc.envs.pair_actions import PairActionSpace
from ltlc.envs.random_streams import RandomStreams
from ltlc.envs.success import Success
from ltlc.envs.wrapper import FLAT_INFO, BaseReward, InitialLabel, check_modes, warn_discount_varies
from ltlc.errors import InvalidArgumentError, check_type
from ltlc.ltl import Formula
from ltlc.task import Task

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


class LTLVectorWrapper(AnyVectorWrapper):
    """`LTLWrapper` for a vector environment: equal to wrapping every sub-environment, without a loop over automata.

    `infos["ltl"]` holds an array per entry; the sets of names in `label_names` are made when they are looked at. It has
    two entries more: `valid`, False where this step only began a new episode (autoreset mode NEXT_STEP), so that replay
    can skip it; and, after a step, `base_terminated`, whether the environment ended the episode, whatever the task
    does, so that replay can teach other automaton states. In mode SAME_STEP the entries of a finished sub-environment
    are those of its new episode, and `infos["final_info"]["ltl"]` has those of its last step, to go with
    `infos["final_obs"]`.

    Where the task itself ends an episode, the sub-environment begins a new one when the autoreset mode says so:
    Gymnasium's SyncVectorEnv and AsyncVectorEnv can do so, and so can any vector environment that knows `reset_mask`
    and has a method `begin_episode(mask)`, like `VectorGridWorld`. An AsyncVectorEnv in mode NEXT_STEP makes one step
    too many there, of which nothing is seen but the random numbers it takes. Vector wrappers that keep statistics of
    episodes belong outside of this one.

    Args:
        env: the vector environment.
        task: see `LTLWrapper`.
        labels: see `LTLWrapper`; functions and predicates are called with the observation of each sub-environment in
            turn, and with its info, a read-only mapping. The sub-environment itself can be had from SyncVectorEnv.
        batch_labels: in place of `labels`, and faster: a function of (observations) or (observations, infos) of many
            sub-environments at once, a dict of such predicates, or the text `module:name` of either. Labels come as an
            array of bitmasks or of event strings, a boolean array with a column per name, a dict from name to boolean
            array, or a sequence of single labels. It is not always the whole batch that is labelled.
        observation: see `LTLWrapper`.
        reward: see `LTLWrapper`.
        initial_label: see `LTLWrapper`.
        extra_labels: see `LTLWrapper`.
        warn_discount: see `LTLWrapper`; the bundled agents use the discounts, and nothing is said where they learn.
        success_key: see `LTLWrapper`; in mode SAME_STEP the last word of an episode is told in `infos["final_info"]`.
        flat_info: see `LTLWrapper`.

    Raises:
        UnknownNameError: see `LTLWrapper`.
        InvalidArgumentError: see `LTLWrapper`; `labels` and `batch_labels` are both given; or the task can end
            episodes, and this kind of vector environment cannot reset single sub-environments.
    """

    def __init__(
        self,
        env: VectorEnv[Any, Any, Any],
        task: Task | Formula | str | DRA | DFA,
        labels: LabelSource = None,
        *,
        batch_labels: LabelSource = None,
        observation: ObservationMode = "dict",
        reward: BaseReward = "replace",
        initial_label: InitialLabel = "read",
        extra_labels: ExtraLabels = "error",
        warn_discount: bool = True,
        success_key: bool = False,
        flat_info: bool = False,
    ) -> None:
        check_type(env, VectorEnv, "env", "a vector environment of Gymnasium; LTLWrapper takes single environments")
        super().__init__(env)
        check_modes(reward, initial_label, extra_labels)
        self.task = task_in(env, task)
        tables = self.task.tables
        self.labels, self.batch_labels, self.initial_label = labels, batch_labels, initial_label
        self.autoreset_mode = AutoresetMode(env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP))
        own, self.warn_discount = spoken_letters(tables.aps, tables.possible), warn_discount
        self.labeller = VectorLabeller(labels, batch_labels, env, extra_labels, self.autoreset_mode, own)
        self.observer = observer(observation, env.single_observation_space, tables.n_states)
        self.single_observation_space = self.observer.space
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self.observation_mode = observation
        self.choices = PairActionSpace(tables, env.single_action_space)
        if self.choices.active:
            self.single_action_space = self.choices.space
            self.action_space = batch_space(self.single_action_space, env.num_envs)
        self.masks = ActionMasks(env.single_observation_space, env.single_action_space, env.num_envs)
        self._base_reward, self._flat_info, self._end = reward, flat_info, end_letter(tables.aps, tables.letter_class)
        self._tables = FlatTables(tables, skip=initial_label == "skip")
        base = env.unwrapped
        resettable = isinstance(base, SyncVectorEnv | AsyncVectorEnv) or hasattr(base, "begin_episode")
        if self._tables.can_stop and not resettable:
            raise InvalidArgumentError(
                f"the task can end episodes, but {type(base).__name__} cannot reset single sub-environments "
                '(it has no method begin_episode); make it with vectorization_mode="sync", or use a scheme and an '
                "on_deadlock that end none"
            )
        n = env.num_envs
        self._streams = RandomStreams(n)
        self._state = np.full(n, tables.initial_state, dtype=np.int64)
        self._finished, self._any_finished = np.zeros(n, dtype=np.bool_), False
        self._restart_late: BoolArray | None = None
        self._everywhere = np.ones(n, dtype=np.bool_)
        self._success = Success(self.task.automaton, initial_label == "skip") if success_key else None

    @property
    def automaton_state(self) -> IntArray:
        """The automata's states after the last letter, shape (num_envs,)."""
        return self.task.tables.automaton_state[self._state].astype(np.int64)

    def action_masks(self) -> BoolArray:
        """Which actions there are now, and are allowed where the environment shows masks, shape (num_envs, n_actions).

        Raises:
            InvalidArgumentError: the actions are not discrete.
        """
        if self.choices.mask is None:
            raise InvalidArgumentError(f"actions of {self.single_action_space} cannot be masked")
        return self.masks.within(np.asarray(self.choices.mask[self._state]))

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin episodes in all sub-environments, or in those of the boolean array `options["reset_mask"]`."""
        if self.warn_discount:
            self.warn_discount = False
            warn_discount_varies(self.task)
        mask = (options or {}).get("reset_mask", self._everywhere)
        observations, infos = self.env.reset(seed=seed, options=None if options is None else dict(options))  # type: ignore[arg-type]
        self._streams.seed(seed)
        self.masks.see(observations, infos, mask)
        ltl = self._begin(self.labeller.of(observations, infos, mask), mask)
        self._finished = self._finished & ~mask
        self._any_finished = bool(self._finished.any())
        if self._restart_late is not None:
            late = self._restart_late & ~mask
            self._restart_late = late if late.any() else None
        ltl["valid"] = ~mask
        self._tell(infos, ltl, mask)
        return self.observer.batch(observations, self._state.copy()), infos

    def step(self, actions: Any) -> tuple[Any, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Step all sub-environments and automata.

        Raises:
            InvalidArgumentError: in mode DISABLED, a sub-environment whose episode is over was not reset; or an action
                chooses a pair that cannot be chosen now.
        """
        if self._any_finished and self.autoreset_mode == AutoresetMode.DISABLED:
            raise InvalidArgumentError(
                f"the episodes of sub-environments {np.flatnonzero(self._finished).tolist()} are over; autoreset is "
                'disabled, so reset them with options={"reset_mask": ...}'
            )
        if self.choices.active:
            actions, self._state = self.choices.split_all(actions, self._state, ~self._finished)
        observations, base_rewards, terminated, truncated, infos = self.env.step(actions)
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            return self._finish_same_step(observations, base_rewards, terminated, truncated, infos)
        begun = self._finished if self._any_finished else None
        if self._restart_late is not None:
            late, self._restart_late = self._restart_late, None
            terminated, truncated = terminated & ~late, truncated & ~late
            observations = self._restart(late, base_rewards, infos)
        self.masks.see(observations, infos)
        letters = self.labeller.of(observations, infos)
        base_terminated = terminated.copy()
        ltl, stops = self._read(letters, begun, terminated)
        if stops is not None:
            self._schedule(stops & ~(terminated | truncated))
            terminated = terminated | stops
        self._finished = terminated | truncated
        self._any_finished = bool(self._finished.any())
        ltl["valid"] = self._everywhere.copy() if begun is None else ~begun
        ltl["base_terminated"] = base_terminated
        rewards = self._rewards(ltl, base_rewards)
        self._tell(infos, ltl, self._everywhere)
        return self.observer.batch(observations, self._state.copy()), rewards, terminated, truncated, infos

    def _begin(self, letters: IntArray, mask: BoolArray) -> dict[str, Any]:
        """Put the masked automata at the start of an episode; returns the info of a reset (right where masked)."""
        before, word = self._state, None if self._success is None else self._success.state
        ltl, _ = self._read(letters, self._everywhere)
        self._state = np.where(mask, self._state, before)
        if self._success is not None:
            self._success.state = np.where(mask, self._success.state, word)
        ltl["state"] = self._state.copy()
        if self._base_reward == "info":
            ltl["base_reward"] = np.zeros(self.num_envs)
        if self.choices.active or self.masks.allowed is not None:
            ltl["action_mask"] = self.action_masks()
        return ltl

    def _read(
        self, letters: IntArray, begun: BoolArray | None = None, terminated: BoolArray | None = None
    ) -> tuple[dict[str, Any], BoolArray | None]:
        """One letter for all automata, the first one where an episode has begun: infos, and which episodes end.

        `terminated` says where the environment ended its episode.
        """
        tables = self._tables
        if self._end and terminated is not None:
            letters = letters + self._end * terminated
        classes = tables.letter_class.take(letters)
        state = self._state if begun is None else np.where(begun, tables.before_episode, self._state)
        index = state * tables.n_classes
        index += classes
        self._state = tables.next_state.take(index)
        reward = tables.reward.take(index)
        stops = None
        if tables.can_stop:
            stops = tables.surely.take(index)
            if tables.by_chance is not None:
                chance = tables.by_chance.take(index)
                drawn = chance > 0
                if drawn.any():
                    stops[drawn] = self._streams.draw(drawn) < chance[drawn]
            if tables.stop_pays:
                reward += np.where(stops, tables.stop_reward.take(index), 0.0)
        if terminated is not None and terminated.any():
            over = terminated if stops is None else terminated & ~stops
            reward += np.where(over, tables.final.take(index), 0.0)
        ltl = {
            "state": self._state.copy(),
            "label": letters,
            "letter_class": classes,
            "reward": reward,
            "discount": tables.discount.take(index),
            "violated": tables.violated.take(index),
            "accepting": tables.accepted.take(index),
            "progress": tables.progress.take(self._state),
        }
        if self._success is not None:
            ltl["success"] = self._success.read(letters, False if begun is None else begun)
        if self.choices.active or self.masks.allowed is not None:
            ltl["action_mask"] = self.action_masks()
        return ltl, stops

    def _tell(self, infos: dict[str, Any], ltl: dict[str, Any], mask: BoolArray) -> None:
        """Put what the automata say into the infos; the mask says where it is so."""
        ltl["label_names"] = LabelNames(self.task.aps, ltl["label"], self.task.tables.possible)
        infos["ltl"], infos["_ltl"] = ltl, mask.copy()
        if self._success is not None:
            infos["is_success"], infos["_is_success"] = ltl["success"].copy(), mask.copy()
        if self._flat_info:
            for key, entry in FLAT_INFO.items():
                infos[key], infos[f"_{key}"] = ltl[entry].copy(), mask.copy()

    @property
    def adds_base_reward(self) -> bool:
        """Whether the environment's own rewards are paid on top of those of the task."""
        return self._base_reward == "add"

    def _rewards(self, ltl: dict[str, Any], base_rewards: FloatArray) -> FloatArray:
        if self._base_reward == "add":
            return np.asarray(ltl["reward"] + base_rewards)
        if self._base_reward == "info":
            ltl["base_reward"] = np.asarray(base_rewards, dtype=np.float64)
        return np.asarray(ltl["reward"].copy())

    def _schedule(self, mask: BoolArray) -> None:
        """Tell the environment that the task ended these episodes (modes NEXT_STEP and DISABLED)."""
        if self.autoreset_mode == AutoresetMode.DISABLED or not mask.any():
            return
        base = self.env.unwrapped
        if isinstance(base, SyncVectorEnv):
            base._autoreset_envs |= mask  # the only door there is to a reset at the next step
        elif isinstance(base, AsyncVectorEnv):
            self._restart_late = mask.copy()
        else:
            base.begin_episode(mask)  # type: ignore[attr-defined]

    def _restart(self, late: BoolArray, base_rewards: FloatArray, infos: dict[str, Any]) -> Any:
        """Reset sub-environments in processes of their own, which have just made one step too many: observations."""
        observations, new_infos = self.env.reset(options={"reset_mask": late.copy()})
        merge(infos, new_infos, late)
        base_rewards[late] = 0
        return observations

    def _finish_same_step(
        self,
        observations: Any,
        base_rewards: FloatArray,
        terminated: BoolArray,
        truncated: BoolArray,
        infos: dict[str, Any],
    ) -> tuple[Any, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """`step` from where the environment has been stepped, in mode SAME_STEP."""
        ended = np.asarray(infos.get("_final_obs", np.zeros(self.num_envs, dtype=np.bool_)))
        self.masks.see(observations, infos)
        if ended.any():
            self.masks.see_last(infos, ended)
            letters = self.labeller.of(observations, infos, ~ended)
            letters += self.labeller.of_final(infos["final_obs"], infos["final_info"], ended)
        else:
            letters = self.labeller.of(observations, infos)
        ltl, stops = self._read(letters, terminated=terminated)
        rewards = self._rewards(ltl, base_rewards)
        ltl["valid"] = self._everywhere.copy()
        ltl["base_terminated"] = terminated.copy()
        done = terminated | truncated if stops is None else terminated | truncated | stops
        if stops is not None:
            terminated = terminated | stops
        if done.any():
            observations = self._final(observations, infos, ltl, ended, done)
        self._tell(infos, ltl, self._everywhere)
        return self.observer.batch(observations, self._state.copy()), rewards, terminated, truncated, infos

    def _final(
        self, observations: Any, infos: dict[str, Any], ltl: dict[str, Any], ended: BoolArray, done: BoolArray
    ) -> Any:
        """Move what belongs to the last steps into final_obs and final_info, and begin the new episodes."""
        final_obs = infos.get("final_obs", np.full(self.num_envs, None, dtype=object))
        final_info = infos.get("final_info", {})
        by_task = done & ~ended
        if by_task.any():
            for i in np.flatnonzero(by_task):  # an object array can only be filled one by one
                final_obs[i] = copied(part(self.env.single_observation_space, observations, i))
            own = {key: value for key, value in infos.items() if not key.lstrip("_").startswith("final_")}
            merge(final_info, copied(own), by_task)
            observations, new_infos = self.env.reset(options={"reset_mask": by_task.copy()})
            merge(infos, new_infos, by_task)
        for i in np.flatnonzero(done):
            final_obs[i] = self.observer.single(final_obs[i], int(self._state[i]))
        self._tell(final_info, {key: column.copy() for key, column in ltl.items()}, done)
        infos["final_obs"], infos["_final_obs"] = final_obs, done.copy()
        infos["final_info"], infos["_final_info"] = final_info, done.copy()
        self.masks.see(observations, infos)
        for key, column in self._begin(self.labeller.of(observations, infos, done), done).items():
            ltl[key][done] = column[done]
        return observations
