"""Checkpoints: runs that are killed, interrupted or out of disk go on unharmed; damage is recognised."""

import dataclasses
import errno
import os
import shutil
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from short_training import MAP, SHORT, TASK, assert_same, grid, rows

from ltlc.agents import (
    CHECKPOINT_FILE,
    POLICY_FILE,
    DoubleDQN,
    DQNConfig,
    Progress,
    TrainingResult,
    train,
)
from ltlc.envs import LTLVectorWrapper, VectorGridWorld
from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.task import Task


@pytest.fixture(scope="module")
def whole() -> TrainingResult:
    """A short run that nothing interrupts, without a folder."""
    return train(grid(), DQNConfig(**SHORT))


@pytest.fixture(scope="module")
def trained_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trained") / "run"
    train(grid(), DQNConfig(**SHORT | {"total_steps": 500}), folder=folder)
    return folder


@pytest.fixture
def short_run(trained_once: Path, tmp_path: Path) -> Path:
    """A copy that a test may damage."""
    return shutil.copytree(trained_once, tmp_path / "run")


class Killed(Exception):
    """Stands for a kill: nothing of the run gets a chance to clean up."""


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{}, {"optimizer": "sgd", "batch_norm": True, "counterfactual": False}])
def test_resumed_run_is_bit_identical(tmp_path: Path, changes: dict[str, Any]) -> None:
    config = DQNConfig(**SHORT | changes)
    whole = train(grid(), config, folder=tmp_path / "whole")
    alone = train(grid(), config)

    def kill(progress: Progress) -> None:
        if progress.row.steps >= 1_500:
            raise Killed

    with pytest.raises(Killed):
        train(grid(), config, folder=tmp_path / "parts", callback=kill)
    resumed = train(grid(), folder=tmp_path / "parts", resume=True)
    assert_same(whole.agent, resumed.agent)
    assert_same(whole.agent, alone.agent)
    assert rows(tmp_path / "whole") == rows(tmp_path / "parts")
    assert resumed.steps == whole.steps and not resumed.interrupted


@pytest.mark.slow
def test_what_is_left_open_is_as_in_the_run_to_resume(tmp_path: Path) -> None:
    config = DQNConfig(**SHORT | {"train_frequency": 5, "horizon": 50, "total_steps": 200})
    train(grid(), config, folder=tmp_path)
    left_open = dataclasses.replace(config, train_frequency=None, horizon=None)
    assert train(grid(), left_open, folder=tmp_path, resume=True).agent.config.horizon == 50
    with pytest.raises(InvalidArgumentError, match="the run to resume has horizon 50, not 60"):
        train(grid(), dataclasses.replace(left_open, horizon=60), folder=tmp_path, resume=True)


def test_resumed_run_of_another_kind_of_environment_is_bit_identical(tmp_path: Path) -> None:
    def lake() -> LTLVectorWrapper:
        env = gym.make_vec("FrozenLake-v1", num_envs=4, vectorization_mode="sync")
        labels = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}
        return LTLVectorWrapper(env, "F goal & G !hole", labels)

    config = DQNConfig(**SHORT)

    def kill(progress: Progress) -> None:
        if progress.row.steps >= 1_500:
            raise Killed

    whole = train(lake(), config)
    with pytest.raises(Killed):
        train(lake(), config, folder=tmp_path, callback=kill)
    assert_same(whole.agent, train(lake(), folder=tmp_path, resume=True).agent)


SCRIPT = """
    import os, signal, sys
    import ltlc.atomic
    from ltlc.agents import DQNConfig, train
    from ltlc.envs import LTLVectorWrapper, VectorGridWorld
    from ltlc.task import Task

    true_replace, writes = os.replace, []

    def replace(source, target):
        writes.append(target)
        if sum(str(target).endswith("checkpoint.ltlc") for target in writes) == 3:  # the first is of the beginning
            os.kill(os.getpid(), signal.SIGKILL)  # all is written under a temporary name, nothing is in place
        true_replace(source, target)

    os.replace = replace
    env = LTLVectorWrapper(VectorGridWorld("S.A", 4, max_episode_steps=20), Task("F A", reward="thesis"))
    config = DQNConfig(hidden=(8,), batch_size=8, buffer_size=500, learning_starts=0, total_steps=1_200,
                       checkpoint_every=400, log_every=200)
    train(env, config, folder=sys.argv[1])
"""


@pytest.mark.slow
def test_kill_during_a_checkpoint_leaves_the_previous_one(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(textwrap.dedent(SCRIPT))
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, str(script), str(tmp_path / "run")], env=environment, check=False)
    assert done.returncode == -signal.SIGKILL
    env = LTLVectorWrapper(VectorGridWorld("S.A", 4, max_episode_steps=20), Task("F A", reward="thesis"))
    seen: list[int] = []
    resumed = train(env, folder=tmp_path / "run", resume=True, callback=lambda p: seen.append(p.row.steps))
    assert 600 <= seen[0] < 604 and resumed.steps >= 1_200  # a row comes with the first step of 4 that is due
    assert_same(resumed.agent, train(env, resumed.agent.config).agent)


