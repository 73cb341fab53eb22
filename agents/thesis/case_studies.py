"""The case studies of the thesis, chapter 5: its recorded automata, its rewards, its worlds; our agent and the judge.

What the thesis leaves out of its word (the label of the first state) is left out here, a violation leads back to the
state before it, and reaching an accepting state ends the episode.
"""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ltlc.envs import recorded_automaton
from ltlc.envs.spec import EnvSpec
from ltlc.errors import RewardWarning
from ltlc.mdp.verdict import Judge, PolicyVerdict
from ltlc.pictures.curves import Curve, draw_curves
from ltlc.pictures.policy import draw_policy

from ..double_dqn.config import DQNConfig
from ..registry import DOUBLE_DQN
from ..training.evaluate import EvaluationCallback
from ..training.progress import Progress
from ..training.report import Report, tabular_policy
from ..training.run_config import RunConfig, num_envs_for
from ..training.run_folder import RunFolder

FloatArray = npt.NDArray[np.float64]
ROWS = 60
"""how often a run is judged while it learns."""
EPSILON_STEPS = 100_000
"""steps over which exploration falls, at most."""
NEARLY_OPTIMAL = 0.01
"""relative regret."""


class Experiment(NamedTuple):
    """One training of the thesis."""

    title: str
    automaton: str
    """name of the recorded automaton."""
    size: str
    """of the world."""
    dynamic: bool
    steps: int
    """environment steps of our training."""
    hours: float
    """of the thesis' training, on a Tesla K80."""

    @property
    def env(self) -> str:
        """Name of the world in Gymnasium's registry."""
        return f"ltlc/Thesis{self.size}{'Dynamic' if self.dynamic else ''}-v0"


EXPERIMENTS: Mapping[str, Mapping[str, Experiment]] = MappingProxyType({
    "case1": {
        "static": Experiment("case study I, static", "phi_1", "10x10", False, 300_000, 3.0),
        "dynamic": Experiment("case study I, dynamic", "phi_1", "10x10", True, 300_000, 0.5),
    },
    "case2": {
        "static": Experiment("case study II, static", "phi_2", "10x10", False, 600_000, 14.0),
        "dynamic": Experiment("case study II, dynamic", "phi_2", "10x10", True, 600_000, 17.0),
    },
})  # fmt: skip
"""the experiments of sections 5.1 and 5.2, by variant; section 5.3 is `ltlc.agents.thesis.runtime`."""


@dataclass(frozen=True)
class Outcome:
    """What became of one experiment with one seed."""

    experiment: Experiment
    seed: int
    run: RunFolder
    report: Report
    seconds: float
    """of training."""
    nearly_optimal_after: float | None
    """seconds of training until the exact regret was below 1 %, or None."""
    solved_in: float
    """seconds for the exact solution, end components included."""
    episodes: FloatArray
    """shape (n,); episodes that had ended when each row was written."""
    returns: FloatArray
    """shape (n,); mean return of the episodes of the row, exploration included; NaN where none ended."""
    greedy: FloatArray
    """shape (n,); exact expected return of the policy learned so far; NaN where its episodes need not end."""

    @property
    def judge(self) -> Judge:
        """The judge."""
        assert self.report.judge is not None
        return self.report.judge

    @property
    def verdict(self) -> PolicyVerdict:
        """On what was learned."""
        assert self.report.verdict is not None
        return self.report.verdict


