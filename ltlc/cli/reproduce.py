"""`ltlc reproduce`: the experiments of the thesis, ours and the exact optimum beside it."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from ltlc.cli import flags
from ltlc.cli.messages import complain
from ltlc.cli.progress import training_display
from ltlc.cli.runtime import compare
from ltlc.cli.verdicts import number
from ltlc.errors import InvalidArgumentError

QUICK = 10
"""part of the steps that --quick makes."""
UNLEARNED = 0.2
"""part of the return that may be lost without a word."""


def reproduce(
    case: Annotated[Literal["case1", "case2", "runtime"], typer.Argument(help="Sections 5.1, 5.2, 5.3 of the thesis.")],
    static: Annotated[bool, typer.Option("--static", help="Only the static environment (cases 1 and 2).")] = False,
    dynamic: Annotated[bool, typer.Option("--dynamic", help="Only the dynamic one, labels seen by chance.")] = False,
    seeds: Annotated[
        int | None,
        typer.Option(
            "--seeds", metavar="N", help="Train with seeds 0 to N-1.", show_default="1; runtime 3, with --quick 1"
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A tenth of the steps, or one seed: to see that it works.")
    ] = False,
    out: Annotated[
        str | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            callback=flags.path_given,
            help="Where runs and figures go.",
            show_default="reproduce/CASE",
        ),
    ] = None,
    json_: flags.Json = False,
) -> None:
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
    thesis = import_module("ltlc.agents.thesis.case_studies")
    if case == "runtime" and (static or dynamic):
        raise InvalidArgumentError("the run-time comparison is static; leave --static and --dynamic out")
    if seeds is not None and seeds < 1:
        raise InvalidArgumentError(f"--seeds is {seeds}; at least 1 is needed")
    folder = Path("reproduce") / case if out is None else Path(out)
    if case == "runtime":
        raise typer.Exit(compare(folder, seeds, quick, json_))
    wanted = {"static": static, "dynamic": dynamic} if static != dynamic else {}
    outcomes: dict[str, list[Any]] = {}
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
                raise typer.Exit(complain("interrupted", code=130))
            outcomes.setdefault(name, []).append(done)
    pictures = _draw(thesis, case, folder, outcomes)
    if json_:
        print(json.dumps([_values(one) for runs in outcomes.values() for one in runs], indent=2))
        return
    for runs in outcomes.values():
        for one in runs:
            _print_outcome(one)
    print("Pictures:", *pictures, sep="\n  ")


def _draw(thesis: Any, case: str, folder: Path, outcomes: dict[str, list[Any]]) -> list[Path]:
    pictures = []
    for name, runs in outcomes.items():
        figure = {("case1", "static"): "figure-5.2", ("case1", "dynamic"): "figure-5.3"}.get((case, name))
        path = folder / f"{figure or f'policy-{name}'}.png"
        pictures.append(thesis.draw_learned(path, runs[0], title=_capital(runs[0].experiment.title)))
    path = folder / ("figure-5.4.png" if case == "case2" else "learning.png")
    title = {"case1": "Case study I", "case2": "Case study II"}[case]
    pictures.append(thesis.draw_learning(path, outcomes, title=title))
    return pictures


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _values(outcome: Any) -> dict[str, Any]:
    return {
        "experiment": outcome.experiment.title,
        "seed": outcome.seed,
        "thesis_hours": outcome.experiment.hours,
        "seconds": outcome.seconds,
        "nearly_optimal_after_seconds": outcome.nearly_optimal_after,
        "exact_solution_seconds": outcome.solved_in,
        **outcome.report.to_dict(),
    }


def _print_outcome(one: Any) -> None:
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
