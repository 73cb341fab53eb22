"""The picture of a sweep: what each group of seeds has learned, below each other."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ltlc.mdp.estimate import Estimate
from ltlc.pictures.plotting import FAINT, INK, LINES, blank, saved, style_axes


@dataclass(frozen=True)
class Band:
    """One line of the picture.

    Attributes:
        name: what stands beside it.
        values: a dot for each, in [0, 1].
        mean: with its interval; None: none.
        maximum: a tick; None: none.
    """

    name: str
    values: tuple[float, ...]
    mean: Estimate | None
    maximum: float | None


def draw_bands(path: str | os.PathLike[str], bands: Sequence[Band], label: str) -> Path:
    """Draw bands into a .png, .svg or .pdf file.

    Args:
        path: of the file.
        bands: from top to bottom.
        label: of the axis.

    Returns:
        The path that was written.

    Raises:
        OSError: the file cannot be written.
    """
    figure = blank(8.0, 1.0 + 0.34 * max(len(bands), 1), layout="constrained")
    axes = figure.add_subplot()
    for place, band in enumerate(bands):
        if band.maximum is not None:
            axes.plot([band.maximum] * 2, [place - 0.32, place + 0.32], color=INK, linewidth=1.4)
        axes.plot(band.values, [place] * len(band.values), "o", color=FAINT, markersize=3.5, alpha=0.7)
        if band.mean is not None:
            axes.plot([band.mean.low, band.mean.high], [place] * 2, color=LINES[0], linewidth=3, alpha=0.6)
            axes.plot(band.mean.value, place, "D", color=LINES[0], markersize=5)
    axes.set(xlim=(-0.03, 1.03), ylim=(len(bands) - 0.4, -0.6), xlabel=label)
    axes.set_yticks(range(len(bands)), [band.name for band in bands])
    style_axes(axes, grid="x")
    return saved(figure, path)
