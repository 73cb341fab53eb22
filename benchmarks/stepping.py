"""What stepping costs: the wrappers over bare environments, alone and vectorised.

Each figure is the best of several rounds, and bare and wrapped rounds take turns, so that a busy machine disturbs both
alike. Run with `python benchmarks/stepping.py [--json FILE]`.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from ltlc.envs import LTLVectorWrapper, LTLWrapper, recorded_automaton, thesis_vector_world, thesis_world
from ltlc.task import Task

NUM_ENVS = 4096
FORMULAS = ("phi_1", "phi_2")


class StillVectorEnv(gym.vector.VectorEnv):
    """A vector environment that costs nothing: its labels are drawn beforehand."""

    def __init__(self, num_envs: int, propositions: tuple[str, ...]) -> None:
        self.num_envs = num_envs
        self.propositions = propositions
        self.single_observation_space = gym.spaces.Discrete(2)
        self.single_action_space = gym.spaces.Discrete(2)
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, num_envs)
        self.metadata = {"autoreset_mode": gym.vector.AutoresetMode.NEXT_STEP}
        rng = np.random.default_rng(0)
        self.letters = rng.choice(1 << len(propositions), size=(64, num_envs))
        self.zeros = np.zeros(num_envs, dtype=np.int64)
        self.rewards = np.zeros(num_envs)
        self.never = np.zeros(num_envs, dtype=bool)
        self.time = 0

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:  # noqa: D102
        return self.zeros, {"labels": self.letters[0]}

    def begin_episode(self, mask: Any) -> None:
        """Every step is as good as the first."""

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:  # noqa: D102
        self.time = (self.time + 1) % 64
        return self.zeros, self.rewards, self.never, self.never, {"labels": self.letters[self.time]}


class StillEnv(gym.Env):
    """An environment that costs next to nothing, and shows the numbers 0 to 15 in turn."""

    observation_space = gym.spaces.Discrete(16)
    action_space = gym.spaces.Discrete(2)

    def __init__(self) -> None:
        self.time = 0

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[int, dict[str, Any]]:  # noqa: D102
        return 0, {}

    def step(self, action: Any) -> tuple[int, float, bool, bool, dict[str, Any]]:  # noqa: D102
        self.time = (self.time + 1) % 16
        return self.time, 0.0, False, False, {}


def label_functions(aps: tuple[str, ...]) -> dict[str, Any]:
    """Functions of one observation whose labels come as a frozenset, as a set, and as a dict of predicates."""
    names = [frozenset(name for i, name in enumerate(aps) if shown >> i & 1) for shown in range(16)]
    held = [{name: name in label for name in aps} for label in names]
    return {
        "frozenset": lambda shown: names[shown],
        "set": lambda shown: set(names[shown]),
        "predicates": {name: lambda shown, name=name: held[shown][name] for name in aps},
    }


def best(rounds: int, *works: Callable[[], int]) -> list[float]:
    """Seconds per step of each piece of work, which returns how many steps it made."""
    seconds = [float("inf")] * len(works)
    for _ in range(rounds):
        for i, work in enumerate(works):
            start = time.perf_counter()
            steps = work()
            seconds[i] = min(seconds[i], (time.perf_counter() - start) / steps)
    return seconds


def single_steps(env: gym.Env, steps: int) -> Callable[[], int]:
    def work() -> int:
        env.reset(seed=0)
        actions = np.random.default_rng(0).integers(0, env.action_space.n, steps).tolist()
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return steps

    return work


def vector_steps(env: gym.vector.VectorEnv, steps: int) -> Callable[[], int]:
    env.reset(seed=0)
    high = int(env.single_action_space.n)  # type: ignore[attr-defined]
    actions = np.random.default_rng(0).integers(0, high, (16, env.num_envs))

    def work() -> int:
        for i in range(steps):
            env.step(actions[i % 16])
        return steps * env.num_envs

    return work


def measure(rounds: int) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    task = Task("F(a & F b) & G !c")
    for kind, labels in label_functions(task.aps).items():
        wrapper = LTLWrapper(StillEnv(), task, labels, observation="none", warn_discount=False)
        bare, wrapped = best(rounds, single_steps(StillEnv(), 2000), single_steps(wrapper, 2000))
        rows.append(row(f"LTLWrapper, labels: {kind}", bare, wrapped))
    for name in FORMULAS:
        task = Task(recorded_automaton(name), reward="thesis")
        for mode in ("dict", "flat", "index", "none"):
            bare, wrapped = best(
                rounds,
                single_steps(thesis_world(), 2000),
                single_steps(LTLWrapper(thesis_world(), task, observation=mode), 2000),
            )
            rows.append(row(f"LTLWrapper, {name}, {mode}", bare, wrapped))
        for scheme, world in (("thesis", "still"), ("thesis, no stop", "still"), ("thesis", "grid")):
            reward = "thesis" if scheme == "thesis" else "parity"
            vector_task = task if scheme == "thesis" else Task(recorded_automaton(name), reward, on_deadlock="stay")
            rows.append(vector_row(name, reward, world, vector_task, rounds))
    return rows


def vector_row(name: str, reward: str, world: str, task: Task, rounds: int) -> dict[str, Any]:
    def make() -> gym.vector.VectorEnv:
        if world == "grid":
            return thesis_vector_world("10x10", NUM_ENVS, max_episode_steps=500)
        return StillVectorEnv(NUM_ENVS, task.aps)

    bare, wrapped = best(rounds, vector_steps(make(), 40), vector_steps(LTLVectorWrapper(make(), task), 40))
    figures = row(f"LTLVectorWrapper, {name}, {reward}, {world} world", bare, wrapped)
    return {**figures, "automaton_steps_per_s": 1 / (wrapped - bare), "steps_per_s": 1 / wrapped}


def row(what: str, bare: float, wrapped: float) -> dict[str, Any]:
    """The figures of one line, from seconds per step."""
    return {
        "what": what,
        "bare_us": bare * 1e6,
        "wrapped_us": wrapped * 1e6,
        "overhead_us": (wrapped - bare) * 1e6,
        "ratio": wrapped / bare,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    parser.add_argument("--rounds", type=int, default=40, help="rounds per figure; the best counts")
    arguments = parser.parse_args()
    rows = measure(arguments.rounds)
    print(f"{'':58} {'bare us':>9} {'wrapped us':>10} {'overhead us':>11} {'automaton steps/s':>18}")
    for row in rows:
        speed = f"{row['automaton_steps_per_s']:18.3g}" if "automaton_steps_per_s" in row else ""
        print(f"{row['what']:58} {row['bare_us']:9.4f} {row['wrapped_us']:10.4f} {row['overhead_us']:11.4f} {speed}")
    print(f"vector figures: {NUM_ENVS} sub-environments on one core, microseconds per sub-environment and step")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
