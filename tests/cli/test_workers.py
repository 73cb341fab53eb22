"""Training with environments in processes of their own, from the command line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

MINE = """
import time
def labels(observation):
    return {"goal": observation == 15, "hole": observation in (5, 7, 11, 12)}
def wrong(observation):
    return {"goal"} if observation < 4 else observation / 0
def slow(observation):
    time.sleep(0.001)
    return labels(observation)
"""
LAKE = ["F goal & G !hole", "--env", "FrozenLake-v1", "--steps", "1500", "--episode-steps", "20", "--num-envs", "5"]


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    (tmp_path / "mine.py").write_text(MINE)
    return tmp_path


def command(folder: Path, *words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "ltlc", "train", *LAKE, *words],
        cwd=folder, start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


@pytest.mark.slow
def test_training_with_processes_ends_in_the_same_bytes(mine: Path) -> None:
    for n in (0, 2):
        with command(mine, "--labels", "mine:labels", "--workers", str(n), "--out", f"run{n}", "--quiet") as process:
            assert process.wait(timeout=120) == 0, process.stderr.read()
    for name in ("policy.ltlc", "checkpoint.ltlc", "metrics.csv", "result.json"):
        assert (mine / "run0" / name).read_bytes() == (mine / "run2" / name).read_bytes(), name


@pytest.mark.slow
def test_labels_that_fail_in_a_process_are_named(mine: Path) -> None:
    with command(mine, "--labels", "mine:wrong", "--workers", "2", "--agent", "double-dqn") as process:
        assert process.wait(timeout=120) == 2
        error = process.stderr.read()
    assert "wrong fails in" in error and "ZeroDivisionError" in error and "Traceback" not in error


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_ctrl_c_leaves_no_processes(mine: Path) -> None:
    with command(mine, "--labels", "mine:slow", "--workers", "2", "--steps", "1000000") as process:
        for line in process.stdout:
            if " steps " in line:
                break
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        assert len(children) == 2
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(timeout=60) == 130, process.stderr.read()
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline and any(Path(f"/proc/{child}").exists() for child in children):
        time.sleep(0.1)
    assert not any(Path(f"/proc/{child}").exists() for child in children)
