"""Time to train the thesis' tasks until the policy is nearly optimal, judged exactly; optionally beside another agent.

    python benchmarks/training.py                      # all tasks, five seeds each
    python benchmarks/training.py phi_3-5x5 --seeds 1 --json training.json
    python benchmarks/training.py phi_1-static --peer  # and stable-baselines3's DQN, same wrapper, same network

Rewards are the thesis' (equation 4.3) with its recorded automata, gamma is 0.99, motion noise 0.4. The policy is judged
on the known model every now and then; the clock stands still meanwhile. `seconds` is wall time, `cpu` processor time.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ltlc.agents import DQNConfig, Progress, greedy_policy, train
from ltlc.agents.tensor_tables import TensorTables
from ltlc.envs import LTLVectorWrapper, LTLWrapper, labelled_mdp, recorded_automaton, thesis_vector_world, thesis_world
from ltlc.mdp import Judge, LabelledMDP
from ltlc.task import Task

NUM_ENVS = 64
EPISODE_STEPS = 500
THRESHOLDS = (0.05, 0.01)
PEER_STEPS = 10**9
PEER_EXPLORATION_STEPS = 50_000
PEER_FACTOR = 50.0
"""the other agent is given this many times our time to the first threshold."""


class Case(NamedTuple):
    """A task of the thesis, and how long its training may take."""

    formula: str
    size: str
    dynamic: bool
    total_steps: int
    bound: float
    """seconds of training until the regret is below 1 %."""
    thesis_hours: float


CASES = {
    "phi_1-static": Case("phi_1", "10x10", False, 300_000, 60, 3.0),
    "phi_1-dynamic": Case("phi_1", "10x10", True, 300_000, 60, 0.5),
    "phi_2-static": Case("phi_2", "10x10", False, 600_000, 180, 14.0),
    "phi_2-dynamic": Case("phi_2", "10x10", True, 600_000, 180, 17.0),
    "phi_3-5x5": Case("phi_3", "5x5", False, 60_000, 10, 0.33),
    "phi_3-10x10": Case("phi_3", "10x10", False, 150_000, 30, 3.5),
    "phi_4-5x5": Case("phi_4", "5x5", False, 150_000, 60, 3.0),
    "phi_4-10x10": Case("phi_4", "10x10", False, 300_000, 90, 9.0),
}


@dataclass
class Clock:
    """Wall and processor time, with pauses."""

    wall: float = 0.0
    cpu: float = 0.0
    since: tuple[float, float] | None = None

    def start(self) -> None:
        """Go on."""
        self.since = (time.perf_counter(), time.process_time())

    def pause(self) -> None:
        """Stand still."""
        assert self.since is not None
        self.wall += time.perf_counter() - self.since[0]
        self.cpu += time.process_time() - self.since[1]
        self.since = None


@dataclass
class Measurement:
    """One training run, judged as it went."""

    agent: str
    case: str
    seed: int
    optimum: float
    clock: Clock = field(default_factory=Clock)
    reached: dict[float, tuple[float, float, int]] = field(default_factory=dict)
    """per threshold of relative regret: wall seconds, processor seconds, environment steps when first below it."""
    regret: float = float("nan")
    """relative, at the end."""

    def judge(self, regret: float, steps: int) -> None:
        """Note how good the policy is, while the clock stands still."""
        self.regret = regret
        for threshold in THRESHOLDS:
            if regret < threshold:
                self.reached.setdefault(threshold, (self.clock.wall, self.clock.cpu, steps))


def task_of(case: Case) -> Task:
    """The task with the thesis' rewards and its recorded automaton."""
    return Task(recorded_automaton(case.formula), "thesis")


def model_of(case: Case) -> LabelledMDP:
    """The known dynamics."""
    return labelled_mdp(thesis_world(case.size, dynamic=case.dynamic))


