"""Carrying out a sweep by an engine, and going on where it was cut."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass

from ltlc.atomic import atomic_write
from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.sweeps.engine import Engine, is_done
from ltlc.sweeps.grid import Cell, Grid
from ltlc.sweeps.processes import Processes

PLAN_FILE = "sweep.json"
"""what each run of a sweep is, so that a folder is not continued by another sweep."""


@dataclass(frozen=True)
class Progress:
    """How far a sweep has come.

    Attributes:
        cell: the run that has just ended, or was there already.
        done: runs that have ended, this one included.
        total: all runs.
        error: what its command said where it failed; empty where it did not.
    """

    cell: Cell
    done: int
    total: int
    error: str = ""


def run_grid(
    grid: Grid, *, processes: int = 1, engine: Engine | None = None, report: Callable[[Progress], None] | None = None
) -> dict[str, str]:
    """Train all runs of a sweep that have not ended yet; those that were cut go on from their checkpoints.

    A run that fails does not stop the others. Whenever this process ends, the ones that it has started end as well, and
    calling this again goes on; the files are then those of a sweep that was never cut, to the byte, but for times. They
    do not depend on the engine either.

    Args:
        grid: the sweep.
        processes: that train at a time, each with one thread; without an engine.
        engine: what trains; None: processes of this machine.
        report: called after each run.

    Returns:
        What failed, by the name of the run, with what its command said.

    Raises:
        InvalidArgumentError: the folder holds another sweep, or there is no process to train in.
        FileFormatError: its plan is damaged.
        OSError: the folder cannot be written.
    """
    engine = engine if engine is not None else Processes(processes)
    write_plan(grid)
    failed: dict[str, str] = {}
    done = 0

    def ended(cell: Cell, error: str) -> None:
        nonlocal done
        done += 1
        if error:
            failed[cell.name] = error
        if report is not None:
            report(Progress(cell, done, len(grid.cells), error))

    missing = [cell for cell in grid.cells if not is_done(grid.folder, cell)]
    for cell in grid.cells:
        if cell not in missing:
            ended(cell, "")
    if missing:
        with closing(engine.run(grid.folder, missing)) as running:
            for cell, error in running:
                ended(cell, error)
    return failed


def write_plan(grid: Grid) -> None:
    """Write what the runs are, or compare with what was written before.

    Runs may be added to a sweep, such as further seeds; those that are there stay what they are.

    Raises:
        InvalidArgumentError: the folder holds another sweep.
        FileFormatError: its plan is damaged.
        OSError: the folder cannot be written.
    """
    grid.folder.mkdir(parents=True, exist_ok=True)
    file = grid.folder / PLAN_FILE
    before: Mapping[str, list[str]] = {}
    if file.exists():
        try:
            before = json.loads(file.read_text(encoding="utf-8"))["runs"]
            changed = [
                cell.name for cell in grid.cells if before.get(cell.name, list(cell.arguments)) != [*cell.arguments]
            ]
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise FileFormatError(f"{file} is not the plan of a sweep: {error}") from error
        if changed:
            raise InvalidArgumentError(
                f"{grid.folder} holds another sweep, in which {changed[0]} is something else; give another folder (out)"
            )
    runs = {**before, **{cell.name: list(cell.arguments) for cell in grid.cells}}
    atomic_write(file, json.dumps({"runs": runs}, ensure_ascii=False, indent=1) + "\n")
