"""The display of a training run while it goes on."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import Any

from ltlc.cli.messages import complain

Display = Callable[[Any], None]
"""Called with each row of metrics."""


@contextlib.contextmanager
def training_display(total_steps: int, *, quiet: bool) -> Iterator[Display]:
    """A live bar on a terminal, about twenty plain lines elsewhere, nothing if quiet; what goes wrong in any case."""
    if quiet:
        yield _with_warnings(lambda progress: None)
    elif sys.stdout.isatty():
        with _bar(total_steps) as display:
            yield _with_warnings(display)
    else:
        yield _with_warnings(_Lines(total_steps))


def _with_warnings(display: Display) -> Display:
    def show(progress: Any) -> None:
        display(progress)
        for shortcoming in progress.shortcomings:
            complain(f"warning: {shortcoming}")

    return show


@contextlib.contextmanager
def _bar(total_steps: int) -> Iterator[Display]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("steps  {task.fields[figures]}"),
        TextColumn("[dim]{task.fields[left]} left"),
    )
    with Progress(*columns, console=Console(highlight=False)) as bars:
        task = bars.add_task("training", total=total_steps, figures="", left="?")

        def display(progress: Any) -> None:
            row = progress.row
            steps = min(row.steps, total_steps)
            bars.update(task, completed=steps, figures=row.text, left=clock(progress.seconds_left))

        yield display


class _Lines:
    def __init__(self, total_steps: int) -> None:
        self.total_steps = total_steps
        self.next = 0.0

    def __call__(self, progress: Any) -> None:
        row = progress.row
        if row.steps < min(self.next, self.total_steps):
            return
        self.next = row.steps + self.total_steps / 20
        print(f"{row.steps:>9} steps  {row.text}  {clock(progress.seconds_left)} left", flush=True)


def clock(seconds: float) -> str:
    """Seconds as minutes:seconds, or hours:minutes:seconds."""
    minutes, rest = divmod(max(round(seconds), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
