"""The end of a training run: the verdict, and the pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ltlc.mdp.verdict import Judge

from .dqn import DoubleDQN
from .pictures import Curve, board_of, draw_curves, draw_policy
from .report import Report, make_judge, report, tabular_policy
from .run_folder import CURVE_PICTURE, POLICY_PICTURE, RunFolder


def judge_run(run: RunFolder, agent: DoubleDQN, *, episodes: int = 100, seed: int = 0) -> Report:
    """The verdict on what a run has learned: exact where the environment is known, sampled elsewhere.

    Args:
        run: the run.
        agent: what it has learned.
        episodes: to sample.
        seed: of the sampling.
    """
    judge = make_judge(run.config.setting, run.task)
    if judge is not None and agent.encoder.n_observations != judge.rewards.mdp.n_states:
        judge = None  # a wrapper shows something else than the state
    env = run.vector_env()
    try:
        return report(agent, judge, env, episodes=episodes, seed=seed)
    finally:
        env.close()


def draw_run(run: RunFolder, agent: DoubleDQN, judge: Judge | None) -> list[Path]:
    """Draw what can be drawn: the curve, the policy where there is a map, the automaton where there is Graphviz."""
    drawn = [run.draw_automaton(), draw_curve(run, judge), _draw_policy(run, agent, judge)]
    return [path for path in drawn if path is not None]


def draw_curve(run: RunFolder, judge: Judge | None) -> Path | None:
    """Returns of episodes over training steps, or nothing where no episode ended."""
    rows = [row for row in run.metrics() if row.get("episode_return") is not None]
    if not rows:
        return None
    steps, returns = (np.array([row[key] for row in rows], dtype=np.float64) for key in ("steps", "episode_return"))
    optimum = None if judge is None or judge.optimum is None else judge.optimum.total_return
    curve = Curve("training, with exploration", steps, returns, optimum)
    title = run.task.formula or run.config.setting.env
    return draw_curves(
        run.path / CURVE_PICTURE, [curve], title=title, x_label="environment steps", window=max(len(rows) // 20, 1)
    )


def _draw_policy(run: RunFolder, agent: DoubleDQN, judge: Judge | None) -> Path | None:
    board = board_of(run.config.setting.single)
    if board is None or judge is None:
        return None
    return draw_policy(
        run.path / POLICY_PICTURE,
        board,
        tabular_policy(agent, judge.rewards.mdp),
        run.automaton,
        run.task.tables,
        title=run.task.formula or "policy",
        subtitle=f"learned in {run.config.setting.env} with the rewards '{run.config.reward}'",
        reached=judge.reached,
        classes=judge.letter_classes,
    )
