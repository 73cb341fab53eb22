"""What `make demo` runs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
def test_demo(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "examples" / "demo.py"), "--quick"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "<svg" in (tmp_path / "demo" / "task.svg").read_text()
    assert "accepted: " in done.stdout
    assert "(exit code 1: rejected)" in done.stdout
    assert "exact optimum" in done.stdout and "-604.6" in done.stdout
    assert (tmp_path / "demo" / "learned" / "figure-5.3.png").exists()
    assert done.stdout.endswith("The automaton is in demo/task.json, its picture in demo/task.svg.\n")
