"""Tables 5.1 and 5.2 of the thesis anew: how long each system takes to the same exact quality, and what it builds."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from types import MappingProxyType
from typing import Any

from ltlc.envs import LTLVectorWrapper, labelled_mdp, recorded_automaton, thesis_vector_world, thesis_world
from ltlc.errors import RewardWarning, UnknownNameError
from ltlc.mdp import Judge
from ltlc.task import Task

from ..registry import AGENTS, DOUBLE_DQN
from ..training.evaluate import Evaluation, EvaluationCallback
from ..training.loop import train

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
SYSTEMS = (DOUBLE_DQN, "q-learning", "double-q-learning", "fu-topcu", "sadigh", "wang")
"""what is compared: the deep agent with its network, and every tabular learner."""
REGRET = 0.01
"""part of the optimal return that a good policy may lose."""
SECONDS, QUICK_SECONDS = 60.0, 20.0
"""time limit of each run."""
_TABULAR_ENVS = 256
_ENVS: Mapping[str, int] = MappingProxyType({DOUBLE_DQN: 16})
"""environments stepped together, where they are not those of the tabular learners."""
_CHANGES: Mapping[str, Mapping[str, Any]] = MappingProxyType({
    DOUBLE_DQN: {"hidden": (256,), "total_steps": 1_000_000, "epsilon_steps": 100_000},  # it is stopped far earlier
})  # fmt: skip
"""what is not as in the defaults of the system."""


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
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RewardWarning)  # what they teach is what is to be seen
            task = Task(recorded_automaton(formula), reward="thesis")
        judge = Judge(labelled_mdp(thesis_world(world)), task)
        for system in wanted:
            runs = [_run(system, world, task, judge, regret, allowed, seed) for seed in chosen]
            rows.append(_row(system, world, formula, judge, runs))
            if progress is not None:
                progress(rows[-1])
    return rows


def _run(
    system: str, world: str, task: Task, judge: Judge, regret: float, limit: float, seed: int
) -> tuple[bool, Evaluation]:
    """Train until the policy is good, or the time is up; whether it is, and the last evaluation."""

    def good(found: Evaluation) -> bool:
        assert found.regret is not None  # the thesis' rewards are discounted
        return found.satisfaction >= judge.maximum.probability - 1e-6 and found.regret <= regret

    env = LTLVectorWrapper(thesis_vector_world(world, _ENVS.get(system, _TABULAR_ENVS)), task)
    config = dataclasses.replace(AGENTS[system].defaults, seed=seed, **_CHANGES.get(system, {}))
    evaluate = EvaluationCallback(judge, lambda found: good(found) or found.row.seconds >= limit)
    if train(env, config, agent=system, callback=evaluate).interrupted:
        raise KeyboardInterrupt
    return good(evaluate.evaluations[-1]), evaluate.evaluations[-1]


def _row(system: str, world: str, formula: str, judge: Judge, runs: Sequence[tuple[bool, Evaluation]]) -> RuntimeRow:
    last = [found for _, found in runs]
    seconds = [found.row.seconds for found in last]
    built = [found.row.product_states for found in last if found.row.product_states is not None]
    return RuntimeRow(
        system=system,
        world=world,
        formula=formula,
        runs=len(runs),
        reached=sum(good for good, _ in runs),
        seconds=median(seconds),
        fastest=min(seconds),
        slowest=max(seconds),
        steps=int(median(found.row.steps for found in last)),
        regret=max(found.regret or 0.0 for found in last),
        probability=min(found.satisfaction for found in last),
        max_probability=judge.maximum.probability,
        product_states=max(built) if built else None,
        accepting_components=last[-1].row.accepting_components,
        reachable_states=judge.words.n_states,
        thesis_hours=THESIS_HOURS.get((system, world, formula)),
        thesis_product_states=THESIS_STATES[world, formula],
    )
