"""Steps of a vector environment, made ready for the replay buffer: whatever the autoreset mode, nothing bogus."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.vector.utils import concatenate, create_empty_array

from ltlc.envs import HeldActions, LTLVectorWrapper
from ltlc.envs.action_masks import MASK
from ltlc.errors import InvalidArgumentError
from ltlc.graph import bits
from ltlc.rewards import RewardTables

from ..agent import Agent
from ..encoder import ObservationEncoder, without_texts
from ..transitions import TransitionBatch
from .contents import Content
from .shortcomings import Seen

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Episode:
    """An episode that ended while collecting."""

    reward: float
    """sum of the rewards paid, undiscounted."""
    length: int
    """steps."""
    violations: int
    """steps that entered a deadlock of the automaton."""
    acceptances: int
    """steps that carried an acceptance mark."""


@dataclass(frozen=True)
class Interface:
    """What an agent sees of a vector environment: base observations, automaton states, reward tables."""

    env: VectorEnv[Any, Any, Any]
    wrapper: LTLVectorWrapper | None
    """the wrapper that adds the automaton, or None for an environment that pays its own rewards."""
    space: spaces.Space[Any]
    """of a single observation, without the automaton."""
    n_actions: int
    """of the environment, without the choices of the task."""
    autoreset_mode: AutoresetMode
    masked: bool = False
    """whether masks come with the infos; then they are an entry `action_mask` of `space`, beside `observation`."""

    @classmethod
    def of(cls, env: VectorEnv[Any, Any, Any]) -> Interface:
        """The interface of an environment, with or without a `LTLVectorWrapper` in its chain of wrappers.

        Raises:
            InvalidArgumentError: it is no vector environment, or its actions are not discrete from 0.
        """
        if not isinstance(env, VectorEnv):
            raise InvalidArgumentError(
                f"{type(env).__name__} is no vector environment; make one with gymnasium.make_vec(id, num_envs=16), "
                "and put ltlc.LTLVectorWrapper around it"
            )
        actions = env.single_action_space
        if not isinstance(actions, spaces.Discrete) or actions.start != 0:
            advice = (
                "; make them discrete before the task is wrapped around it: "
                "env = ltlc.envs.DiscretisedVectorActions(env, 5)"
            )
            raise InvalidArgumentError(
                f"the agent needs discrete actions from 0; this environment has {actions}"
                f"{advice if isinstance(actions, spaces.Box) else ''}"
            )
        wrapper: Any = env
        while isinstance(wrapper, VectorWrapper) and not isinstance(wrapper, LTLVectorWrapper):
            wrapper = wrapper.env
        wrapper = wrapper if isinstance(wrapper, LTLVectorWrapper) else None
        space = env.single_observation_space
        if wrapper is not None:
            wrapper.warn_discount = False  # replay keeps the discount of each step
            space = _base_space(wrapper, space)
        n_actions = int(actions.n) // (1 if wrapper is None else 1 + wrapper.task.tables.n_choices)
        mode = AutoresetMode(env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP))
        space = without_texts(space)
        masked = wrapper is not None and wrapper.masks.shown_by(wrapper.env) and not wrapper.masks.observed
        if masked:
            space = spaces.Dict({"observation": space, MASK: spaces.MultiBinary(n_actions)})
        return cls(env, wrapper, space, n_actions, mode, masked)

    @property
    def tables(self) -> RewardTables | None:
        """Reward tables of the task, or None without one."""
        return None if self.wrapper is None else self.wrapper.task.tables

    @property
    def episode_steps(self) -> int | None:
        """Steps after which episodes are cut; None where the environment does not say."""
        env: Any = self.env
        while True:
            limit = next((limit for limit in _limits(env) if isinstance(limit, int)), None)
            if limit is not None or not isinstance(env, VectorWrapper):
                return limit
            env = env.env

    def base(self, observations: Any) -> Any:
        """The part of a batch of observations (or of one) that is not the automaton."""
        if self.wrapper is None:
            return observations
        n_states = self.wrapper.task.tables.n_states
        match self.wrapper.observation_mode:
            case "dict":
                return observations["observation"]
            case "flat":
                return observations[..., :-n_states]
            case "index":
                return observations // n_states
        return observations


def _limits(env: VectorEnv[Any, Any, Any]) -> Iterator[Any]:
    """What says after how many steps episodes are cut, the surest first."""
    yield getattr(env, "max_episode_steps", None)
    for one in getattr(env, "envs", ())[:1]:
        if isinstance(one, gym.Env) and one.has_wrapper_attr("_max_episode_steps"):  # of Gymnasium's TimeLimit
            yield one.get_wrapper_attr("_max_episode_steps")
    spec = getattr(env, "spec", None)
    yield getattr(spec, "kwargs", {}).get("max_episode_steps")  # asked for; the spec itself is as it was registered
    yield getattr(spec, "max_episode_steps", None)


def _base_space(wrapper: LTLVectorWrapper, space: spaces.Space[Any]) -> spaces.Space[Any]:
    n_states = wrapper.task.tables.n_states
    match wrapper.observation_mode:
        case "dict":
            assert isinstance(space, spaces.Dict)
            return space["observation"]
        case "flat":
            assert isinstance(space, spaces.Box)
            return spaces.Box(space.low[:-n_states], space.high[:-n_states], dtype=space.dtype)
        case "index":
            assert isinstance(space, spaces.Discrete)
            return spaces.Discrete(int(space.n) // n_states)
    return space


class Collector:
    """Steps a vector environment and keeps what belongs to each step together.

    Args:
        interface: of the environment.
        encoder: of its observations.

    Attributes:
        packed: current observations, shape (num_envs, width).
        states: current table states, shape (num_envs,).
        episodes: how many have ended.
        accepting_steps: how many steps carried an acceptance mark.
        letters: union of all labels read, as a bitmask.
        classes: letter classes of all labels read.
    """

    def __init__(self, interface: Interface, encoder: ObservationEncoder) -> None:
        self.interface, self.encoder = interface, encoder
        n = interface.env.num_envs
        self.packed: npt.NDArray[Any] = np.zeros((n, encoder.width), dtype=encoder.dtype)
        self.states = np.zeros(n, dtype=np.int64)
        self._held = HeldActions(1, interface.n_actions)
        self._ended: list[tuple[int, Episode]] = []
        self._totals = np.zeros((4, n))
        self._done = np.zeros(n, dtype=np.bool_)
        self.episodes = self.accepting_steps = self.letters = 0
        self.classes: set[int] = set()

    @property
    def seen(self) -> Seen:
        """What all steps came across; without a task nothing is accepting or not."""
        wrapper = self.interface.wrapper
        if wrapper is None:
            return Seen(len(self.packed), self.episodes, accepting=True, accepting_elsewhere=True)
        never = tuple(name for i, name in enumerate(wrapper.task.aps) if not self.letters >> i & 1)
        elsewhere = _can_accept(wrapper.task.tables, self.classes)
        return Seen(len(self.packed), self.episodes, self.accepting_steps > 0, elsewhere, never)

    def seen_state(self) -> list[Any]:
        """What `seen` follows from, as plain values."""
        # Files hold numbers of 63 bits at most.
        letters = self.letters if self.letters.bit_length() < 63 else bits(self.letters)
        return [self.episodes, self.accepting_steps, letters, sorted(self.classes)]

    def load_seen_state(self, state: Content, n_classes: int) -> None:
        """Check what `seen_state` gave, read from a file, and go back to it.

        Raises:
            FileFormatError: it is something else.
        """
        episodes, accepting_steps, letters, classes = state.entries(4)
        read = {entry.count(most=n_classes - 1) for entry in classes.entries()}
        is_list = isinstance(letters.value, list | tuple)
        seen = sum(1 << entry.count(most=1 << 16) for entry in letters.entries()) if is_list else letters.count()
        self.episodes, self.accepting_steps, self.letters, self.classes = (
            episodes.count(), accepting_steps.count(), seen, read
        )  # fmt: skip

    def reset(self, seed: int) -> None:
        """Begin new episodes everywhere; those under way are dropped.

        Raises:
            InvalidArgumentError: an automaton is stepped by the sub-environments, where the agent cannot see it.
        """
        observations, infos = self.interface.env.reset(seed=seed)
        if self.interface.wrapper is None and "ltl" in infos:
            raise InvalidArgumentError(
                "the sub-environments are wrapped in LTLWrapper; put LTLVectorWrapper around them all instead"
            )
        self._see(observations, infos)
        self._totals[:] = 0
        self._done[:] = False
        self._held.clear()

    def step(self, actions: npt.NDArray[np.int64]) -> TransitionBatch:
        """Carry out one action in each sub-environment; the rows of those that only began an episode are left out."""
        env, mode = self.interface.env, self.interface.autoreset_mode
        packed = self.packed
        states, taken = self._split(np.asarray(actions, dtype=np.int64))
        observations, rewards, terminated, truncated, infos = env.step(actions)
        begun = self._done if mode == AutoresetMode.NEXT_STEP else np.zeros_like(self._done)
        done = (terminated | truncated) & ~begun
        self._see(observations, infos)
        ltl = self._ltl(infos, terminated)
        rewards = rewards - ltl.get("shaping", 0.0)  # what is learned are the rewards of the task
        arrived = self.packed
        if mode == AutoresetMode.SAME_STEP and done.any():
            arrived = self.packed.copy()
            arrived[done] = self._final(infos, done)
            ltl = _of_last_step(ltl, infos, done)
        base_reward = np.asarray(rewards, dtype=np.float64) - ltl["reward"]
        self._count(rewards, ltl, begun, done)
        self._done = done
        if mode == AutoresetMode.DISABLED and done.any():
            self._see(*env.reset(options={"reset_mask": done.copy()}))
        real = ~begun
        return TransitionBatch(
            observation=packed[real],
            state=states[real],
            action=taken[real],
            letter_class=ltl["letter_class"][real],
            base_reward=base_reward[real],
            terminated=ltl["base_terminated"][real],
            next_observation=arrived[real],
            copy=np.flatnonzero(real),
            ended=done[real],
        )

    def follow(self, agent: Agent) -> TransitionBatch:
        """Carry out what an agent's policy chooses in each sub-environment; actions are held as long as it says."""
        if self._held.repeat != agent.action_repeat:
            self._held = HeldActions(agent.action_repeat, agent.n_actions)
        deciding = self._held.deciding(len(self.packed))
        chosen = np.zeros(len(deciding), dtype=np.int64)
        if deciding.any():
            chosen[deciding] = agent.packed_policy(self.packed[deciding], self.states[deciding])
        steps = self.step(self._held.keep(chosen, deciding))
        self._held.advance(steps.copy, steps.ended)
        return steps

    def _split(self, actions: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """The table states after the choices in the actions, and what the environment is asked to do."""
        tables = self.interface.tables
        if tables is None or not tables.n_choices:
            return self.states, actions
        choice, taken = np.divmod(actions, self.interface.n_actions)
        chosen = tables.select_pair[self.states, np.maximum(choice - 1, 0)]
        return np.where(choice > 0, chosen, self.states).astype(np.int64), taken

    def take_episodes(self) -> list[tuple[int, Episode]]:
        """The episodes that ended since the last call, each with the number of its sub-environment."""
        ended, self._ended = self._ended, []
        return ended

    def _see(self, observations: Any, infos: dict[str, Any]) -> None:
        base = self.interface.base(observations)
        if self.interface.masked and self.interface.wrapper is not None:
            base = {"observation": base, MASK: self.interface.wrapper.masks.allowed}
        self.packed = self.encoder.pack(base)
        if self.interface.wrapper is not None:
            self.states = np.asarray(infos["ltl"]["state"], dtype=np.int64)
            labels = infos["ltl"]["label"]
            numbers = self.interface.wrapper.task.automaton.letter_numbers
            self.letters |= int(np.bitwise_or.reduce(numbers.masks(labels)))
            self.classes.update(self.interface.wrapper.task.tables.letter_class[labels].tolist())

    def _ltl(self, infos: dict[str, Any], terminated: BoolArray) -> dict[str, Any]:
        if self.interface.wrapper is not None:
            return infos["ltl"]  # type: ignore[no-any-return]
        n = len(terminated)
        nothing = np.zeros(n, dtype=np.bool_)
        return {"reward": np.zeros(n), "letter_class": np.zeros(n, dtype=np.int64), "violated": nothing,
                "accepting": nothing, "base_terminated": terminated}  # fmt: skip

    def _final(self, infos: dict[str, Any], done: BoolArray) -> npt.NDArray[Any]:
        """Packed last observations of the episodes that ended, mode SAME_STEP."""
        each = [self.interface.base(infos["final_obs"][i]) for i in np.flatnonzero(done)]
        space = self.interface.space
        if self.interface.masked:
            masks = infos["final_info"].get(MASK, np.ones((len(done), self.interface.n_actions)))[done]
            each = [{"observation": base, MASK: mask} for base, mask in zip(each, masks, strict=True)]
        batch: Any = create_empty_array(space, len(each))
        return self.encoder.pack(concatenate(space, each, batch))

    def _count(self, rewards: npt.NDArray[Any], ltl: dict[str, Any], begun: BoolArray, done: BoolArray) -> None:
        self._totals += np.stack([rewards, np.ones(len(rewards)), ltl["violated"], ltl["accepting"]])
        self._totals[:, begun] = 0
        self.accepting_steps += int(ltl["accepting"][~begun].sum())
        self.episodes += int(done.sum())
        for i in np.flatnonzero(done):
            reward, length, violations, acceptances = self._totals[:, i].tolist()
            self._ended.append((int(i), Episode(reward, int(length), int(violations), int(acceptances))))
        self._totals[:, done] = 0


def _of_last_step(ltl: dict[str, Any], infos: dict[str, Any], done: BoolArray) -> dict[str, Any]:
    """The columns of the step that was made, where `ltl` has those of the new episode (mode SAME_STEP)."""
    last = infos.get("final_info", {}).get("ltl")
    if last is None:
        return ltl
    keys = ("reward", "letter_class", "violated", "accepting", "base_terminated")
    return {key: np.where(done, last[key], ltl[key]) for key in keys}


def _can_accept(tables: RewardTables, classes: Collection[int]) -> bool:
    """Whether letters of these classes alone can lead from the start of the tables to an accepting step."""
    letters = np.array(sorted(classes), dtype=np.int64)
    reached, new = set(), {tables.initial_state}
    while new:
        states = np.array(sorted(new), dtype=np.int64)
        if tables.accepted[np.ix_(states, letters)].any():
            return True
        reached |= new
        following = {*tables.next_state[np.ix_(states, letters)].ravel().tolist()}
        if tables.n_choices:
            following |= {*tables.select_pair[states].ravel().tolist()} - {-1}
        new = following - reached
    return False
