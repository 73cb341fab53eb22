"""The run-time comparison as a picture: a panel for each world and formula, a dot for each system."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from ltlc.pictures.plotting import FAINT, INK, LINES, RULE, blank, saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TICKS = {0.01: "10 ms", 0.1: "0.1 s", 1: "1 s", 10: "10 s", 60: "1 min", 600: "10 min", 3600: "1 h", 36_000: "10 h"}
_OURS, _THESIS = LINES[0], LINES[1]
_HOUR = 3600.0


class TimedRow(Protocol):
    """What is drawn of one system in one world with one formula."""

    @property
    def world(self) -> str:
        """Where it ran."""
        ...

    @property
    def formula(self) -> str:
        """Name of the formula."""
        ...

    @property
    def system(self) -> str:
        """What learned."""
        ...

    @property
    def runs(self) -> int:
        """How often it was run."""
        ...

    @property
    def reached(self) -> int:
        """How many runs became good."""
        ...

    @property
    def seconds(self) -> float:
        """Median time of learning."""
        ...

    @property
    def fastest(self) -> float:
        """Time of the fastest run."""
        ...

    @property
    def slowest(self) -> float:
        """Time of the slowest run."""
        ...

    @property
    def thesis_hours(self) -> str | None:
        """Hours in the thesis; None: not in its table."""
        ...


def draw_runtime(
    path: str | os.PathLike[str], rows: Sequence[TimedRow], *, formulas: Mapping[str, str], regret: float
) -> Path:
    """Draw seconds until a good policy on a logarithmic axis, beside the hours of the thesis.

    Args:
        path: a .png, .svg or .pdf file.
        rows: one for each system, world and formula.
        formulas: the text of each formula by its name.
        regret: what a good policy may lose, as a part of the optimum.

    Returns:
        The path that was written.
    """
    cases = list(dict.fromkeys((row.world, row.formula) for row in rows))
    columns = min(len(cases), 2)
    lines = -(-len(cases) // columns)
    systems = list(dict.fromkeys(row.system for row in rows))
    panel, above, below = 0.6 + 0.26 * len(systems), 0.5, 0.72
    height = above + below + lines * panel
    figure = blank(9.6 if columns == 2 else 5.4, height)
    left, width = (0.135, 0.395) if columns == 2 else (0.235, 0.7)
    for i, case in enumerate(cases):
        line, column = divmod(i, columns)
        bottom = height - above - (line + 1) * panel + 0.18
        box = (left + column * (width + 0.055), bottom / height, width, (panel - 0.5) / height)
        axes = figure.add_axes(box)
        _panel(axes, [row for row in rows if (row.world, row.formula) == case], systems, formulas[case[1]])
        if column:
            axes.set_yticklabels([])
        if line < lines - 1 and i + columns < len(cases):
            axes.set_xticklabels([])
    title = f"Time until a policy is within {100 * regret:g} % of the optimum"
    figure.text(0.02, 1 - 0.3 / height, title, fontsize=13, fontweight="bold", color=INK, va="center")
    figure.legend(
        handles=_handles(rows),
        loc="lower left",
        bbox_to_anchor=(0.012, 0.0),
        ncols=4 if columns == 2 else 2,
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        columnspacing=1.6,
        handletextpad=0.4,
    )
    return saved(figure, path)


def _panel(axes: Axes, rows: Sequence[TimedRow], systems: Sequence[str], formula: str) -> None:
    axes.set_xscale("log")
    axes.set_xlim(0.01, 3.6e5)
    axes.set_ylim(len(systems) - 0.4, -0.6)
    axes.set_xticks(list(_TICKS), list(_TICKS.values()))
    axes.set_xticks([], minor=True)
    axes.set_yticks(range(len(systems)), systems)
    axes.grid(axis="x", color=RULE, linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(colors=FAINT, labelcolor=INK, labelsize=8, length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    first = rows[0]
    title = f"{first.world.replace('x', ' x ')}   {formula}"
    axes.set_title(title, loc="left", fontsize=9, color=INK, pad=5)
    for row in rows:
        y = systems.index(row.system)
        done = row.reached == row.runs
        axes.plot([0.01, row.seconds], [y, y], color=_OURS, linewidth=0.8, alpha=0.35, zorder=2)
        axes.plot([row.fastest, row.slowest], [y, y], color=_OURS, linewidth=3.2, alpha=0.45, zorder=3)
        face = _OURS if done else "white"
        axes.plot(row.seconds, y, "o", color=_OURS, markerfacecolor=face, markersize=6.5, zorder=4)
        text = f"{'' if done else '> '}{seconds_text(row.seconds)}"
        axes.text(max(row.slowest, row.seconds) * 1.6, y, text, fontsize=8, color=INK, va="center")
        if row.thesis_hours is not None:
            _thesis(axes, row.thesis_hours, y)


def _thesis(axes: Axes, hours: str, y: int) -> None:
    more = hours.startswith(">")
    x = float(hours.removeprefix(">")) * _HOUR
    axes.plot(x, y, ">" if more else "D", color=_THESIS, markersize=6 if more else 5, zorder=4)
    axes.text(x / 1.6, y, f"{hours} h", fontsize=8, color=_THESIS, va="center", ha="right")


def _handles(rows: Sequence[TimedRow]) -> list[object]:
    from matplotlib.lines import Line2D

    def mark(marker: str, color: str, label: str, size: float, face: str | None = None) -> Line2D:
        shape: dict[str, Any] = {"linestyle": "", "marker": marker, "markersize": size, "label": label}
        return Line2D([], [], color=color, markerfacecolor=face or color, **shape)

    runs = max(row.runs for row in rows)
    missed = [mark("o", _OURS, "here, not by every run", 6.5, "white")] if any(r.reached < r.runs for r in rows) else []
    return [
        mark("o", _OURS, "here" if runs == 1 else f"here: median and range of {runs} seeds", 6.5),
        *missed,
        mark("D", _THESIS, "thesis, table 5.1", 5),
        mark(">", _THESIS, "thesis, longer than", 6),
    ]


def seconds_text(seconds: float) -> str:
    """Seconds in two or three digits."""
    return f"{seconds:.0f} s" if seconds >= 20 else f"{seconds:.1f} s" if seconds >= 1 else f"{seconds:.2f} s"
