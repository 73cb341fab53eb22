"""`ltlc reproduce`: the experiments of the thesis, ours and the exact optimum beside it."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from ltlc.cli import flags
from ltlc.cli.messages import complain
from ltlc.cli.options import Argument, Option
from ltlc.cli.progress import training_display
from ltlc.cli.verdicts import number
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.agents.thesis.case_studies import Outcome
    from ltlc.agents.thesis.runtime import RuntimeRow

QUICK = 10
"""part of the steps that --quick makes."""
UNLEARNED = 0.2
"""part of the return that may be lost without a word."""


def reproduce(
    case: Annotated[Literal["case1", "case2", "runtime"], Argument(help="Sections 5.1, 5.2, 5.3 of the thesis.")],
    static: Annotated[bool, Option("--static", help="Only the static environment (cases 1 and 2).")] = False,
    dynamic: Annotated[bool, Option("--dynamic", help="Only the dynamic one, labels seen by chance.")] = False,
    seeds: Annotated[
        int | None,
        Option("--seeds", metavar="N", help="Train with seeds 0 to N-1.", shown_default="1; runtime 3, with --quick 1"),
    ] = None,
    quick: Annotated[bool, Option("--quick", help="A tenth of the steps, or one seed: to see that it works.")] = False,
    out: Annotated[
        str | None,
        Option(
            "--out",
            "-o",
            metavar="DIR",
            is_path=True,
            help="Where runs and figures go.",
            shown_default="reproduce/CASE",
        ),
    ] = None,
    json_: flags.Json = False,
) -> int:
    """Run the experiments of the thesis and print its figures beside ours.

    Recorded automata and rewards are those of the thesis; the agents are ours,
    and every figure of ours is exact, since the worlds are known. 'runtime' is
    about tables 5.1 and 5.2: how long each system takes to the same quality,
    and how many states of the product it builds; about two minutes in all.

    \b
    Examples:
      ltlc reproduce case1
      ltlc reproduce case2 --dynamic --seeds 5
      ltlc reproduce runtime --quick
    """
    from ltlc.agents.thesis import case_studies as thesis

    if case == "runtime" and (static or dynamic):
        raise InvalidArgumentError("the run-time comparison is static; leave --static and --dynamic out")
    if seeds is not None and seeds < 1:
        raise InvalidArgumentError(f"--seeds is {seeds}; at least 1 is needed")
    folder = Path("reproduce") / case if out is None else Path(out)
    if case == "runtime":
        return _compare_runtime(folder, seeds, quick, json_)
    wanted = {"static": static, "dynamic": dynamic} if static != dynamic else {}
    outcomes: dict[str, list[Outcome]] = {}
    for name, experiment in thesis.EXPERIMENTS[case].items():
        if not wanted.get(name, not wanted):
            continue
        steps = experiment.steps // QUICK if quick else experiment.steps
        for seed in range(seeds or 1):
            if not json_:
                print(f"{experiment.title}, seed {seed}: {steps} steps", flush=True)
            with training_display(steps, quiet=json_) as display:
                done = thesis.reproduce(experiment, folder / f"{name}-{seed}", seed=seed, steps=steps, callback=display)
            if done is None:
                return complain("interrupted", code=130)
            outcomes.setdefault(name, []).append(done)
    pictures = _draw(case, folder, outcomes)
    if json_:
        print(json.dumps([_values(one) for runs in outcomes.values() for one in runs], indent=2))
        return 0
    for runs in outcomes.values():
        for one in runs:
            _print_outcome(one)
    print("Pictures:", *pictures, sep="\n  ")
    return 0


def _draw(case: str, folder: Path, outcomes: dict[str, list[Outcome]]) -> list[Path]:
    from ltlc.agents.thesis.case_studies import draw_learned, draw_learning

    pictures = []
    for name, runs in outcomes.items():
        figure = {("case1", "static"): "figure-5.2", ("case1", "dynamic"): "figure-5.3"}.get((case, name))
        path = folder / f"{figure or f'policy-{name}'}.png"
        pictures.append(draw_learned(path, runs[0], title=_capital(runs[0].experiment.title)))
    path = folder / ("figure-5.4.png" if case == "case2" else "learning.png")
    title = {"case1": "Case study I", "case2": "Case study II"}[case]
    pictures.append(draw_learning(path, outcomes, title=title))
    return pictures


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _values(outcome: Outcome) -> dict[str, Any]:
    return {
        "experiment": outcome.experiment.title,
        "seed": outcome.seed,
        "thesis_hours": outcome.experiment.hours,
        "seconds": outcome.seconds,
        "nearly_optimal_after_seconds": outcome.nearly_optimal_after,
        "exact_solution_seconds": outcome.solved_in,
        **outcome.report.to_dict(),
    }


def _print_outcome(one: Outcome) -> None:
    """What the thesis says, what we learned, and what is best."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    experiment, verdict, optimum = one.experiment, one.verdict, one.judge.optimum
    nearly = one.nearly_optimal_after
    table = Table(f"{experiment.title}, seed {one.seed}", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("thesis", "learned", "exact optimum"):
        table.add_column(heading, justify="right")
    table.add_row("time", f"{experiment.hours:g} h", f"{one.seconds:.1f} s", f"{one.solved_in:.2f} s")
    table.add_row("  until within 1 %", "", "not reached" if nearly is None else f"{nearly:.1f} s")
    for title, name in _FIGURES.items():
        table.add_row(title, "", number(getattr(verdict, name)), number(getattr(optimum, name)))
    maximum = one.judge.maximum
    learned = number(verdict.satisfaction, verdict.satisfaction_bounds)
    table.add_row("P(formula satisfied)", "", learned, number(maximum.probability, (maximum.lower, maximum.upper)))
    Console(highlight=False).print(table)
    regret = one.report.regret
    if regret is not None and regret > UNLEARNED:
        print(
            f"Not learned in these steps: {regret:.0%} of the optimal discounted return is lost. What an episode "
            "brings is counted to its end, however late a policy that goes in circles gets there. Take more steps."
        )


_FIGURES = {
    "return, discounted": "discounted_return",
    "return of an episode": "total_return",
    "steps of an episode": "steps",
    "violations in an episode": "violations_per_episode",
    "violations per step": "violations_per_step",
    "acceptances per 1000 steps": "acceptances_per_1000_steps",
}


def _compare_runtime(folder: Path, seeds: int | None, quick: bool, json_: bool) -> int:
    """Run the comparison of tables 5.1 and 5.2, print them and draw it; the exit code."""
    from ltlc.agents.thesis.runtime import REGRET, runtime_comparison
    from ltlc.envs import recorded_automaton
    from ltlc.pictures.runtime import draw_runtime

    folder.mkdir(parents=True, exist_ok=True)
    chosen = None if seeds is None else tuple(range(seeds))
    if not json_:
        print(
            "Good is a policy that satisfies the formula as probably as possible, and whose exact expected return is "
            f"within {100 * REGRET:g} % of the optimum.",
            flush=True,
        )
    show = None if json_ else _print_row
    try:
        rows = runtime_comparison(quick=quick, seeds=chosen, progress=show)
    except KeyboardInterrupt:
        return complain("interrupted before the tables were complete", code=130)
    formulas = {row.formula: recorded_automaton(row.formula).formula or row.formula for row in rows}
    drawn = draw_runtime(folder / "runtime.png", rows, formulas=formulas, regret=REGRET)
    if json_:
        print(json.dumps([row.to_dict() for row in rows], indent=2))
        return 0
    _print_times(rows)
    _print_states(rows)
    print(f"Picture: {drawn}")
    return 0


def _print_row(row: RuntimeRow) -> None:
    lost = f"{row.regret:.2%} lost" if row.regret < float("inf") else "no policy"
    done = f"{lost}; {row.reached} of {row.runs} good"
    print(f"{_case(row):12} {row.system:18} {row.seconds:7.2f} s {row.steps:8} steps  {done}", flush=True)


def _case(row: RuntimeRow) -> str:
    return f"{row.world} {row.formula}"


def _print_times(rows: Sequence[RuntimeRow]) -> None:
    """Table 5.1: ours in seconds, the thesis' in hours."""
    from ltlc.pictures.runtime import seconds_text

    def ours(row: RuntimeRow) -> str:
        time = seconds_text(row.seconds)
        return time if row.reached == row.runs else f"> {time} ({row.reached} of {row.runs})"

    def theirs(row: RuntimeRow) -> str:
        return f"{row.thesis_hours} h" if row.thesis_hours else ""

    runs = rows[0].runs
    print(f"\nTime until good{'' if runs == 1 else f', median of {runs} seeds'} (table 5.1):")
    _print_table(rows, {"": ours, "thesis": theirs})


def _print_states(rows: Sequence[RuntimeRow]) -> None:
    """Table 5.2: what each system builds or visits, what there is, and the thesis' figures."""

    def ours(row: RuntimeRow) -> str:
        return "none" if row.product_states is None else str(row.product_states)

    first = [row for row in rows if row.system == rows[0].system]
    extra = {
        "reachable at all": [str(row.reachable_states) for row in first],
        "thesis": [str(row.thesis_product_states) for row in first],
    }
    print("States of the product, built or visited (table 5.2):")
    _print_table(rows, {"": ours}, extra)


def _print_table(
    rows: Sequence[RuntimeRow],
    cells: dict[str, Callable[[RuntimeRow], str]],
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