def configuration(case: Case, seed: int) -> DQNConfig:
    """The defaults with a network, not the table that would do here, and with the length of training of this case."""
    return DQNConfig(hidden=(256,), total_steps=case.total_steps, seed=seed, log_every=case.total_steps // 60)


def measure(name: str, seed: int) -> Measurement:
    """Train the bundled agent to the end."""
    case = CASES[name]
    world = thesis_vector_world(case.size, NUM_ENVS, dynamic=case.dynamic, max_episode_steps=EPISODE_STEPS)
    env = LTLVectorWrapper(world, task_of(case), initial_label="skip", extra_labels="ignore")
    result = Measurement("ltlc", name, seed, float("nan"))
    judge = Judge(model_of(case), env.task, initial_label="skip")

    def callback(progress: Progress) -> None:
        result.clock.pause()
        result.optimum = judge.value
        result.judge(judge.regret(greedy_policy(progress.agent)), progress.row.steps)
        result.clock.start()

    result.clock.start()
    train(env, configuration(case, seed), callback=callback)
    result.clock.pause()
    return result


def measure_peer(name: str, seed: int, cap: float, *, tuned: bool) -> Measurement:
    """Train stable-baselines3's DQN for at most `cap` seconds, or until it is below the first threshold.

    The same wrapper and hidden layers; the automaton state is an indicator vector in the input. Untuned, it runs as it
    comes, on one environment, but for the time over which exploration fades. Tuned, it is also given our reward scale,
    batches, exploration, learning rate and number of environments; what is left of the difference is counterfactual
    replay, the double estimator and the implementation.
    """
    import gymnasium as gym
    from stable_baselines3 import DQN
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import DummyVecEnv

    case, task = CASES[name], task_of(CASES[name])
    config = configuration(case, seed).filled(numbered=True)
    scale = TensorTables.of(task.tables, config.reward_scale).scale
    label = "stable-baselines3" + ("+ours" if tuned else "")
    result = Measurement(label, name, seed, float("nan"))

    def make() -> gym.Env[Any, Any]:
        world = thesis_world(case.size, dynamic=case.dynamic)
        wrapped = LTLWrapper(world, task, observation="flat", initial_label="skip", extra_labels="ignore")
        limited = gym.wrappers.TimeLimit(wrapped, EPISODE_STEPS)
        return gym.wrappers.TransformReward(limited, lambda r: r / scale) if tuned else limited

    settings: dict[str, Any] = {"exploration_fraction": PEER_EXPLORATION_STEPS / PEER_STEPS}
    if tuned:
        settings |= {
            "learning_rate": config.learning_rate,
            "buffer_size": config.buffer_size,
            "learning_starts": config.learning_starts,
            "batch_size": config.batch_size,
            "tau": config.tau,
            "target_update_interval": 1,
            "train_freq": 1,
            "exploration_initial_eps": config.epsilon_start,
            "exploration_final_eps": config.epsilon_final,
        }
    env = DummyVecEnv([make] * (NUM_ENVS if tuned else 1))
    network = {"net_arch": list(config.hidden or ())}
    agent = DQN("MlpPolicy", env, policy_kwargs=network, gamma=0.99, seed=seed, device="cpu", **settings)
    judge, shown = peer_judge(case, task)
    result.optimum = judge.value

    class Watch(BaseCallback):
        def _on_step(self) -> bool:
            if self.n_calls % (200 if tuned else 5_000):
                return True
            result.clock.pause()
            values = agent.q_net(agent.policy.obs_to_tensor(shown)[0]).detach().numpy()
            policy = values.argmax(axis=1).reshape(-1, task.tables.n_states)
            result.judge(judge.regret(policy), self.num_timesteps)
            result.clock.start()
            return result.clock.wall < cap and THRESHOLDS[0] not in result.reached

    result.clock.start()
    agent.learn(PEER_STEPS, callback=Watch())
    result.clock.pause()
    return result


def peer_judge(case: Case, task: Task) -> tuple[Judge, npt.NDArray[np.float32]]:
    """The judge, and the flat observations of all pairs (cell, automaton state) in its order."""
    mdp = model_of(case)
    cells, states = np.eye(mdp.n_states, dtype=np.float32), np.eye(task.tables.n_states, dtype=np.float32)
    pairs = [np.repeat(cells, len(states), axis=0), np.tile(states, (len(cells), 1))]
    return Judge(mdp, task, initial_label="skip"), np.concatenate(pairs, axis=1)


def line(result: Measurement) -> str:
    """One row of the table."""
    cells = [f"{result.case:14}", f"{result.agent:22}", f"{result.seed:4}"]
    for threshold in THRESHOLDS:
        wall, cpu, steps = result.reached.get(threshold, (float("nan"),) * 3)
        cells.append(f"{wall:8.1f} {cpu:8.1f} {steps:9.0f}")
    return "  ".join([*cells, f"{result.regret:8.2%}", f"{result.clock.wall:8.1f}"])


def summary(results: Sequence[Measurement]) -> list[str]:
    """One line per case: the slowest seed beside the bound and the thesis."""
    lines = []
    for name in dict.fromkeys(result.case for result in results):
        case = CASES[name]
        ours = [r.reached.get(THRESHOLDS[-1]) for r in results if r.case == name and r.agent == "ltlc"]
        done = [reached for reached in ours if reached is not None]
        worst = max((reached[0] for reached in done), default=float("nan"))
        cpu = max((reached[1] for reached in done), default=float("nan"))
        lines.append(
            f"{name:14}  {len(done)} of {len(ours)} seeds below {THRESHOLDS[-1]:.0%}; slowest {worst:.1f} s "
            f"({cpu:.1f} s cpu), bound {case.bound:.0f} s, thesis {case.thesis_hours:g} h"
        )
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and write JSON if asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("cases", nargs="*", help=f"any of {', '.join(CASES)}; all by default")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--peer", action="store_true", help="also train stable-baselines3's DQN (must be installed)")
    parser.add_argument("--cap", type=float, default=600.0, help="most seconds for the other agent")
    parser.add_argument("--json", help="write the measurements to this file")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.cases if name not in CASES]
    if unknown:
        parser.error(f"unknown case {unknown[0]!r}; known: {', '.join(CASES)}")
    heads = "".join(f"  {f'to {t:.0%}: seconds, cpu, steps':>27}" for t in THRESHOLDS)
    print(f"{'case':14}  {'agent':22}  seed{heads}    regret  whole, s")
    results: list[Measurement] = []
    for name in options.cases or CASES:
        for seed in range(options.seeds):
            for result in measurements(name, seed, options.cap if options.peer and seed == 0 else None):
                results.append(result)
                print(line(result), flush=True)
    print("\n" + "\n".join(summary(results)))
    if options.json:
        with open(options.json, "w", encoding="utf-8") as stream:
            json.dump([asdict(result) for result in results], stream, indent=1)


def measurements(name: str, seed: int, peer_cap_s: float | None) -> Iterator[Measurement]:
    """Ours, and, where the other agent gets time, that one as it comes and with our settings."""
    ours = measure(name, seed)
    yield ours
    if peer_cap_s is not None:
        for tuned in (False, True):
            yield measure_peer(name, seed, peer_cap(ours, peer_cap_s), tuned=tuned)


def peer_cap(ours: Measurement, cap: float) -> float:
    """Seconds the other agent is given."""
    reached = ours.reached.get(THRESHOLDS[0])
    return min(cap, PEER_FACTOR * reached[0]) if reached else cap


if __name__ == "__main__":
    main()
