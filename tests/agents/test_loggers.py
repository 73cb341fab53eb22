"""What docs/runs.md says of loggers: one line sends them the rows of metrics."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium as gym
import pytest

import ltlc
from ltlc.agents import FittedQConfig, train

PAGE = Path(__file__).parents[2] / "docs" / "runs.md"


@pytest.mark.slow
def test_the_callback_for_weights_and_biases(monkeypatch: pytest.MonkeyPatch) -> None:
    logged: list[tuple[dict[str, float], int]] = []

    class Run:
        def log(self, values: dict[str, float], step: int) -> None:
            logged.append((values, step))

    wandb: Any = ModuleType("wandb")
    wandb.init = lambda project: Run()
    monkeypatch.setitem(sys.modules, "wandb", wandb)
    (code,) = (
        block
        for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
        if "import wandb" in block
    )
    values: dict[str, Any] = {}
    exec(code, values)
    world = gym.make_vec("FrozenLake-v1", num_envs=4)
    envs = ltlc.LTLVectorWrapper(world, "F goal", {"goal": lambda state: state == 15})
    train(envs, FittedQConfig(total_steps=800, log_every=400), callback=values["log"])
    assert [step >= 400 for _, step in logged] == [True, True]
    assert {"steps", "episodes", "episode_return", "successes", "epsilon"} <= logged[-1][0].keys()
    assert None not in logged[-1][0].values()
