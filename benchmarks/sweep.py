"""A sweep of 60 runs, killed and resumed, in processes and on Ray: its table must be the same to the byte.

    python benchmarks/sweep.py                          # in processes; needs /proc to see what outlives a kill
    python benchmarks/sweep.py --engines processes ray  # also on a cluster of Ray with two workers on this machine
    python benchmarks/sweep.py --seeds 1 --kills 1 --json sweep.json

The sweep has 3 formulas, 2 rewards, 2 agents and 5 seeds, of 1 000 steps each. It is run once to its end in processes.
Then, by each engine, it is begun, killed (SIGKILL) where a third and two thirds of the runs have ended, begun anew, and
compared: the three files of the sweep, and of each run the metrics, the verdict and the policy.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from ltlc.agents.training.run_folder import RESULT_FILE
from ltlc.sweeps import Grid, read_grid

LABELS = """
MAP = "SFFFFHFHFFFHHFFG"

def lake(state):
    return {"H": {"hole"}, "G": {"goal"}}.get(MAP[state], set())
"""
GRID = """
out = "{out}"
seeds = {seeds}
steps = 1000
num_envs = 2
[formulas]
reach = "F goal & G !hole"
live = "G F goal"
safe = "G !hole"
[environments]
lake = {{ env = "FrozenLake-v1", labels = "sensors.py:lake", episode_steps = 40 }}
[rewards]
two-discount = {{ gamma = 0.99 }}
zeta-discount = {{ zeta = 0.99 }}
[agents]
fitted-q = {{}}
table = {{ agent = "q-learning", epsilon_final = 0.2 }}
"""
TABLES = ("table.csv", "runs.csv", "table.png")
OF_RUNS = ("metrics.csv", "result.json", "policy.ltlc", "dra.json")


def begin(grid: Grid, engine: str, workers: int) -> subprocess.Popen[bytes]:
    words = [sys.executable, "-m", "ltlc", "sweep", f"{grid.folder}.toml", "--engine", engine, "-j", str(workers)]
    environ = {name: value for name, value in os.environ.items() if name != "RAY_ADDRESS"}
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environ)


def ended(grid: Grid) -> int:
    return sum((grid.folder / cell.name / RESULT_FILE).exists() for cell in grid.cells)


def outliving(grid: Grid) -> int:
    """Processes that still train runs of the sweep."""
    pattern = f"--out {grid.folder}/".encode()
    found = 0
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            found += pattern in path.read_bytes().replace(b"\0", b" ")
        except OSError:  # it has just ended
            continue
    return found


def cut(grid: Grid, engine: str, workers: int, kills: int) -> dict[str, Any]:
    """Run a sweep that is killed; where it was killed, and what was alive ten seconds later."""
    at: list[int] = []
    left = 0
    for kill in range(kills):
        child = begin(grid, engine, workers)
        wanted = len(grid.cells) * (kill + 1) // (kills + 1)
        while ended(grid) < wanted and child.poll() is None:
            time.sleep(0.02)
        child.send_signal(signal.SIGKILL)
        child.wait()
        at.append(ended(grid))
        deadline = time.monotonic() + 10
        while outliving(grid) and time.monotonic() < deadline:
            time.sleep(0.05)
        left += outliving(grid)
    code = begin(grid, engine, workers).wait()
    return {"killed_at": at, "left_alive": left, "exit_code": code}


def differing(one: Grid, other: Grid) -> list[str]:
    """Files that are not the same to the byte."""
    names = [*TABLES, *(f"{cell.name}/{name}" for cell in one.cells for name in OF_RUNS)]
    return [name for name in names if _bytes(one.folder / name) != _bytes(other.folder / name)]


def _bytes(path: Path) -> bytes | None:
    return path.read_bytes() if path.exists() else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--engines", nargs="+", choices=["processes", "ray"], default=["processes"])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    target = None if given.json is None else given.json.resolve()
    answers: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("sensors.py").write_text(LABELS)
        grids = {}
        for name in ("whole", *given.engines):
            Path(f"{name}.toml").write_text(GRID.format(out=name, seeds=given.seeds))
            grids[name] = read_grid(f"{name}.toml")
        whole = grids["whole"]
        since = time.monotonic()
        code = begin(whole, "processes", given.workers).wait()
        seconds = time.monotonic() - since
        print(f"never killed: {len(whole.cells)} runs in {seconds:.0f} s, exit code {code}", flush=True)
        for engine in given.engines:
            since = time.monotonic()
            answer = cut(grids[engine], engine, given.workers, given.kills)
            answer |= {"seconds": time.monotonic() - since, "differing": differing(whole, grids[engine])}
            answers[engine] = {"runs": ended(grids[engine]), **answer}
            print(
                f"{engine}: killed after {answer['killed_at']} runs, {answer['left_alive']} processes left alive, "
                f"{answers[engine]['runs']} runs in {answer['seconds']:.0f} s; "
                f"files that differ: {', '.join(answer['differing']) or 'none'}",
                flush=True,
            )
        os.chdir("/")
    if target is not None:
        target.write_text(json.dumps(answers, indent=2) + "\n")
    sys.exit(any(answer["differing"] or answer["left_alive"] or answer["exit_code"] for answer in answers.values()))


if __name__ == "__main__":
    main()
