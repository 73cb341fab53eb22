"""A tabular learner at work on a task: what it finds becomes rows of metrics, what it ends with an agent."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium.vector import VectorEnv

from ltlc.mdp import expected_return
from ltlc.mdp.verdict import Judge

from ..registry import AGENTS
from ..training.checkpoint import Checkpoint, agreed_run, stream_seed
from ..training.contents import Content
from ..training.interrupt import InterruptFlag
from ..training.metrics import Metrics
from ..training.progress import Callback, Progress, Stopwatch, TrainingResult
from ..training.shortcomings import EARLY
from ..training.storage import POLICY_FILE
from .config import LearnerConfig
from .experience import Experience
from .learner import Found, TabularLearner
from .policy import TablePolicy, table_of


def train_learner(
    learner: type[TabularLearner],
    env: VectorEnv[Any, Any, Any],
    agent: str,
    config: LearnerConfig | None,
    *,
    folder: Path | None = None,
    run_id: str = "",
    resume: bool = False,
    judge: Judge | None = None,
    callback: Callback | None = None,
) -> TrainingResult:
    """Train a tabular learner, judging as it goes where that can be done exactly; the clock stands still meanwhile.

    Legs and checkpoints are those of `ltlc.agents.train`; planning after the last step begins anew where it was cut.

    Args:
        learner: what learns.
        env: the environment; it is not closed.
        agent: its name in the registry.
        config: its hyperparameters; None: those of the run to resume, or the defaults.
        folder: where metrics, checkpoints and in the end the policy go; None: nowhere.
        run_id: what the files of the run carry as its identity; a resumed run goes on with its own.
        resume: whether to go on from the checkpoint in the folder.
        judge: of the task, or None where the dynamics are not known.
        callback: called with each row of metrics; stops the training by returning True.

    Raises:
        InvalidArgumentError: there is no task, observations are not discrete, or the rewards want more than actions.
        LtlcError, OSError: see `ltlc.agents.train`.
    """
    saved, config, run_id = agreed_run(agent, config, folder, run_id, resume)
    with InterruptFlag() as interrupt:
        run = _Run(learner, env, agent, config, folder, run_id, saved, judge, callback)
        try:
            while not (run.learner.done or run.complete or run.stopped or interrupt.raised):
                run.advance()
            if run.learner.done and not (run.complete or run.stopped):
                for found in run.learner.conclude():
                    run.report(found)
                    if run.stopped or interrupt.raised:
                        break
        finally:
            run.metrics.close()
        if not interrupt.raised:
            run.finish()
        return run.result(interrupt.raised)


class _Run:
    """The state of a training run: everything a checkpoint holds."""

    def __init__(
        self,
        learner: type[TabularLearner],
        env: VectorEnv[Any, Any, Any],
        agent: str,
        config: LearnerConfig,
        folder: Path | None,
        run_id: str,
        saved: Content | None,
        judge: Judge | None,
        callback: Callback | None,
    ) -> None:
        self.config, self.folder, self.callback = config, folder, callback
        self.uses_rewards = AGENTS[agent].uses_rewards
        self.experience = Experience(env, stream_seed(config, 1), unrewarded=not self.uses_rewards)
        self.learner = learner(self.experience, config)
        space, self.tables = self.experience.space, self.experience.task.tables
        self.checkpoint = Checkpoint(folder, run_id, agent, config, self.tables, space, env.num_envs)
        n_states = self.experience.n_states
        # a wrapper may show something else than the state
        self.judge = judge if judge is not None and judge.rewards.mdp.n_states == n_states else None
        self.policy: TablePolicy | None = None
        self.message, self.leg = "", 0
        self.complete = self.stopped = False
        if saved is not None:
            self._restore(saved)
        self.metrics = Metrics(folder, self.experience.steps)
        self.watch = Stopwatch(self.metrics.seconds)
        self.reported = self.experience.steps
        if saved is None:
            self._write()
        self.saved_steps = self.experience.steps
        self._begin_leg()

    def advance(self) -> None:
        """Let the learner step; then a row of metrics and a checkpoint, if they are due."""
        before = self.experience.steps
        self.learner.step()
        if self.learner.done:
            return
        if self._passed(self.config.log_every, before):
            self.report(self.learner.plan())
        if self._passed(self.config.checkpoint_every, before):
            self._save()
            self._begin_leg()

    def report(self, found: Found) -> None:
        """Keep what was found, write a row of metrics, and call back."""
        table, row = found
        seconds = round(self.watch.seconds, 3)
        with self.watch.paused():
            if table is not None and not self.uses_rewards:
                table = table[:, self.tables.automaton_state]
            self.policy, self.message = self._policy(table), row.message
            row = replace(row, seconds=seconds)
            if self.policy is not None and self.judge is not None:
                value = expected_return(self.judge.rewards, self.judge.rewards.lift(self.policy.table))
                row = replace(row, satisfaction=self.judge.satisfaction(self.policy.table), discounted_return=value)
            self.metrics.write(row)
            if self.callback is not None:
                early = self.reported < EARLY * self.config.total_steps <= row.steps  # so that it is told once
                lacking = self.learner.shortcomings() if early else ()
                self.stopped = bool(self.callback(Progress(self.policy, row, self.config.total_steps, lacking)))
        self.reported = row.steps

    def finish(self) -> None:
        """Write the last checkpoint and the policy."""
        if not self.complete:
            self.complete = not self.stopped
            self._save()
        if self.policy is not None and self.folder is not None:
            self.policy.save(self.folder / POLICY_FILE, run=self.checkpoint.run)

    def result(self, interrupted: bool) -> TrainingResult:
        """What the training has come to."""
        return TrainingResult(
            self.policy, self.experience.steps, self.config.total_steps, self.watch.seconds, interrupted, self.folder,
            self.saved_steps, self.learner.shortcomings(), self.message,
        )  # fmt: skip

    def _passed(self, every: int, before: int) -> bool:
        return self.experience.steps // every > before // every

    def _begin_leg(self) -> None:
        self.experience.begin(stream_seed(self.config, self.leg + 1))
        self.learner.generator = np.random.default_rng([self.config.seed, self.leg + 1])

    def _policy(self, table: npt.NDArray[Any] | None) -> TablePolicy | None:
        if table is None:
            return None
        return TablePolicy(self.experience.space, self.experience.n_actions, self.tables, table)

    def _save(self) -> None:
        self.leg += 1
        self._write()

    def _write(self) -> None:
        self.saved_steps = self.experience.steps
        table = None if self.policy is None else torch.from_numpy(self.policy.table)
        self.checkpoint.write({
            "leg": self.leg,
            "experience": self.experience.state_dict(),
            "learner": self.learner.state_dict(),
            "result": {"table": table, "message": self.message} if self.complete else None,
        })  # fmt: skip

    def _restore(self, saved: Content) -> None:
        """Go back to where a checkpoint was written; all of it is checked before any file is touched."""
        self.checkpoint.check(saved)
        self.leg = saved["leg"].count()
        self.experience.load_state(saved["experience"])
        self.learner.load_state(saved["learner"])
        result = saved["result"]
        if result.value is not None:
            self.complete, self.message = True, result["message"].text()
            if result["table"].value is not None:
                pairs = self.experience.n_states, self.tables.n_states
                self.policy = self._policy(table_of(result["table"], pairs, self.experience.n_actions))
