"""The display of a training run while it goes on."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from ltlc.cli.messages import complain

if TYPE_CHECKING:
    from ltlc.mdp import Judge

MOST_JUDGING = 0.1
"""of the time of a training that judging on the way may take."""
Display = Callable[[Any], None]
"""Called with each row of metrics."""


@contextlib.contextmanager
def training_display(total_steps: int, *, quiet: bool, judge: Judge | None = None) -> Iterator[Display]:
    """A live bar on a terminal, about twenty plain lines elsewhere, nothing if quiet; what goes wrong in any case.

    Args:
        total_steps: of the training.
        quiet: whether to show nothing.
        judge: of the task, where the environment is known.
    """
    if quiet:
        yield _with_warnings(lambda progress: None)
        return
    figures = _Figures(judge)
    if sys.stdout.isatty():
        with _bar(total_steps, figures) as display:
            yield _with_warnings(display)
    else:
        yield _with_warnings(_Lines(total_steps, figures))


class _Figures:
    """A row as text, with what has been learned so far, judged exactly where that is possible and takes little time."""

    def __init__(self, judge: Judge | None) -> None:
        self.judge = judge
        self.spent = 0.0

    def __call__(self, progress: Any) -> str:
        row, found = progress.row, None
        if self.judge is not None and row.satisfaction is None and self.spent <= MOST_JUDGING * (row.seconds + 1):
            since = time.perf_counter()
            found = _satisfaction(self.judge, progress.agent)
            self.spent += time.perf_counter() - since
        return str(row.told(found))


def _satisfaction(judge: Judge, agent: Any) -> float | None:
    from ltlc.agents.training.report import tabular_policy

    if agent is None or agent.encoder.n_observations != judge.rewards.mdp.n_states:
        return None
    return float(judge.satisfaction(tabular_policy(agent, judge.rewards.mdp)))


def _with_warnings(display: Display) -> Display:
    def show(progress: Any) -> None:
        display(progress)
        for shortcoming in progress.shortcomings:
            complain(f"warning: {shortcoming}")

    return show


@contextlib.contextmanager
def _bar(total_steps: int, figures: Callable[[Any], str]) -> Iterator[Display]:
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
            bars.update(task, completed=steps, figures=figures(progress), left=clock(progress.seconds_left))

        yield display


class _Lines:
    def __init__(self, total_steps: int, figures: Callable[[Any], str]) -> None:
        self.total_steps, self.figures = total_steps, figures
        self.next = 0.0

    def __call__(self, progress: Any) -> None:
        row = progress.row
        if row.steps < min(self.next, self.total_steps):
            return
        self.next = row.steps + self.total_steps / 20
        print(f"{row.steps:>9} steps  {self.figures(progress)}  {clock(progress.seconds_left)} left", flush=True)


def clock(seconds: float) -> str:
    """Seconds as minutes:seconds, or hours:minutes:seconds."""
    minutes, rest = divmod(max(round(seconds), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
