"""Ray as the engine of a sweep: a cluster that is there, or one on this machine."""

from __future__ import annotations

import os
import socket
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ltlc.errors import InvalidArgumentError, MissingProgramError
from ltlc.sweeps.engine import train_cell
from ltlc.sweeps.grid import Cell

try:
    import ray
except ImportError as error:
    raise MissingProgramError.of_library("ray", "ray", error) from error

_HANDED_ON = ("LTLC_", "PYTHONPATH", "PYTHONHASHSEED")
"""how the names of variables begin that trainings elsewhere must know."""

_PATIENCE = 10.0
"""seconds in which a cluster must answer."""


@dataclass(frozen=True)
class RayTasks:
    """Trains in tasks of Ray, each on one core.

    The cluster is the one that this process has connected to, else the one at `address`, at RAY_ADDRESS or started by
    `ray start` on this machine, else a new one on this machine, which ends with the sweep. Its machines must have ltlc
    and see the folder of the sweep and that of this process at the same paths, as on a network file system.

    Attributes:
        workers: cores of a new cluster; in another one, runs at a time; None: all there are.
        address: of a cluster; "local": a new one in any case; None: see above.

    Raises:
        InvalidArgumentError: there is no worker.

    Example:
        run_grid(grid, engine=RayTasks(workers=2))
    """

    workers: int | None = None
    address: str | None = None

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise InvalidArgumentError(f"workers is {self.workers}; it must be at least 1")

    def run(self, folder: Path, cells: Sequence[Cell]) -> Generator[tuple[Cell, str], None, None]:
        """See `Engine`.

        Raises:
            InvalidArgumentError: there is no cluster at the address.
        """
        ours = not ray.is_initialized()
        if ours:
            self._connect()
        try:
            train = ray.remote(num_cpus=1)(_trained)
            environ = {name: value for name, value in os.environ.items() if name.startswith(_HANDED_ON)}
            there = os.getcwd(), environ
            left, waiting = list(cells), dict[Any, Cell]()
            try:
                while left or waiting:
                    while left and len(waiting) < (self.workers or len(cells)):
                        cell = left.pop(0)
                        waiting[train.remote(folder, cell, *there)] = cell
                    (reference,), _ = ray.wait(list(waiting), num_returns=1)
                    yield waiting.pop(reference), _answer(reference)
            finally:
                for reference in waiting:
                    ray.cancel(reference, force=True)
        finally:
            if ours:
                ray.shutdown()

    def _connect(self) -> None:
        quiet = {"log_to_driver": False, "logging_level": "error", "configure_logging": False}
        given = self.address or os.environ.get("RAY_ADDRESS")
        if given != "local":
            try:
                _knock(given or "")
                ray.init(address=given or "auto", **quiet)
            except OSError as error:
                if given not in (None, "auto"):
                    raise InvalidArgumentError(f"no cluster of Ray answers at {given}: {error}") from error
            else:
                return
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # a new cluster sends nothing to anybody
        ray.init(address="local", num_cpus=self.workers, include_dashboard=False, **quiet)


def _knock(address: str) -> None:
    """See whether anybody listens at host:port; Ray itself asks for minutes.

    Raises:
        OSError: nobody does.
    """
    host, colon, port = address.rpartition(":")
    if colon and port.isdecimal() and "/" not in host:
        socket.create_connection((host, int(port)), timeout=_PATIENCE).close()


def _trained(folder: Path, cell: Cell, cwd: str, environ: dict[str, str]) -> str:
    """What a task does."""
    return train_cell(folder, cell, cwd=cwd, environ=environ)


def _answer(reference: Any) -> str:
    try:
        return str(ray.get(reference))
    except ray.exceptions.RayError as error:  # a machine is lost, or has no ltlc
        return f"Ray: {error}"
