"""Pictures of grid worlds: text for a terminal, pixels for a video."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ltlc.envs.grid_map import GridMap

Pixels = npt.NDArray[np.uint8]

_CELL = 48
"""pixels across a cell."""
_PAPER, _GRID, _WALL, _ROBOT, _RIM = "#fbfaf7", "#d9d6cf", "#4a4a4f", "#2f5d8a", "#ffffff"
_TINTS = ("#f2c57c", "#9fc7a5", "#e59a8c", "#a9b8de", "#d6a9d0", "#8fc7cf", "#cfcf8a", "#c9b199")


def as_text(layout: GridMap, robot: int, label: Iterable[str] = ()) -> str:
    """The map with the robot as `@`, and below it what it reads."""
    flat = list("".join(layout.text))
    flat[robot] = "@"
    rows = ["".join(flat[i : i + layout.columns]) for i in range(0, len(flat), layout.columns)]
    return "\n".join([*rows, "label: " + (" ".join(label) or "-")]) + "\n"


def as_pixels(layout: GridMap, robot: int) -> Pixels:
    """The map with the robot as a disc, shape (48 * rows, 48 * columns, 3), uint8."""
    pixels = _background(layout).copy()
    row, column = divmod(robot, layout.columns)
    cell = pixels[row * _CELL : (row + 1) * _CELL, column * _CELL : (column + 1) * _CELL]
    for radius, colour in ((0.34, _RIM), (0.29, _ROBOT)):
        _disc(cell, radius * _CELL, colour)
    return pixels


def tints(layout: GridMap) -> dict[str, str]:
    """A colour for each labelled map character, in order of the characters."""
    characters = sorted(set("".join(layout.text)) - {".", "#"})
    return {character: _TINTS[i % len(_TINTS)] for i, character in enumerate(characters)}


@lru_cache(maxsize=16)
def _background(layout: GridMap) -> Pixels:
    """Everything but the robot; drawn once per map."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    figure = Figure(figsize=(layout.columns * _CELL / 100, layout.rows * _CELL / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, layout.columns), ylim=(layout.rows, 0))
    axes.axis("off")
    tint = tints(layout)
    for cell, character in enumerate("".join(layout.text)):
        row, column = divmod(cell, layout.columns)
        face = _WALL if character == "#" else tint.get(character, _PAPER)
        axes.add_patch(Rectangle((column, row), 1, 1, facecolor=face, edgecolor=_GRID, linewidth=1))
        if character in tint:
            axes.text(column + 0.5, row + 0.52, character, ha="center", va="center", fontsize=17, color="#33312e")
        elif cell == layout.start:
            axes.text(column + 0.5, row + 0.52, "S", ha="center", va="center", fontsize=13, color="#a7a39a")
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]


def _disc(cell: Pixels, radius: float, colour: str) -> None:
    """Draw a disc with a soft edge into the middle of a square of pixels."""
    y, x = np.indices(cell.shape[:2]) - (_CELL - 1) / 2
    cover = np.clip(radius + 0.5 - np.hypot(x, y), 0, 1)[..., None]
    rgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    cell[:] = np.rint(cell * (1 - cover) + rgb * cover)
