"""Metrics of a training run: CSV files always, TensorBoard where it is installed.

What is measured by the clock has a file of its own, so that the rest is the same in every run of a configuration.
"""

from __future__ import annotations

import contextlib
import csv
import io
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ltlc.atomic import atomic_write_all
from ltlc.errors import FileFormatError
from ltlc.mdp.figures import figure_text

from .collect import Episode
from .contents import Content

METRICS_FILE = "metrics.csv"
TIMES_FILE = "times.csv"


@dataclass(frozen=True, kw_only=True)
class Row:
    """Metrics of a training, of the steps since the row before; None: not known, or nothing of the kind there.

    Attributes:
        steps: environment steps since the start of training.
        seconds: of training, interruptions and judging not counted.
        updates: how often the agent has learned, since the start of training.
        episodes: that ended since the row before; the next four are means over them.
        episode_return: sum of rewards, undiscounted.
        episode_length: steps.
        violations: steps that entered a deadlock of the automaton.
        acceptances: accepting steps.
        loss: mean loss of the updates; of the fits of a table, the largest change in the last sweep.
        epsilon: probability of an exploring action.
        learning_rate: of a network.
        value: a tabular learner's own estimate of its objective.
        product_states: that it has built, or visited.
        accepting_components: accepting maximal end components of the product that it has built.
        satisfaction: exact probability that its policy so far satisfies the formula.
        discounted_return: exact expected return of its policy so far.
        message: where it stands, in a few words; not in the file.
        successes: of the episodes, those with an accepting step and no violation; not in the file.
    """

    steps: int
    seconds: float = 0.0
    updates: int | None = None
    episodes: int | None = None
    episode_return: float | None = None
    episode_length: float | None = None
    violations: float | None = None
    acceptances: float | None = None
    loss: float | None = None
    epsilon: float | None = None
    learning_rate: float | None = None
    value: float | None = None
    product_states: int | None = None
    accepting_components: int | None = None
    satisfaction: float | None = None
    discounted_return: float | None = None
    message: str = ""
    successes: int | None = None

    def to_dict(self) -> dict[str, float]:
        """What is known, as numbers by name, for loggers such as `wandb.log`."""
        values = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "message"}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def text(self) -> str:
        """The row for a person."""
        return self.told()

    def told(self, satisfaction: float | None = None) -> str:
        """The row for a person.

        Args:
            satisfaction: the satisfaction probability of what has been learned so far; None: it is not known, and the
                part of the episodes with an accepting step and no violation stands for it, exploration included.
        """
        if self.satisfaction is not None and self.discounted_return is not None:
            return f"P(satisfied) {figure_text(self.satisfaction)}  return {figure_text(self.discounted_return)}"
        if self.value is not None:
            return self.message or f"own estimate {figure_text(self.value)}"
        known = "" if satisfaction is None else f"P(satisfied) {figure_text(satisfaction)}  "
        if self.episode_return is None or self.violations is None:
            return f"{known}no episode ended"
        if not known and self.successes is not None and self.episodes:
            known = f"P(satisfied) about {self.successes / self.episodes:.2f}  "
        return f"{known}return {self.episode_return:.1f}  violations {self.violations:.2f}"


TIMES_HEADER = ("steps", "seconds")
_HEADER = tuple(field.name for field in fields(Row) if field.name not in ("seconds", "message", "successes"))