def reproduce(
    experiment: Experiment,
    folder: str | os.PathLike[str],
    *,
    seed: int = 0,
    steps: int | None = None,
    callback: Callable[[Progress], None] = lambda progress: None,
) -> Outcome | None:
    """Train one experiment, judging as it goes; the clock stands still meanwhile. None if it was interrupted.

    Args:
        experiment: what to train.
        folder: the run folder; an older run in it is replaced.
        seed: of everything random.
        steps: environment steps; None: those of the experiment.
        callback: called with each row of metrics.

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, chapter 5.
    """
    total = steps or experiment.steps
    env_spec = EnvSpec(env=experiment.env, initial_label="skip")
    num_envs = num_envs_for(total, env_spec.episode_steps)
    learner = DQNConfig.one_step(  # a network, as in the thesis, though a table would do
        num_envs,
        epsilon_steps=min(total // 3, EPSILON_STEPS),
        total_steps=total,
        seed=seed,
        log_every=max(total // ROWS, 1),
    )
    config = RunConfig(
        env_spec=env_spec,
        reward="thesis",
        num_envs=num_envs,
        agent=DOUBLE_DQN,
        hyperparameters=learner,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RewardWarning)  # what they teach is what is to be seen
        run = RunFolder.create(folder, config, recorded_automaton(experiment.automaton), force=True)
    with run:
        since = time.perf_counter()
        judge = run.judge
        assert judge is not None and judge.optimum is not None and judge.maximum is not None  # both are solved here
        solved_in = time.perf_counter() - since
        evaluate = EvaluationCallback(judge)

        def look(progress: Progress) -> None:
            evaluate(progress)
            callback(progress)

        result = run.train(callback=look)
        if result.interrupted or result.agent is None:
            return None
        verdict = judge.judge(tabular_policy(result.agent, judge.rewards.mdp))
        report = Report(verdict, judge, None)
        run.write_result({"steps": result.steps, **report.to_dict()})
        run.draw_automaton()
    found = evaluate.evaluations
    good = (one.row.seconds for one in found if one.regret is not None and one.regret < NEARLY_OPTIMAL)
    greedy = [one.total_return if np.isfinite(one.total_return) else np.nan for one in found]
    returns = np.array([one.row.episode_return for one in found], dtype=np.float64)
    episodes = np.cumsum([one.row.episodes or 0 for one in found], dtype=np.float64)
    return Outcome(
        experiment, seed, run, report, result.seconds, next(good, None), solved_in, episodes, returns, np.array(greedy)
    )


def draw_learned(path: str | os.PathLike[str], outcome: Outcome, *, title: str) -> Path:
    """The learned policy on the map, a panel per automaton state (thesis, figures 5.2 and 5.3)."""
    run, verdict = outcome.run, outcome.verdict
    board = run.config.env_spec.board
    agent = run.load()
    assert board is not None
    return draw_policy(
        path,
        board,
        tabular_policy(agent, outcome.judge.rewards.mdp),
        run.automaton,
        run.task.tables,
        title=f"{title}: {run.task.formula}",
        subtitle=f"learned in {outcome.seconds:.0f} s; expected return {verdict.total_return:.1f}, "
        f"exact optimum {_optimal_return(outcome):.1f}",
        reached=outcome.judge.reached,
        classes=outcome.judge.letter_classes,
    )


def draw_learning(path: str | os.PathLike[str], outcomes: Mapping[str, Sequence[Outcome]], *, title: str) -> Path:
    """Return over episodes, a curve per variant over all its seeds (thesis, figure 5.4)."""
    curves = []
    for name, runs in outcomes.items():
        shared = np.linspace(0, min(run.episodes[-1] for run in runs), ROWS)
        returns, greedy = (
            np.array([_interpolated(shared, run.episodes, getattr(run, column)) for run in runs])
            for column in ("returns", "greedy")
        )
        curves.append(Curve(name, shared, returns, _optimal_return(runs[0]), greedy))
    return draw_curves(path, curves, title=title, x_label="episodes", window=5)


def _interpolated(x: FloatArray, known: FloatArray, y: FloatArray) -> FloatArray:
    there = np.isfinite(y)
    return np.interp(x, known[there], y[there], left=np.nan) if there.any() else np.full(len(x), np.nan)


def _optimal_return(outcome: Outcome) -> float:
    assert outcome.judge.optimum is not None
    return outcome.judge.optimum.total_return
