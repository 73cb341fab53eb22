"""What a training needs of memory is known, said, and checked before it is taken."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.agents import DQNConfig, train
from ltlc.agents.double_dqn.replay import ReplaySize
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.training import memory
from ltlc.agents.training.memory import check_memory, free_memory, size_text
from ltlc.agents.training.storage import read_file, write_file
from ltlc.cli.app import run
from ltlc.envs import LTLVectorWrapper
from ltlc.errors import MemoryLimitExceeded
from ltlc.task import Task

PICTURES = """
import gymnasium as gym
import numpy as np

class Pictures(gym.Env):
    observation_space = gym.spaces.Box(0, 255, (210, 160, 3), np.uint8)
    action_space = gym.spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros((210, 160, 3), np.uint8), {}

    def step(self, action):
        return np.full((210, 160, 3), 7, np.uint8), 0.0, False, False, {}

def labels(observation, info):
    return {"b"} if observation[0, 0, 0] else set()

gym.register("Pictures-v0", entry_point=Pictures)
"""
PONG = ("F b", "--env", "pictures:Pictures-v0", "--labels", "pictures:labels", "--episode-steps", "20")
TINY = (
    "--hyper",
    "hidden=2",
    "--hyper",
    "batch_size=2",
    "--hyper",
    "learning_starts=30",
    "--hyper",
    "train_frequency=9",
)


class Pixels(gym.Env[Any, int]):
    """Shows a picture and a number."""

    observation_space = spaces.Dict({"picture": spaces.Box(0, 255, (50, 40, 3), np.uint8), "place": spaces.Discrete(9)})
    action_space = spaces.Discrete(2)
    propositions = ("b",)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        return self.observation_space.sample(), {"labels": set()}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        return self.observation_space.sample(), 0.0, False, False, {"labels": {"b"}}


def pixels() -> LTLVectorWrapper:
    return LTLVectorWrapper(SyncVectorEnv([Pixels] * 2), Task("G F b"))


@pytest.mark.slow
def test_a_short_run_of_pictures_takes_what_it_needs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pictures.py").write_text(PICTURES)
    assert run(["train", *PONG, "--steps", "40", "--out", "here", *TINY]) == 0
    assert "Replay: the last 41 steps, 4.24 MB" in capsys.readouterr().out  # a picture of 100 800 bytes each
    assert Path("here/checkpoint.ltlc").stat().st_size < 15e6


@pytest.mark.slow
def test_too_much_is_refused_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pictures.py").write_text(PICTURES)
    assert run(["train", *PONG, "--steps", "300000", "--out", "here", *TINY, "--hyper", "max_memory=1.5"]) == 3
    error = capsys.readouterr().err
    assert "the replay of 300064 steps of 101 kB each, with its copy for a checkpoint, would take 60.5 GB" in error
    assert "1.5 GB are allowed (max_memory); lower buffer_size" in error
    assert not Path("here").exists()
    monkeypatch.setattr(memory, "free_memory", lambda device: 4_000_000_000)
    assert run(["train", *PONG, "--steps", "300000", "--out", "here", *TINY]) == 3
    assert "4.0 GB are free on cpu" in capsys.readouterr().err
    assert run(["train", *PONG, "--steps", "40", "--out", "here", *TINY, "-q"]) == 0


def test_large_images_take_four_gigabytes_unless_somebody_says_so() -> None:
    frames = ObservationEncoder(spaces.Box(0, 255, (84, 84, 4), np.uint8))
    size = ReplaySize.of(DQNConfig(), frames, 16)
    assert 3.9e9 < size.bytes < 4.001e9
    most = DQNConfig(max_memory=9.0, total_steps=2_000_000)
    assert ReplaySize.of(most, frames, 16).rows == most.buffer_size


@pytest.mark.slow
def test_in_python_likewise() -> None:
    config = DQNConfig(hidden=(2,), batch_size=2, total_steps=30, max_memory=0.00022)
    with pytest.raises(MemoryLimitExceeded, match=r"the replay of 32 steps of 6.05 kB each would take 206 kB"):
        train(pixels(), DQNConfig(**config.to_dict() | {"max_memory": 0.0002}))
    assert train(pixels(), config).steps == 30


def test_networks_are_checked_too() -> None:
    with pytest.raises(MemoryLimitExceeded, match=r"a network with layers of 100000000000 units .* make them smaller"):
        train(pixels(), DQNConfig(hidden=(10**11,), total_steps=30))


def test_free_memory_is_what_the_kernel_and_the_container_leave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "_CONTROL_GROUP", tmp_path)
    monkeypatch.setattr(memory, "_KERNEL", tmp_path / "meminfo")
    (tmp_path / "meminfo").write_text("MemTotal: 9000 kB\nMemAvailable:    5000 kB\n")
    assert free_memory("cpu") == 5_120_000
    (tmp_path / "memory.max").write_text("3000000\n")
    (tmp_path / "memory.current").write_text("2000000\n")
    (tmp_path / "memory.stat").write_text("anon 5\ninactive_file 500000\n")
    assert free_memory("cpu") == 1_500_000
    (tmp_path / "memory.max").write_text("max\n")
    assert free_memory("cpu") == 5_120_000
    (tmp_path / "meminfo").unlink()
    assert free_memory("cpu") is None or free_memory("cpu") > 0
    with pytest.raises(MemoryLimitExceeded, match="a cake would take 2 MB, and 1 MB are allowed"):
        check_memory("a cake", 2_000_000, "cpu", "eat less", 0.001)


def test_sizes_for_a_person() -> None:
    assert [size_text(size) for size in (12, 4_200, 8.27e6, 40.3e9, 67.2e12)] == [
        "12 bytes", "4.2 kB", "8.27 MB", "40.3 GB", "67,200.0 GB",
    ]  # fmt: skip


def test_a_file_is_put_together_once(tmp_path: Path) -> None:
    """The head with the checksum stands before what torch writes, and what is read is what was written."""
    path = write_file(tmp_path / "a", "checkpoint", {"x": torch.arange(5)})
    assert read_file(path, "checkpoint")["x"].value.tolist() == [0, 1, 2, 3, 4]
    head, _, payload = path.read_bytes().partition(b"\n")
    assert len(head.split()) == 4 and torch.load(io.BytesIO(payload), weights_only=True)["x"].sum() == 10
