"""Environments in processes of their own are the same environments, to the last bit."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from vector_rollouts import TASKS, N, run

from ltlc.envs import LTLVectorWrapper
from ltlc.envs.spec import EnvSpec
from ltlc.envs.workers import WorkerVectorEnv
from ltlc.errors import InvalidArgumentError, WorkerLost
from ltlc.task import Task


class Sometimes(RandomEnv):
    """Has entries in some of its infos only."""

    def _see(self) -> tuple[Any, dict[str, Any]]:
        observation, info = super()._see()
        more = {"more": np.arange(3), "text": "x", "deep": {"z": 0.5}} if info["coin"] == 3 else {}
        return observation, info | more


def several(make: type[RandomEnv], kind: str, n: int) -> SyncVectorEnv:
    return SyncVectorEnv([partial(make, kind)] * n)


@pytest.mark.parametrize("workers", [1, 2, 9])
@pytest.mark.parametrize("kind", ["discrete", "dict"])
@pytest.mark.slow
def test_processes_step_as_one_does(kind: str, workers: int) -> None:
    for task in TASKS:
        one = LTLVectorWrapper(several(Sometimes, kind, N), task())
        many = LTLVectorWrapper(WorkerVectorEnv(partial(several, Sometimes, kind), N, workers), task())
        assert run(one, many, 60, AutoresetMode.NEXT_STEP)["begun"] > 3
        many.close()
        assert not any(process.is_alive() for process in many.unwrapped.processes)


def test_some_sub_environments_are_reset() -> None:
    envs = [several(Sometimes, "box", N), WorkerVectorEnv(partial(several, Sometimes, "box"), N, 3)]
    mask = np.arange(N) == 1
    seen = []
    for env in envs:
        env.reset(seed=[3, None, 5, 6, 7])
        env.step(np.zeros(N, dtype=np.int64))
        seen.append(env.reset(seed=4, options={"reset_mask": mask})[0].tolist())
        seen.append(env.step(np.zeros(N, dtype=np.int64))[1].tolist())
        env.close()
    assert seen[:2] == seen[2:]


class Fails(RandomEnv):
    def step(self, action: Any) -> Any:
        if action:
            raise ZeroDivisionError("of its own")
        return super().step(action)


def test_what_goes_wrong_is_told() -> None:
    env = WorkerVectorEnv(partial(several, Fails, "discrete"), 4, 2)
    env.reset(seed=0)
    with pytest.raises(ZeroDivisionError, match="of its own") as raised:
        env.step(np.array([0, 0, 0, 1]))
    assert any("in step" in note for note in raised.value.__notes__)
    env.processes[1].kill()
    with pytest.raises(WorkerLost, match=r"has ended with exit code -9"):
        for _ in range(2):
            env.step(np.zeros(4, dtype=np.int64))
    env.close()
    with pytest.raises(InvalidArgumentError, match="workers is -1"):
        EnvSpec(env="ltlc/Grid-v0").vector(Task("F goal"), 2, workers=-1)
