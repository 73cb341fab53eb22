"""What worlds of many copies share: episodes that end and begin again, and a single environment as a batch of one."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ltlc.envs.letters import NamesOfLetters
from ltlc.envs.random_streams import RandomStreams
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.scene import Scene

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_ROUNDS = 10_000
"""rounds of rejection sampling, after which there is thought to be nothing to find."""


class VectorWorld(VectorEnv[Any, Any, Any]):
    """Many copies of one world, stepped together by array operations.

    Rewards are 0, since the task is a formula's business. `infos["labels"]` holds letters, shape (num_envs,), int64,
    bit i = `propositions[i]`. All three autoreset modes are supported, and `begin_episode` lets a wrapper end episodes
    on its own. A world says how episodes begin (`_begin`), what actions do (`_move`), what is seen (`_observation`)
    and what holds (`_letters`).

    Args:
        num_envs: number of copies.
        observation_space: of one copy.
        action_space: of one copy.
        propositions: what labels are made of.
        max_episode_steps: steps after which an episode is truncated; None for never.
        autoreset_mode: when a finished copy starts again.
        render_mode: one of `metadata["render_modes"]`, or None.

    Raises:
        InvalidArgumentError: a number is below 1.
        UnknownNameError: there is no such mode.
    """

    def __init__(
        self,
        num_envs: int,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        propositions: tuple[str, ...],
        *,
        max_episode_steps: int | None,
        autoreset_mode: AutoresetMode | str,
        render_mode: str | None,
    ) -> None:
        if num_envs < 1 or (max_episode_steps is not None and max_episode_steps < 1):
            raise InvalidArgumentError(
                f"num_envs is {num_envs}, max_episode_steps {max_episode_steps}; both start at 1"
            )
        check_render_mode(render_mode, self.metadata["render_modes"])
        modes = [mode.value for mode in AutoresetMode]
        if autoreset_mode not in (*modes, *AutoresetMode):
            raise UnknownNameError("autoreset mode", str(autoreset_mode), modes)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.num_envs, self.max_episode_steps, self.render_mode = num_envs, max_episode_steps, render_mode
        self.propositions = propositions
        self.single_observation_space, self.single_action_space = observation_space, action_space
        self.observation_space = batch_space(observation_space, num_envs)
        self.action_space = batch_space(action_space, num_envs)
        self._elapsed = np.zeros(num_envs, dtype=np.int64)
        self._finished = np.zeros(num_envs, dtype=np.bool_)
        self._any_finished = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start new episodes in all copies, or in those of the boolean array `options["reset_mask"]`."""
        if seed is not None:
            self._seed(seed)
        mask = (options or {}).get("reset_mask")
        if mask is None:
            mask = np.ones(self.num_envs, dtype=np.bool_)
        elif not isinstance(mask, np.ndarray) or mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise InvalidArgumentError(f"reset_mask must be a boolean array of shape ({self.num_envs},), got {mask!r}")
        self._start(mask)
        self._finished &= ~mask
        self._any_finished = bool(self._finished.any())
        return self._observation(), {"labels": self._letters()}

    def step(self, actions: Any) -> tuple[Any, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Move all copies.

        Raises:
            InvalidArgumentError: an action is out of range, or (mode DISABLED) a finished copy was not reset.
        """
        actions = self._checked(actions)
        restarted = self._finished if self._any_finished else None
        if restarted is not None and self.autoreset_mode == AutoresetMode.DISABLED:
            raise InvalidArgumentError("a finished sub-environment must be reset before it is stepped (reset_mask)")
        terminated = self._move(actions)
        self._elapsed += 1
        if restarted is not None:
            terminated &= ~restarted
            self._start(restarted)
        truncated = np.zeros(self.num_envs, dtype=np.bool_)
        if self.max_episode_steps is not None:
            np.greater_equal(self._elapsed, self.max_episode_steps, out=truncated)
        done = terminated | truncated
        ends = bool(done.any())
        infos: dict[str, Any] = {}
        if self.autoreset_mode != AutoresetMode.SAME_STEP:
            self._finished, self._any_finished = done, ends
        elif ends:
            infos = self._final(done)
            self._start(done)
        infos["labels"] = self._letters()
        return self._observation(), np.zeros(self.num_envs), terminated, truncated, infos

    def begin_episode(self, mask: BoolArray) -> None:
        """End the episodes of the masked copies from outside; with NEXT_STEP, the next step starts new ones."""
        self._finished = self._finished | mask
        self._any_finished = bool(self._finished.any())

    @abstractmethod
    def _seed(self, seed: int | Sequence[int | None]) -> None:
        """Start the random numbers over."""

    @abstractmethod
    def _begin(self, mask: BoolArray) -> None:
        """Put the masked copies at the start of an episode."""

    @abstractmethod
    def _move(self, actions: Any) -> BoolArray:
        """Carry out one action in each copy; a new array says which episodes the world ends, shape (num_envs,)."""

    @abstractmethod
    def _observation(self) -> Any:
        """What all copies show, in arrays that later steps leave alone."""

    @abstractmethod
    def _letters(self) -> IntArray:
        """What holds in all copies, shape (num_envs,), in an array that later steps leave alone."""

    def _start(self, mask: BoolArray) -> None:
        self._begin(mask)
        self._elapsed[mask] = 0

    def _checked(self, actions: Any) -> npt.NDArray[Any]:
        """Actions as an array: numbers in range, or vectors cut to the box of actions."""
        n, space = self.num_envs, self.single_action_space
        if isinstance(space, spaces.Discrete):
            actions = np.asarray(actions)
            if actions.shape != (n,) or actions.max() >= space.n or actions.min() < 0:
                raise InvalidArgumentError(f"actions must be {n} numbers in 0..{space.n - 1}, got {actions!r}")
            return np.asarray(actions)
        assert isinstance(space, spaces.Box)
        actions = np.asarray(actions, dtype=np.float64)
        if actions.shape != (n, *space.shape) or not np.isfinite(actions).all():
            raise InvalidArgumentError(f"actions must be {n} finite vectors of shape {space.shape}, got {actions!r}")
        return np.asarray(np.clip(actions, space.low, space.high))

    def _final(self, done: BoolArray) -> dict[str, Any]:
        """What Gymnasium's SAME_STEP mode tells about the last step of the episodes that ended."""
        final_obs = np.full(self.num_envs, None, dtype=object)
        observation = self._observation()
        for i in np.flatnonzero(done):  # an object array can only be filled one by one
            final_obs[i] = observation[i]
        labels = np.where(done, self._letters(), 0)
        final_info = {"labels": labels, "_labels": done.copy()}
        return {"final_obs": final_obs, "_final_obs": done.copy(), "final_info": final_info, "_final_info": done.copy()}


class StreamedWorld(VectorWorld):
    """A world whose copies have streams of random numbers of their own.

    Copy i of a batch seeded with s goes the way of the single world seeded with s + i, whatever its neighbours do.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 - as Gymnasium has it

    def __init__(self, num_envs: int, *arguments: Any, **options: Any) -> None:
        super().__init__(num_envs, *arguments, **options)
        self._streams = RandomStreams(num_envs)

    @abstractmethod
    def scene(self, copy: int = 0) -> Scene:
        """The world of one copy, and who moves in it, now."""

    def render(self) -> Any:
        """One picture per copy, see `SingleWorld.render`."""
        if self.render_mode is None:
            return None
        from ltlc.pictures.trajectories import as_pixels

        return tuple(as_pixels(self.scene(copy)) for copy in range(self.num_envs))

    def _seed(self, seed: int | Sequence[int | None]) -> None:
        self._streams.seed(seed)

    def _draw_until(
        self, mask: BoolArray, width: int, accepted: Callable[[FloatArray, IntArray], BoolArray], what: str
    ) -> FloatArray:
        """Uniform numbers in [0, 1) that are accepted, shape (mask.sum(), width).

        Args:
            mask: copies that draw.
            width: how many numbers a copy draws at once.
            accepted: whether numbers, shape (m, width), are good in the m copies whose numbers are given.
            what: is drawn, for the message.

        Raises:
            InvalidArgumentError: nothing is ever accepted.
        """
        numbers = np.empty((self.num_envs, width))
        pending = mask.copy()
        for _ in range(_ROUNDS):
            copies = np.flatnonzero(pending)
            if not len(copies):
                return numbers[mask]
            drawn = self._streams.draw_many(pending, width)
            good = accepted(drawn, copies)
            numbers[copies[good]] = drawn[good]
            pending[copies[good]] = False
        raise InvalidArgumentError(f"there is no room for {what}, or next to none")


class SingleWorld(gym.Env[Any, Any]):
    """One environment, which is a batch of one.

    `info["labels"]` is the frozenset of propositions that hold; the reward is 0.

    Args:
        batch: one copy of a world.
        render_mode: one of `metadata["render_modes"]`, or None.
    """

    metadata = StreamedWorld.metadata

    def __init__(self, batch: StreamedWorld, render_mode: str | None = None) -> None:
        check_render_mode(render_mode, self.metadata["render_modes"])
        self._batch, self.render_mode = batch, render_mode
        self.propositions = batch.propositions
        self.observation_space, self.action_space = batch.single_observation_space, batch.single_action_space
        self._names = NamesOfLetters(self.propositions)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; `options` are not used."""
        super().reset(seed=seed)
        observations, infos = self._batch.reset(seed=seed)
        return observations[0], {"labels": self._names[int(infos["labels"][0])]}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Move.

        Raises:
            InvalidArgumentError: the action is out of range.
        """
        batch = self._batch
        terminated = batch._move(batch._checked([action]))
        return (
            batch._observation()[0], 0.0, bool(terminated[0]), False, {"labels": self._names[int(batch._letters()[0])]}
        )  # fmt: skip

    def render(self) -> Any:
        """The world with who moves in it, an array of shape (height, width, 3), uint8."""
        if self.render_mode is None:
            gym.logger.warn("render() needs a render mode: render_mode='rgb_array'")
            return None
        from ltlc.pictures.trajectories import as_pixels

        return as_pixels(self.scene())

    def scene(self, copy: int = 0) -> Scene:
        """The world and who moves in it, now."""
        return self._batch.scene(copy)


def check_render_mode(mode: str | None, modes: Sequence[str]) -> None:
    """Refuse a render mode that does not exist.

    Raises:
        UnknownNameError: there is no such mode.
    """
    if mode not in (None, *modes):
        raise UnknownNameError("render mode", str(mode), modes)
