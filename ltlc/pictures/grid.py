"""Pictures of grid worlds: text for a terminal, pixels for a video."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ltlc.board import Board

Pixels = npt.NDArray[np.uint8]

_CELL = 48
"""pixels across a cell."""
_PAPER, _GRID, _WALL, _ROBOT, _RIM = "#fbfaf7", "#d9d6cf", "#4a4a4f", "#2f5d8a", "#ffffff"


def as_text(board: Board, robot: int, label: Iterable[str] = ()) -> str:
    """The map with the robot as `@`, and below it what it reads."""
    flat = list(board.cells)
    flat[robot] = "@"
    rows = ["".join(flat[i : i + board.columns]) for i in range(0, len(flat), board.columns)]
    return "\n".join([*rows, "label: " + (" ".join(label) or "-")]) + "\n"


def as_pixels(board: Board, robot: int) -> Pixels:
    """The map with the robot as a disc, shape (48 * rows, 48 * columns, 3), uint8."""
    pixels = _background(board).copy()
    row, column = divmod(robot, board.columns)
    cell = pixels[row * _CELL : (row + 1) * _CELL, column * _CELL : (column + 1) * _CELL]
    for radius, colour in ((0.34, _RIM), (0.29, _ROBOT)):
        _disc(cell, radius * _CELL, colour)
    return pixels


@lru_cache(maxsize=16)
def _background(board: Board) -> Pixels:
    """Everything but the robot; drawn once per map."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    figure = Figure(figsize=(board.columns * _CELL / 100, board.rows * _CELL / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, board.columns), ylim=(board.rows, 0))
    axes.axis("off")
    tint = board.tints
    for cell, character in enumerate(board.cells):
        row, column = divmod(cell, board.columns)
        face = _WALL if character == "#" else tint.get(character, _PAPER)
        axes.add_patch(Rectangle((column, row), 1, 1, facecolor=face, edgecolor=_GRID, linewidth=1))
        if character in tint:
            axes.text(column + 0.5, row + 0.52, character, ha="center", va="center", fontsize=17, color="#33312e")
        elif cell == board.start:
            axes.text(column + 0.5, row + 0.52, "S", ha="center", va="center", fontsize=13, color="#a7a39a")
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]


def _disc(cell: Pixels, radius: float, colour: str) -> None:
    """Draw a disc with a soft edge into the middle of a square of pixels."""
    y, x = np.indices(cell.shape[:2]) - (_CELL - 1) / 2
    cover = np.clip(radius + 0.5 - np.hypot(x, y), 0, 1)[..., None]
    rgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    cell[:] = np.rint(cell * (1 - cover) + rgb * cover)
