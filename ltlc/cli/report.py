"""`ltlc report`: a page about a run."""

from __future__ import annotations

from typing import Annotated

import typer

from ltlc.cli import flags
from ltlc.errors import InvalidArgumentError


def report(
    run: Annotated[
        str, typer.Argument(metavar="RUN", callback=flags.path_given, help="A run folder, as 'ltlc train' makes it.")
    ],
    output: Annotated[
        str | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            callback=flags.path_given,
            show_default="report.html in the folder",
            help="Where to write the page.",
        ),
    ] = None,
    episodes: Annotated[
        int, typer.Option("--episodes", "-n", metavar="N", help="Episodes to sample where nothing exact is possible.")
    ] = 100,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Of the episode that is shown.")] = 0,
) -> None:
    """Write a page about a run: verdict, automaton, learning curve, policy, failures, and an episode to step through.

    One HTML file that needs no network and no program but a browser, on a
    phone as well.

    \b
    Examples:
      ltlc report runs/c-u-a-thesis10x10-v0-0
      ltlc report runs/balance -o balance.html
    """  # fmt: skip
    if episodes < 2:
        raise InvalidArgumentError(f"--episodes is {episodes}; at least 2 are needed for an interval")
    from ltlc.reports import report_of_run

    print(report_of_run(run, output, episodes=episodes, seed=seed))
