"""What came out of a sweep: a line for each group of runs that differ in the seed alone, with intervals."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ltlc.agents.training.run_folder import RESULT_FILE
from ltlc.atomic import atomic_write
from ltlc.errors import FileFormatError
from ltlc.mdp.estimate import Estimate, mean
from ltlc.pictures.sweep import Band, draw_bands
from ltlc.sweeps.grid import Cell, Grid

TABLE_FILE, RUNS_FILE, PICTURE_FILE = "table.csv", "runs.csv", "table.png"
_EXACT, _SAMPLED = "satisfaction", "accepted_without_violation"


@dataclass(frozen=True)
class Row:
    """What the seeds of a group have learned.

    Attributes:
        formula, environment, reward, agent: names in the file of the sweep.
        values: of each seed that has learned something: the satisfaction probability, or where the environment is not
            known the part of the episodes with an accepting step and no violation.
        seeds: how many there are in all.
        exact: whether the values are.
        maximum: the largest satisfaction probability; None where the environment is not known.

    Example:
        >>> Row("reach", "lake", "default", "auto", (0.75, 0.8), 3, True, 14 / 17).mean.value
        0.775
    """

    formula: str
    environment: str
    reward: str
    agent: str
    values: tuple[float, ...]
    seeds: int
    exact: bool
    maximum: float | None

    @property
    def mean(self) -> Estimate | None:
        """Over the seeds, with a bootstrap interval of 95 %; None where fewer than two have learned something."""
        return mean(self.values, method="bootstrap") if len(self.values) > 1 else None


def table_of(grid: Grid) -> list[Row]:
    """A row for each group of a sweep, from the verdicts that are there.

    Raises:
        FileFormatError: a verdict is damaged.
    """
    groups: dict[tuple[str, str, str, str], list[Cell]] = {}
    for cell in grid.cells:
        groups.setdefault(cell.group, []).append(cell)
    rows = []
    for group, cells in groups.items():
        verdicts = [_verdict(grid.folder, cell) for cell in cells]
        found = [(value, one) for one in verdicts if one is not None and (value := _value(one)) is not None]
        maxima = [verdict["maximum_satisfaction"][1] for _, verdict in found if "maximum_satisfaction" in verdict]
        exact = bool(found) and all(verdict["exact"] for _, verdict in found)
        rows.append(Row(*group, tuple(v for v, _ in found), len(cells), exact, maxima[0] if maxima else None))
    return rows


def write_table(grid: Grid) -> list[Path]:
    """Write what came out: `table.csv`, a line for each group; `runs.csv`, one for each run; and a picture.

    Raises:
        FileFormatError: a verdict is damaged.
        OSError: a file cannot be written.
    """
    rows = table_of(grid)
    head = ("formula", "environment", "reward", "agent", "seeds", "learned", "mean", "low", "high", "maximum", "exact")
    lines: list[Sequence[Any]] = [head]
    for row in rows:
        estimate = row.mean
        middle = sum(row.values) / len(row.values) if row.values else ""
        low, high = ("", "") if estimate is None else (estimate.low, estimate.high)
        known = "" if row.maximum is None else row.maximum
        names = row.formula, row.environment, row.reward, row.agent
        lines.append((*names, row.seeds, len(row.values), middle, low, high, known, row.exact))
    paths = [
        atomic_write(grid.folder / TABLE_FILE, _csv(lines)),
        atomic_write(grid.folder / RUNS_FILE, _csv(_lines_of_runs(grid))),
    ]
    bands = [
        Band(f"{row.formula} · {row.environment} · {row.reward} · {row.agent}", row.values, row.mean, row.maximum)
        for row in rows
    ]
    return [*paths, draw_bands(grid.folder / PICTURE_FILE, bands, "satisfaction probability; dots: seeds, bars: 95 %")]


def outcome(folder: Path, cell: Cell) -> tuple[float, bool] | None:
    """What a run has learned, and whether that is exact; None: nothing yet, or nothing at all.

    Raises:
        FileFormatError: its verdict is damaged.
    """
    verdict = _verdict(folder, cell)
    value = _value(verdict)
    return None if verdict is None or value is None else (value, bool(verdict["exact"]))


def _lines_of_runs(grid: Grid) -> list[Sequence[Any]]:
    lines: list[Sequence[Any]] = [
        ("run", "formula", "environment", "reward", "agent", "seed", "value", "return", "steps")
    ]
    for cell in grid.cells:
        verdict = _verdict(grid.folder, cell)
        value, learned = _value(verdict), (verdict or {}).get("learned") or {}
        paid = learned.get("discounted_return", learned.get("total_return"))
        paid = paid["value"] if isinstance(paid, Mapping) else paid
        cells = ("" if one is None else one for one in (value, paid, (verdict or {}).get("steps")))
        lines.append((cell.name, *cell.group, cell.seed, *cells))
    return lines


def _verdict(folder: Path, cell: Cell) -> dict[str, Any] | None:
    """The verdict on a run; None where there is none yet."""
    file = folder / cell.name / RESULT_FILE
    if not file.exists():
        return None
    try:
        verdict: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        _value(verdict)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise FileFormatError(f"{file} is not the verdict of a run: {error}") from error
    return verdict


def _value(verdict: dict[str, Any] | None) -> float | None:
    learned = None if verdict is None else verdict["learned"]
    if learned is None:
        return None
    return float(learned[_EXACT] if _EXACT in learned else learned[_SAMPLED]["value"])


def _csv(lines: Sequence[Sequence[Any]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()
