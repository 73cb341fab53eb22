"""A labelled grid world as a value: map, motion noise, label probabilities, and the step distribution they make.

Cells are numbered row by row from the top left, walls included. Actions are UP 0, RIGHT 1, DOWN 2, LEFT 3 and, where
there are five, NONE 4. A move into a wall or over the edge stays where it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Literal

import numpy as np
import numpy.typing as npt

from ltlc.errors import InvalidArgumentError, UnknownNameError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Labels = Mapping[str, float | str | Mapping[str, float]]
Slip = float | Sequence[float] | Sequence[Sequence[float]]
Miss = Literal["empty", "hold"]

ACTIONS = ("UP", "RIGHT", "DOWN", "LEFT", "NONE")
HOLD = "hold"
"""proposition that says that a label was missed and nothing was read."""
_OFFSETS = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))
_FREE, _WALL, _START = ".", "#", "S"


@dataclass(frozen=True, eq=False)
class GridMap:
    """A labelled grid world; made by `grid_map`.

    Attributes:
        text: one string per row: `.` free, `#` wall, any other character a labelled cell.
        start: cell where episodes begin.
        propositions: what labels are made of; bit i of a letter is `propositions[i]`.
        cell_labels: per cell the letters that can be read on entering it, with their probabilities (sum 1).
        executed: shape (n_actions, n_actions); entry = probability that the action chosen (row) turns out as the
            column.
    """

    text: tuple[str, ...]
    start: int
    propositions: tuple[str, ...]
    cell_labels: tuple[tuple[tuple[int, float], ...], ...]
    executed: FloatArray

    @property
    def rows(self) -> int:
        """Height in cells."""
        return len(self.text)

    @property
    def columns(self) -> int:
        """Width in cells."""
        return len(self.text[0])

    @property
    def n_cells(self) -> int:
        """Number of cells, walls included."""
        return self.rows * self.columns

    @property
    def n_actions(self) -> int:
        """4 or 5."""
        return len(self.executed)

    @cached_property
    def coordinates(self) -> IntArray:
        """Row and column of each cell, shape (n_cells, 2)."""
        return np.stack(np.divmod(np.arange(self.n_cells), self.columns), axis=1)

    @cached_property
    def target(self) -> IntArray:
        """Where each action leads without noise, shape (n_cells, n_actions)."""
        target = np.empty((self.n_cells, self.n_actions), dtype=np.int64)
        for cell, (row, column) in enumerate(self.coordinates.tolist()):
            for action, (down, right) in enumerate(_OFFSETS[: self.n_actions]):
                r = min(max(row + down, 0), self.rows - 1)
                c = min(max(column + right, 0), self.columns - 1)
                target[cell, action] = cell if self.text[r][c] == _WALL else r * self.columns + c
        return target

    def move_probability(self, cell: int, action: int) -> dict[int, float]:
        """Probability of each next cell."""
        reached: dict[int, float] = {}
        for turned_out, probability in enumerate(self.executed[action].tolist()):
            if probability > 0:
                target = int(self.target[cell, turned_out])
                reached[target] = reached.get(target, 0.0) + probability
        return reached

    @cached_property
    def sampler(self) -> StepSampler:
        """The joint distribution of next cell and letter, ready to be drawn from."""
        return StepSampler.from_rows(
            [
                [
                    (target, letter, p * q)
                    for target, p in self.move_probability(cell, action).items()
                    for letter, q in self.cell_labels[target]
                ]
                for cell, action in product(range(self.n_cells), range(self.n_actions))
            ]
        )

    @cached_property
    def start_sampler(self) -> StepSampler:
        """The distribution of the first letter."""
        return StepSampler.from_rows([[(self.start, letter, p) for letter, p in self.cell_labels[self.start]]])


@dataclass(frozen=True, eq=False)
class StepSampler:
    """Rows of outcomes (cell, letter) with probabilities, drawn with one uniform number each.

    Attributes:
        width: slots per row; 1 means that nothing is random.
        threshold: shape (n_rows * width,); a slot keeps its own outcome below this, else takes that of its alias.
        alias: shape (n_rows * width,); slot index.
        cell: shape (n_rows * width,); outcome of the slot.
        letter: shape (n_rows * width,); outcome of the slot.

    References:
        A. J. Walker, An efficient method for generating discrete random variables with general distributions, ACM
        TOMS 1977, doi 10.1145/355744.355749; M. D. Vose, A linear algorithm for generating random numbers with a given
        distribution, IEEE TSE 1991, doi 10.1109/32.92917.
    """

    width: int
    threshold: FloatArray
    alias: IntArray
    cell: IntArray
    letter: IntArray

    @classmethod
    def from_rows(cls, rows: Sequence[Sequence[tuple[int, int, float]]]) -> StepSampler:
        """Build the tables; each row lists (cell, letter, probability), which sum to 1."""
        width = max(len(row) for row in rows)
        threshold = np.ones(len(rows) * width)
        alias = np.arange(len(rows) * width)
        outcome = np.zeros((len(rows) * width, 2), dtype=np.int64)
        for i, row in enumerate(rows):
            base = i * width
            outcome[base : base + width] = row[0][:2]
            outcome[base : base + len(row)] = [entry[:2] for entry in row]
            weight = [entry[2] * width for entry in row] + [0.0] * (width - len(row))
            small = [slot for slot in range(width) if weight[slot] < 1]
            large = [slot for slot in range(width) if weight[slot] >= 1]
            while small and large:
                poor, rich = small.pop(), large[-1]
                threshold[base + poor], alias[base + poor] = weight[poor], base + rich
                weight[rich] -= 1 - weight[poor]
                if weight[rich] < 1:
                    small.append(large.pop())
            # What is left has weight 1 up to rounding, or is an empty slot that must point to a real outcome.
            for slot in small:
                if slot >= len(row):
                    alias[base + slot], threshold[base + slot] = base, 0.0
        return cls(width, threshold, alias, outcome[:, 0].copy(), outcome[:, 1].copy())


def grid_map(
    text: str | Sequence[str],
    *,
    labels: Labels | None = None,
    start: tuple[int, int] | None = None,
    slip: Slip = 0.0,
    actions: int = 5,
    miss: Miss = "empty",
) -> GridMap:
    """Read a grid world from text.

    Args:
        text: rows of equal width: `.` or space for a free cell, `#` for a wall, `S` for the start, and any other
            character for a cell whose label is that character unless `labels` says otherwise.
        labels: per map character its label: a name, the probability of seeing its own name, or a probability for each
            of several names (seen independently of each other).
        start: (row, column), instead of an `S` on the map.
        slip: probability that an action turns out as one of the others, which are equally likely; one number, one for
            each action, or the whole matrix of probabilities (row: action chosen, column: what it turns out as).
        actions: 4 or 5 (with NONE).
        miss: what is read when a label that is there is not seen: nothing (`empty`), or the proposition "hold", on
            which `Task(..., hold="hold")` keeps the automaton where it is.

    Raises:
        InvalidArgumentError: the map has no cells, rows of different width, no start or two; a probability is not one.
        UnknownNameError: `labels` speaks of a character that is not on the map, or `miss` is neither of the two.
    """
    if miss not in ("empty", "hold"):
        raise UnknownNameError("miss mode", miss, ("empty", "hold"))
    rows = tuple(text.strip("\n").splitlines() if isinstance(text, str) else text)
    rows = tuple(row.replace(" ", _FREE) for row in rows)
    if not rows or not rows[0]:
        raise InvalidArgumentError("the grid map has no cells")
    for i, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise InvalidArgumentError(f"grid map: row {i} has {len(row)} cells, row 0 has {len(rows[0])}")
    cell = _start(rows, start)
    flat = "".join(rows).replace(_START, _FREE)
    width = len(rows[0])
    meaning = _meaning(sorted(set(flat) - {_FREE, _WALL}), labels or {})
    propositions = tuple(sorted({name for named in meaning.values() for name in named}))
    if miss == "hold":
        propositions = (*propositions, HOLD)
    return GridMap(
        text=tuple(flat[i : i + width] for i in range(0, len(flat), width)),
        start=cell,
        propositions=propositions,
        cell_labels=tuple(_letters(meaning.get(character, {}), propositions, miss) for character in flat),
        executed=_executed(slip, actions),
    )


def _start(rows: Sequence[str], start: tuple[int, int] | None) -> int:
    marked = [i for i, character in enumerate("".join(rows)) if character == _START]
    if start is None:
        if len(marked) != 1:
            raise InvalidArgumentError(
                f"the grid map has {len(marked)} cells marked S; mark one, or pass start=(row, column)"
            )
        return marked[0]
    row, column = start
    if not (0 <= row < len(rows) and 0 <= column < len(rows[0])) or rows[row][column] == _WALL:
        raise InvalidArgumentError(
            f"start {tuple(start)} is a wall or lies outside the {len(rows)} x {len(rows[0])} map"
        )
    return row * len(rows[0]) + column


def _meaning(characters: Sequence[str], labels: Labels) -> dict[str, dict[str, float]]:
    for character in labels:
        if character not in characters:
            raise UnknownNameError("map character", character, characters)
    meaning: dict[str, dict[str, float]] = {}
    for character in characters:
        label = labels.get(character, 1.0)
        if isinstance(label, Mapping):
            named = {name: float(p) for name, p in label.items()}
        else:
            named = {label: 1.0} if isinstance(label, str) else {character: float(label)}
        for name, p in named.items():
            if not 0 <= p <= 1:
                raise InvalidArgumentError(f"label {name!r} of map character {character!r} has probability {p}")
        meaning[character] = named
    return meaning


def _letters(named: Mapping[str, float], propositions: Sequence[str], miss: Miss) -> tuple[tuple[int, float], ...]:
    """Letters that a cell can show, with probabilities; more likely ones first."""
    shown: dict[int, float] = {}
    for seen in product((True, False), repeat=len(named)):
        letter, probability = 0, 1.0
        for (name, p), here in zip(named.items(), seen, strict=True):
            letter |= here << propositions.index(name)
            probability *= p if here else 1 - p
        if letter == 0 and named and miss == "hold":
            letter = 1 << propositions.index(HOLD)
        if probability > 0:
            shown[letter] = shown.get(letter, 0.0) + probability
    return tuple(sorted(shown.items(), key=lambda entry: (-entry[1], entry[0])))


def _executed(slip: Slip, actions: int) -> FloatArray:
    if actions not in (4, 5):
        raise InvalidArgumentError(f"{actions!r} actions; a grid world has 4, or 5 with NONE")
    noise = np.asarray(slip, dtype=np.float64)
    if noise.ndim < 2:
        if noise.ndim == 1 and noise.shape != (actions,):
            raise InvalidArgumentError(f"slip has {noise.size} entries for {actions} actions")
        per_action = np.broadcast_to(noise, (actions,))
        executed = np.repeat(per_action[:, None] / (actions - 1), actions, axis=1)
        np.fill_diagonal(executed, 1 - per_action)
    else:
        executed = noise
    proper = executed.shape == (actions, actions) and bool((executed >= 0).all())
    if not proper or not np.allclose(executed.sum(axis=1), 1, rtol=0, atol=1e-12):
        raise InvalidArgumentError(f"slip {slip!r} does not give each of {actions} actions a probability distribution")
    return executed
