"""Carrying out a sweep: so many processes at a time, each of which trains one run, and going on where it was cut."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path

from ltlc.agents.training.run_folder import CONFIG_FILE, RESULT_FILE
from ltlc.atomic import atomic_write
from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.sweeps.grid import Cell, Grid

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


def run_grid(grid: Grid, *, processes: int = 1, report: Callable[[Progress], None] | None = None) -> dict[str, str]:
    """Train all runs of a sweep that have not ended yet; those that were cut go on from their checkpoints.

    A run that fails does not stop the others. Whenever this process ends, the ones that it has started end as well, and
    calling this again goes on; the files are then those of a sweep that was never cut, to the byte, but for times.

    Args:
        grid: the sweep.
        processes: that train at a time, each with one thread.
        report: called after each run.

    Returns:
        What failed, by the name of the run, with what its command said.

    Raises:
        InvalidArgumentError: the folder holds another sweep, or there is no process to train in.
        FileFormatError: its plan is damaged.
        OSError: the folder cannot be written.
    """
    if processes < 1:
        raise InvalidArgumentError(f"processes is {processes}; it must be at least 1")
    grid.folder.mkdir(parents=True, exist_ok=True)
    _plan(grid)
    failed: dict[str, str] = {}
    done = 0
    children = _Children()
    with ThreadPoolExecutor(processes) as pool:
        waiting: dict[Future[str], Cell] = {}
        try:
            for cell in grid.cells:
                waiting[pool.submit(children.run, grid.folder, cell)] = cell
            while waiting:
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    cell, error, done = waiting.pop(future), future.result(), done + 1
                    if error:
                        failed[cell.name] = error
                    if report is not None:
                        report(Progress(cell, done, len(grid.cells), error))
        except BaseException:
            children.stop()
            pool.shutdown(cancel_futures=True)
            raise
    return failed


def _plan(grid: Grid) -> None:
    """Write what the runs are, or compare with what was written before.

    Runs may be added to a sweep, such as further seeds; those that are there stay what they are.
    """
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


class _Children:
    """The processes that train now."""

    def __init__(self) -> None:
        self._running: set[subprocess.Popen[str]] = set()
        self._lock = threading.Lock()
        self._stopped = False

    def run(self, folder: Path, cell: Cell) -> str:
        """Train one run to its end; what was said where it failed."""
        place = folder / cell.name
        if (place / RESULT_FILE).exists():
            return ""
        resume = ["--resume"] if (place / CONFIG_FILE).exists() else []
        words = ["train", *cell.arguments, "--out", str(place), "--quiet", *resume]
        with self._lock:
            if self._stopped:
                return "not begun"
            child = subprocess.Popen(
                [sys.executable, "-m", "ltlc.sweeps.child", *words],
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, encoding="utf-8",
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )  # fmt: skip
            self._running.add(child)
        assert child.stderr is not None
        said = child.stderr.read()  # its standard input stays open until it has ended
        code = child.wait()
        with self._lock:
            self._running.discard(child)
        if child.stdin is not None:
            child.stdin.close()
        child.stderr.close()
        if code == 0 or (place / RESULT_FILE).exists():
            return ""
        return said.strip() or f"it ended with code {code}"

    def stop(self) -> None:
        """End all of them."""
        with self._lock:
            self._stopped = True
            for child in self._running:
                child.terminate()
