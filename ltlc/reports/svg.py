"""Pictures for a page: a learning curve and policies on a map, as SVG whose colours the page chooses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np
import numpy.typing as npt

from ltlc.board import DIRECTIONS, Board

Array = npt.NDArray[np.float64]

WIDTH, HEIGHT = 400, 240
_LEFT, _RIGHT, _TOP, _BOTTOM = 50, 16, 10, 30
_MOST_POINTS = 400
CELL = 20
"""units of a cell of a map."""
WAY_COLOURS = 4
"""colours of lines on a map, which the page chooses."""


def curve(x: Array, y: Array, best: float | None, x_label: str, y_label: str) -> str:
    """A curve, thin, with its running mean, and a dashed line for what is best.

    Args:
        x: shape (n,).
        y: shape (n,).
        best: None: no line.
        x_label: below.
        y_label: above.
    """
    keep = np.unique(np.linspace(0, len(x) - 1, min(len(x), _MOST_POINTS)).astype(int))
    window = max(len(y) // 20, 1)
    total = np.concatenate(([0.0], np.cumsum(y)))
    first = np.maximum(np.arange(len(y)) - window + 1, 0)
    mean = (total[1:] - total[first]) / (np.arange(len(y)) - first + 1)
    values = [*y.tolist(), *([] if best is None else [best])]
    low, high = min(values), max(values)
    if low == high:
        low, high = low - 1, high + 1
    left, right = float(x.min()), max(float(x.max()), float(x.min()) + 1)

    def at(px: float, py: float) -> str:
        across = _LEFT + (px - left) / (right - left) * (WIDTH - _LEFT - _RIGHT)
        return f"{across:.1f},{_down(py, low, high):.1f}"

    def line(kind: str, ys: Array) -> str:
        points = " ".join(at(x[i], ys[i]) for i in keep)
        return f'<polyline class="{kind}" points="{points}"/>'

    parts = [f'<svg class="curve" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(y_label)}">']
    for tick in ticks(low, high):
        height = _down(tick, low, high)
        parts.append(f'<line class="grid" x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{height:.1f}" y2="{height:.1f}"/>')
        parts.append(f'<text x="{_LEFT - 4}" y="{height + 3.5:.1f}" text-anchor="end">{tick:.5g}</text>')
    for tick in ticks(left, right, 3):
        across = at(tick, low).split(",")[0]
        text = f"{tick / 1000:.5g}k" if right >= 10_000 else f"{tick:.5g}"
        parts.append(f'<text x="{across}" y="{HEIGHT - 16}" text-anchor="middle">{text}</text>')
    parts.append(f'<text x="{WIDTH - _RIGHT}" y="{HEIGHT - 3}" text-anchor="end">{escape(x_label)}</text>')
    if best is not None:
        height = _down(best, low, high)
        parts.append(f'<line class="best" x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{height:.1f}" y2="{height:.1f}"/>')
    parts += [line("thin", y), line("mean", mean)] if window > 1 else [line("mean", y)]
    return "".join([*parts, "</svg>"])


def _down(value: float, low: float, high: float) -> float:
    return _TOP + (high - value) / (high - low) * (HEIGHT - _TOP - _BOTTOM)


def ticks(low: float, high: float, most: int = 5) -> list[float]:
    """At most so many round numbers between two.

    Example:
        >>> ticks(0, 1), ticks(-3, 1200, 3)
        ([0.0, 0.25, 0.5, 0.75, 1.0], [0.0, 1000.0])
    """
    raw = (high - low) / max(most - 1, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * power for factor in (1, 2, 2.5, 5, 10) if factor * power >= raw * (1 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 12) + 0.0 for i in range(first, math.floor(high / step + 1e-9) + 1)]


def policy_on_board(board: Board, actions: Sequence[int], seen: Sequence[bool]) -> str:
    """A map with an arrow in each cell where there is something to decide.

    Args:
        board: the map.
        actions: of each cell.
        seen: which cells can be visited at all.
    """
    parts = _map(board, seen)
    for cell, character in enumerate(board.cells):
        if character != "#" and seen[cell] and cell not in board.final:
            tint = character in board.tints
            x, y = _middle(board, cell, 2 if tint else 0)
            across, down = DIRECTIONS[board.actions[int(actions[cell]) % len(board.actions)]]
            parts.append(_arrow("arrow on" if tint else "arrow", x, y, across, down))
    return "".join([*parts, "</svg>"])


def ways_on_board(board: Board, ways: Sequence[tuple[Sequence[int], float]]) -> str:
    """A map with lines, the thicker the more probable, and a cross where each ends.

    Args:
        board: the map.
        ways: cells in order, and a probability; the most probable first.
    """
    parts = _map(board, [True] * len(board.cells))
    most = max((probability for _, probability in ways), default=1.0)
    for number, (cells, probability) in enumerate(ways):
        shift = 1.5 * ((number + 1) // 2) * (-1) ** number
        places = [_middle(board, cell, shift) for cell in cells]
        x, y = places[-1]
        style = f'class="way w{number % WAY_COLOURS}" stroke-width="{0.6 + 2.4 * probability / most:.2f}"'
        parts.append(f'<polyline {style} points="{" ".join(f"{a:g},{b:g}" for a, b in places)}"/>')
        parts.append(
            f'<path class="way w{number % WAY_COLOURS}" d="M{x - 3:g} {y - 3:g}l6 6m-6 0l6 -6" stroke-width="1.4">'
            f"<title>{probability:.4g}</title></path>"
        )
    return "".join([*parts, "</svg>"])


def _middle(board: Board, cell: int, shift: float) -> tuple[float, float]:
    row, column = divmod(cell, board.columns)
    return column * CELL + CELL / 2 + shift, row * CELL + CELL / 2 + shift


def _map(board: Board, seen: Sequence[bool]) -> list[str]:
    """The cells of a map, in an element that is still open."""
    width, height = board.columns * CELL, board.rows * CELL
    parts = [f'<svg class="board" viewBox="-1 -1 {width + 2} {height + 2}" role="img">']
    for cell, character in enumerate(board.cells):
        row, column = divmod(cell, board.columns)
        x, y = column * CELL, row * CELL
        tint = board.tints.get(character)
        kind = "wall" if character == "#" else "marked" if tint else "free" if seen[cell] else "never"
        fill = f' style="fill:{escape(tint)}"' if tint else ""
        parts.append(f'<rect class="{kind}" x="{x}" y="{y}" width="{CELL}" height="{CELL}"{fill}/>')
        if tint and character != "#":
            parts.append(f'<text class="sign" x="{x + 2}" y="{y + 8}">{escape(character)}</text>')
    row, column = divmod(board.start, board.columns)
    start = f'<rect class="start" x="{column * CELL + 1}" y="{row * CELL + 1}" width="{CELL - 2}" height="{CELL - 2}"/>'
    return [*parts, start]


def _arrow(kind: str, x: float, y: float, across: int, down: int) -> str:
    if not across and not down:
        return f'<circle class="{kind}" cx="{x}" cy="{y}" r="2"/>'
    tip, tail = (x + across * 6, y + down * 6), (x - across * 6, y - down * 6)
    side = (-down * 3, across * 3)
    neck = (x + across * 2, y + down * 2)
    head = " ".join(f"{a:g},{b:g}" for a, b in (
        tip, (neck[0] + side[0], neck[1] + side[1]), (neck[0] - side[0], neck[1] - side[1])
    ))  # fmt: skip
    line = f'<line class="{kind}" x1="{tail[0]:g}" y1="{tail[1]:g}" x2="{neck[0]:g}" y2="{neck[1]:g}"/>'
    return f'{line}<polygon class="{kind}" points="{head}"/>'
