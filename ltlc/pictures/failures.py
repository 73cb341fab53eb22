"""Pictures of how a policy fails: the routes into what is lost, on the map."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ltlc.board import Board
from ltlc.errors import InvalidArgumentError
from ltlc.pictures.plotting import FAINT, INK, LINES, PAPER, RULE, WALL, blank, saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_ROUTES = 12
_CELL = 0.56


def draw_failures(
    path: str | os.PathLike[str],
    board: Board,
    routes: Sequence[tuple[Sequence[int], float]],
    *,
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw the most probable ways to fail, the thicker the more probable; a cross stands where a run is lost.

    Args:
        path: a .png, .svg or .pdf file.
        board: the map.
        routes: cells in order, and a probability; the most probable first. At most 12 are drawn.
        title: the heading.
        subtitle: a line below it.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: a cell is not on the map.
        OSError: the file cannot be written.

    Example:
        >>> import tempfile
        >>> board = Board(("..", ".H"), start=0, actions=("RIGHT", "DOWN"))
        >>> draw_failures(Path(tempfile.mkdtemp()) / "lost.svg", board, [((0, 1, 3), 0.25)], title="F goal").name
        'lost.svg'
    """
    if any(not 0 <= cell < len(board.cells) for cells, _ in routes for cell in cells):
        raise InvalidArgumentError(f"a route leaves the board of {len(board.cells)} cells")
    shown = list(routes[:MAX_ROUTES])
    size = max(board.columns * _CELL + 0.6, 4.6), board.rows * _CELL + 1.3 + 0.18 * len(shown)
    figure = blank(*size)
    axes = figure.add_axes(
        (
            0.3 / size[0],
            (0.3 + 0.18 * len(shown)) / size[1],
            board.columns * _CELL / size[0],
            board.rows * _CELL / size[1],
        )
    )
    _map(axes, board)
    most = max((probability for _, probability in shown), default=1.0)
    for number, (cells, probability) in enumerate(shown):
        colour = LINES[number % len(LINES)]
        shift = 0.5 + 0.07 * ((number + 1) // 2) * (-1) ** number
        x, y = ([value + shift for value in place] for place in _places(board, cells))
        axes.plot(x, y, color=colour, linewidth=1 + 4 * probability / most, alpha=0.75, solid_joinstyle="round")
        axes.plot(x[-1], y[-1], "x", color=colour, markersize=11, markeredgewidth=2.2)
        text = f"{probability:.4g}: {' '.join(map(str, cells[:14]))}{' ...' if len(cells) > 14 else ''}"
        figure.text(
            0.3 / size[0], (0.12 + 0.18 * (len(shown) - 1 - number)) / size[1], text, fontsize=7.5, color=colour
        )
    figure.text(0.3 / size[0], 1 - 0.3 / size[1], title, fontsize=12, color=INK, va="center", fontweight="bold")
    figure.text(0.3 / size[0], 1 - 0.58 / size[1], subtitle, fontsize=8.5, color=FAINT, va="center")
    return saved(figure, path)


def _places(board: Board, cells: Sequence[int]) -> tuple[list[int], list[int]]:
    rows, columns = zip(*(divmod(cell, board.columns) for cell in cells), strict=True)
    return list(columns), list(rows)


def _map(axes: Axes, board: Board) -> None:
    from matplotlib.patches import Rectangle

    axes.set(xlim=(-0.02, board.columns + 0.02), ylim=(board.rows + 0.02, -0.02), aspect="equal")
    axes.axis("off")
    tint = board.tints
    for cell, character in enumerate(board.cells):
        row, column = divmod(cell, board.columns)
        face = WALL if character == "#" else tint.get(character, PAPER)
        axes.add_patch(Rectangle((column, row), 1, 1, facecolor=face, edgecolor=RULE, linewidth=0.7))
        if character in tint:
            axes.text(column + 0.09, row + 0.29, character, fontsize=9, color=INK, va="center", fontweight="bold")
    row, column = divmod(board.start, board.columns)
    axes.add_patch(Rectangle((column + 0.06, row + 0.06), 0.88, 0.88, fill=False, edgecolor=LINES[1], linewidth=2))
