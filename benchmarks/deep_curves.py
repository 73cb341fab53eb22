"""What agents have learned after how many steps: success of the policies on the way, as a picture.

    python benchmarks/deep_curves.py flat-2 --steps 100000 --picture docs/deep-curves.svg
    python benchmarks/deep_curves.py flat-2 flat-5 --agents ltlc ppo --seeds 3 --json curves.json

Agents, tasks and settings are those of `deep.py`. Ten times in a training the policy so far is judged by 100 episodes,
in an environment of its own; of DQN and PPO the setting counts whose last policies succeed more often.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from deep import (
    EVAL_ENVS,
    PEERS,
    SETTINGS,
    DeepTask,
    Policy,
    evaluate,
    load_tasks,
    our_policy,
    peer_goal,
    peer_model,
    peer_policy,
)
from stable_baselines3.common.callbacks import BaseCallback

from ltlc import Task
from ltlc.agents import DQNConfig, Progress, train
from ltlc.agents.training.run_config import num_envs_for

POINTS, EPISODES = 10, 100
TITLES = {"ltlc": "ltlc double-dqn", "dqn": "Stable-Baselines3 DQN", "ppo": "Stable-Baselines3 PPO"}


@dataclass(frozen=True)
class Curve:
    """Success of the policies of one training.

    Attributes:
        task: its name.
        agent: ltlc, dqn or ppo.
        setting: of a peer.
        seed: of the training.
        steps: after which the policy was judged.
        success: part of the episodes, each in [0, 1].
    """

    task: str
    agent: str
    setting: str
    seed: int
    steps: tuple[int, ...]
    success: tuple[float, ...]


def our_curve(task: DeepTask, seed: int, total: int) -> Curve:
    """Train with the defaults of `ltlc train`, and judge on the way."""
    goal, seen = Task(task.formula), []

    def judge(progress: Progress) -> bool:
        if progress.row.steps >= (len(seen) + 1) * total / POINTS:
            seen.append(
                (
                    progress.row.steps,
                    success(task, goal, our_policy(progress.agent), seed, progress.agent.action_repeat),
                )
            )
        return False

    with contextlib.closing(task.spec.vector(goal, num_envs_for(total, task.spec.episode_steps))) as env:
        config = DQNConfig(total_steps=total, seed=seed, log_every=max(total // (2 * POINTS), env.num_envs))
        train(env, config, callback=judge)
    return Curve(task.name, "ltlc", "default", seed, *zip(*seen, strict=True))


def peer_curve(task: DeepTask, kind: str, setting: str, seed: int, total: int) -> Curve:
    """Train an agent of Stable-Baselines3, and judge on the way."""
    goal, model, seen = peer_goal(task, setting), peer_model(task, kind, setting, seed), []

    class Judge(BaseCallback):
        def _on_step(self) -> bool:
            if self.num_timesteps >= (len(seen) + 1) * total / POINTS:
                seen.append((self.num_timesteps, success(task, goal, peer_policy(model, goal), seed)))
            return True

    model.learn(total, callback=Judge())
    return Curve(task.name, kind, setting, seed, *zip(*seen, strict=True))


def success(task: DeepTask, goal: Task, policy: Policy, seed: int, action_repeat: int = 1) -> float:
    """Part of the episodes in which a policy succeeds."""
    with contextlib.closing(task.spec.vector(goal, EVAL_ENVS)) as env:
        return evaluate(policy, env, task.recurring, EPISODES, seed + 1, action_repeat)["success"]


def best_settings(curves: Sequence[Curve]) -> list[Curve]:
    """Of each agent and task, the curves of the setting whose policies succeed more often, last and on the way."""
    groups: dict[tuple[str, str], dict[str, list[Curve]]] = {}
    for curve in curves:
        groups.setdefault((curve.task, curve.agent), {}).setdefault(curve.setting, []).append(curve)
    return [curve for settings in groups.values() for curve in max(settings.values(), key=_worth)]


def _worth(runs: Sequence[Curve]) -> tuple[float, float]:
    return sum(run.success[-1] for run in runs), sum(sum(run.success) for run in runs)


def draw(curves: Sequence[Curve], path: Path) -> None:
    """Draw a panel for each task, a line for each seed, a colour for each agent."""
    from ltlc.pictures.plotting import FAINT, INK, LINES, blank, saved, style_axes

    names = list(dict.fromkeys(curve.task for curve in curves))
    agents = list(dict.fromkeys(curve.agent for curve in curves))
    formulas = {name: task.formula for name, task in load_tasks().items()}
    figure = blank(7.0, 0.6 + 2.2 * len(names), layout="constrained")
    for k, name in enumerate(names):
        axes = figure.add_subplot(len(names), 1, k + 1)
        style_axes(axes, grid="y")
        for curve in (curve for curve in curves if curve.task == name):
            label = TITLES[curve.agent] if curve.seed == min(c.seed for c in curves) else None
            colour = LINES[agents.index(curve.agent)]
            axes.plot((0, *curve.steps), (0.0, *curve.success), color=colour, linewidth=1.8, label=label)
        axes.set_title(formulas[name], loc="left", fontsize=9, color=INK)
        axes.set(xlim=(0, None), ylim=(-0.03, 1.03))
        axes.set_ylabel("success", color=INK, fontsize=9)
        axes.xaxis.set_major_formatter(lambda x, _: f"{x:,.0f}".replace(",", " "))
        if k == 0:
            axes.legend(frameon=False, fontsize=8.5, labelcolor=FAINT, loc="center right")
    axes.set_xlabel("environment steps", color=INK, fontsize=9)
    saved(figure, path)


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, judge, print, and write JSON and a picture if asked to."""
    tasks = load_tasks()
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("tasks", nargs="+", metavar="TASK", choices=tasks, help="names of tasks")
    parser.add_argument("--agents", nargs="+", choices=("ltlc", *PEERS), default=["ltlc", *PEERS])
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="seeds 0 to N-1; default 1")
    parser.add_argument("--steps", type=int, default=100_000, metavar="N", help="of each training; default 100 000")
    parser.add_argument("--json", metavar="FILE", help="write the curves as JSON")
    parser.add_argument("--picture", metavar="FILE", help="draw the best settings' curves")
    options = parser.parse_args(arguments)
    warnings.simplefilter("ignore")
    curves: list[Curve] = []
    for name in options.tasks:
        for seed in range(options.seeds):
            for agent in options.agents:
                for setting in ["default"] if agent == "ltlc" else SETTINGS:
                    if agent == "ltlc":
                        curves.append(our_curve(tasks[name], seed, options.steps))
                    else:
                        curves.append(peer_curve(tasks[name], agent, setting, seed, options.steps))
                    print(name, agent, setting, seed, *(f"{part:.2f}" for part in curves[-1].success), flush=True)
    if options.json:
        Path(options.json).write_text(
            json.dumps([asdict(curve) for curve in curves], indent=1) + "\n", encoding="utf-8"
        )
    if options.picture:
        draw(best_settings(curves), Path(options.picture))


if __name__ == "__main__":
    main()
