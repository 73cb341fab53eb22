"""Short and quick training runs of the deep agent on a small grid, and whether two agents are the same."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import torch

from ltlc.agents import DoubleDQN
from ltlc.envs import LTLVectorWrapper, VectorGridWorld
from ltlc.task import Task

MAP = "S..\n.C.\nA.B"
TASK = Task("F(A & F B) & G !C", reward="thesis", on_deadlock="stay")
QUICK: dict[str, Any] = {
    "hidden": (32,), "batch_size": 256, "buffer_size": 20_000, "learning_starts": 256, "epsilon_steps": 2_000,
    "total_steps": 6_000, "log_every": 1_000, "checkpoint_every": 2_500, "learning_rate": 3e-3, "averaging": 0.02,
    "train_frequency": 4, "tau": 0.1,
}  # fmt: skip

SHORT: dict[str, Any] = {
    "hidden": (16,), "batch_size": 32, "buffer_size": 1_500, "learning_starts": 100, "epsilon_steps": 1_000,
    "total_steps": 2_500, "log_every": 250, "checkpoint_every": 1_000,
}  # fmt: skip
"""A run with two checkpoints before its end, and a buffer that overflows; it does not learn much."""


def grid(**options: Any) -> LTLVectorWrapper:
    env = VectorGridWorld(MAP, 4, slip=0.05, max_episode_steps=200)
    return LTLVectorWrapper(env, TASK, **({"observation": "none"} | options))


def weights(agent: DoubleDQN) -> dict[str, torch.Tensor]:
    parts = {"q": agent.q_network, "target": agent.target_network, "policy": agent.policy_network}
    found = {f"{name}.{key}": value for name, part in parts.items() for key, value in part.state_dict().items()}
    for i, slot in agent.optimizer.state_dict()["state"].items():
        found |= {f"optimizer.{i}.{key}": torch.as_tensor(value) for key, value in slot.items()}
    return found


def assert_same(one: DoubleDQN, other: DoubleDQN) -> None:
    mine, theirs = weights(one), weights(other)
    assert mine.keys() == theirs.keys()
    assert all(torch.equal(mine[name], theirs[name]) for name in mine)


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "metrics.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))
