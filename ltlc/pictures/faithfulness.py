"""What reward schemes optimise, as bars."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from ltlc.errors import InvalidArgumentError
from ltlc.mdp.figures import figure_text
from ltlc.pictures.plotting import blank, saved

_GREY = "#777777"


class SchemeRow(Protocol):
    """What is drawn of one scheme, see `ltlc.faithful.Faithfulness`."""

    @property
    def name(self) -> str:
        """The scheme."""
        ...

    @property
    def satisfaction(self) -> float | None:
        """How probably its optimal policy satisfies the formula."""
        ...

    @property
    def gap(self) -> float | None:
        """What that misses the maximum by."""
        ...

    @property
    def problem(self) -> str | None:
        """Why there is no answer."""
        ...

    @property
    def faithful(self) -> bool | None:
        """Whether the gap is no more than rounding."""
        ...


class SchemeReport(Protocol):
    """What is drawn, see `ltlc.faithful.FaithfulnessReport`."""

    @property
    def formula(self) -> str | None:
        """The text of the formula."""
        ...

    @property
    def maximum(self) -> float:
        """The maximum satisfaction probability."""
        ...

    @property
    def lower(self) -> float:
        """A proved bound on it."""
        ...

    @property
    def upper(self) -> float:
        """Likewise."""
        ...

    @property
    def rows(self) -> Sequence[SchemeRow]:
        """The schemes."""
        ...


def draw_faithfulness(path: str | os.PathLike[str], report: SchemeReport, *, subtitle: str = "") -> Path:
    """Draw a report as bars, one per scheme, with the maximum as a line.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: the suffix is not .png, .svg or .pdf.
        OSError: the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InvalidArgumentError(f"{target}: the suffix must be .png, .svg or .pdf")
    rows = report.rows[::-1]
    figure = blank(8, 1.3 + 0.32 * len(rows), "constrained")
    axes = figure.add_subplot()
    for y, row in enumerate(rows):
        if row.satisfaction is None:
            axes.text(0.01, y, row.problem or "", va="center", color=_GREY, size=8, style="italic")
            continue
        axes.barh(y, row.satisfaction, height=0.62, color=_colour(row))
        if not row.faithful:
            axes.text(1.02, y, f"loses {row.gap:.2g}", va="center", size=8)
        inside = row.satisfaction > 0.85
        axes.text(
            row.satisfaction + (-0.01 if inside else 0.01),
            y,
            f"{row.satisfaction:.4f}".rstrip("0").rstrip("."),
            va="center",
            ha="right" if inside else "left",
            color="white" if inside else "black",
            size=8,
        )
    axes.axvline(report.maximum, color="black", linewidth=1, linestyle=(0, (4, 3)))
    possible = f"possible: {figure_text(report.maximum, (report.lower, report.upper))}"
    axes.text(report.maximum, len(rows) - 0.35, possible, ha="center", va="bottom", size=8)
    axes.set_yticks(range(len(rows)), [row.name for row in rows])
    axes.set_xlim(0, 1.15)
    axes.set_xticks([0, 0.2, 0.4, 0.6, 0.8, 1])
    axes.set_ylim(-0.6, len(rows) - 0.4)
    axes.set_xlabel("probability that the optimal policy of the scheme satisfies the formula")
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    title = report.formula or "an automaton without a formula"
    figure.suptitle(f"{title}\n{subtitle}" if subtitle else title, size=10)
    return saved(figure, target)


def _colour(row: SchemeRow) -> str:
    return "#2a7f62" if row.faithful else "#d99a2b" if (row.gap or 0.0) <= 0.01 else "#c44536"
