"""Pictures of worlds in the plane: frames, and trajectories coloured by the state of the automaton."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ltlc.automata import DRA
from ltlc.pictures.plotting import FAINT, INK, PAPER, RULE, blank, saved
from ltlc.pictures.policy import waits_for
from ltlc.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

_TINTS = {
    "red": "#e8938a", "magenta": "#dda0d0", "yellow": "#f0dd8a", "orange": "#f3bd83", "blue": "#9fb8e0",
    "green": "#a3cfa0", "aqua": "#98d6d6", "purple": "#bba5dd", "brown": "#c9ab8f", "pink": "#f3bfd0",
    "gray": "#c6c4c0",
}  # fmt: skip
"""of regions that are called by colours."""
_OTHER_TINT = "#f0ebe0"
_PATHS = ("#1b1b1b", "#c2410c", "#1d5fa8", "#2f7d32", "#8a2c9b", "#a8781a", "#0e7f86", "#b02a5b")
"""of automaton states, in order of first appearance."""
_PANEL = 2.5
"""inches across a world."""
_PIXELS = 384


@dataclass(frozen=True)
class Trajectory:
    """One episode to draw.

    Attributes:
        scene: the world.
        places: (x, y) of each observation, shape (length + 1, 2).
        states: of the automaton after each observation, shape (length + 1,).
        caption: what stands above it.
    """

    scene: Scene
    places: FloatArray
    states: IntArray
    caption: str = ""


def draw_trajectories(
    path: str | os.PathLike[str],
    trajectories: Sequence[Trajectory],
    automaton: DRA,
    *,
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw episodes, each on a map of its world: a line in the colour of the automaton state that it was walked in.

    Returns:
        The path that was written.

    Raises:
        OSError: the file cannot be written.
    """
    states = list(dict.fromkeys(int(q) for one in trajectories for q in one.states))
    colour = {q: _PATHS[i % len(_PATHS)] for i, q in enumerate(states)}
    n_columns = min(len(trajectories), 3)
    n_rows = -(-len(trajectories) // n_columns)
    above, below, gap, caption = 0.8 if subtitle else 0.55, 0.3 + 0.18 * min(len(states), len(_PATHS)), 0.25, 0.26
    width = max(n_columns * (_PANEL + gap) + gap, 5.5)
    height = n_rows * (_PANEL + caption + 0.1) + above + below
    figure = blank(width, height)
    for i, one in enumerate(trajectories):
        row, column = divmod(i, n_columns)
        left, bottom = gap + column * (_PANEL + gap), height - above - (row + 1) * (_PANEL + caption + 0.1) + 0.1
        axes = figure.add_axes((left / width, bottom / height, _PANEL / width, _PANEL / height))
        _draw_world(axes, one.scene, 72 * _PANEL)
        _draw_path(axes, one, colour)
        figure.text(left / width, (bottom + _PANEL + 0.1) / height, one.caption, fontsize=8, color=FAINT, va="center")
    figure.text(gap / width, 1 - 0.3 / height, title, fontsize=12, color=INK, va="center", fontweight="bold")
    if subtitle:
        figure.text(gap / width, 1 - 0.58 / height, subtitle, fontsize=8.5, color=FAINT, va="center")
    texts = waits_for(automaton, _possible_classes(automaton, trajectories))
    _state_legend(figure, texts, colour, (gap / width, (below - 0.1) / height))
    return saved(figure, path)


def as_pixels(scene: Scene) -> npt.NDArray[np.uint8]:
    """A world with who moves in it, shape (384, 384, 3), uint8."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = blank(_PIXELS / 100, _PIXELS / 100)
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    _draw_world(axes, scene, 0.72 * _PIXELS)
    axes.plot(*scene.position, "o", color=INK, markeredgecolor=PAPER, markersize=11, zorder=5)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]


def _draw_world(axes: Axes, scene: Scene, points: float) -> None:
    """The map of a world, `points` wide."""
    from matplotlib.patches import Circle, Patch, Rectangle

    left, bottom, right, top = scene.bounds
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
    for side in axes.spines.values():
        side.set(color=FAINT, linewidth=0.8)
    scale = points / (right - left)
    for region in scene.regions:
        x, y, r = region.x, region.y, region.radius
        tint = _TINTS.get(region.name, _OTHER_TINT)
        if region.square:
            patch: Patch = Rectangle((x - r, y - r), 2 * r, 2 * r, facecolor=tint, edgecolor=RULE, linewidth=0.7)
        else:
            patch = Circle((x, y), r, facecolor=tint, edgecolor=PAPER, linewidth=0.8, alpha=0.75)
        axes.add_patch(patch)
    for region in scene.regions:
        size = min(1.3 * region.radius * scale, 3.0 * region.radius * scale / max(len(region.name), 5), 9)
        axes.text(
            region.x, region.y, region.name, fontsize=size, color=INK, alpha=0.6, ha="center", va="center", zorder=2
        )


def _draw_path(axes: Axes, one: Trajectory, colour: dict[int, str]) -> None:
    """A line, a ring where it begins and a disc where it ends; the step into a state has the colour of that state."""
    from matplotlib.collections import LineCollection

    first, last = one.places[:-1], one.places[1:]
    colours = [colour[int(q)] for q in one.states[1:]]
    if one.scene.wraps:
        first, last, colours = _unwrapped(one.scene, first, last, colours)
    lines = LineCollection(list(np.stack([first, last], axis=1)), colors=colours, linewidths=1.5, capstyle="round")
    lines.set(zorder=3, clip_on=one.scene.wraps)
    axes.add_collection(lines)
    for place, state, face in ((one.places[0], one.states[0], PAPER), (one.places[-1], one.states[-1], None)):
        tint = colour[int(state)]
        rim = PAPER if face is None else tint
        axes.plot(*place, "o", color=face or tint, markeredgecolor=rim, markersize=6.5, zorder=4, clip_on=False)


def _unwrapped(
    scene: Scene, first: FloatArray, last: FloatArray, colours: list[str]
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Steps that go round the world as two lines, of which each leaves the map on one side."""
    span = np.array([scene.bounds[2] - scene.bounds[0], scene.bounds[3] - scene.bounds[1]])
    step = last - first
    jump = np.round(step / span) * span
    round_ = np.flatnonzero(jump.any(axis=1))
    again = [colours[i] for i in round_]
    return (
        np.concatenate([first, first[round_] + jump[round_]]),
        np.concatenate([last - jump, last[round_]]),
        colours + again,
    )


def _possible_classes(automaton: DRA, trajectories: Sequence[Trajectory]) -> IntArray:
    """Letter classes of what can hold together somewhere in the worlds."""
    labels = set().union(*(one.scene.labels for one in trajectories))
    letters = [automaton.letter(name for name in automaton.aps if name in label) for label in labels]
    return np.unique(automaton.letter_class[letters])


def _state_legend(figure: Figure, texts: Sequence[str], colour: dict[int, str], corner: tuple[float, float]) -> None:
    from matplotlib.lines import Line2D

    shown = list(colour.items())[: len(_PATHS)]
    longest = int(figure.get_figwidth() * 14)
    figure.legend(
        [Line2D([], [], color=tint, linewidth=2.5) for _, tint in shown],
        [f"q{q}  {texts[q]}"[:longest] for q, _ in shown],
        loc="upper left",
        bbox_to_anchor=corner,
        borderaxespad=0,
        borderpad=0,
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        labelspacing=0.35,
        handlelength=1.6,
    )
