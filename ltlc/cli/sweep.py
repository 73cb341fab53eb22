"""`ltlc sweep`: many trainings from one file."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Literal

from ltlc.cli import flags
from ltlc.cli.messages import complain
from ltlc.cli.options import Argument, Option
from ltlc.cli.verdicts import number

if TYPE_CHECKING:
    from ltlc.sweeps import Engine, Progress, Row


def sweep(
    grid: Annotated[str, Argument(metavar="GRID", is_path=True, help="A .toml file that says what to run.")],
    processes: Annotated[
        int | None,
        Option("--processes", "-j", least=1, metavar="N", help="Runs at a time.", shown_default="one per core"),
    ] = None,
    engine: Annotated[
        Literal["processes", "ray"],
        Option(
            "--engine",
            help="Processes of this machine, or tasks of Ray: on the cluster that there is, else on "
            "one of its own here.",
        ),
    ] = "processes",
    json_: flags.Json = False,
) -> int:
    """Train formulas x environments x rewards x agents x seeds, and make one table of what came out.

    Each run has a folder of its own, as 'ltlc train' makes it. Started again,
    a sweep goes on where it was cut, and comes out the same to the byte; runs
    may be added to the file meanwhile.

    \b
    A file:
      seeds = 5
      steps = 10000
      \\[formulas]
      reach = "F goal & G !hole"
      \\[environments]
      lake = { env = "FrozenLake-v1", labels = "lake:labels" }
      \\[rewards]
      two-discount = {}
      short = { reward = "two-discount", gamma = 0.99 }
      \\[agents]
      fitted-q = {}
      q-learning = {}

    \b
    Examples:
      ltlc sweep grid.toml
      ltlc sweep grid.toml --processes 2 --json
      ltlc sweep grid.toml --engine ray
    """
    from ltlc.sweeps import read_grid, run_grid, table_of, write_table

    wanted = read_grid(grid)

    def told(progress: Progress) -> None:
        if not json_:
            print(
                f"[{progress.done}/{progress.total}] {progress.cell.name}{' failed' * bool(progress.error)}", flush=True
            )

    failed = run_grid(wanted, engine=_engine(engine, processes), report=told)
    files = write_table(wanted)
    rows = table_of(wanted)
    if json_:
        values = [asdict(row) | {"mean": None if row.mean is None else asdict(row.mean)} for row in rows]
        print(json.dumps({"rows": values, "failed": failed}, ensure_ascii=False, indent=2))
    else:
        _print(rows)
        print(f"Files: {', '.join(map(str, files))}")
    for name, said in failed.items():
        complain(f"{name}: {said.removeprefix('ltlc: ')}")
    return 1 if failed else 0


def _engine(name: Literal["processes", "ray"], processes: int | None) -> Engine:
    if name == "ray":
        from ltlc.sweeps.ray_engine import RayTasks

        return RayTasks(processes)
    from ltlc.sweeps import Processes

    return Processes(processes or os.cpu_count() or 1)


def _print(rows: list[Row]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("formula", "environment", "reward", "agent"):
        table.add_column(heading)
    for heading in ("seeds", "P(satisfied) [95 %]", "possible"):
        table.add_column(heading, justify="right")
    for row in rows:
        alone = row.values[0] if row.values else None
        middle = number(row.mean if row.mean is not None else alone) or "nothing learned"
        if row.values and not row.exact:
            middle += " (sampled)"
        seeds = str(row.seeds) if len(row.values) == row.seeds else f"{len(row.values)} of {row.seeds}"
        table.add_row(row.formula, row.environment, row.reward, row.agent, seeds, middle, number(row.maximum))
    Console(highlight=False).print(table)
