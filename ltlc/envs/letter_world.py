"""LetterWorld: letters on a small torus, a new map in each episode, where multi-task agents are compared.

References:
    P. Vaezipoor, A. Li, R. Toro Icarte, S. McIlraith, LTL2Action: generalizing LTL instructions for multi-task RL,
    ICML 2021, arXiv 2102.06858.
    M. Jackermeier, A. Abate, DeepLTL: learning to efficiently satisfy complex LTL specifications for multi-task RL,
    ICLR 2025, arXiv 2410.04631.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from ltlc.automata import DRA
from ltlc.compiler import compile
from ltlc.envs.letters import Letters
from ltlc.envs.vector_world import BoolArray, IntArray, SingleWorld, StreamedWorld
from ltlc.errors import InvalidArgumentError
from ltlc.ltl import Formula
from ltlc.scene import Region, Scene

Words = npt.NDArray[np.uint64]

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1))
"""rows and columns that the actions add: up, right, down, left."""
_LARGEST = 8
"""cells across: a set of cells is a word of 64 bits."""
_CANDIDATES = 1024
"""sets of cells that a copy draws at once."""
_ROUNDS = 1_000
"""of candidates, after which there is thought to be no valid map."""


class VectorLetterWorld(StreamedWorld):
    """Many agents, each on a torus of letters of its own.

    Each letter stands on several cells, all at random, drawn anew for each episode; maps are valid if every cell can be
    reached from the start (0, 0), which is free, without passing a letter. All valid maps are equally probable. An
    observation shows which letter is where, shape (size, size, number of letters), uint8 of 0 and 1, with the agent
    in the middle (row and column size // 2). What holds is the letter of the cell entered.

    Args:
        num_envs: number of copies.
        size: rows and columns, 2 to 8.
        letters: their names.
        each: cells of each letter.
        max_episode_steps: see `VectorWorld`, as the other arguments.
        autoreset_mode: when a finished copy starts again.
        render_mode: see `VectorWorld`.

    Raises:
        InvalidArgumentError: the size is another, a letter is there twice, or there is no room for them all.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        size: int = 7,
        letters: Sequence[str] = "abcdefghijkl",
        each: int = 2,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        names = tuple(letters)
        if not 2 <= size <= _LARGEST or each < 1 or not names or len({*names}) < len(names):
            raise InvalidArgumentError(
                f"a torus of {size} x {size} cells with {each} of each letter {', '.join(map(repr, names))}; the size "
                f"is 2 to {_LARGEST}, and there is a letter, each named once and on one cell at least"
            )
        n = size * size
        if len(names) * each >= n:
            raise InvalidArgumentError(f"{len(names) * each} cells with letters leave none free of {size} x {size}")
        super().__init__(
            num_envs,
            spaces.Box(0, 1, (size, size, len(names)), np.uint8),
            spaces.Discrete(len(MOVES)),
            names,
            max_episode_steps=max_episode_steps,
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
        )
        self.size = size
        self._kinds = np.repeat(np.arange(1, len(names) + 1, dtype=np.int8), each)
        row, column = np.divmod(np.arange(n), size)
        self._next = np.stack([(row + dr) % size * size + (column + dc) % size for dr, dc in MOVES], axis=1)
        away = row - size // 2, column - size // 2
        self._view = (row[:, None] + away[0]) % size * size + (column[:, None] + away[1]) % size
        self._one_hot = np.eye(len(names) + 1, dtype=np.uint8)[:, 1:]
        self._offset = np.arange(num_envs) * n
        self._map = np.zeros((num_envs, n), dtype=np.int8)
        self._cell = np.zeros(num_envs, dtype=np.int64)

    def optimal_steps(self, formula: Formula | str | DRA) -> IntArray:
        """The fewest steps from the start of the maps of now until the formula is satisfied whatever follows.

        By breadth-first search on map x automaton.

        Args:
            formula: a formula, or its automaton.

        Returns:
            shape (num_envs,), int64; -1 where it cannot be.

        Raises:
            UnknownNameError: a proposition is no letter of the world.
        """
        automaton = formula if isinstance(formula, DRA) else compile(formula)
        letters = Letters(automaton.aps, self.propositions, "ignore", automaton.letter_numbers)
        bits = np.arange(len(self.propositions) + 1)
        classes = automaton.letter_class[letters.of_batch((1 << bits) >> 1, len(bits))]
        after = automaton.delta[:, classes].astype(np.int64)
        n, states = self.size**2, automaton.n_states
        never = n * states + 1
        done = np.isin(np.arange(states), automaton.accepting_sinks)
        best = np.broadcast_to(np.where(done, 0, never), (self.num_envs, n, states)).astype(np.int64)
        entering = after[:, self._map].transpose(1, 2, 0)
        while True:
            arrived = np.take_along_axis(best, entering, axis=2)
            new = np.minimum(best, 1 + arrived[:, self._next].min(axis=2))
            if (new == best).all():
                break
            best = new
        steps = best[:, 0, after[automaton.initial_state, 0]]
        return np.where(steps < never, steps, -1)

    def scene(self, copy: int = 0) -> Scene:
        """The letters and the agent of one copy; the first row is above."""
        n = self.size
        regions = (
            Region(self.propositions[kind - 1], cell % n, n - 1 - cell // n, 0.5, square=True)
            for cell, kind in enumerate(self._map[copy].tolist())
            if kind
        )
        row, column = divmod(int(self._cell[copy]), n)
        return Scene((-0.5, -0.5, n - 0.5, n - 0.5), tuple(regions), (column, n - 1 - row), wraps=True)

    def _begin(self, mask: BoolArray) -> None:
        marked = self._draw_valid(mask)
        n = self.size**2
        m = len(marked)
        where = (marked[:, None] >> np.arange(n, dtype=np.uint64)) & np.uint64(1)
        order = np.argsort(self._streams.words(mask, len(self._kinds)), axis=1)
        maps = np.zeros((m, n), dtype=np.int8)
        maps[where.astype(np.bool_)] = self._kinds[order].ravel()
        self._map[mask] = maps
        self._cell[mask] = 0

    def _draw_valid(self, mask: BoolArray) -> Words:
        """The cells that have letters on new maps of the masked copies, uniform among the valid sets."""
        found = np.zeros(self.num_envs, dtype=np.uint64)
        pending = mask.copy()
        for _ in range(_ROUNDS):
            copies = np.flatnonzero(pending)
            if not len(copies):
                return found[mask]
            drawn = self._candidates(pending)
            row, column = np.nonzero(np.bitwise_count(drawn) == len(self._kinds))
            good = _valid(drawn[row, column], self.size)
            row, column = row[good], column[good]
            first, at = np.unique(row, return_index=True)
            found[copies[first]] = drawn[row[at], column[at]]
            pending[copies[first]] = False
        raise InvalidArgumentError(
            f"there is no valid map, or next to none, of {self.size} x {self.size} cells with "
            f"{len(self._kinds)} letters; take fewer letters"
        )

    def _candidates(self, mask: BoolArray) -> Words:
        """Random sets of cells without (0, 0), shape (mask.sum(), _CANDIDATES).

        Cells are independent, each in a set with a probability in eighths that is near what is wanted, so that sets of
        the wanted size are uniform and frequent. A set is made from the binary digits of the probability: a random
        word joined where the digit is 1, met where it is 0.
        """
        cells = self.size**2
        eighths = min(max(round(8 * len(self._kinds) / (cells - 1)), 1), 7)
        chosen = np.zeros((int(mask.sum()), _CANDIDATES), dtype=np.uint64)
        for digit in (1, 2, 4):
            if eighths & digit:
                chosen |= self._streams.words(mask, _CANDIDATES)
            elif eighths % digit:
                chosen &= self._streams.words(mask, _CANDIDATES)
        return chosen & np.uint64((1 << cells) - 2)

    def _move(self, actions: Any) -> BoolArray:
        self._cell = self._next[self._cell, actions]
        return np.zeros(self.num_envs, dtype=np.bool_)

    def _observation(self) -> Any:
        shown = self._map.take(self._offset[:, None] + self._view[self._cell])
        return self._one_hot.take(shown, axis=0).reshape(self.num_envs, *self.single_observation_space.shape)  # type: ignore[misc]

    def _letters(self) -> IntArray:
        return np.asarray((1 << self._map.take(self._offset + self._cell).astype(np.int64)) >> 1)


class LetterWorld(SingleWorld):
    """One agent on a torus of letters; see `VectorLetterWorld`.

    Args:
        size: rows and columns, 2 to 8.
        letters: their names.
        each: cells of each letter.
        render_mode: see `SingleWorld`.
    """

    def __init__(
        self,
        *,
        size: int = 7,
        letters: Sequence[str] = "abcdefghijkl",
        each: int = 2,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(VectorLetterWorld(size=size, letters=letters, each=each), render_mode)


def _valid(marked: Words, size: int) -> BoolArray:
    """Whether every cell of a torus can be reached from cell 0 without passing marked cells.

    Args:
        marked: sets of cells, bit row * size + column.
        size: rows and columns.
    """
    full = np.uint64((1 << size * size) - 1)
    free = ~marked & full
    good = _grown(free, size) == full  # cheap, and most sets fail already here
    candidates = np.flatnonzero(good)
    free = free[candidates]
    reached = np.ones_like(free)
    while True:
        new = _grown(reached, size) & free
        if (new == reached).all():
            break
        reached = new
    good[candidates] = _grown(reached, size) == full
    return np.asarray(good)


def _grown(cells: Words, size: int) -> Words:
    """Sets of cells with their neighbours on a torus."""
    n = size * size
    full = np.uint64((1 << n) - 1)
    west = np.uint64(sum(1 << row * size for row in range(size)))
    east = west << np.uint64(size - 1)
    one, wide, across, down = (np.uint64(k) for k in (1, size - 1, size, n - size))
    rows = cells | (cells >> across) | (cells << down) | (cells << across) | (cells >> down)
    columns = ((cells & ~east) << one) | ((cells & east) >> wide) | ((cells & ~west) >> one) | ((cells & west) << wide)
    return np.asarray((rows | columns) & full)
