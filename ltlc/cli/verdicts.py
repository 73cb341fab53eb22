"""Verdicts for a person: what was learned and what is best, side by side."""

from __future__ import annotations

import decimal
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ltlc.mdp.verdict import Judge
    from ltlc.prism import Exported


def number(value: Any) -> str:
    """A figure, or an interval, in a few characters."""
    if value is None:
        return ""
    if not isinstance(value, float | int):  # an estimate
        return f"{number(value.value)}  [{number(value.low)}, {number(value.high)}]"
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if math.isnan(value):
        return "undefined"
    if value == int(value) and abs(value) < 1e6:
        return str(int(value))
    return f"{value:.1f}" if abs(value) >= 100 else f"{value:.4g}"


def print_figures(lines: Sequence[tuple[str, Any, Any]], headings: Sequence[str]) -> None:
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
        table.add_row(line[0], *(number(line[column]) for column in columns))
    Console(highlight=False).print(table)


def checks_of(exported: Exported | None) -> dict[str, Any]:
    """The commands that check an answer again, as JSON values."""
    return {} if exported is None else {"check": {"prism": exported.prism, "storm": exported.storm}}


def print_checks(exported: Exported, probability: float) -> None:
    """Print the commands that check an answer again, and what they should say."""
    print(f"PRISM or Storm should find {probability:.6g}:")
    print(f"  {exported.prism}\n  {exported.storm}")


def maximum_text(judge: Judge) -> str:
    """Pmax with its bounds, and what that means for learning."""
    maximum = judge.maximum
    value = maximum.probability
    if value == 0:
        return "The largest probability of satisfying the formula here is 0."
    bounds = "" if maximum.lower == maximum.upper else f", {between(maximum.lower, maximum.upper)}"
    return f"The largest probability of satisfying the formula here is {value:.6g}{bounds}."


def between(lower: float, upper: float) -> str:
    """Two bounds, rounded outwards, with as many digits as it takes to see what is known, nine at least."""
    gap = -math.floor(math.log10(upper - lower)) + 1
    digits = min(max(9, gap), 17)
    down, up = (
        float(decimal.Context(prec=digits, rounding=rounding).create_decimal(bound))
        for bound, rounding in ((lower, decimal.ROUND_FLOOR), (upper, decimal.ROUND_CEILING))
    )
    return f"between {down:.{digits}g} and {up:.{digits}g}"
