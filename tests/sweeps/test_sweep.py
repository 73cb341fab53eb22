"""A sweep runs what its file says, whatever happens meanwhile, and its table says what the runs have learned."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ltlc.cli.app import run
from ltlc.errors import FileFormatError, InvalidArgumentError, LtlcError, UnknownNameError
from ltlc.sweeps import Cell, read_grid, run_grid, table_of, write_table
from ltlc.sweeps import engine as engine_module

LABELS = """
MAP = "SFFFFHFHFFFHHFFG"

def lake(state):
    return {"H": {"hole"}, "G": {"goal"}}.get(MAP[state], set())
"""
GRID = """
seeds = [0, 3]
steps = 400
num_envs = 2
[formulas]
reach = "F goal & G !hole"
[environments]
lake = { env = "FrozenLake-v1", labels = "sensors.py:lake", arguments = { is_slippery = false }, episode_steps = 40 }
[rewards]
two-discount = { gamma = 0.99 }
[agents]
fitted-q = {}
table = { agent = "q-learning", epsilon_final = 0.2 }
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("sensors.py").write_text(LABELS)
    return tmp_path


def written(text: str = GRID, name: str = "grid.toml") -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


def test_a_file_is_read() -> None:
    grid = read_grid(written())
    assert grid.folder == Path("sweeps/grid")
    assert [cell.name for cell in grid.cells] == [
        f"reach-lake-two-discount-{agent}-{seed}" for agent in ("fitted-q", "table") for seed in (0, 3)
    ]
    assert grid.cells[3].arguments == (
        "F goal & G !hole", "--env", "FrozenLake-v1", "--labels", "sensors.py:lake", "--episode-steps", "40",
        "--env-set", "is_slippery=false", "--reward", "two-discount", "--set", "gamma=0.99",
        "--agent", "q-learning", "--hyper", "epsilon_final=0.2", "--steps", "400", "--num-envs", "2", "--seed", "3",
    )  # fmt: skip


def test_what_is_not_said_is_left_to_the_command() -> None:
    text = 'out = "here"\n[formulas]\nf = "F a"\n[environments]\ng = "ltlc/Grid-v0"\n'
    grid = read_grid(written(text))
    assert (grid.folder, len(grid.cells)) == (Path("here"), 1)
    assert grid.cells[0].arguments == ("F a", "--env", "ltlc/Grid-v0", "--agent", "auto", "--seed", "0")
    assert grid.cells[0].name == "f-g-default-auto-0"


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (("seeds = [0, 3]", "seeds = 0"), InvalidArgumentError, "seeds is 0; it must be a whole number, at least 1"),
        (("steps = 400", "steps = true"), InvalidArgumentError, "steps is True"),
        (("steps = 400", "stepz = 400"), UnknownNameError, "'stepz'. Did you mean steps"),
        (("[formulas]", "[formulae]"), UnknownNameError, "formulae"),
        (("episode_steps", "episodes"), UnknownNameError, "'episodes'"),
        (("reach = ", "'a/b' = "), InvalidArgumentError, "'a/b' must be of letters"),
        (('reach = "F goal & G !hole"', ""), FileFormatError, "no formulas"),
        (("seeds", "seeds = = 3"), FileFormatError, "is no TOML"),
        (("fitted-q = {}", "fitted-q = 3"), InvalidArgumentError, "must be a table"),
        (("epsilon_final", "agent-x = 1\n[agents.more"), FileFormatError, "is no TOML"),
        (("[0, 3]", "[0, 0]"), FileFormatError, "two runs would be in the folder"),
    ],
)
def test_wrong_files_are_told(change: tuple[str, str], kind: type[LtlcError], message: str) -> None:
    with pytest.raises(kind, match=message):
        read_grid(written(GRID.replace(*change, 1)))


def fake(values: dict[str, Any]) -> None:
    """Verdicts of runs, as if they had been trained."""
    for name, value in values.items():
        place = Path("sweeps/grid") / name
        place.mkdir(parents=True)
        (place / "result.json").write_text(json.dumps(value))


def exact(value: float) -> dict[str, Any]:
    learned = {"satisfaction": value, "discounted_return": value / 2}
    return {"exact": True, "learned": learned, "maximum_satisfaction": [0.8, 0.8, 0.8], "steps": 400}


@pytest.mark.slow
def test_the_table_says_what_verdicts_say() -> None:
    grid = read_grid(written(GRID.replace("[0, 3]", "4")))
    sampled = {"accepted_without_violation": {"value": 0.25}, "total_return": {"value": 7.0}}
    names = "reach-lake-two-discount-"
    fake({f"{names}fitted-q-{seed}": exact(value) for seed, value in enumerate((0.5, 0.75, 0.25, 0.5))})
    fake({f"{names}table-0": {"exact": False, "learned": sampled, "steps": 400}, f"{names}table-1": {"learned": None}})
    first, second = table_of(grid)
    assert (first.values, first.seeds, first.exact, first.maximum) == ((0.5, 0.75, 0.25, 0.5), 4, True, 0.8)
    assert first.mean is not None and first.mean.value == 0.5 and 0.25 <= first.mean.low < 0.5 < first.mean.high <= 0.75
    assert (second.values, second.seeds, second.exact, second.maximum, second.mean) == ((0.25,), 4, False, None, None)
    paths = write_table(grid)
    assert [path.name for path in paths] == ["table.csv", "runs.csv", "table.png"]
    rows = list(csv.DictReader(paths[0].read_text().splitlines()))
    assert [row["mean"] for row in rows] == ["0.5", "0.25"]
    runs = list(csv.DictReader(paths[1].read_text().splitlines()))
    assert (runs[1]["value"], runs[1]["return"], runs[4]["return"], runs[7]["value"]) == ("0.75", "0.375", "7.0", "")
    assert paths[2].read_bytes().startswith(b"\x89PNG")


