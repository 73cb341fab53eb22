"""The paper that pictures are drawn on: colours, blank figures, and how a figure becomes a file."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ltlc.atomic import atomic_write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, FAINT, PAPER, RULE = "#2b2a28", "#8d8982", "#ffffff", "#dedad2"
WALL, ARROW, NEVER = "#56545a", "#1f4e79", "#f1efea"
LINES = ("#1f5a94", "#c8553d", "#4f8a4c", "#8a5aa8")


def blank(width: float, height: float, layout: str | None = None) -> Figure:
    """A figure of so many inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor=PAPER, layout=layout)  # type: ignore[arg-type]
    FigureCanvasAgg(figure)
    return figure


def style_axes(axes: Axes, *, grid: str) -> None:
    """Take away from axes what says nothing; `grid` lines stand on the axis of the values, x or y."""
    axes.grid(axis=grid, color=RULE, linewidth=0.7)  # type: ignore[arg-type]
    axes.set_axisbelow(True)
    axes.tick_params(colors=FAINT, labelcolor=INK, labelsize=9)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(FAINT)


def saved(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure to a .png, .svg or .pdf file, complete or not at all; the same figure gives the same bytes."""
    from matplotlib import rc_context

    stream = io.BytesIO()
    suffix = Path(path).suffix.lower().removeprefix(".")
    metadata = {"Date": None} if suffix == "svg" else {"CreationDate": None} if suffix == "pdf" else {}
    with rc_context({"svg.hashsalt": "ltlc"}):  # else the names of clips are drawn anew each time
        figure.savefig(stream, format=suffix, dpi=150, metadata=metadata)
    return atomic_write(path, stream.getvalue())
