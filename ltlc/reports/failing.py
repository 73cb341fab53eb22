"""Why what a run has learned satisfies its formula with a probability below 1."""

from __future__ import annotations

from collections.abc import Sequence

from ltlc.agents.agent import Agent
from ltlc.agents.training.failed_episodes import FailedEpisodes, failed_episodes
from ltlc.agents.training.report import tabular_policy
from ltlc.agents.training.run_folder import RunFolder
from ltlc.judging.reasons import Reasons, reasons


def why_of_run(run: RunFolder, agent: Agent, *, episodes: int = 100, seed: int = 0) -> Reasons | FailedEpisodes:
    """Why a run fails where it does: exactly where its environment is known, else by episodes.

    Args:
        run: the run.
        agent: what it has learned.
        episodes: to sample where nothing exact is possible.
        seed: of the sampling.
    """
    judge, spec = run.judge, run.config.env_spec
    if judge is not None and agent.encoder.n_observations == judge.rewards.mdp.n_states:
        return reasons(judge, run.task, tabular_policy(agent, judge.rewards.mdp))
    env = spec.vector(run.task, min(episodes, 16))
    try:
        return failed_episodes(agent, env, episodes=episodes, max_steps=spec.episode_steps, seed=seed)
    finally:
        env.close()


def ways_on_map(found: Reasons) -> list[tuple[Sequence[int], float]]:
    """The ways to fail as states of the model, which are cells where there is a map; each with its probability."""
    place = found.judge.words.mdp_state
    ways = [(route.states, route.probability) for route in found.failure.routes] or [
        (entry.path.states, entry.probability) for entry in found.failure.entries
    ]
    return [([int(place[state]) for state in states], probability) for states, probability in ways]