def test_runs_that_are_there_are_not_run_again(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = read_grid(written())
    fake({cell.name: exact(0.5) for cell in grid.cells})
    monkeypatch.setattr(engine_module.subprocess, "Popen", None)
    seen: list[int] = []
    assert run_grid(grid, report=lambda progress: seen.append(progress.done)) == {}
    assert seen == [1, 2, 3, 4]


def test_an_engine_of_ones_own_carries_out_what_is_missing() -> None:
    grid = read_grid(written())
    first, *others = grid.cells
    fake({first.name: exact(0.5)})
    asked: list[str] = []

    class Backwards:
        def run(self, folder: Path, cells: Sequence[Cell]) -> Generator[tuple[Cell, str], None, None]:
            for cell in reversed(cells):
                asked.append(cell.name)
                yield cell, "no" if cell == others[0] else ""

    told: list[tuple[int, str]] = []
    failed = run_grid(grid, engine=Backwards(), report=lambda one: told.append((one.done, one.cell.name)))
    assert failed == {others[0].name: "no"}
    assert asked == [cell.name for cell in reversed(others)]
    assert told == list(enumerate([first.name, *asked], start=1))
    with pytest.raises(InvalidArgumentError, match="processes is 0"):
        run_grid(grid, processes=0)


def test_without_ray_it_is_asked_for(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.delitem(sys.modules, "ltlc.sweeps.ray_engine", raising=False)
    assert run(["sweep", written(), "--engine", "ray"]) == 2
    assert "pip install ray, or pip install 'ltlc[ray]'" in " ".join(capsys.readouterr().err.split())


def test_another_sweep_in_the_folder_is_refused() -> None:
    grid = read_grid(written())
    fake({cell.name: exact(0.5) for cell in grid.cells})
    run_grid(grid)
    with pytest.raises(InvalidArgumentError, match="holds another sweep, in which reach-lake"):
        run_grid(read_grid(written(GRID.replace("steps = 400", "steps = 500"))))
    more = read_grid(written(GRID.replace("[0, 3]", "[3, 0]")))
    assert run_grid(more) == {}
    Path("sweeps/grid/sweep.json").write_text("[]")
    with pytest.raises(FileFormatError, match="is not the plan of a sweep"):
        run_grid(grid)


def test_damaged_verdicts_are_told() -> None:
    grid = read_grid(written())
    fake({grid.cells[0].name: {"learned": {"something": 1}}})
    with pytest.raises(FileFormatError, match="is not the verdict of a run"):
        table_of(grid)


@pytest.mark.slow
def test_a_failing_run_stops_no_other(capsys: pytest.CaptureFixture[str]) -> None:
    text = GRID.replace("[environments]", 'wrong = "F nothing"\n[environments]').replace("[0, 3]", "1")
    text = text.replace('table = { agent = "q-learning", epsilon_final = 0.2 }', "")
    assert run(["sweep", written(text), "--processes", "1", "--json"]) == 1
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert list(answer["failed"]) == ["wrong-lake-two-discount-fitted-q-0"]
    assert "nothing" in err
    assert [len(row["values"]) for row in answer["rows"]] == [1, 0]
    assert answer["rows"][0]["maximum"] == pytest.approx(1)


def alive(pattern: str) -> bool:
    return any(
        pattern in path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if path.exists()
    )


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="needs /proc")
def test_killed_and_resumed_is_the_same_table_to_the_byte() -> None:
    text = GRID.replace("steps = 400", "steps = 3000").replace("[0, 3]", "2")
    whole = read_grid(written(f'out = "whole"\n{text}', "whole.toml"))
    assert run_grid(whole, processes=2) == {}
    write_table(whole)
    cut_file = written(f'out = "cut-{os.getpid()}"\n{text}', "cut.toml")
    cut = read_grid(cut_file)
    random = np.random.default_rng(5)
    for _ in range(2):
        child = subprocess.Popen(
            [sys.executable, "-m", "ltlc", "sweep", cut_file, "-j", "2"], stdout=subprocess.DEVNULL
        )
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline and not any(
            (cut.folder / c.name / "config.json").exists() for c in cut.cells
        ):
            time.sleep(0.05)
        time.sleep(float(random.random()) * 3)
        child.send_signal(signal.SIGKILL)
        child.wait()
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline and alive(str(cut.folder)):
            time.sleep(0.1)
        assert not alive(f"--out {cut.folder}")  # what it had started has ended with it
    assert run_grid(cut, processes=2) == {}
    write_table(cut)
    for name in ("table.csv", "runs.csv", "table.png"):
        assert (cut.folder / name).read_bytes() == (whole.folder / name).read_bytes()
