"""The engine that a sweep has by itself: so many processes at a time on this machine."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from ltlc.errors import InvalidArgumentError
from ltlc.sweeps.engine import train_cell
from ltlc.sweeps.grid import Cell


@dataclass(frozen=True)
class Processes:
    """Trains in processes of this machine, each with one thread.

    Attributes:
        count: that train at a time.

    Raises:
        InvalidArgumentError: there is none.

    Example:
        >>> Processes(2)
        Processes(count=2)
    """

    count: int = 1

    def __post_init__(self) -> None:
        if self.count < 1:
            raise InvalidArgumentError(f"processes is {self.count}; it must be at least 1")

    def run(self, folder: Path, cells: Sequence[Cell]) -> Generator[tuple[Cell, str], None, None]:
        """See `Engine`."""
        children = _Children()
        with ThreadPoolExecutor(self.count) as pool:
            try:
                waiting = {pool.submit(train_cell, folder, cell, started=children.add): cell for cell in cells}
                for future in as_completed(waiting):
                    yield waiting[future], future.result()
            finally:
                children.stop()
                pool.shutdown(cancel_futures=True)


class _Children:
    """The processes that were started; they end when this one asks for it."""

    def __init__(self) -> None:
        self._all: list[subprocess.Popen[str]] = []
        self._lock = threading.Lock()
        self._stopped = False

    def add(self, child: subprocess.Popen[str]) -> bool:
        """Keep one; whether it may go on."""
        with self._lock:
            self._all.append(child)
            return not self._stopped

    def stop(self) -> None:
        """End those that still run."""
        with self._lock:
            self._stopped = True
            for child in self._all:
                if child.poll() is None:
                    child.terminate()
