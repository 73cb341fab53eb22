"""Curves of what was learned: returns over training (thesis, figure 5.4)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ltlc.mdp.figures import figure_text
from ltlc.pictures.plotting import INK, LINES, blank, saved, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = npt.NDArray[np.float64]

FEW = 12
"""so many points get a dot each."""


@dataclass(frozen=True)
class Curve:
    """Returns of episodes over training."""

    name: str
    x: FloatArray
    """shape (n,); episodes or environment steps, ascending."""
    y: FloatArray
    """shape (n,) or (n_runs, n); return, NaN where there is none."""
    optimum: float | None = None
    """exact optimal value, drawn as a dashed line."""
    learned: FloatArray | None = None
    """as `y`; exact expected return of the policy learned so far, drawn as the main line if given."""
    outcome: float | None = None
    """exact expected return of the policy learned in the end, drawn as a dot there."""

    @property
    def marks(self) -> list[float]:
        """What is drawn beside the returns, where it is a finite number."""
        return [value for value in (self.optimum, self.outcome) if value is not None and np.isfinite(value)]


def draw_curves(
    path: str | os.PathLike[str],
    curves: Sequence[Curve],
    *,
    title: str,
    x_label: str,
    y_label: str = "return of an episode (sum of rewards)",
    window: int = 25,
) -> Path:
    """Draw returns over training: the median of a moving window, and the band from its 10th to its 90th percentile.

    Args:
        path: a .png, .svg or .pdf file.
        curves: one or several, each with its own colour.
        title: the heading.
        x_label: what x is.
        y_label: what y is.
        window: points of x in a window; all runs of a curve count.

    Returns:
        The path that was written.
    """
    figure = blank(7.6, 4.3, "constrained")
    axes = figure.add_subplot()
    for curve, colour in zip(curves, LINES * len(curves), strict=False):
        _curve(axes, curve, colour, window, alone=len(curves) == 1)
    _limit(axes, curves)
    axes.set_title(title, loc="left", fontsize=12, fontweight="bold", color=INK, pad=10)
    axes.set_xlabel(x_label, color=INK)
    axes.set_ylabel(y_label, color=INK)
    axes.margins(x=0.01)
    style_axes(axes, grid="y")
    axes.xaxis.set_major_formatter(_thousands)
    handles, texts = axes.get_legend_handles_labels()
    n_columns = -(-len(texts) // max(len(curves), 1)) if len(texts) > 3 else len(texts)
    order = [i for column in range(n_columns) for i in range(column, len(texts), n_columns)]  # rows: one per curve
    figure.legend(
        [handles[i] for i in order],
        [texts[i] for i in order],
        loc="outside lower center",
        ncols=max(n_columns, 1),
        frameon=False,
        fontsize=8.5,
        columnspacing=1.6,
        labelcolor=INK,
    )
    return saved(figure, path)


def _curve(axes: Axes, curve: Curve, colour: str, window: int, *, alone: bool) -> None:
    low, middle, high = moving_percentiles(np.atleast_2d(curve.y), window)
    axes.fill_between(curve.x, low, high, color=colour, alpha=0.15, linewidth=0)
    prefix = "" if alone else f"{curve.name}: "
    if curve.learned is None:
        marker = "o" if len(curve.x) <= FEW else None  # so that a single one is seen
        axes.plot(curve.x, middle, color=colour, linewidth=1.7, marker=marker, markersize=4.5, label=curve.name)
    else:
        axes.plot(curve.x, middle, color=colour, linewidth=0.8, alpha=0.6, label=f"{prefix}while exploring")
        _, best, _ = moving_percentiles(np.atleast_2d(curve.learned), 1)
        axes.plot(curve.x, best, color=colour, linewidth=1.9, label=f"{prefix}learned so far, exact")
    if curve.outcome in curve.marks:
        text = f"{prefix}learned, exact {figure_text(curve.outcome, digits=5)}"
        axes.plot(curve.x[-1:], [curve.outcome], "o", color=colour, markersize=7, label=text, clip_on=False, zorder=3)
    if curve.optimum in curve.marks:
        text = f"{prefix}exact optimum {figure_text(curve.optimum, digits=5)}"
        axes.axhline(curve.optimum, color=colour, linewidth=1.1, linestyle=(0, (5, 3)), label=text)


def _limit(axes: Axes, curves: Sequence[Curve]) -> None:
    """Leave the worst returns of the beginning out of the picture where they would squeeze the rest."""
    shown = np.concatenate([np.ravel(curve.y) for curve in curves])
    shown = shown[np.isfinite(shown)]
    if shown.size:
        marks = [value for curve in curves for value in curve.marks]
        best = max([shown.max(), *marks])
        worst = min([np.percentile(shown, 4), *(curve.outcome for curve in curves if curve.outcome in curve.marks)])
        if best > worst:
            axes.set_ylim(worst - 0.05 * (best - worst), best + 0.08 * (best - worst))


def moving_percentiles(y: FloatArray, window: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """10th, 50th and 90th percentile of a window around each point, NaN left out; `y` has shape (n_runs, n)."""
    n = y.shape[1]
    half = max(window // 2, 0)
    rows = np.full((3, n), np.nan)
    for i in range(n):
        part = y[:, max(i - half, 0) : i + half + 1]
        part = part[np.isfinite(part)]
        if part.size:
            rows[:, i] = np.percentile(part, (10, 50, 90))
    return rows[0], rows[1], rows[2]


def _thousands(value: float, _: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if value == int(value) else f"{value:g}"
