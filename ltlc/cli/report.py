"""`ltlc report`: a page about a run."""

from __future__ import annotations

from typing import Annotated

from ltlc.cli.options import Argument, Option
from ltlc.errors import InvalidArgumentError


def report(
    run: Annotated[str, Argument(metavar="RUN", is_path=True, help="A run folder, as 'ltlc train' makes it.")],
    output: Annotated[
        str | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            is_path=True,
            shown_default="report.html in the folder",
            help="Where to write the page.",
        ),
    ] = None,
    episodes: Annotated[
        int, Option("--episodes", "-n", metavar="N", help="Episodes to sample where nothing exact is possible.")
    ] = 100,
    seed: Annotated[int, Option("--seed", least=0, metavar="N", help="Of the episode that is shown.")] = 0,
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
