"""A sweep on Ray comes out as one in processes, to the byte, also by Ray Tune and when it is killed.

Ray is seldom there: `make test-rllib` runs these tests in an environment of its own.
"""

from __future__ import annotations

import importlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ltlc.cli.app import run
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.sweeps import Grid, read_grid, run_grid, write_table

ray = pytest.importorskip("ray", reason="Ray is not installed; make test-rllib", exc_type=ImportError)
RayTasks = importlib.import_module("ltlc.sweeps.ray_engine").RayTasks

pytestmark = [pytest.mark.peer, pytest.mark.slow, pytest.mark.filterwarnings("ignore")]

LABELS = """
MAP = "SFFFFHFHFFFHHFFG"

def lake(state):
    return {"H": {"hole"}, "G": {"goal"}}.get(MAP[state], set())
"""
GRID = """
out = "OUT"
seeds = 2
steps = 3000
num_envs = 2
[formulas]
reach = "F goal & G !hole"
[environments]
lake = { env = "FrozenLake-v1", labels = "sensors.py:lake", episode_steps = 40 }
[rewards]
two-discount = { gamma = 0.99 }
[agents]
fitted-q = {}
table = { agent = "q-learning", epsilon_final = 0.2 }
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    Path("sensors.py").write_text(LABELS)
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    yield tmp_path
    ray.shutdown()


def grid_in(out: str, text: str = GRID) -> Grid:
    Path(f"{out}.toml").write_text(text.replace("OUT", out), encoding="utf-8")
    return read_grid(f"{out}.toml")


def files(grid: Grid) -> dict[str, bytes]:
    """Tables, and what each run has to say, but for times."""
    write_table(grid)
    names = ["table.csv", "runs.csv", "table.png"]
    names += [f"{cell.name}/{name}" for cell in grid.cells for name in ("metrics.csv", "result.json", "policy.ltlc")]
    return {name: (grid.folder / name).read_bytes() for name in names if (grid.folder / name).exists()}


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of a sweep in processes that was never cut."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("processes"))
        Path("sensors.py").write_text(LABELS)
        grid = grid_in("processes")
        assert run_grid(grid, processes=2) == {}
        found = files(grid)
    assert len(found) == 15
    return found


def test_the_same_table_as_in_processes(expected: dict[str, bytes]) -> None:
    found = grid_in("tasks")
    seen: list[int] = []
    assert run_grid(found, engine=RayTasks(2, "local"), report=lambda progress: seen.append(progress.done)) == {}
    assert seen == [1, 2, 3, 4]
    assert not ray.is_initialized()
    assert files(found) == expected


def test_a_failing_run_stops_no_other(capsys: pytest.CaptureFixture[str]) -> None:
    grid_in(
        "failing", GRID.replace("[environments]", 'wrong = "F nothing"\n[environments]').replace("2\nsteps", "1\nsteps")
    )
    assert run(["sweep", "failing.toml", "--engine", "ray", "-j", "2"]) == 1
    out, err = capsys.readouterr()
    assert "wrong-lake-two-discount-table-0 failed" in out
    assert "nothing" in err


def test_a_cluster_that_is_not_there() -> None:
    with pytest.raises(InvalidArgumentError, match="no cluster of Ray answers at 127"):
        run_grid(grid_in("nowhere"), engine=RayTasks(address="127.0.0.1:1"))
    with pytest.raises(InvalidArgumentError, match="workers is 0"):
        RayTasks(0)


def test_the_search_space_of_tune_gives_the_same_table(
    tmp_path: Path, expected: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The code of docs/runs.md."""
    pytest.importorskip("ray.tune", exc_type=ImportError)
    monkeypatch.setenv("HOME", str(tmp_path))  # where Tune writes
    grid = grid_in("grid")
    ray.init(address="local", num_cpus=2, include_dashboard=False, log_to_driver=False)
    text = (Path(__file__).parents[2] / "docs" / "runs.md").read_text(encoding="utf-8")
    (code,) = (block for block in re.findall(r"```python\n(.*?)```", text, re.S) if "ray_tune" in block)
    values: dict[str, Any] = {}
    exec(code.replace("num_samples=20", "num_samples=1"), values)
    assert files(grid) == expected  # runs with parameters that were searched stand beside the grid
    place = Path(values["best"].metrics["folder"])
    assert place.parent == tmp_path / "grid" and re.fullmatch(r"reach-lake-.*-0-[0-9a-f]{12}", place.name)
    assert len(values["found"]) == 2
    assert values["best"].metrics["exact"] is True


def test_configurations_of_tune_that_mean_nothing() -> None:
    from ltlc.sweeps.ray_tune import _cell

    grid = grid_in("tuned")
    axes: dict[str, Any] = {
        "formula": "reach", "environment": "lake", "reward": "two-discount", "agent": "table", "seed": 1
    }  # fmt: skip
    assert _cell(grid, axes) == grid.cells[3]
    other = _cell(grid, axes | {"hyper": {"epsilon_final": 0.5, "zeta": [1]}, "set": {"gamma": 0.5}})
    words = " ".join(other.arguments)
    assert words.count("epsilon_final") == 1 and "--hyper epsilon_final=0.5 --hyper zeta=[1] --set gamma=0.5" in words
    with pytest.raises(UnknownNameError, match="'hypers'"):
        _cell(grid, axes | {"hypers": {}})
    with pytest.raises(InvalidArgumentError, match="has no run"):
        _cell(grid, axes | {"seed": 7})


def alive(pattern: str) -> bool:
    return any(
        pattern in path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if path.exists()
    )


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="needs /proc")
def test_killed_and_resumed_is_the_same_to_the_byte(expected: dict[str, bytes]) -> None:
    cut = grid_in(f"cut-{os.getpid()}")
    words = [sys.executable, "-m", "ltlc", "sweep", f"{cut.folder}.toml", "--engine", "ray", "-j", "2"]
    child = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline and not any((cut.folder / c.name / "config.json").exists() for c in cut.cells):
        time.sleep(0.05)
    child.send_signal(signal.SIGKILL)
    child.wait()
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline and alive(f"--out {cut.folder}"):
        time.sleep(0.1)
    assert not alive(f"--out {cut.folder}")  # what it had started has ended with it
    assert run_grid(cut, engine=RayTasks(2, "local")) == {}
    assert files(cut) == expected
