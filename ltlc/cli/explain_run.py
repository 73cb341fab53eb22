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
    from ltlc.agents.training.failed_episodes import failed_episodes
    from ltlc.agents.training.report import tabular_policy
    from ltlc.agents.training.run_folder import RunFolder
    from ltlc.judging.reasons import reasons

    run = RunFolder.open(folder)
    agent = run.load()
    spec, judge = run.config.env_spec, run.judge
    if judge is not None and agent.encoder.n_observations == judge.rewards.mdp.n_states:
        found = reasons(judge, run.task, tabular_policy(agent, judge.rewards.mdp))
        if output is not None:
            _draw(output, run, found)
        _print(run, found.to_dict(), found.lines(), as_json)
        return
    if output is not None:
        raise InvalidArgumentError("-o draws exact ways to fail, and the dynamics of this environment are not known")
    env = spec.vector(run.task, min(episodes, 16))
    try:
        sampled = failed_episodes(agent, env, episodes=episodes, max_steps=spec.episode_steps, seed=seed)
    finally:
        env.close()
    _print(run, sampled.to_dict(), sampled.lines(), as_json)


def _print(run: RunFolder, data: object, lines: list[str], as_json: bool) -> None:
    if as_json:
        print(json.dumps(data, ensure_ascii=False, indent=2))
        return
    print(f"{run.task.formula or 'an automaton without a formula'} in {run.config.env_spec.env}")
    print("\n".join(lines))


def _draw(output: str, run: RunFolder, found: Reasons) -> None:
    from ltlc.pictures.failures import draw_failures

    board = run.config.env_spec.board
    if board is None:
        raise InvalidArgumentError(f"{run.config.env_spec.env} has no map to draw on; leave -o out")
    failure, place = found.failure, found.judge.words.mdp_state
    ways = [(route.states, route.probability) for route in failure.routes] or [
        (entry.path.states, entry.probability) for entry in failure.entries
    ]
    draw_failures(
        output,
        board,
        [([int(place[state]) for state in states], probability) for states, probability in ways],
        title=run.task.formula or "what is lost",
        subtitle=f"{failure.loss:.4g} is lost; ways to fail, the thicker the more probable",
    )
