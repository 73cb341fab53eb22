"""`ltlc faithful`: what each reward scheme really optimises in a known environment."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from ltlc.cli import flags, spec
from ltlc.cli.diagnostics import tell
from ltlc.cli.options import Argument, Option
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.faithful import Candidate, FaithfulnessReport


def faithful(
    formula: Annotated[str, Argument(metavar="FORMULA", help="A formula, a .json or .hoa file, or -.")],
    env: spec.GivenEnv,
    labels: spec.Labels = None,
    variables: spec.Variables = None,
    env_set: spec.EnvArguments = None,
    initial_label: spec.InitialLabel = "read",
    reward: Annotated[
        list[str] | None,
        Option(
            "--reward",
            "-r",
            metavar="NAME[,KEY=VALUE...]",
            help="A scheme from 'ltlc rewards', with parameters. May be repeated.",
            shown_default="all, with the parameters of their papers",
        ),
    ] = None,
    on_deadlock: spec.OnDeadlock = None,
    on_termination: spec.OnTermination = "repeat",
    finite: flags.Finite = False,
    goal: flags.Goal = "reach",
    exclusive: flags.Exclusive = None,
    acceptance: flags.Acceptance = "state",
    translator: flags.Translator = "auto",
    output: Annotated[
        str | None,
        Option("--output", "-o", metavar="FILE", is_path=True, help="Draw the table: .png, .svg or .pdf."),
    ] = None,
    json_: flags.Json = False,
) -> None:
    """Compute what each reward scheme really optimises.

    For each scheme a policy that is optimal for its rewards is computed
    exactly, without learning, and judged by the formula: the probability that
    it satisfies it, beside the largest one possible.

    \b
    Examples:
      ltlc faithful "!C U (A & (!C U B))" --env ltlc/Thesis10x10-v0
      ltlc faithful "!C U A" -e ltlc/Thesis10x10-v0 -r eventual -r two-discount,gamma=0.999 -o bars.png
    """
    from ltlc.faithful import default_candidates, faithfulness

    given = [_candidate(text, on_deadlock, on_termination) for text in reward or ()]
    candidates = given or default_candidates(on_deadlock, on_termination)
    env_spec = spec.env_spec_of(env, labels, env_set, initial_label=initial_label, variables=variables)
    automaton = spec.automaton_of(formula, env_spec, acceptance, translator, finite, goal, exclusive)
    if env_spec.model is None:
        raise InvalidArgumentError(f"{env_spec.why_no_model}, so what is optimal there cannot be computed")
    tell(automaton, env_spec)
    report = faithfulness(env_spec.model, automaton, candidates, initial_label=initial_label)
    if output is not None:
        _draw(Path(output), report, env)
    if json_:
        print(json.dumps(report.to_dict(), ensure_ascii=False, indent=2))
        return
    _print(report, env)
    if output is not None:
        print(f"The picture is in {output}.")


def _candidate(text: str, on_deadlock: Any, on_termination: Any) -> Candidate:
    from ltlc.faithful import Candidate

    name, *parameters = text.split(",")
    return Candidate.from_name(name, on_deadlock, on_termination, **spec.parameters_of(parameters, name, "--reward"))


def _print(report: FaithfulnessReport, env: str) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from ltlc.mdp.figures import figure_text

    most = figure_text(report.maximum, (report.lower, report.upper), digits=6)
    print(f"{report.formula or 'an automaton without a formula'} in {env}: at most {most} is possible.")
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("optimal for")
    for heading in ("best return", "P(satisfied)", "loses"):
        table.add_column(heading, justify="right")
    for row in report.rows:
        if row.objective is None or row.satisfaction is None or row.gap is None:
            best = "-" if row.objective is None else figure_text(row.objective, digits=6)
            table.add_row(row.name, best, "-", row.problem, style="dim")
        else:
            loses = "" if row.faithful else f"[bold red]{row.gap:.6f}[/]"
            table.add_row(row.name, figure_text(row.objective, digits=6), f"{row.satisfaction:.6f}", loses)
    Console(highlight=False).print(table)


def _draw(path: Path, report: FaithfulnessReport, env: str) -> None:
    from ltlc.pictures.faithfulness import draw_faithfulness

    draw_faithfulness(path, report, subtitle=f"in {env}")
