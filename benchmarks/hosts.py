"""One task file, trained unchanged in every library that the bridges lead to, and P(sat) of what was learned.

    python benchmarks/hosts.py                    # all hosts that are installed
    python benchmarks/hosts.py sac atari --json hosts.json
    .venv-rllib/bin/python benchmarks/hosts.py rllib   # the environment that make test-rllib makes

The file is benchmarks/errand.json, the automaton of `!pit U (key & (!pit U goal))`. A host brings an environment and
says what `key`, `goal` and `pit` are there. Grid worlds are judged exactly, the others by episodes.
"""

from __future__ import annotations

import argparse
import importlib
import json
import runpy
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.wrappers import TimeLimit

import ltlc
from ltlc.envs import GridWorld
from ltlc.mdp.estimate import probability

FILE = Path(__file__).with_name("errand.json")
EXAMPLES = Path(__file__).parents[1] / "examples"
MAP, LABELS = ("S..k", ".##.", "..x.", "...g"), {"k": "key", "g": "goal", "x": "pit"}
HORIZON = 50


@dataclass(frozen=True)
class Learned:
    """What a host has learned: P(sat), with bounds that are proved where it is exact."""

    value: float
    low: float
    high: float
    exact: bool

    @classmethod
    def of(cls, found: ltlc.judging.Judgement) -> Learned:
        """What a judgement says."""
        return cls(found.satisfaction, *found.bounds, found.exact)


def task(reward: str | None = None) -> ltlc.Task:
    automaton = ltlc.load(FILE)
    return (ltlc.Task(automaton) if reward is None else ltlc.Task(automaton, reward)).for_horizon(HORIZON)


def grid(reward: str | None = None, **how: Any) -> Any:
    """The grid world of the examples, with the task, observed as a vector."""
    world = GridWorld(MAP, labels=LABELS, slip=0.1, actions=4)
    wrapped = ltlc.LTLWrapper(world, task(reward), **{"observation": "flat", "warn_discount": False} | how)
    return TimeLimit(wrapped, HORIZON)


def gymnasium_loop(steps: int = 30_000) -> Learned:
    """Tabular Q-learning in a loop of one's own."""
    env, random = grid(observation="index"), np.random.default_rng(0)
    q, visits = (np.zeros((int(env.observation_space.n), 4)) for _ in range(2))
    state, _ = env.reset(seed=0)
    for _ in range(steps):
        action = int(random.integers(4)) if random.random() < 0.5 else int(q[state].argmax())
        after, reward, terminated, truncated, info = env.step(action)
        visits[state, action] += 1
        goal = reward + (0.0 if terminated else info["ltl"]["discount"] * q[after].max())
        q[state, action] += (goal - q[state, action]) / visits[state, action] ** 0.65
        state = env.reset()[0] if terminated or truncated else after
    return Learned.of(ltlc.judge(lambda seen: int(q[seen].argmax()), env))


def sb3_dqn(steps: int = 8_000) -> Learned:
    from stable_baselines3 import DQN

    from ltlc.bridges.stable_baselines3 import replay

    env = grid()
    model = DQN(
        "MlpPolicy", env, learning_rate=1e-3, learning_starts=500, train_freq=1, target_update_interval=200,
        exploration_fraction=0.7, policy_kwargs={"net_arch": [64]}, seed=0, device="cpu",
        **replay(env, counterfactual=True),
    )  # fmt: skip
    return Learned.of(ltlc.judge(model.learn(steps), env))


def sb3_ppo(steps: int = 20_000) -> Learned:
    """One discount for all steps, so the rewards are those that need none."""
    from stable_baselines3 import PPO

    env = grid("zeta-reach")
    return Learned.of(ltlc.judge(PPO("MlpPolicy", env, **_PPO).learn(steps), env))


