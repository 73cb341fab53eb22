"""Labelled grid worlds as Gymnasium environments, one at a time and natively batched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from ltlc.board import Board
from ltlc.envs.grid_map import GridMap, Labels, Miss, Slip, StepSampler, grid_map
from ltlc.envs.grid_model import grid_board, grid_model
from ltlc.envs.vector_world import BoolArray, IntArray, VectorWorld, check_render_mode
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp import LabelledMDP

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
        check_render_mode(render_mode, self.metadata["render_modes"])
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


class VectorGridWorld(VectorWorld):
    """Many copies of one grid world, stepped together by array look-ups.

    The same world as `GridWorld`; with one copy, also the same random numbers within an episode. `infos["labels"]`
    holds letters, see `VectorWorld`.

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

    metadata = GridWorld.metadata

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
        self.layout = _read(map, labels, start, slip, actions, miss)
        super().__init__(
            num_envs,
            _observation_space(self.layout, observation),
            spaces.Discrete(self.layout.n_actions),
            self.layout.propositions,
            max_episode_steps=max_episode_steps,
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
        )
        self._coordinates = self.layout.coordinates if observation == "coordinates" else None
        self._cell = np.full(num_envs, self.layout.start)
        self._letter = np.zeros(num_envs, dtype=np.int64)
        self._uniform = np.empty(num_envs)

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

    def _seed(self, seed: int | Sequence[int | None]) -> None:
        """One generator serves all copies, so of a sequence of seeds the whole sequence is one seed."""
        entropy = [seed] if isinstance(seed, int | np.integer) else [-1 if s is None else s for s in seed]
        self._np_random, self._np_random_seed = _generator(entropy)

    def _begin(self, mask: BoolArray) -> None:
        cell, letter = self._draw(self.layout.start_sampler, np.zeros(int(mask.sum()), dtype=np.int64))
        self._cell[mask], self._letter[mask] = cell, letter

    def _move(self, actions: Any) -> BoolArray:
        self._cell, self._letter = self._draw(self.layout.sampler, self._cell * self.layout.n_actions + actions)
        return np.zeros(self.num_envs, dtype=np.bool_)

    def _observation(self) -> IntArray:
        return self._cell.copy() if self._coordinates is None else self._coordinates[self._cell]

    def _letters(self) -> IntArray:
        return self._letter.copy()

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


def _generator(entropy: Sequence[int]) -> tuple[np.random.Generator, int]:
    if len(entropy) == 1:
        return gym.utils.seeding.np_random(entropy[0])
    return np.random.default_rng([s + 1 for s in entropy]), -1
