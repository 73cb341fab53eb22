"""Verdicts for a person: what was learned and what is best, side by side."""

from __future__ import annotations

import decimal
import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ltlc.cli.messages import complain

if TYPE_CHECKING:
    from ltlc.agents.training.run_folder import RunFolder
    from ltlc.faithful import Shortfall
    from ltlc.mdp.estimate import Estimate
    from ltlc.mdp.figures import Line
    from ltlc.mdp.verdict import Judge
    from ltlc.prism import Exported
    from ltlc.task import Task


def number(value: float | Estimate | None, bounds: tuple[float, float] | None = None) -> str:
    """A figure with its proved bounds, if any, or an interval, in a few characters."""
    from ltlc.mdp.figures import figure_text

    if value is None:
        return ""
    if not isinstance(value, float | int):
        return f"{number(value.value)}  [{number(value.low)}, {number(value.high)}]"
    return figure_text(value, bounds)


def print_figures(lines: Sequence[Line], headings: Sequence[str]) -> None:
    """Print a row per figure; columns without any entry are left out."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    columns = [column for column in range(1, 3) if any(line[column] is not None for line in lines)]
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for column in columns:
        table.add_column(headings[column - 1], justify="right")
    for line in lines:
        cells = ("", number(line.learned, line.learned_bounds), number(line.optimum, line.optimum_bounds))
        table.add_row(line.title, *(cells[column] for column in columns))
    Console(highlight=False).print(table)


def warn_of_shortfall(found: Shortfall | None, task: Task) -> None:
    """Print to stderr what the optimum of the rewards of a task misses, and the options for rewards that do not."""
    from ltlc.rewards import arguments_of

    if found is None:
        return
    how = ""
    if found.better is not None:
        better, (name, parameters) = found.better, arguments_of(found.better.scheme)
        options = [f"--reward {name}", *(f"--set {key}={json.dumps(value)}" for key, value in parameters.items())]
        if better.on_termination != "repeat" or task.on_termination != "repeat":
            options.append(f"--on-termination {better.on_termination}")
        if better.on_deadlock is not None:
            options.append(f"--on-deadlock {better.on_deadlock}")
        elif task.on_deadlock is not None:
            options.append("without --on-deadlock")
        how = f" ({' '.join(options)})"
    complain(f"warning: {found.text}{how}")


def fitted_text(run: RunFolder) -> str:
    """The rewards of a run whose agent has fitted them to what it can tell apart, and how to have others."""
    return (
        f"{run.learned_task.scheme}, fitted to how far a network looks ahead: what takes longer counts for less than "
        f"it does for the probability of satisfaction. Others: --hyper horizon=N (0: {run.task.scheme})"
    )


def checks_of(exported: Exported | None) -> dict[str, Any]:
    """The commands that check an answer again, as JSON values."""
    return {} if exported is None else {"check": {"prism": exported.prism, "storm": exported.storm}}


def print_checks(exported: Exported, probability: float) -> None:
    """Print the commands that check an answer again, and what they should say."""
    print(f"PRISM or Storm should find {probability:.6g}:")
    print(f"  {exported.prism}\n  {exported.storm}")


def maximum_text(judge: Judge) -> str:
    """Pmax with its bounds, and what that means for learning."""
    from ltlc.mdp.figures import figure_text

    maximum = judge.maximum
    value = maximum.probability
    if value == 0:
        return "The largest probability of satisfying the formula here is 0."
    text = figure_text(value, (maximum.lower, maximum.upper), digits=6)
    bounds = "" if maximum.lower == maximum.upper else f", {between(maximum.lower, maximum.upper)}"
    return f"The largest probability of satisfying the formula here is {text}{bounds}."


def between(lower: float, upper: float) -> str:
    """Two bounds, rounded outwards, with as many digits as it takes to see what is known, nine at least."""
    gap = -math.floor(math.log10(upper - lower)) + 1
    digits = min(max(9, gap), 17)
    down, up = (
        float(decimal.Context(prec=digits, rounding=rounding).create_decimal(bound))
        for bound, rounding in ((lower, decimal.ROUND_FLOOR), (upper, decimal.ROUND_CEILING))
    )
    return f"between {down:.{digits}g} and {up:.{digits}g}"
