"""Tables 5.1 and 5.2 of the thesis anew: how long each system takes to the same exact quality, and what it builds."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any, NamedTuple

import numpy.typing as npt

from ltlc.envs import LTLVectorWrapper, labelled_mdp, recorded_automaton, thesis_vector_world, thesis_world
from ltlc.errors import UnknownNameError
from ltlc.mdp import (
    Product,
    RewardProduct,
    expected_return,
    max_satisfaction_probability,
    optimal_return,
    satisfaction_probability,
)
from ltlc.mdp.measures import from_start
from ltlc.task import Task

from ..config import DQNConfig
from ..evaluate import greedy_policy
from ..train import Progress, train
from .learned import Learned
from .registry import LEARNERS

CASES = (("5x5", "phi_3"), ("10x10", "phi_3"), ("5x5", "phi_4"), ("10x10", "phi_4"))
"""worlds and formulas of the tables, in their order."""
DQN = "double-dqn"
SYSTEMS = (DQN, *LEARNERS)
"""every system that is compared."""
_HOURS = {
    (DQN, "5x5", "phi_3"): "0.33", (DQN, "10x10", "phi_3"): "3.5",
    (DQN, "5x5", "phi_4"): "3", (DQN, "10x10", "phi_4"): "9",
    ("fu-topcu", "5x5", "phi_3"): "0.22", ("fu-topcu", "10x10", "phi_3"): ">25",
    ("fu-topcu", "5x5", "phi_4"): "8", ("fu-topcu", "10x10", "phi_4"): ">25",
}  # fmt: skip
_PRODUCT_STATES = {("5x5", "phi_3"): 100, ("10x10", "phi_3"): 400, ("5x5", "phi_4"): 375, ("10x10", "phi_4"): 1500}
_TABULAR_ENVS, _DQN_ENVS = 256, 16
_QUICK_SECONDS, _FULL_SECONDS = 20.0, 60.0


@dataclass(frozen=True)
class RuntimeRow:
    """One system on one world and formula."""

    system: str
    world: str
    formula: str
    runs: int
    """how often it was run, each time from another seed."""
    reached: int
    """how many runs reached the quality within the time limit."""
    seconds: float
    """of learning and planning until then, or until the limit; judging does not count. Median of the runs."""
    steps: int
    """environment steps until then; median."""
    regret: float
    """exact: part of the optimal expected return that the last policy loses; inf if there was none. Largest."""
    probability: float
    """exact probability that the last policy satisfies the formula. Smallest of the runs."""
    max_probability: float
    """the largest there is."""
    product_states: int
    """product states built by learners of a model, visited by Q-learning; 0: it keeps no record. Largest."""
    accepting_components: int | None
    """that the system found in the last run; None: it does not look for them."""
    thesis_hours: str | None
    """table 5.1, on other hardware and to no stated quality; None: not in the table."""
    thesis_product_states: int
    """table 5.2."""


def runtime_comparison(
    *,
    quick: bool = False,
    systems: Sequence[str] = SYSTEMS,
    cases: Sequence[tuple[str, str]] = CASES,
    seeds: Sequence[int] | None = None,
    regret: float = 0.01,
    limit: float | None = None,
    progress: Callable[[RuntimeRow], None] | None = None,
) -> list[RuntimeRow]:
    """Run every system on every world and formula until its policy is good, and say how long that took.

    A policy is good if it satisfies the formula with the largest possible probability (to 1e-6) and its exact
    discounted return under the thesis' rewards is within `regret` of the optimum. In these worlds almost any policy
    satisfies phi_3 and phi_4 at last, since noise takes the robot everywhere; the return, which counts steps, tells
    them apart.

    Args:
        quick: one seed and at most 20 seconds for each run, instead of three seeds and 60 seconds.
        systems: some of `SYSTEMS`.
        cases: pairs of a world (`thesis_map`) and a recorded automaton, some of `CASES`.
        seeds: instead of the above.
        regret: part of the optimal return that may be lost.
        limit: seconds for each run, instead of the above.
        progress: called with each row as it comes.

    Raises:
        UnknownNameError: there is no such system, world or automaton.

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, section 5.3. The
        5x5 world is not recorded there, nor whether motion was noisy; here it is, as in the case studies.
    """
    for system in systems:
        if system not in SYSTEMS:
            raise UnknownNameError("system", system, SYSTEMS)
    chosen = seeds if seeds is not None else (0,) if quick else (0, 1, 2)
    allowed = limit if limit is not None else _QUICK_SECONDS if quick else _FULL_SECONDS
    rows = []
    for world, formula in cases:
        for system in systems:
            rows.append(_row(system, world, formula, chosen, _Judge(world, formula, regret, allowed)))
            if progress is not None:
                progress(rows[-1])
    return rows


def _row(system: str, world: str, formula: str, seeds: Sequence[int], judge: _Judge) -> RuntimeRow:
    runs: list[tuple[Learned, _Verdict]] = []
    for seed in seeds:
        judge.verdict = _Verdict(False, float("inf"), 0.0)
        learned = _run(system, world, judge, seed)
        runs.append((learned, judge.verdict))
    return RuntimeRow(
        system=system,
        world=world,
        formula=formula,
        runs=len(runs),
        reached=sum(verdict.good for _, verdict in runs),
        seconds=median(learned.seconds for learned, _ in runs),
        steps=int(median(learned.steps for learned, _ in runs)),
        regret=max(verdict.regret for _, verdict in runs),
        probability=min(verdict.probability for _, verdict in runs),
        max_probability=judge.max_probability,
        product_states=max(learned.product_states for learned, _ in runs),
        accepting_components=runs[-1][0].accepting_components,
        thesis_hours=_HOURS.get((system, world, formula)),
        thesis_product_states=_PRODUCT_STATES[world, formula],
    )


class _Verdict(NamedTuple):
    good: bool
    regret: float
    probability: float


class _Judge:
    """Stops a run when its policy is good, or its time is up."""

    def __init__(self, world: str, formula: str, allowed: float, limit: float) -> None:
        automaton = recorded_automaton(formula)
        self.task = Task(automaton, reward="thesis")
        mdp = labelled_mdp(thesis_world(world))
        self._product, self._rewards = Product(mdp, automaton), RewardProduct(mdp, self.task.tables)
        self._optimum = from_start(self._rewards.initial, optimal_return(self._rewards).value)
        self.max_probability = max_satisfaction_probability(self._product).probability
        self._allowed, self._limit = allowed, limit
        self.verdict = _Verdict(False, float("inf"), 0.0)

    def look(self, policy: npt.NDArray[Any] | None, seconds: float) -> bool:
        """Judge a policy; whether to stop."""
        if policy is not None:
            value = expected_return(self._rewards, self._rewards.lift(policy))
            regret = (self._optimum - value) / abs(self._optimum)
            probability = satisfaction_probability(self._product, self._product.lift(policy)).probability
            good = regret <= self._allowed and probability >= self.max_probability - 1e-6
            self.verdict = _Verdict(good, regret, probability)
        return self.verdict.good or seconds >= self._limit


def _run(system: str, world: str, judge: _Judge, seed: int) -> Learned:
    if system == DQN:
        return _run_dqn(world, judge, seed)
    learner = LEARNERS[system]
    env = LTLVectorWrapper(thesis_vector_world(world, _TABULAR_ENVS), judge.task)

    def callback(learned: Learned) -> bool:
        return judge.look(learned.policy, learned.seconds)

    return learner.train(env, dataclasses.replace(learner.config, seed=seed), callback=callback)


def _run_dqn(world: str, judge: _Judge, seed: int) -> Learned:
    env = LTLVectorWrapper(thesis_vector_world(world, _DQN_ENVS), judge.task)
    judging = 0.0

    def callback(progress: Progress) -> bool:
        nonlocal judging
        before = time.perf_counter()
        stop = judge.look(greedy_policy(progress.agent), progress.row.seconds - judging)
        judging += time.perf_counter() - before
        return stop

    result = train(env, DQNConfig(seed=seed), callback=callback)
    return Learned(
        policy=None,
        message=str(result),
        steps=result.steps,
        seconds=result.seconds - judging,
        product_states=0,
        accepting_components=None,
        value=0.0,
    )
