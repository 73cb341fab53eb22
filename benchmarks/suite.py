"""The certified benchmark suite: published tasks, their exact optima, and what the bundled agent learns in each.

    python benchmarks/suite.py --exact                   # all tasks, nothing is learned
    python benchmarks/suite.py                           # and the agent, with five seeds
    python benchmarks/suite.py gate devious --seeds 1 --json suite.json
    python benchmarks/suite.py --exact --storm           # beside Storm, where stormpy is installed

The agent is `DQNConfig()`, rewarded by `two-discount`: one configuration and one scheme for all tasks, of which it knows
the formula and nothing of the dynamics. What it has learned is judged exactly: the probability that its greedy policy
satisfies the formula. It learns the tasks whose product has at most 2000 states.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from suite_tasks import SuiteTask, load_suite
from suite_world import ModelWorld

from ltlc import Task, compile
from ltlc.agents import DQNConfig, greedy_policy, train
from ltlc.automata import RabinAutomaton
from ltlc.envs import LTLVectorWrapper
from ltlc.envs.setting import EPISODE_STEPS
from ltlc.mdp import Product, max_satisfaction_probability
from ltlc.mdp.verdict import Judge

NUM_ENVS = 64
LEARNED_UP_TO = 2_000
"""product states."""
SCHEME = "two-discount"
PRECISION = 1e-6
SHORTFALL = 0.01
"""a learned policy may miss the maximum by no more."""


@dataclass(frozen=True)
class Exact:
    """The exact side of a task."""

    task: str
    formula: str
    reference: float
    published: bool
    product_states: int
    pmax: float
    lower: float
    upper: float
    seconds: float
    storm: float | None = None

    @property
    def difference(self) -> float:
        """From the reference."""
        return self.pmax - self.reference


@dataclass(frozen=True)
class Learned:
    """What one seed learned."""

    task: str
    seed: int
    satisfaction: float
    """exact probability that the learned policy satisfies the formula."""
    shortfall: float
    """what it misses the maximum by."""
    steps: int
    seconds: float
    cpu: float
    """seconds of processor time."""


def automaton_of(task: SuiteTask) -> RabinAutomaton:
    return compile(task.formula, acceptance="transition")


def exact(task: SuiteTask, *, storm: bool = False) -> Exact:
    """Solve a task; bounds are closed to 1e-6 if they are not at once."""
    since = time.perf_counter()
    product = Product(task.model, automaton_of(task))
    best = max_satisfaction_probability(product)
    if best.upper - best.lower > PRECISION:
        best = max_satisfaction_probability(product, method="interval", precision=PRECISION)
    seconds = time.perf_counter() - since
    return Exact(
        task.name, task.formula, task.pmax, task.published, product.n_states, best.probability, best.lower, best.upper,
        seconds, storm_maximum(task) if storm else None,
    )  # fmt: skip


def learn(task: SuiteTask, seed: int, maximum: float, **changes: object) -> Learned:
    """Train the bundled agent as it comes, and judge what it has learned."""
    automaton = automaton_of(task)
    goal = Task(automaton, SCHEME)
    world = ModelWorld(task.model, NUM_ENVS, EPISODE_STEPS)
    config = dataclasses.replace(DQNConfig(), seed=seed, **changes)  # type: ignore[arg-type]
    wall, cpu = time.perf_counter(), time.process_time()
    result = train(LTLVectorWrapper(world, goal, extra_labels="ignore"), config)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    satisfaction = Judge(task.model, automaton, goal.tables).satisfaction(greedy_policy(result.agent))
    return Learned(task.name, seed, satisfaction, maximum - satisfaction, result.steps, wall, cpu)
