"""What carries out the runs of a sweep, and how one of them is trained."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from pathlib import Path
from typing import Protocol

from ltlc.agents.training.folder_lock import is_locked
from ltlc.agents.training.run_folder import CONFIG_FILE, RESULT_FILE
from ltlc.sweeps.grid import Cell

_PATIENCE = 30.0
"""seconds in which a process of a sweep that was killed must have ended; it does so at once where it is not stuck."""


class Engine(Protocol):
    """Carries out runs, many at a time.

    `train_cell` is the whole work for one of them; an engine says where and when it is called.
    """

    def run(self, folder: Path, cells: Sequence[Cell]) -> Generator[tuple[Cell, str], None, None]:
        """Train runs to their ends.

        When the iterator is closed, everything that it has started ends as well.

        Args:
            folder: of the sweep.
            cells: the runs; none of them has ended yet.

        Yields:
            Each run as it ends, in any order, with what its command said where it failed, else "".
        """
        ...


def is_done(folder: Path, cell: Cell) -> bool:
    """Whether a run has its verdict."""
    return (folder / cell.name / RESULT_FILE).exists()


def train_cell(
    folder: Path,
    cell: Cell,
    *,
    cwd: str | None = None,
    environ: Mapping[str, str] | None = None,
    started: Callable[[subprocess.Popen[str]], bool] = lambda child: True,
) -> str:
    """Train one run in a process of its own, from its checkpoint if there is one; that process ends with this one.

    Args:
        folder: of the sweep.
        cell: the run.
        cwd: where relative paths begin; None: where this process has them begin.
        environ: variables for the process, over those of this one.
        started: called with the process; False ends it.

    Returns:
        What it said where it failed; else "".
    """
    root = Path(cwd) if cwd is not None else Path()
    place = folder / cell.name
    if is_done(root / folder, cell):
        return ""
    deadline = time.monotonic() + _PATIENCE
    while is_locked(root / place) and time.monotonic() < deadline:  # by a run of a sweep that has just been killed
        time.sleep(0.1)
    resume = ["--resume"] if (root / place / CONFIG_FILE).exists() else []
    child = subprocess.Popen(
        [sys.executable, "-m", "ltlc.sweeps.child", "train", *cell.arguments, "--out", str(place), "--quiet", *resume],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, encoding="utf-8", cwd=cwd,
        env={**os.environ, **(environ or {}), "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    with child:
        if not started(child):
            child.terminate()
        assert child.stderr is not None
        said = child.stderr.read()  # its standard input stays open until it has ended
        code = child.wait()
    if code == 0 or is_done(root / folder, cell):
        return ""
    return said.strip() or f"it ended with code {code}"
