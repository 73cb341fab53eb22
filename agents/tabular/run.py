"""A tabular learner at work on a task: what it reports becomes rows of metrics, what it ends with an agent."""

from __future__ import annotations

from pathlib import Path

from ltlc.envs import LTLVectorWrapper
from ltlc.mdp import expected_return
from ltlc.mdp.verdict import Judge

from ..encoder import ObservationEncoder
from ..training.collect import Interface
from ..training.metrics import Metrics, Row
from ..training.progress import Callback, Progress, TrainingResult
from ..training.shortcomings import EARLY, shortcomings
from ..training.storage import POLICY_FILE
from .config import LearnerConfig
from .experience import check_choices
from .learned import Learned
from .policy import TablePolicy
from .registry import LEARNERS


def train_learner(
    env: LTLVectorWrapper,
    agent: str,
    config: LearnerConfig,
    *,
    folder: Path | None = None,
    run_id: str = "",
    resume: bool = False,
    judge: Judge | None = None,
    callback: Callback | None = None,
) -> TrainingResult:
    """Train a tabular learner, judging as it goes where that can be done exactly; the clock stands still meanwhile.

    Args:
        env: the environment; it is not closed.
        agent: name of the learner.
        config: its hyperparameters.
        folder: where `metrics.csv` and in the end the policy go; None: nowhere.
        run_id: identity of the run, which its files carry.
        resume: without effect; there is no checkpoint, and training begins anew.
        judge: of the task, or None where the dynamics are not known.
        callback: called with each row of metrics; stops the training by returning True.

    Raises:
        InvalidArgumentError: observations are not discrete, or the rewards want more than actions.
    """
    check_choices(env.task)
    learner = LEARNERS[agent]
    interface, tables = Interface.of(env), env.task.tables
    if judge is not None and ObservationEncoder(interface.space).n_observations != judge.rewards.mdp.n_states:
        judge = None  # a wrapper shows something else than the state
    metrics = Metrics(folder)
    rows: list[Row] = []

    def policy(learned: Learned) -> TablePolicy | None:
        if learned.policy is None:
            return None
        table = learned.policy if learner.uses_rewards else learned.policy[:, tables.automaton_state]
        return TablePolicy(interface.space, interface.n_actions, tables, table)

    def report(learned: Learned) -> bool | None:
        found = policy(learned)
        before = rows[-1].steps if rows else 0
        rows.append(_row(learned, found, judge))
        metrics.write(rows[-1])
        if callback is None:
            return None
        early = before < EARLY * config.total_steps <= learned.steps  # so that it is told once
        return callback(Progress(found, rows[-1], config.total_steps, _shortcomings(learned) if early else ()))

    try:
        learned = learner.train(env, config, callback=report)
    except KeyboardInterrupt:
        steps, seconds = (rows[-1].steps, rows[-1].seconds) if rows else (0, 0.0)
        return TrainingResult(None, steps, config.total_steps, seconds, interrupted=True, folder=folder)
    finally:
        metrics.close()
    found = policy(learned)
    if found is not None and folder is not None:
        found.save(folder / POLICY_FILE, run=run_id)
    return TrainingResult(
        found, learned.steps, config.total_steps, learned.seconds, folder=folder,
        shortcomings=_shortcomings(learned), message=learned.message,
    )  # fmt: skip


def _shortcomings(learned: Learned) -> tuple[str, ...]:
    if learned.seen is None:
        return ()
    return tuple(shortcomings(learned.seen, learned.steps, counterfactual=learned.counterfactual))


def _row(learned: Learned, agent: TablePolicy | None, judge: Judge | None) -> Row:
    satisfaction = value = None
    if agent is not None and judge is not None:
        satisfaction = judge.satisfaction(agent.table)
        value = expected_return(judge.rewards, judge.rewards.lift(agent.table))
    return Row(
        steps=learned.steps,
        seconds=round(learned.seconds, 3),
        value=learned.value,
        product_states=learned.product_states,
        satisfaction=satisfaction,
        discounted_return=value,
        message=learned.message,
    )
