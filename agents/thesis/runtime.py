"""Tables 5.1 and 5.2 of the thesis anew: how long each system takes to the same exact quality, and what it builds."""

from __future__ import annotations

import dataclasses
import math
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy.typing as npt

from ltlc.envs import LTLVectorWrapper, labelled_mdp, recorded_automaton, thesis_vector_world, thesis_world
from ltlc.errors import RewardWarning, UnknownNameError
from ltlc.mdp import Judge
from ltlc.task import Task

from ..double_dqn.config import DQNConfig
from ..registry import DOUBLE_DQN
from ..tabular.learned import Learned
from ..tabular.registry import LEARNERS
from ..training.evaluate import greedy_policy
from ..training.loop import train
from ..training.progress import Progress

CASES = (("5x5", "phi_3"), ("10x10", "phi_3"), ("5x5", "phi_4"), ("10x10", "phi_4"))
"""worlds and formulas of the tables, in their order."""
THESIS_HOURS: Mapping[tuple[str, str, str], str] = MappingProxyType({
    (DOUBLE_DQN, "5x5", "phi_3"): "0.33", (DOUBLE_DQN, "10x10", "phi_3"): "3.5",
    (DOUBLE_DQN, "5x5", "phi_4"): "3", (DOUBLE_DQN, "10x10", "phi_4"): "9",
    ("fu-topcu", "5x5", "phi_3"): "0.22", ("fu-topcu", "10x10", "phi_3"): ">25",
    ("fu-topcu", "5x5", "phi_4"): "8", ("fu-topcu", "10x10", "phi_4"): ">25",
})  # fmt: skip
"""table 5.1: hours by system, world and formula, with a deep Q-network and with Fu and Topcu's method."""
THESIS_STATES: Mapping[tuple[str, str], int] = MappingProxyType(
    dict(zip(CASES, (100, 400, 375, 1500), strict=True)),
)
"""table 5.2: states of the product."""
SYSTEMS = (DOUBLE_DQN, *LEARNERS)
"""what is compared: the deep agent with its network, and every tabular learner."""
REGRET = 0.01
"""part of the optimal return that a good policy may lose."""
SECONDS, QUICK_SECONDS = 60.0, 20.0
"""time limit of each run."""
_TABULAR_ENVS, _DQN_ENVS = 256, 16


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
    fastest: float
    """as `seconds`, of the fastest run."""
    slowest: float
    """as `seconds`, of the slowest run."""
    steps: int
    """environment steps until then; median."""
    regret: float
    """exact: part of the optimal expected return that the last policy loses; inf if there was none. Largest."""
    probability: float
    """exact probability that the last policy satisfies the formula. Smallest of the runs."""
    max_probability: float
    """the largest there is."""
    product_states: int | None
    """product states built by learners of a model, visited by Q-learning; largest of the runs. None: a network."""
    accepting_components: int | None
    """that the system found in the last run; None: it does not look for them."""
    reachable_states: int
    """product states that any policy can visit."""
    thesis_hours: str | None
    """table 5.1, on other hardware and to no stated quality; None: not in the table."""
    thesis_product_states: int
    """table 5.2."""

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values; infinities as text."""
        return dataclasses.asdict(self) | {"regret": self.regret if math.isfinite(self.regret) else str(self.regret)}


def runtime_comparison(
    *,
    quick: bool = False,
    systems: Sequence[str] | None = None,
    cases: Sequence[tuple[str, str]] | None = None,
    seeds: Sequence[int] | None = None,
    regret: float = REGRET,
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
        systems: some of `SYSTEMS`; None: all.
        cases: pairs of a world (`thesis_map`) and a recorded automaton, some of `CASES`; None: all.
        seeds: instead of the above.
        regret: part of the optimal return that may be lost.
        limit: seconds for each run, instead of the above.
        progress: called with each row as it comes.

    Raises:
        UnknownNameError: there is no such system, world or automaton.
        KeyboardInterrupt: Ctrl-C.

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, section 5.3. The
        5x5 world is not recorded there, nor whether motion was noisy; here it is, as in the case studies.
    """
    wanted = SYSTEMS if systems is None else systems
    for system in wanted:
        if system not in SYSTEMS:
            raise UnknownNameError("system", system, SYSTEMS)
    chosen = seeds if seeds is not None else (0,) if quick else (0, 1, 2)
    allowed = limit if limit is not None else QUICK_SECONDS if quick else SECONDS
    rows = []
    for world, formula in CASES if cases is None else cases:
        for system in wanted:
            rows.append(_row(system, world, formula, chosen, _Referee(world, formula, regret, allowed)))
            if progress is not None:
                progress(rows[-1])
    return rows


