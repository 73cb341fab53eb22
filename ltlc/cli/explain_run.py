"""`ltlc explain RUN`: why what a run has learned satisfies its formula with a probability below 1."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.agents.training.run_folder import RunFolder
    from ltlc.judging.reasons import Reasons


def print_reasons(folder: str, output: str | None, episodes: int, seed: int, as_json: bool) -> None:
    """Explain a run: exactly where its environment is known, else by episodes.

    Args:
        folder: the run folder.
        output: a picture of the ways to fail on the map, or None.
        episodes: to sample where nothing exact is possible.
        seed: of the sampling.
        as_json: whether to print JSON.
    """
    from ltlc.agents.training.run_folder import RunFolder
    from ltlc.judging.reasons import Reasons
    from ltlc.reports.failing import why_of_run

    run = RunFolder.open(folder)
    found = why_of_run(run, run.load(), episodes=episodes, seed=seed)
    if output is not None:
        if not isinstance(found, Reasons):
            raise InvalidArgumentError(
                "-o draws exact ways to fail, and the dynamics of this environment are not known"
            )
        _draw(output, run, found)
    _print(run, found.to_dict(), found.lines(), as_json)


def _print(run: RunFolder, data: object, lines: list[str], as_json: bool) -> None:
    if as_json:
        print(json.dumps(data, ensure_ascii=False, indent=2))
        return
    print(f"{run.task.formula or 'an automaton without a formula'} in {run.config.env_spec.env}")
    print("\n".join(lines))


def _draw(output: str, run: RunFolder, found: Reasons) -> None:
    from ltlc.pictures.failures import draw_failures
    from ltlc.reports.failing import ways_on_map

    board = run.config.env_spec.board
    if board is None:
        raise InvalidArgumentError(f"{run.config.env_spec.env} has no map to draw on; leave -o out")
    draw_failures(
        output,
        board,
        ways_on_map(found),
        title=run.task.formula or "what is lost",
        subtitle=f"{found.failure.loss:.4g} is lost; ways to fail, the thicker the more probable",
    )
