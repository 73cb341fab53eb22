"""The end of a training run: the verdict, the pictures, and files for other judges."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from ltlc.envs import DrawnEnv
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import Judge, expected_return_within
from ltlc.pictures.curves import Curve, draw_curves
from ltlc.pictures.policy import draw_policy
from ltlc.prism import Exported, export_policy

from ..agent import Agent
from .report import Report, report, tabular_policy
from .run_folder import CURVE_PICTURE, POLICY_PICTURE, TRAJECTORIES_PICTURE, RunFolder
from .trajectories import draw_episodes

DRAWN_EPISODES = 6
JUDGED_TOGETHER = 50
"""environments that episodes are sampled from, whatever the training had: a network values many as fast as one."""


def judge_run(run: RunFolder, agent: Agent, *, episodes: int = 100, seed: int = 0) -> Report:
    """The verdict on what a run has learned: exact where the environment is known, sampled elsewhere.

    Args:
        run: the run.
        agent: what it has learned.
        episodes: to sample.
        seed: of the sampling.
    """
    judge = run.judge
    if judge is not None and agent.encoder.n_observations != judge.rewards.mdp.n_states:
        judge = None  # a wrapper shows something else than the state
    together = run.config.num_envs if judge is not None else min(episodes, JUDGED_TOGETHER)
    env = run.config.env_spec.vector(run.task, together, 0 if judge is not None else run.config.workers)
    try:
        found = report(agent, judge, env, episodes=episodes, seed=seed)
        return found if judge is None else replace(found, shortfall=run.shortfall)
    finally:
        env.close()


def export_run(run: RunFolder, agent: Agent, folder: str | os.PathLike[str]) -> Exported:
    """Write what a run has learned as a Markov chain that PRISM or Storm can check, with the formula.

    Raises:
        InvalidArgumentError: the dynamics of the environment or the formula are not known, or a proposition cannot be
            the name of a label in PRISM.
        OSError: a file cannot be written.
    """
    spec = run.config.env_spec
    if spec.model is None:
        raise InvalidArgumentError(f"the dynamics of {spec.env} are not known, so there is no Markov chain to write")
    policy = tabular_policy(agent, spec.model)
    return export_policy(spec.model, run.task, policy, folder, initial_label=spec.initial_label)


def draw_run(run: RunFolder, agent: Agent, judge: Judge | None) -> list[Path]:
    """Draw the curve, the policy where there is a map, episodes in the plane, the automaton where a program can."""
    drawn = [
        run.draw_automaton(),
        draw_curve(run, agent, judge),
        _draw_policy(run, agent, judge),
        _draw_episodes(run, agent),
    ]
    return [path for path in drawn if path is not None]


def draw_curve(run: RunFolder, agent: Agent, judge: Judge | None) -> Path | None:
    """Returns over training steps, or nothing where none were recorded.

    Those of the episodes that ended, with exploration, where they are in the metrics (fitted Q iteration, double DQN);
    else the exact ones of the policies learned so far (tabular learners). Where the dynamics are known, a line shows
    what the policy that is optimal for the rewards would return, and a dot what the one that was learned does.
    """
    best = outcome = None
    sampled = any(row.get("episode_return") is not None for row in run.metrics())
    if sampled:
        column, name, label = "episode_return", "training, with exploration", "return of an episode (sum of rewards)"
        if judge is not None and judge.optimal_policy is not None:  # episodes are cut, and so is what is best
            policies = judge.optimal_policy, tabular_policy(agent, judge.rewards.mdp)
            lifted = (judge.rewards.lift(policy) for policy in policies)
            steps = run.config.env_spec.episode_steps
            best, outcome = (expected_return_within(judge.rewards, policy, steps) for policy in lifted)
    else:
        column, name, label = "discounted_return", "learned so far, exact", "expected return, discounted"
        best = None if judge is None else judge.value
    rows = [row for row in run.metrics() if row.get(column) is not None]
    if not rows:
        return None
    planned = len(rows) > 1 and len({row["steps"] for row in rows}) == 1  # all in the learned model
    axis, x_label = ("seconds", "seconds of learning and planning") if planned else ("steps", "environment steps")
    x, returns = (np.array([row[key] for row in rows], dtype=np.float64) for key in (axis, column))
    title = run.task.formula or run.config.env_spec.env
    return draw_curves(
        run.path / CURVE_PICTURE,
        [Curve(name, x, returns, best, outcome=outcome)],
        title=title,
        x_label=x_label,
        y_label=label,
        window=max(len(rows) // 20, 1) if sampled else 1,
    )


def _draw_policy(run: RunFolder, agent: Agent, judge: Judge | None) -> Path | None:
    board = run.config.env_spec.board
    if board is None or judge is None:
        return None
    policy = tabular_policy(agent, judge.rewards.mdp)
    rewards = f" with the rewards '{run.config.reward}'" if run.entry.uses_rewards else ""
    likely = "" if policy.ndim == 2 else "; the most probable actions"
    return draw_policy(
        run.path / POLICY_PICTURE,
        board,
        policy if policy.ndim == 2 else policy.argmax(axis=2),
        run.automaton,
        run.task.tables,
        title=run.task.formula or "policy",
        subtitle=f"learned by {run.config.agent} in {run.config.env_spec.env}{rewards}{likely}",
        reached=judge.reached,
        classes=judge.letter_classes,
    )


def _draw_episodes(run: RunFolder, agent: Agent) -> Path | None:
    spec = run.config.env_spec
    if not isinstance(spec.single.unwrapped, DrawnEnv):
        return None
    env = spec.vector(run.task, DRAWN_EPISODES)
    try:
        return draw_episodes(
            agent,
            env,
            run.path / TRAJECTORIES_PICTURE,
            max_steps=spec.episode_steps,
            title=run.task.formula or "trajectories",
            subtitle=f"learned by {run.config.agent} in {spec.env}",
        )
    finally:
        env.close()