@pytest.mark.slow
def test_ctrl_c_stops_cleanly_and_can_be_resumed(tmp_path: Path, whole: TrainingResult) -> None:
    config = DQNConfig(**SHORT)

    def interrupt(progress: Progress) -> None:
        if 1_500 <= progress.row.steps < 1_600:
            signal.raise_signal(signal.SIGINT)

    first = train(grid(), config, folder=tmp_path, callback=interrupt)
    assert first.interrupted and 1_500 <= first.steps < 1_600
    assert f"interrupted; {first.saved_steps} are in" in str(first) and first.saved_steps <= first.steps
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    second = train(grid(), folder=tmp_path, resume=True)
    assert second.steps >= 2_500 and not second.interrupted
    assert_same(second.agent, whole.agent)
    assert "interrupted" not in str(second)
    assert "nothing was written" in str(TrainingResult(second.agent, 1, 9, 1.0, True))


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "other"])
def test_damaged_checkpoint_is_recognised(short_run: Path, damage: str) -> None:
    path = short_run / CHECKPOINT_FILE
    whole = path.read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    path.write_bytes({"cut": whole[:middle], "flip": flipped, "empty": b"", "other": b"PK\3\4 some archive\n"}[damage])
    with pytest.raises(FileFormatError, match=r"checkpoint\.ltlc: .*damaged"):
        train(grid(), folder=short_run, resume=True)


@pytest.mark.slow
def test_policy_is_no_checkpoint(short_run: Path) -> None:
    (short_run / CHECKPOINT_FILE).write_bytes((short_run / POLICY_FILE).read_bytes())
    with pytest.raises(FileFormatError, match="not a checkpoint file"):
        train(grid(), folder=short_run, resume=True)


@pytest.mark.slow
def test_checkpoint_of_something_else_is_refused(short_run: Path) -> None:
    with pytest.raises(InvalidArgumentError, match="holds a training run; pass resume=True"):
        train(grid(), folder=short_run)
    with pytest.raises(InvalidArgumentError, match="no checkpoint to resume from"):
        train(grid(), folder=short_run / "elsewhere", resume=True)
    with pytest.raises(InvalidArgumentError, match=r"batch_size 32, not 128.* resume with config=None"):
        train(grid(), DQNConfig(**SHORT | {"total_steps": 500, "batch_size": 128}), folder=short_run, resume=True)
    other = LTLVectorWrapper(VectorGridWorld(MAP, 4), Task("F A"), observation="none", extra_labels="ignore")
    with pytest.raises(InvalidArgumentError, match="other reward tables"):
        train(other, folder=short_run, resume=True)
    fewer = LTLVectorWrapper(VectorGridWorld(MAP, 2), TASK, observation="none")
    with pytest.raises(InvalidArgumentError, match="checkpoint is of 4 environments"):
        train(fewer, folder=short_run, resume=True)


@pytest.mark.slow
def test_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: TrainingResult) -> None:
    def fill_the_disk(progress: Progress) -> None:
        if progress.row.steps >= 1_500:
            monkeypatch.setattr("ltlc.agents.training.storage.atomic_write", full)

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    config = DQNConfig(**SHORT)
    with pytest.raises(OSError, match=r"cannot write the checkpoint .*No space left.* unharmed") as failure:
        train(grid(), config, folder=tmp_path, callback=fill_the_disk)
    assert failure.value.errno == errno.ENOSPC
    monkeypatch.undo()
    assert_same(train(grid(), folder=tmp_path, resume=True).agent, whole.agent)


@pytest.mark.slow
def test_metrics_are_plain_csv(short_run: Path) -> None:
    text = (short_run / "metrics.csv").read_text().splitlines()
    assert text[0] == (
        "steps,updates,episodes,episode_return,episode_length,violations,acceptances,loss,epsilon,learning_rate,"
        "value,product_states,accepting_components,satisfaction,discounted_return"
    )
    assert len(text) == 3
    row = rows(short_run)[-1]
    assert int(row["steps"]) >= 500 and float(row["loss"]) > 0


@pytest.mark.slow
def test_metrics_file_of_something_else_is_not_touched(short_run: Path) -> None:
    (short_run / "metrics.csv").write_text("shopping,list\n")
    with pytest.raises(FileFormatError, match="line 1 is not the header"):
        train(grid(), folder=short_run, resume=True)
    assert (short_run / "metrics.csv").read_text() == "shopping,list\n"


@pytest.mark.slow
def test_policy_comes_back_from_its_file(short_run: Path) -> None:
    agent = DoubleDQN.load(short_run / POLICY_FILE)
    trained = train(grid(), DQNConfig(**SHORT | {"total_steps": 500})).agent
    assert np.array_equal(agent.q_values(np.arange(9)), trained.q_values(np.arange(9)))
    assert agent.encoder.space == trained.encoder.space and agent.config == trained.config
    with pytest.raises(FileFormatError, match="not a policy file"):
        DoubleDQN.load(short_run / CHECKPOINT_FILE)


def test_policies_of_all_spaces_come_back(tmp_path: Path) -> None:
    parts = {"b": spaces.Box(0.0, 1.0, (2,)), "d": spaces.Discrete(3, start=1), "m": spaces.MultiBinary(2)}
    space = spaces.Dict({"one": spaces.Dict(parts), "two": spaces.Tuple([spaces.MultiDiscrete([2, 3])])})
    agent = DoubleDQN(space, 2, TASK.tables, DQNConfig(hidden=(4,)))
    agent.save(tmp_path / "policy.ltlc")
    again = DoubleDQN.load(tmp_path / "policy.ltlc")
    assert again.encoder.space == space
    assert_same(agent, again)
