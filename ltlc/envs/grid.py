"""Labelled grid worlds as Gymnasium environments, one at a time and natively batched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ltlc.board import Board
from ltlc.envs.grid_map import GridMap, Labels, Miss, Slip, StepSampler, grid_map
from ltlc.envs.grid_model import grid_board, grid_model
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp import LabelledMDP

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
Observation = Literal["index", "coordinates"]


def _read(
    text: str | Sequence[str] | GridMap,
    labels: Labels | None,
    start: tuple[int, int] | None,
    slip: Slip,
    actions: int,
    miss: Miss,
) -> GridMap:
    if isinstance(text, GridMap):
        return text
    return grid_map(text, labels=labels, start=start, slip=slip, actions=actions, miss=miss)


def _observation_space(layout: GridMap, observation: str) -> spaces.Space[Any]:
    if observation == "index":
        return spaces.Discrete(layout.n_cells)
    if observation == "coordinates":
        return spaces.MultiDiscrete([layout.rows, layout.columns])
    raise UnknownNameError("observation of a grid world", observation, ("index", "coordinates"))


class GridWorld(gym.Env[Any, Any]):
    """A robot on a labelled grid; rewards are 0 and episodes do not end, since the task is a formula's business.

    Observations are cell numbers (`index`), or (row, column) (`coordinates`). `info["labels"]` is the frozenset of
    propositions read on entering the cell, drawn anew at each step. See `grid_map` for the other arguments.

    Attributes:
        layout: the grid as a value.
        propositions: what labels are made of.
    """

    metadata = {  # noqa: RUF012 - as Gymnasium has it
        "render_modes": ["ansi", "rgb_array"],
        "render_fps": 8,
    }

    def __init__(
        self,
        map: str | Sequence[str] | GridMap,
        *,
        labels: Labels | None = None,
        start: tuple[int, int] | None = None,
        slip: Slip = 0.0,
        actions: int = 5,
        miss: Miss = "empty",
        observation: Observation = "index",
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise UnknownNameError("render mode", str(render_mode), self.metadata["render_modes"])
        self.layout = _read(map, labels, start, slip, actions, miss)
        self.propositions = self.layout.propositions
        self.render_mode = render_mode
        self.observation_space = _observation_space(self.layout, observation)
        self.action_space = spaces.Discrete(self.layout.n_actions)
        self._observe: Sequence[Any] = range(self.layout.n_cells)
        if observation == "coordinates":
            self._observe = list(self.layout.coordinates)
        self._names = {
            letter: frozenset(name for i, name in enumerate(self.propositions) if letter >> i & 1)
            for label in self.layout.cell_labels
            for letter, _ in label
        }
        self._moves = _Draw(self.layout.sampler)
        self._first = _Draw(self.layout.start_sampler)
        self._cell = self.layout.start
        self._letter = self.layout.cell_labels[self._cell][0][0]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Go back to the start; `options` are not used."""
        super().reset(seed=seed)
        self._cell, self._letter = self._first.draw(0, self.np_random)
        return self._observation(), {"labels": self._names[self._letter]}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Move; the label read is that of the cell entered.

        Raises:
            InvalidArgumentError: the action is out of range.
        """
        n_actions = self.layout.n_actions
        if not 0 <= action < n_actions:
            raise InvalidArgumentError(f"action {action!r} of a grid world with actions 0..{n_actions - 1}")
        self._cell, self._letter = self._moves.draw(self._cell * n_actions + int(action), self.np_random)
        return self._observation(), 0.0, False, False, {"labels": self._names[self._letter]}

    def render(self) -> Any:
        """The grid with the robot on it: text for `ansi`, an array of shape (height, width, 3) for `rgb_array`."""
        if self.render_mode is None:
            gym.logger.warn("render() needs a render mode: GridWorld(..., render_mode='ansi' or 'rgb_array')")
            return None
        from ltlc.pictures.grid import as_pixels, as_text

        if self.render_mode == "ansi":
            return as_text(self.board(), self._cell, sorted(self._names[self._letter]))
        return as_pixels(self.board(), self._cell)

    def labelled_mdp(self) -> LabelledMDP:
        """The exact model; states are cells."""
        return grid_model(self.layout)

    def board(self) -> Board:
        """The map, to draw policies on."""
        return grid_board(self.layout)

    def _observation(self) -> Any:
        here = self._observe[self._cell]
        return here.copy() if isinstance(here, np.ndarray) else here


class _Draw:
    """A `StepSampler` as plain lists, for one draw at a time."""

    def __init__(self, sampler: StepSampler) -> None:
        self.width = sampler.width
        self.threshold: list[float] = sampler.threshold.tolist()
        self.alias: list[int] = sampler.alias.tolist()
        self.outcome = list(zip(sampler.cell.tolist(), sampler.letter.tolist(), strict=True))

    def draw(self, row: int, random: np.random.Generator) -> tuple[int, int]:
        """Next cell and letter; takes one number from the generator unless nothing is random."""
        if self.width == 1:
            return self.outcome[row]
        u = random.random() * self.width
        slot = row * self.width + int(u)
        return self.outcome[slot if u - int(u) < self.threshold[slot] else self.alias[slot]]


class VectorGridWorld(VectorEnv[Any, Any, Any]):
    """Many copies of one grid world, stepped together by array look-ups.

    The same world as `GridWorld`; with one copy, also the same random numbers within an episode. `infos["labels"]`
    holds letters, shape (num_envs,), int64, bit i = `propositions[i]`. All three autoreset modes are supported, and
    `begin_episode` lets a wrapper end episodes on its own.

    Args:
        map: see `grid_map`, as the other arguments without a word here.
        num_envs: number of copies.
        labels: see `grid_map`.
        start: see `grid_map`.
        slip: see `grid_map`.
        actions: see `grid_map`.
        miss: see `grid_map`.
        observation: cell numbers (`index`), or (row, column) (`coordinates`).
        max_episode_steps: steps after which an episode is truncated; None for never.
        autoreset_mode: when a finished copy starts again.
        render_mode: see `GridWorld`.
    """

    def __init__(
        self,
        map: str | Sequence[str] | GridMap,
        num_envs: int = 1,
        *,
        labels: Labels | None = None,
        start: tuple[int, int] | None = None,
        slip: Slip = 0.0,
        actions: int = 5,
        miss: Miss = "empty",
        observation: Observation = "index",
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        if num_envs < 1 or (max_episode_steps is not None and max_episode_steps < 1):
            raise InvalidArgumentError(
                f"num_envs is {num_envs}, max_episode_steps {max_episode_steps}; both start at 1"
            )
        if render_mode not in (None, *GridWorld.metadata["render_modes"]):
            raise UnknownNameError("render mode", str(render_mode), GridWorld.metadata["render_modes"])
        self.layout = _read(map, labels, start, slip, actions, miss)
        self.propositions = self.layout.propositions
        self.num_envs = num_envs
        self.render_mode = render_mode
        modes = [mode.value for mode in AutoresetMode]
        if autoreset_mode not in (*modes, *AutoresetMode):
            raise UnknownNameError("autoreset mode", str(autoreset_mode), modes)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**GridWorld.metadata, "autoreset_mode": self.autoreset_mode}
        self.max_episode_steps = max_episode_steps
        self.single_observation_space = _observation_space(self.layout, observation)
        self.single_action_space = spaces.Discrete(self.layout.n_actions)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._coordinates = self.layout.coordinates if observation == "coordinates" else None
        self._cell = np.full(num_envs, self.layout.start)
        self._letter = np.zeros(num_envs, dtype=np.int64)
        self._elapsed = np.zeros(num_envs, dtype=np.int64)
        self._finished = np.zeros(num_envs, dtype=np.bool_)
        self._any_finished = False
        self._uniform = np.empty(num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start new episodes in all copies, or in those of the boolean array `options["reset_mask"]`.

        One generator serves all copies, so of a sequence of seeds the whole sequence is one seed.
        """
        if seed is not None:
            entropy = [seed] if isinstance(seed, int | np.integer) else [-1 if s is None else s for s in seed]
            self._np_random, self._np_random_seed = _generator(entropy)
        mask = (options or {}).get("reset_mask")
        if mask is None:
            mask = np.ones(self.num_envs, dtype=np.bool_)
        elif not isinstance(mask, np.ndarray) or mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise InvalidArgumentError(f"reset_mask must be a boolean array of shape ({self.num_envs},), got {mask!r}")
        self._begin(mask)
        self._finished &= ~mask
        self._any_finished = bool(self._finished.any())
        return self._observation(), {"labels": self._letter.copy()}

    def step(self, actions: Any) -> tuple[Any, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Move all copies.

        Raises:
            InvalidArgumentError: an action is out of range, or (mode DISABLED) a finished copy was not reset.
        """
        n, n_actions = self.num_envs, self.layout.n_actions
        actions = np.asarray(actions)
        if actions.shape != (n,) or actions.max() >= n_actions or actions.min() < 0:
            raise InvalidArgumentError(f"actions must be {n} numbers in 0..{n_actions - 1}, got {actions!r}")
        restarted = self._finished if self._any_finished else None
        if restarted is not None and self.autoreset_mode == AutoresetMode.DISABLED:
            raise InvalidArgumentError("a finished sub-environment must be reset before it is stepped (reset_mask)")
        self._cell, self._letter = self._draw(self.layout.sampler, self._cell * n_actions + actions)
        if restarted is not None:
            self._begin(restarted)
        truncated = np.zeros(n, dtype=np.bool_)
        if self.max_episode_steps is not None:
            self._elapsed += 1
            if restarted is not None:
                self._elapsed[restarted] = 0
            np.greater_equal(self._elapsed, self.max_episode_steps, out=truncated)
        infos: dict[str, Any] = {}
        done = bool(truncated.any()) if self.max_episode_steps is not None else False
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            if done:
                infos = self._final(truncated)
                self._begin(truncated)
        else:
            self._finished, self._any_finished = truncated.copy() if done else truncated, done
        infos["labels"] = self._letter.copy()
        return self._observation(), np.zeros(n), np.zeros(n, dtype=np.bool_), truncated, infos

    def begin_episode(self, mask: BoolArray) -> None:
        """End the episodes of the masked copies from outside; with NEXT_STEP, the next step starts new ones."""
        self._finished = self._finished | mask
        self._any_finished = bool(self._finished.any())

    def render(self) -> Any:
        """One picture per copy, see `GridWorld.render`."""
        if self.render_mode is None:
            return None
        from ltlc.pictures.grid import as_pixels, as_text

        if self.render_mode == "ansi":
            return tuple(
                as_text(self.board(), cell, [p for i, p in enumerate(self.propositions) if letter >> i & 1])
                for cell, letter in zip(self._cell.tolist(), self._letter.tolist(), strict=True)
            )
        return tuple(as_pixels(self.board(), cell) for cell in self._cell.tolist())

    def labelled_mdp(self) -> LabelledMDP:
        """The exact model of one copy."""
        return grid_model(self.layout)

    def board(self) -> Board:
        """The map of one copy."""
        return grid_board(self.layout)

    def _observation(self) -> IntArray:
        return self._cell.copy() if self._coordinates is None else self._coordinates[self._cell]

    def _begin(self, mask: BoolArray) -> None:
        cell, letter = self._draw(self.layout.start_sampler, np.zeros(int(mask.sum()), dtype=np.int64))
        self._cell[mask], self._letter[mask], self._elapsed[mask] = cell, letter, 0

    def _draw(self, sampler: StepSampler, rows: IntArray) -> tuple[IntArray, IntArray]:
        slot = rows
        if sampler.width > 1:
            u = self._uniform if len(rows) == self.num_envs else np.empty(len(rows))
            self.np_random.random(out=u)
            u *= sampler.width
            whole = u.astype(np.int64)
            u -= whole
            slot = rows * sampler.width
            slot += whole
            slot = np.where(u < sampler.threshold.take(slot), slot, sampler.alias.take(slot))
        return sampler.cell.take(slot), sampler.letter.take(slot)

    def _final(self, done: BoolArray) -> dict[str, Any]:
        """What Gymnasium's SAME_STEP mode tells about the last step of the episodes that ended."""
        final_obs = np.full(self.num_envs, None, dtype=object)
        observation = self._observation()
        for i in np.flatnonzero(done):  # an object array can only be filled one by one
            final_obs[i] = observation[i]
        labels = np.where(done, self._letter, 0)
        final_info = {"labels": labels, "_labels": done.copy()}
        return {"final_obs": final_obs, "_final_obs": done.copy(), "final_info": final_info, "_final_info": done.copy()}


def _generator(entropy: Sequence[int]) -> tuple[np.random.Generator, int]:
    if len(entropy) == 1:
        return gym.utils.seeding.np_random(entropy[0])
    return np.random.default_rng([s + 1 for s in entropy]), -1