def maskable_ppo(steps: int = 20_000, copies: int = 1) -> Learned:
    from sb3_contrib import MaskablePPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    envs = grid("zeta-reach") if copies == 1 else DummyVecEnv([lambda: grid("zeta-reach")] * copies)
    more = _PPO | {"n_steps": _PPO["n_steps"] // copies}
    return Learned.of(ltlc.judge(MaskablePPO("MlpPolicy", envs, **more).learn(steps), grid("zeta-reach")))


_PPO: dict[str, Any] = {
    "gamma": 1.0, "n_steps": 512, "batch_size": 64, "learning_rate": 1e-3, "ent_coef": 0.01, "seed": 0, "device": "cpu",
}  # fmt: skip


class Track(gym.Env[Any, Any]):
    """A continuous world: a place on a line, and an action that moves it, by at most 1 and some noise."""

    def __init__(self) -> None:
        self.observation_space = gym.spaces.Box(-3, 3, (1,), np.float32)
        self.action_space = gym.spaces.Box(-1, 1, (1,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin in the middle."""
        super().reset(seed=seed)
        self.place = np.zeros(1, np.float32)
        return self.place, {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Move."""
        moved = self.place + np.clip(action, -1, 1) + 0.1 * self.np_random.standard_normal(1)
        self.place = np.clip(moved, -3, 3).astype(np.float32)
        return self.place, 0.0, False, False, {}


def sb3_sac(steps: int = 4_000) -> Learned:
    from stable_baselines3 import SAC

    from ltlc.bridges.stable_baselines3 import replay

    labels = {"key": lambda x: -2 < x[0] < -1, "goal": lambda x: 1 < x[0] < 2, "pit": lambda x: abs(x[0]) > 2.5}
    wrapped = ltlc.LTLWrapper(Track(), task(), labels, observation="flat", warn_discount=False)
    env = TimeLimit(wrapped, HORIZON)
    model = SAC(
        "MlpPolicy", env, learning_rate=2e-3, learning_starts=500, batch_size=64, ent_coef=0.01, train_freq=2,
        policy_kwargs={"net_arch": [64, 64]}, seed=0, device="cpu", **replay(env, counterfactual=True),
    )  # fmt: skip
    return Learned.of(ltlc.judge(model.learn(steps), env, episodes=200))


def example(name: str, *arguments: Any) -> Learned:
    """One of the examples, with the automaton of the file in the place of its formula."""
    main = runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]
    return Learned.of(main(*arguments, task=ltlc.load(FILE)))


def pettingzoo(episodes: int = 2_000) -> Learned:
    main = runpy.run_path(str(EXAMPLES / "wrap_pettingzoo.py"))["main"]
    found = probability(round(100 * main(episodes, task=ltlc.load(FILE))), 100)
    return Learned(found.value, found.low, found.high, False)


class Numbered(gym.ObservationWrapper[Any, Any, Any]):
    """MiniGrid's DoorKey, whose observation is the number of its state."""

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self.observation_space = gym.spaces.Discrete(5 * 5 * 4 * 2 * 3)

    def observation(self, observation: Any) -> int:
        """The number."""
        world = self.unwrapped
        door = next(cell for cell in world.grid.grid if cell is not None and cell.type == "door")
        (x, y), has_key = world.agent_pos, world.carrying is not None
        return int(((y * 5 + x) * 4 + world.agent_dir) * 6 + has_key * 3 + door.is_open + (not door.is_locked))


def robot(observation: Any, info: Any, env: Any) -> dict[str, bool]:
    """Whether the robot carries the key, has opened the door, and stands in a corner behind it."""
    world = env.unwrapped
    opened = any(cell is not None and cell.type == "door" and cell.is_open for cell in world.grid.grid)
    return {"key": world.carrying is not None, "goal": opened, "pit": tuple(world.agent_pos) == (3, 1)}


def minigrid(steps: int = 30_000) -> Learned:
    """The agent fitted-q of ltlc."""
    importlib.import_module("minigrid")
    from minigrid.wrappers import ReseedWrapper

    from ltlc.agents import FittedQConfig, train

    def make() -> Any:
        return TimeLimit(Numbered(ReseedWrapper(gym.make("MiniGrid-DoorKey-5x5-v0"), seeds=[0])), 100)

    envs = ltlc.LTLVectorWrapper(gym.vector.SyncVectorEnv([make] * 8), task(), robot, warn_discount=False)
    agent = train(envs, FittedQConfig(total_steps=steps)).agent
    return Learned.of(ltlc.judge(agent, make(), task(), labels=robot, episodes=100))


def atari(steps: int = 10_000) -> Learned:
    """Pong by its memory: to the bottom, then to the top, before a point is lost; DQN of Stable-Baselines3."""
    from stable_baselines3 import DQN

    from ltlc.bridges.stable_baselines3 import replay

    gym.register_envs(importlib.import_module("ale_py"))
    labels = {"key": lambda x: x[51] > 0.75, "goal": lambda x: x[51] < 0.2, "pit": lambda x: x[13] > 0}
    pong = gym.make("ALE/Pong-v5", obs_type="ram")
    space = gym.spaces.Box(0, 1, (128,), np.float32)
    ram = gym.wrappers.TransformObservation(pong, lambda x: x.astype(np.float32) / 255, space)
    env = TimeLimit(ltlc.LTLWrapper(ram, task(), labels, observation="flat", warn_discount=False), 100)
    model = DQN(
        "MlpPolicy", env, learning_rate=5e-4, learning_starts=500, train_freq=2, target_update_interval=200,
        exploration_fraction=0.5, batch_size=64, policy_kwargs={"net_arch": [64]}, seed=0, device="cpu",
        **replay(env, counterfactual=True),
    )  # fmt: skip
    return Learned.of(ltlc.judge(model.learn(steps), env, episodes=100))


@dataclass(frozen=True)
class Host:
    """A library, what it needs, and the least P(sat) that what it learns must have."""

    run: Callable[[], Learned]
    needs: tuple[str, ...] = ()
    least: float = 0.9


HOSTS = {
    "gymnasium": Host(gymnasium_loop),
    "dqn": Host(sb3_dqn, ("stable_baselines3",)),
    "ppo": Host(sb3_ppo, ("stable_baselines3",)),
    "sac": Host(sb3_sac, ("stable_baselines3",)),
    "maskable-ppo": Host(maskable_ppo, ("sb3_contrib",)),
    "maskable-ppo-vector": Host(lambda: maskable_ppo(copies=4), ("sb3_contrib",)),
    "rllib": Host(lambda: example("train_rllib"), ("ray", "ray.rllib")),
    "torchrl": Host(lambda: example("train_torchrl"), ("torchrl",)),
    "cleanrl-style": Host(lambda: example("train_cleanrl_style")),
    "pettingzoo": Host(pettingzoo, ("pettingzoo",)),
    "minigrid": Host(minigrid, ("minigrid",)),
    "atari": Host(atari, ("stable_baselines3", "ale_py")),
}


def missing(host: Host) -> str:
    """What is not installed; empty: nothing."""
    for name in host.needs:
        try:
            importlib.import_module(name)
        except ImportError:
            return name
    return ""


def main() -> None:
    import torch

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hosts", nargs="*", choices=[*HOSTS, []])
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    torch.set_num_threads(1)
    warnings.simplefilter("ignore")
    found: dict[str, Any] = {}
    for name in given.hosts or HOSTS:
        absent = missing(HOSTS[name])
        if absent:
            print(f"{name:20} {absent} is not installed", flush=True)
            continue
        since = time.monotonic()
        learned = HOSTS[name].run()
        seconds = time.monotonic() - since
        shown = "exact" if learned.exact else f"sampled, {learned.low:.3f} to {learned.high:.3f}"
        print(f"{name:20} P(sat) {learned.value:.4f} ({shown}) in {seconds:.0f} s", flush=True)
        found[name] = {**vars(learned), "seconds": round(seconds, 1)}
    if given.json is not None:
        given.json.write_text(json.dumps(found, indent=2) + "\n")
    sys.exit(any(found[name]["value"] < HOSTS[name].least for name in found))


if __name__ == "__main__":
    main()