def _row(system: str, world: str, formula: str, seeds: Sequence[int], referee: _Referee) -> RuntimeRow:
    runs: list[tuple[_Run, _Quality]] = []
    for seed in seeds:
        referee.last = _NONE
        run = _run_dqn(world, referee, seed) if system == DOUBLE_DQN else _run_learner(system, world, referee, seed)
        runs.append((run, referee.last))
    seconds = [run.seconds for run, _ in runs]
    built = [run.product_states for run, _ in runs if run.product_states is not None]
    return RuntimeRow(
        system=system,
        world=world,
        formula=formula,
        runs=len(runs),
        reached=sum(quality.good for _, quality in runs),
        seconds=median(seconds),
        fastest=min(seconds),
        slowest=max(seconds),
        steps=int(median(run.steps for run, _ in runs)),
        regret=max(quality.regret for _, quality in runs),
        probability=min(quality.probability for _, quality in runs),
        max_probability=referee.judge.maximum.probability,
        product_states=max(built) if built else None,
        accepting_components=runs[-1][0].accepting_components,
        reachable_states=referee.judge.words.n_states,
        thesis_hours=THESIS_HOURS.get((system, world, formula)),
        thesis_product_states=THESIS_STATES[world, formula],
    )


class _Run(NamedTuple):
    seconds: float
    steps: int
    product_states: int | None = None
    accepting_components: int | None = None


class _Quality(NamedTuple):
    good: bool
    regret: float
    probability: float


_NONE = _Quality(False, math.inf, 0.0)


class _Referee:
    """Stops a run when its policy is good, or its time is up."""

    def __init__(self, world: str, formula: str, allowed: float, limit: float) -> None:
        automaton = recorded_automaton(formula)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RewardWarning)  # what they teach is what is to be seen
            self.task = Task(automaton, reward="thesis")
        self.judge = Judge(labelled_mdp(thesis_world(world)), self.task)
        self._allowed, self._limit = allowed, limit
        self.last = _NONE

    def look(self, policy: npt.NDArray[Any] | None, seconds: float) -> bool:
        """Judge a policy; whether to stop."""
        if policy is not None:
            regret, probability = self.judge.regret(policy), self.judge.satisfaction(policy)
            assert regret is not None  # the thesis' rewards are discounted
            best = probability >= self.judge.maximum.probability - 1e-6
            self.last = _Quality(best and regret <= self._allowed, regret, probability)
        return self.last.good or seconds >= self._limit


def _run_learner(system: str, world: str, referee: _Referee, seed: int) -> _Run:
    env = LTLVectorWrapper(thesis_vector_world(world, _TABULAR_ENVS), referee.task)
    learner, states = LEARNERS[system], referee.task.tables.automaton_state

    def callback(learned: Learned) -> bool:
        policy = learned.policy
        if policy is not None and not learner.uses_rewards:
            policy = policy[:, states]
        return referee.look(policy, learned.seconds)

    learned = learner.train(env, dataclasses.replace(learner.config, seed=seed), callback=callback)
    return _Run(learned.seconds, learned.steps, learned.product_states, learned.accepting_components)


def _run_dqn(world: str, referee: _Referee, seed: int) -> _Run:
    env = LTLVectorWrapper(thesis_vector_world(world, _DQN_ENVS), referee.task)
    judging = 0.0

    def callback(progress: Progress) -> bool:
        nonlocal judging
        before = time.perf_counter()
        stop = referee.look(greedy_policy(progress.agent), progress.row.seconds - judging)
        judging += time.perf_counter() - before
        return stop

    network = DQNConfig(hidden=(256,), total_steps=1_000_000, epsilon_steps=100_000, seed=seed)  # stopped far earlier
    result = train(env, network, callback=callback)
    if result.interrupted:
        raise KeyboardInterrupt
    return _Run(result.seconds - judging, result.steps)
