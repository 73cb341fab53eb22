"""A tabular learner at work on a task: what it reports becomes rows of metrics, what it ends with an agent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from ltlc.atomic import atomic_write_all
from ltlc.envs import LTLVectorWrapper
from ltlc.mdp import expected_return
from ltlc.mdp.verdict import Judge, figure_text

from ..encoder import ObservationEncoder
from ..training.collect import Interface
from ..training.metrics import METRICS_FILE, TIMES_FILE, TIMES_HEADER, csv_line
from ..training.shortcomings import EARLY, shortcomings
from .config import LearnerConfig
from .experience import Experience, check_choices
from .learned import Learned
from .policy import TablePolicy
from .registry import Learner


@dataclass(frozen=True)
class TableRow:
    """What a learner has come to after so many steps."""

    steps: int
    """environment steps since the start of training."""
    seconds: float
    """of learning and planning; judging does not count."""
    value: float
    """the learner's own estimate of its objective."""
    product_states: int
    """product states built, or visited."""
    satisfaction: float | None
    """exact probability that the policy so far satisfies the formula; None: no policy, or nothing exact is known."""
    discounted_return: float | None
    """exact expected return of the policy so far; None as above."""
    message: str = ""
    """where the learner stands, in a few words."""

    @property
    def text(self) -> str:
        """The row for a person."""
        if self.satisfaction is None or self.discounted_return is None:
            return self.message or f"own estimate {figure_text(self.value)}"
        return f"P(satisfied) {figure_text(self.satisfaction)}  return {figure_text(self.discounted_return)}"


@dataclass(frozen=True)
class TableProgress:
    """Where a learner stands; callbacks get it with each row of metrics."""

    row: TableRow
    total_steps: int
    shortcomings: tuple[str, ...] = ()
    """what the training lacks so far; told once, after a quarter of the steps."""

    @property
    def seconds_left(self) -> float:
        """Estimated seconds to go, at the speed so far; fewer where the learner ends before its steps do."""
        return self.row.seconds * (self.total_steps / max(self.row.steps, 1) - 1)


@dataclass(frozen=True)
class TableResult:
    """What a learner came to."""

    agent: TablePolicy | None
    """None: in what the learner found out, no policy satisfies the formula with any probability."""
    steps: int
    """environment steps."""
    seconds: float
    """of learning and planning."""
    message: str
    """how training ended."""
    shortcomings: tuple[str, ...] = ()
    """what the training lacked, and what to try."""


def check_learner(env: LTLVectorWrapper, config: LearnerConfig) -> None:
    """Check that a tabular learner can learn the task of an environment.

    Raises:
        InvalidArgumentError: observations are not discrete, or the rewards want more than actions.
    """
    check_choices(env.task)
    Experience(env, config.seed)


def train_learner(
    env: LTLVectorWrapper,
    learner: Learner,
    config: LearnerConfig,
    *,
    folder: Path | None = None,
    judge: Judge | None = None,
    callback: Callable[[TableProgress], None] | None = None,
) -> TableResult:
    """Train a tabular learner, judging as it goes where that can be done exactly; the clock stands still meanwhile.

    Args:
        env: the environment; it is not closed.
        learner: from the registry.
        config: its hyperparameters.
        folder: where `metrics.csv` and `times.csv` go; None: nowhere. They are complete after each row.
        judge: of the task, or None where the dynamics are not known.
        callback: called with each row of metrics.

    Raises:
        InvalidArgumentError: see `check_learner`.
    """
    check_choices(env.task)
    interface, tables = Interface.of(env), env.task.tables
    if judge is not None and ObservationEncoder(interface.space).n_observations != judge.rewards.mdp.n_states:
        judge = None  # a wrapper shows something else than the state
    rows: list[TableRow] = []

    def agent(learned: Learned) -> TablePolicy | None:
        if learned.policy is None:
            return None
        table = learned.policy if learner.uses_rewards else learned.policy[:, tables.automaton_state]
        return TablePolicy(interface.space, interface.n_actions, tables, table)

    def report(learned: Learned) -> None:
        rows.append(_row(learned, agent(learned), judge))
        if folder is not None:
            metrics = _csv(rows, _HEADER)
            atomic_write_all({folder / TIMES_FILE: _csv(rows, TIMES_HEADER), folder / METRICS_FILE: metrics})
        if callback is not None:
            before = rows[-2].steps if len(rows) > 1 else 0
            early = before < EARLY * config.total_steps <= learned.steps  # so that it is told once
            callback(TableProgress(rows[-1], config.total_steps, _shortcomings(learned) if early else ()))

    learned = learner.train(env, config, callback=report)
    return TableResult(agent(learned), learned.steps, learned.seconds, learned.message, _shortcomings(learned))


def _shortcomings(learned: Learned) -> tuple[str, ...]:
    if learned.seen is None:
        return ()
    return tuple(shortcomings(learned.seen, learned.steps, counterfactual=learned.counterfactual))


def _row(learned: Learned, agent: TablePolicy | None, judge: Judge | None) -> TableRow:
    satisfaction = value = None
    if agent is not None and judge is not None:
        satisfaction = judge.satisfaction(agent.table)
        value = expected_return(judge.rewards, judge.rewards.lift(agent.table))
    return TableRow(
        learned.steps,
        round(learned.seconds, 3),
        learned.value,
        learned.product_states,
        satisfaction,
        value,
        learned.message,
    )


_HEADER = [field.name for field in fields(TableRow) if field.name not in ("seconds", "message")]


def _csv(rows: Sequence[TableRow], names: Sequence[str]) -> str:
    return "".join([csv_line(names), *(csv_line(getattr(row, name) for name in names) for row in rows)])
