"""`ltlc reproduce runtime`: tables 5.1 and 5.2 of the thesis, with every system."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from ltlc.cli.messages import complain


def compare(folder: Path, seeds: int | None, quick: bool, json_: bool) -> int:
    """Run the comparison, print its tables and draw it; the exit code."""
    runtime = import_module("ltlc.agents.thesis.runtime")
    picture = import_module("ltlc.agents.thesis.runtime_picture")
    folder.mkdir(parents=True, exist_ok=True)
    chosen = None if seeds is None else tuple(range(seeds))
    if not json_:
        print(
            "Good is a policy that satisfies the formula as probably as possible, and whose exact expected return is "
            f"within {100 * runtime.REGRET:g} % of the optimum.",
            flush=True,
        )
    show = None if json_ else _print_row
    try:
        rows = runtime.runtime_comparison(quick=quick, seeds=chosen, progress=show)
    except KeyboardInterrupt:
        return complain("interrupted before the tables were complete", code=130)
    drawn = picture.draw_runtime(folder / "runtime.png", rows)
    if json_:
        print(json.dumps([row.to_dict() for row in rows], indent=2))
        return 0
    _print_times(rows)
    _print_states(rows)
    print(f"Picture: {drawn}")
    return 0


def _print_row(row: Any) -> None:
    lost = f"{row.regret:.2%} lost" if row.regret < float("inf") else "no policy"
    done = f"{lost}; {row.reached} of {row.runs} good"
    print(f"{_case(row):12} {row.system:18} {row.seconds:7.2f} s {row.steps:8} steps  {done}", flush=True)


def _case(row: Any) -> str:
    return f"{row.world} {row.formula}"


def _print_times(rows: Sequence[Any]) -> None:
    """Table 5.1: ours in seconds, the thesis' in hours."""
    seconds_text = import_module("ltlc.agents.thesis.runtime_picture").seconds_text

    def ours(row: Any) -> str:
        time = seconds_text(row.seconds)
        return time if row.reached == row.runs else f"> {time} ({row.reached} of {row.runs})"

    def theirs(row: Any) -> str:
        return f"{row.thesis_hours} h" if row.thesis_hours else ""

    runs = rows[0].runs
    print(f"\nTime until good{'' if runs == 1 else f', median of {runs} seeds'} (table 5.1):")
    _print_table(rows, {"": ours, "thesis": theirs})


def _print_states(rows: Sequence[Any]) -> None:
    """Table 5.2: what each system builds or visits, what there is, and the thesis' figures."""

    def ours(row: Any) -> str:
        return "none" if row.product_states is None else str(row.product_states)

    first = [row for row in rows if row.system == rows[0].system]
    extra = {
        "reachable at all": [str(row.reachable_states) for row in first],
        "thesis": [str(row.thesis_product_states) for row in first],
    }
    print("States of the product, built or visited (table 5.2):")
    _print_table(rows, {"": ours}, extra)


def _print_table(
    rows: Sequence[Any],
    cells: dict[str, Callable[[Any], str]],
    extra: dict[str, list[str]] | None = None,
) -> None:
    """A line for each system and kind of cell, a column for each case."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table("", box=box.SIMPLE_HEAD, pad_edge=False)
    for case in dict.fromkeys(map(_case, rows)):
        table.add_column(case, justify="right")
    for system in dict.fromkeys(row.system for row in rows):
        own = [row for row in rows if row.system == system]
        for kind, cell in cells.items():
            line = [cell(row) for row in own]
            if any(line):
                table.add_row(f"  {kind}" if kind else system, *line, style="dim" if kind else "")
    for name, line in (extra or {}).items():
        table.add_row(name, *line, style="dim")
    Console(highlight=False).print(table)
