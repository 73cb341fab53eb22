"""Deep agents on worlds that cannot be counted: ours, and those of Stable-Baselines3, with the same steps.

    python benchmarks/deep.py --list
    python benchmarks/deep.py flat --agents ltlc --seeds 3
    python benchmarks/deep.py cart car --steps 50000 --json deep.json --picture deep.svg

Ours is `ltlc train` with its defaults. DQN and PPO learn in the same wrapped environment, flat and with the automaton
state as one-hot numbers, in two settings each, of which the better one counts: +1 for each acceptance with a discount
of .98, and the same shaped by the distance to acceptance with .99.

A task is judged by episodes of the last policy: done once and for all (an accepting sink was reached), or, where it
recurs, accepted at least once without a violation and without leaving the world. Intervals are Wilson's, at 95 %.
`deep_tasks.toml` holds worlds and tasks.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import subprocess
import sys
import tempfile
import time
import tomllib
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ltlc import Task
from ltlc.agents.training.collect import Interface
from ltlc.agents.training.run_folder import RunFolder
from ltlc.envs import HeldActions, LTLVectorWrapper, LTLWrapper
from ltlc.envs.spec import EnvSpec
from ltlc.envs.success import accepted_forever
from ltlc.errors import UnknownNameError
from ltlc.mdp.estimate import probability

HERE = Path(__file__).parent
EPISODES, EVAL_ENVS, PPO_ENVS = 500, 100, 8
SETTINGS: dict[str, dict[str, float]] = {
    "plain": {"shaping": 0.0, "gamma": 0.98},
    "shaped": {"shaping": 1.0, "gamma": 0.99},
}
PEERS = ("dqn", "ppo")

Policy = Callable[[Any, Any], Any]
"""actions for a batch of observations of the world, and the table states."""


@dataclass(frozen=True)
class DeepTask:
    """A formula in a world.

    Attributes:
        name: of the task.
        world: its name.
        spec: the environment, its labels and the limit of its episodes.
        formula: the task.
        recurring: whether it is to be fulfilled again and again.
        steps: how long is learned.
        rival: published success and mean steps, or accepting visits.
    """

    name: str
    world: str
    spec: EnvSpec
    formula: str
    recurring: bool
    steps: int
    rival: tuple[float, ...]


@dataclass(frozen=True)
class Score:
    """What the last policy of a training does.

    Attributes:
        task: its name.
        agent: ltlc, dqn or ppo.
        setting: of a peer.
        seed: of the training.
        steps: of the training.
        seconds: of the training.
        episodes: that were judged.
        success: part of them.
        lower: end of the interval of success.
        upper: the other end.
        violations: part of the episodes with a violation, or that left the world undone.
        mean_steps: of the successful episodes, until done; of all, where the task recurs.
        visits: accepting steps in an episode.
    """

    task: str
    agent: str
    setting: str
    seed: int
    steps: int
    seconds: float
    episodes: int
    success: float
    lower: float
    upper: float
    violations: float
    mean_steps: float
    visits: float


def load_tasks() -> dict[str, DeepTask]:
    """The tasks by name."""
    document = tomllib.loads((HERE / "deep_tasks.toml").read_text(encoding="utf-8"))
    tasks = {}
    for name, entry in document["tasks"].items():
        world = document["worlds"][entry["world"]]
        spec = EnvSpec(env=world["env"], labels=world.get("labels"), max_episode_steps=world.get("episode_steps"))
        rival = tuple(entry.get("rival", ()))
        recurring = entry.get("recurring", False)
        steps = entry.get("steps", world["steps"])
        tasks[name] = DeepTask(name, entry["world"], spec, entry["formula"], recurring, steps, rival)
    return tasks


def evaluate(
    policy: Policy, env: LTLVectorWrapper, recurring: bool, episodes: int, seed: int, action_repeat: int = 1
) -> dict[str, float]:
    """Judge a policy by the first episodes of each copy, the same number of each."""
    n, interface, sinks = env.num_envs, Interface.of(env), env.task.automaton.accepting_sinks
    kept = accepted_forever(env.task.automaton)
    quota, held = -(-episodes // n), HeldActions(action_repeat, interface.n_actions)
    observations, infos = env.reset(seed=seed)
    length, visits, done_at = (np.zeros(n, dtype=np.int64) for _ in range(3))
    violated, counted = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64)
    rows: list[tuple[bool, bool, int, int]] = []
    while (counted < quota).any():
        chosen = policy(interface.base(observations), infos["ltl"]["state"])
        actions = held.keep(chosen, held.deciding(n))
        observations, _, terminated, truncated, infos = env.step(actions)
        ltl = infos["ltl"]
        valid = ltl["valid"]
        held.advance(np.flatnonzero(valid), (terminated | truncated)[valid])
        length = np.where(valid, length + 1, 0)
        visits = np.where(valid, visits + ltl["accepting"], 0)
        violated = np.where(valid, violated | ltl["violated"], False)
        done = np.isin(env.automaton_state, sinks)
        done_at = np.where(valid, np.where((done_at == 0) & done & ~violated, length, done_at), 0)
        # What the world ends is over: its last letter is repeated for ever.
        ended = valid & ltl["base_terminated"] & (done_at == 0)
        holds = ended & ~violated & kept[env.automaton_state, ltl["letter_class"]]
        done_at[holds] = length[holds]
        violated |= ended & ~holds
        for i in np.flatnonzero(valid & (terminated | truncated) & (counted < quota)):
            good = visits[i] > 0 and not violated[i] if recurring else done_at[i] > 0
            rows.append((bool(good), bool(violated[i]), int(length[i] if recurring else done_at[i]), int(visits[i])))
            counted[i] += 1
    good, bad, steps, accepted = (np.array(column) for column in zip(*rows, strict=True))
    known = probability(int(good.sum()), len(rows))
    walked = steps if recurring else steps[good]
    return {
        "episodes": len(rows), "success": known.value, "lower": known.low, "upper": known.high,
        "violations": float(bad.mean()), "mean_steps": float(walked.mean()) if len(walked) else float("nan"),
        "visits": float(accepted.mean()),
    }  # fmt: skip


def our_policy(agent: Any) -> Policy:
    """What one of our agents does."""
    return lambda seen, states: agent.packed_policy(agent.encoder.pack(seen), states)


def train_ours(task: DeepTask, seed: int, steps: int, episodes: int) -> Score:
    """Train as the command line does with nothing said, and judge."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "run"
        command = [sys.executable, "-m", "ltlc", "train", task.formula, "--env", task.spec.env, "--quiet", "--force"]
        command += ["--steps", str(steps), "--seed", str(seed), "--out", str(place)]
        command += ["--labels", task.spec.labels] * (task.spec.labels is not None)
        command += ["--episode-steps", str(task.spec.episode_steps)]
        subprocess.run(command, check=True, cwd=HERE)
        seconds = float((place / "times.csv").read_text().split()[-1].split(",")[1])
        run = RunFolder.open(place)
        agent = run.load()
        with contextlib.closing(run), contextlib.closing(task.spec.vector(run.task, EVAL_ENVS)) as env:
            found: dict[str, Any] = evaluate(
                our_policy(agent), env, task.recurring, episodes, seed + 1, agent.action_repeat
            )
    return Score(task.name, "ltlc", "default", seed, steps, seconds, **found)