class Metrics:
    """Collects what happens and writes a row now and then.

    Args:
        folder: where `metrics.csv`, `times.csv` and the TensorBoard events go; None: nowhere.
        steps: environment steps made so far; what the files say about later ones is dropped.

    Attributes:
        seconds: of the steps made so far, up to the last row.

    Raises:
        FileFormatError: there is a `metrics.csv` or `times.csv` that is not of a training run.
    """

    def __init__(self, folder: Path | None, steps: int = 0) -> None:
        self._folder = folder
        self.seconds = 0.0
        self._losses: list[float] = []
        self._episodes: list[Episode] = []
        self._writer: Any = None
        if folder is not None:
            times = _kept_rows(folder / TIMES_FILE, TIMES_HEADER, steps)
            with contextlib.suppress(ValueError):  # the header, or a number that is none
                self.seconds = float(times[-1].split(",")[1])
            rows = _kept_rows(folder / METRICS_FILE, _HEADER, steps)
            atomic_write_all({folder / TIMES_FILE: "".join(times), folder / METRICS_FILE: "".join(rows)})
            with contextlib.suppress(ImportError):  # TensorBoard is optional
                from torch.utils.tensorboard.writer import SummaryWriter  # late: it is slow

                self._writer = SummaryWriter(str(folder), purge_step=steps or None)

    def add(self, episodes: list[Episode], losses: list[float]) -> None:
        """Take in what happened in a step."""
        self._episodes += episodes
        self._losses += losses

    def row(self, steps: int, updates: int, epsilon: float, learning_rate: float | None, seconds: float) -> Row:
        """Write a row, and begin the next."""
        episodes, n = self._episodes, len(self._episodes)
        row = Row(
            steps=steps,
            updates=updates,
            episodes=n,
            episode_return=sum(e.reward for e in episodes) / n if n else None,
            episode_length=sum(e.length for e in episodes) / n if n else None,
            violations=sum(e.violations for e in episodes) / n if n else None,
            acceptances=sum(e.acceptances for e in episodes) / n if n else None,
            loss=sum(self._losses) / len(self._losses) if self._losses else None,
            epsilon=epsilon,
            learning_rate=learning_rate,
            seconds=seconds,
            successes=sum(e.acceptances > 0 and e.violations == 0 for e in episodes) if n else None,
        )
        self._episodes, self._losses = [], []
        self.write(row)
        return row

    def write(self, row: Row) -> None:
        """Append a row to the files."""
        if self._folder is not None:
            _append(self._folder / TIMES_FILE, csv_line([row.steps, row.seconds]))
            _append(self._folder / METRICS_FILE, csv_line(getattr(row, name) for name in _HEADER))
        if self._writer is not None:
            for name, value in row.to_dict().items():
                if name != "steps":
                    self._writer.add_scalar(name, value, row.steps)

    def state_dict(self) -> dict[str, Any]:
        """What has been taken in since the last row, as numbers."""
        return {
            "losses": list(self._losses),
            "episodes": [[e.reward, e.length, e.violations, e.acceptances] for e in self._episodes],
        }

    @staticmethod
    def check_state(content: Content) -> None:
        """Check what `state_dict` gave, read from a file.

        Raises:
            FileFormatError: it is something else.
        """
        for loss in content["losses"].entries():
            loss.number()
        for episode in content["episodes"].entries():
            reward, *counts = episode.entries(len(fields(Episode)))
            reward.number()
            for count in counts:
                count.count()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go back to what `state_dict` gave."""
        self._losses = list(state["losses"])
        self._episodes = [Episode(*values) for values in state["episodes"]]

    def close(self) -> None:
        """Finish the TensorBoard file."""
        if self._writer is not None:
            self._writer.close()


def csv_line(values: Iterable[Any]) -> str:
    """A row of a CSV file; None is an empty field."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerow(["" if value is None else value for value in values])
    return stream.getvalue()


def read_rows(folder: Path) -> list[dict[str, float | None]]:
    """The rows of `metrics.csv` with the seconds of `times.csv`; None where there is no value.

    Raises:
        FileFormatError: a file is damaged.
        OSError: `metrics.csv` is missing, or one is not readable.
    """
    rows = _numbers(folder / METRICS_FILE)
    times = _numbers(folder / TIMES_FILE) if (folder / TIMES_FILE).exists() else []
    seconds = [row.get("seconds") for row in times] + [None] * len(rows)
    return [{**row, "seconds": second} for row, second in zip(rows, seconds, strict=False)]


def _numbers(path: Path) -> list[dict[str, float | None]]:
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            return [
                {key: float(value) if value else None for key, value in row.items()} for row in csv.DictReader(stream)
            ]
    except (ValueError, AttributeError, TypeError, csv.Error) as error:
        raise FileFormatError(f"{path}: {error}") from error


def _append(path: Path, line: str) -> None:
    """Add a line to a file.

    Raises:
        OSError: it cannot be written; `filename` is the path.
    """
    try:
        with path.open("a", encoding="utf-8", newline="") as stream:
            stream.write(line)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def _kept_rows(path: Path, header: Iterable[str], steps: int) -> list[str]:
    """The header and the rows up to so many steps; a last line that was cut short is left out, too."""
    kept = [csv_line(header)]
    if steps and path.exists():
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        if not lines or lines[0] != kept[0]:
            raise FileFormatError(f"{path}: line 1 is not the header of a training run; move the file away to go on")
        for line in lines[1:]:
            first = line.split(",", 1)[0]
            if line.endswith("\n") and first.isdecimal() and int(first) <= steps:
                kept.append(line)
    return kept
