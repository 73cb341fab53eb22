"""What `make demo` runs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from ltlc.errors import MissingProgramError
from ltlc.formats.picture import draw

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_demo(tmp_path: Path) -> None:
    try:
        draw("digraph { a }", "svg")
    except MissingProgramError:
        pytest.skip("nothing that draws is installed")
    command = [sys.executable, str(ROOT / "examples" / "demo.py")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert "<svg" in (tmp_path / "demo" / "task.svg").read_text()
    assert "accepted: " in done.stdout
    assert "(exit code 1: rejected)" in done.stdout
    said = re.search(r"satisfies the task with probability ([.\d]+); the largest possible is ([.\d]+)\.", done.stdout)
    assert said is not None
    learned, possible = map(float, said.groups())
    assert possible == pytest.approx(0.9236, abs=1e-4)
    assert possible - 0.01 < learned <= possible
    assert (tmp_path / "demo" / "learned" / "policy.png").exists()
    assert done.stdout.endswith("The policy: demo/learned/policy.png; the automaton: demo/task.svg\n")