def peer_goal(task: DeepTask, setting: str) -> Task:
    """The task as an agent of Stable-Baselines3 is rewarded for it."""
    return Task(task.formula, "accept", shaping=SETTINGS[setting]["shaping"], on_deadlock="terminate")


def peer_model(task: DeepTask, kind: str, setting: str, seed: int) -> Any:
    """An agent of Stable-Baselines3 that has learned nothing yet, in the wrapped environment."""
    import gymnasium as gym
    import stable_baselines3 as sb3
    from stable_baselines3.common.vec_env import DummyVecEnv

    goal = peer_goal(task, setting)

    def make() -> gym.Env[Any, Any]:
        module, _, name = task.spec.env.rpartition(":")
        if module:
            __import__(module)
        base = gym.make(name, max_episode_steps=task.spec.episode_steps)
        labelled = LTLWrapper(base, goal, task.spec.label_source, observation="dict", extra_labels="ignore")
        return gym.wrappers.FlattenObservation(labelled)

    common: dict[str, Any] = {"gamma": SETTINGS[setting]["gamma"], "seed": seed, "device": "cpu"}
    common["policy_kwargs"] = {"net_arch": [256, 256]}
    if kind == "ppo":
        return sb3.PPO("MlpPolicy", DummyVecEnv([make] * PPO_ENVS), n_steps=512, batch_size=256, **common)
    return sb3.DQN("MlpPolicy", DummyVecEnv([make]), learning_rate=5e-4, exploration_fraction=0.3, **common)


def peer_policy(model: Any, goal: Task) -> Policy:
    """What an agent of Stable-Baselines3 does, flat as it has learned."""
    n_states = goal.tables.n_states

    def policy(seen: Any, states: Any) -> Any:
        one_hot = np.eye(n_states, dtype=np.float32)[np.asarray(states)]
        flat = np.asarray(seen, dtype=np.float32).reshape(len(one_hot), -1)
        return model.predict(np.concatenate([one_hot, flat], axis=1), deterministic=True)[0]  # in order of their keys

    return policy


def train_peer(task: DeepTask, kind: str, setting: str, seed: int, steps: int, episodes: int) -> Score:
    """Train an agent of Stable-Baselines3, and judge."""
    goal, model = peer_goal(task, setting), peer_model(task, kind, setting, seed)
    since = time.perf_counter()
    model.learn(steps)
    seconds = time.perf_counter() - since
    with contextlib.closing(task.spec.vector(goal, EVAL_ENVS)) as env:
        found: dict[str, Any] = evaluate(peer_policy(model, goal), env, task.recurring, episodes, seed + 1)
    return Score(task.name, kind, setting, seed, steps, seconds, **found)


