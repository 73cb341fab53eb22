"""Where a training stands, and what it came to; for every agent."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .metrics import Row


@dataclass(frozen=True)
class Progress:
    """Where a training stands; callbacks get it with each row of metrics.

    Attributes:
        agent: what has been learned so far; None: nothing yet.
        row: the metrics.
        total_steps: environment steps of the whole training.
        shortcomings: what the training lacks so far, see `shortcomings`; told once, after a quarter of the steps.
    """

    agent: Any
    row: Row
    total_steps: int
    shortcomings: tuple[str, ...] = ()

    @property
    def seconds_left(self) -> float:
        """Estimated seconds to go, at the speed so far; fewer where the agent ends before its steps do."""
        return self.row.seconds * (self.total_steps / max(self.row.steps, 1) - 1)


@dataclass(frozen=True)
class TrainingResult:
    """What a training came to.

    Attributes:
        agent: what has learned. None: it was interrupted before anything was learned, or there is no policy that
            satisfies the formula with any probability; `message` says so.
        steps: environment steps since the start of training.
        total_steps: those that were asked for.
        seconds: of training, interruptions not counted.
        interrupted: whether it stopped on Ctrl-C.
        folder: of the run, if any.
        saved_steps: environment steps that the checkpoint in the folder holds.
        shortcomings: what the training lacked, and what to try; see `shortcomings`.
        message: how training ended, where there is more to say than that its steps were made.
    """

    agent: Any
    steps: int
    total_steps: int
    seconds: float
    interrupted: bool = False
    folder: Path | None = None
    saved_steps: int = 0
    shortcomings: tuple[str, ...] = ()
    message: str = ""

    def __str__(self) -> str:
        text = f"{self.steps} of {self.total_steps} steps in {self.seconds:.1f} s"
        if not self.interrupted:
            return text
        if self.folder is None:
            return f"{text}, interrupted; nothing was written, since no folder was given"
        return f"{text}, interrupted; {self.saved_steps} are in {self.folder}. Go on with train(..., resume=True)"


Callback = Callable[[Progress], bool | None]
"""Called with each row of metrics; stops the training by returning True."""


class Stopwatch:
    """Seconds of training.

    Args:
        before: seconds of what was trained before.
    """

    def __init__(self, before: float = 0.0) -> None:
        self._since = time.perf_counter() - before

    @property
    def seconds(self) -> float:
        """Seconds so far, without those that were paused."""
        return time.perf_counter() - self._since

    @contextlib.contextmanager
    def paused(self) -> Iterator[None]:
        """Let the clock stand still meanwhile."""
        before = time.perf_counter()
        try:
            yield
        finally:
            self._since += time.perf_counter() - before
