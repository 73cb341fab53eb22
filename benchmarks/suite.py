"""The certified benchmark suite: published tasks, their exact optima, and what the bundled agent learns in each.

    python benchmarks/suite.py --exact                   # all tasks, nothing is learned
    python benchmarks/suite.py                           # and the agent, with five seeds
    python benchmarks/suite.py gate devious --seeds 1 --json suite.json
    python benchmarks/suite.py --network --seeds 1       # as if states could not be counted
    python benchmarks/suite.py --exact --storm           # beside Storm, where stormpy is installed

The agent is `FittedQConfig()`, or `DQNConfig()` with `--network`, rewarded by `ltlc.rewards.RECOMMENDED` as it comes:
one configuration and one scheme for all tasks. It knows the formula and nothing of the dynamics. What it has learned is
judged exactly: the probability that its policy satisfies the formula. It learns the tasks whose product has at
most 2000 states. A policy that is optimal for the rewards is judged, too.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from suite_tasks import SuiteTask, load_suite
from suite_world import ModelWorld

from ltlc import Task, compile
from ltlc.agents import DQNConfig, FittedQConfig, train
from ltlc.automata import DRA
from ltlc.envs import LTLVectorWrapper
from ltlc.errors import UnknownNameError
from ltlc.ltl import parse, to_text
from ltlc.mdp import Judge, Product, max_satisfaction_probability
from ltlc.mdp.reachability import distance_to
from ltlc.prism import write_explicit
from ltlc.rewards import RECOMMENDED

NUM_ENVS = 512
NETWORK_ENVS, NETWORK_STEPS = 64, 100_000
EPISODE_STEPS = 200
LEARNED_UP_TO = 2_000
"""product states."""
SHORTFALL, NETWORK_SHORTFALL = 0.01, 0.02
"""a learned policy may miss the maximum by no more."""
STORM_SECONDS = 60


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
    optimum: float
    """exact probability that a policy that is optimal for the rewards satisfies the formula."""
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


def automaton_of(task: SuiteTask) -> DRA:
    return compile(task.formula, acceptance="transition")


def exact(task: SuiteTask, *, storm: bool = False) -> Exact:
    """Solve a task."""
    since = time.perf_counter()
    automaton = automaton_of(task)
    product = Product(task.model, automaton)
    best = max_satisfaction_probability(product)
    seconds = time.perf_counter() - since
    judge = Judge(task.model, Task(automaton))
    assert judge.optimal_policy is not None  # returns of the default rewards are at most 1
    return Exact(
        task.name, task.formula, task.pmax, task.published, product.n_states, best.probability, best.lower, best.upper,
        seconds, judge.satisfaction(judge.optimal_policy), storm_maximum(task) if storm else None,
    )  # fmt: skip


def learn(task: SuiteTask, seed: int, maximum: float, *, network: bool = False, **changes: object) -> Learned:
    """Train a bundled agent as it comes, and judge what it has learned."""
    automaton = automaton_of(task)
    goal = Task(automaton, RECOMMENDED)
    world = ModelWorld(task.model, NETWORK_ENVS if network else NUM_ENVS, EPISODE_STEPS)
    plain = DQNConfig(total_steps=NETWORK_STEPS) if network else FittedQConfig()
    config = dataclasses.replace(plain, seed=seed, **changes)  # type: ignore[arg-type]
    wall, cpu = time.perf_counter(), time.process_time()
    result = train(LTLVectorWrapper(world, goal, extra_labels="ignore"), config)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    satisfaction = Judge(task.model, goal).satisfaction(result.agent.policy_table())
    return Learned(task.name, seed, satisfaction, maximum - satisfaction, result.steps, wall, cpu)


def fewest_steps(task: SuiteTask) -> int:
    """Steps until the formula is satisfied whatever follows, if chance is kind; -1 where that cannot be."""
    automaton = automaton_of(task)
    product = Product(task.model, automaton)
    done = np.isin(product.machine_state, automaton.accepting_sinks)
    return int(distance_to(product, done)[product.initial > 0].min())


def storm_maximum(task: SuiteTask) -> float | None:
    """The answer of Storm, to its own precision of 1e-6; None where it is not installed, or not done in a minute."""
    if find_spec("stormpy") is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        files = write_explicit(task.model, Path(folder) / "model", style="storm")
        question = f"Pmax=? [{to_text(parse(task.formula), 'prism')}]"
        command = [sys.executable, "-c", _ASK_STORM, str(files[0]), str(files[1]), question]
        try:  # in a process of its own, since nothing else stops Storm where its iteration does not end
            child = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=STORM_SECONDS)
        except subprocess.TimeoutExpired:
            return None
    return float(child.stdout.splitlines()[-1])


_ASK_STORM = """
import sys, stormpy
build = getattr(stormpy, "build_model_from_explicit", None) or stormpy.build_sparse_model_from_explicit
model = build(*sys.argv[1:3])
result = stormpy.model_checking(model, stormpy.parse_properties(sys.argv[3])[0], only_initial_states=True)
state = model.initial_states[0]
print(repr(result.get_value(state) if hasattr(result, "get_value") else result.at(state)))
"""


def exact_line(found: Exact, *, storm: bool) -> str:
    """One row of the exact table."""
    certain = f"[{found.lower:.8f}, {found.upper:.8f}]"
    reference = f"{found.reference:.6f}{'*' if found.published else ' '}"
    cells = [f"{found.task:28}", f"{found.product_states:6}", f"{found.pmax:.8f}", certain, reference]
    cells += [f"{found.difference:+.1e}", f"{found.optimum:.6f}"]
    if storm:
        cells.append("-" if found.storm is None else f"{found.storm:.8f}")
    return "  ".join(cells)


def learned_line(found: Sequence[Learned], allowed: float) -> str:
    """One row of the learned table: the worst of all seeds."""
    worst = min(found, key=lambda run: run.satisfaction)
    good = sum(run.shortfall <= allowed for run in found)
    slowest, cpu = max(run.seconds for run in found), max(run.cpu for run in found)
    return (
        f"  learned: P(sat) {worst.satisfaction:.6f} at worst, {max(worst.shortfall, 0.0):.6f} short; {good} of "
        f"{len(found)} seeds; {worst.steps} steps, {slowest:.1f} s ({cpu:.1f} s cpu) at most"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Solve, learn, print, and write JSON if asked to."""
    suite = load_suite()
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names of tasks, or of groups; default all")
    parser.add_argument("--exact", action="store_true", help="learn nothing")
    parser.add_argument("--network", action="store_true", help="learn with the network, though states can be counted")
    parser.add_argument("--seeds", type=int, default=5, metavar="N", help="learn with seeds 0 to N-1; default 5")
    parser.add_argument("--storm", action="store_true", help="ask Storm, too, where stormpy is installed")
    parser.add_argument("--json", metavar="FILE", help="write the tables as JSON")
    options = parser.parse_args(arguments)
    known = {*suite, *(task.group for task in suite.values())}
    for name in options.tasks:
        if name not in known:
            parser.error(str(UnknownNameError("task", name, sorted(known))))
    wanted = [task for task in suite.values() if not options.tasks or {task.name, task.group} & {*options.tasks}]
    columns = "task, product states, Pmax, its bounds, the reference (* published), difference, optimum of the rewards"
    print(columns + ", Storm" * options.storm)
    rows = []
    for task in wanted:
        solved = exact(task, storm=options.storm)
        print(exact_line(solved, storm=options.storm), flush=True)
        runs = []
        if not options.exact and solved.product_states <= LEARNED_UP_TO:
            runs = [learn(task, seed, solved.pmax, network=options.network) for seed in range(options.seeds)]
            print(learned_line(runs, NETWORK_SHORTFALL if options.network else SHORTFALL), flush=True)
        rows.append(asdict(solved) | {"learned": [asdict(run) for run in runs]})
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