def best_settings(scores: Sequence[Score]) -> list[Score]:
    """Of each agent and task, the seeds of the setting with the larger success, then with more visits."""
    groups: dict[tuple[str, str], dict[str, list[Score]]] = {}
    for score in scores:
        groups.setdefault((score.task, score.agent), {}).setdefault(score.setting, []).append(score)
    chosen = []
    for settings in groups.values():
        chosen += max(settings.values(), key=lambda runs: (sum(r.success for r in runs), sum(r.visits for r in runs)))
    return chosen


def draw(scores: Sequence[Score], path: Path) -> None:
    """Draw the success of each agent on each task with its interval, a dot for each seed."""
    from ltlc.pictures.plotting import FAINT, INK, LINES, blank, saved, style_axes

    names = list(dict.fromkeys(score.task for score in scores))
    agents = list(dict.fromkeys(score.agent for score in scores))
    figure = blank(7.0, 1.1 + 0.42 * len(names), layout="constrained")
    axes = figure.add_subplot()
    style_axes(axes, grid="x")
    for k, agent in enumerate(agents):
        mine = [score for score in scores if score.agent == agent]
        y = np.array([names.index(s.task) + 0.22 * (k - (len(agents) - 1) / 2) + 0.05 * s.seed for s in mine])
        x = np.array([s.success for s in mine])
        reach = np.array([[s.success - s.lower for s in mine], [s.upper - s.success for s in mine]]).clip(0)
        axes.errorbar(x, y, xerr=reach, fmt="o", color=LINES[k], markersize=4.5, linewidth=1.2, label=agent)
    axes.set_yticks(range(len(names)), names)
    axes.set(xlim=(-0.02, 1.02), ylim=(len(names) - 0.5, -0.5))
    axes.set_xlabel("success of the last policy, with 95 % intervals", color=INK, fontsize=9)
    axes.legend(frameon=False, fontsize=8.5, labelcolor=FAINT, loc="lower left", bbox_to_anchor=(0, 1), ncols=3)
    saved(figure, path)


def line(score: Score) -> str:
    """One row of the table."""
    cells = [f"{score.task:10}", f"{score.agent:5}", f"{score.setting:8}", f"{score.seed:2}", f"{score.success:.3f}"]
    cells += [f"[{score.lower:.3f}, {score.upper:.3f}]", f"{score.violations:.3f}", f"{score.mean_steps:7.2f}"]
    return "  ".join([*cells, f"{score.visits:7.2f}", f"{score.seconds:7.1f}"])


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, judge, print, and write JSON and a picture if asked to."""
    tasks = load_tasks()
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names of tasks, or of worlds; default all")
    parser.add_argument("--agents", nargs="+", choices=("ltlc", *PEERS), default=["ltlc", *PEERS])
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="seeds 0 to N-1; default 1")
    parser.add_argument("--steps", type=int, metavar="N", help="of each training; default those of the world")
    parser.add_argument("--episodes", type=int, default=EPISODES, metavar="N", help=f"to judge by; default {EPISODES}")
    parser.add_argument("--list", action="store_true", help="say which tasks there are, and end")
    parser.add_argument("--json", metavar="FILE", help="write all scores as JSON")
    parser.add_argument("--picture", metavar="FILE", help="draw the best settings' success")
    options = parser.parse_args(arguments)
    known = {*tasks, *(task.world for task in tasks.values())}
    for name in options.tasks:
        if name not in known:
            parser.error(str(UnknownNameError("task", name, sorted(known))))
    wanted = [task for task in tasks.values() if not options.tasks or {task.name, task.world} & {*options.tasks}]
    if options.list:
        print("\n".join(f"{task.name:10}  {task.steps:8}  {task.formula}" for task in wanted))
        return
    if find_spec("minigrid") is None:
        skipped = [task.name for task in wanted if task.world in ("lava", "key")]
        wanted = [task for task in wanted if task.name not in skipped]
        if skipped:
            print(f"without {', '.join(skipped)}: minigrid is not installed", file=sys.stderr)
    warnings.simplefilter("ignore")
    print("task, agent, setting, seed, success, its interval, violations, mean steps, visits, seconds")
    scores: list[Score] = []
    for task in wanted:
        steps = options.steps or task.steps
        for seed in range(options.seeds):
            for agent in options.agents:
                for setting in ["default"] if agent == "ltlc" else SETTINGS:
                    if agent == "ltlc":
                        scores.append(train_ours(task, seed, steps, options.episodes))
                    else:
                        scores.append(train_peer(task, agent, setting, seed, steps, options.episodes))
                    print(line(scores[-1]), flush=True)
        if options.json:
            Path(options.json).write_text(json.dumps([asdict(s) for s in scores], indent=1) + "\n", encoding="utf-8")
    if options.picture:
        draw(best_settings(scores), Path(options.picture))


if __name__ == "__main__":
    main()
