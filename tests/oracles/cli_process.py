"""The command line as a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def process(*arguments: str, **options: object) -> subprocess.Popen[str]:
    """The command as a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "ltlc", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.Popen(command, env=environment, text=True, **pipes)  # type: ignore[call-overload]


def ask(child: subprocess.Popen[str], formula: str) -> str:
    """Give a batch one more line, and take the automaton that comes out."""
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdin.write(f"{formula}\n")
    child.stdin.flush()
    text = ""
    for line in iter(child.stdout.readline, ""):
        text += line
        if line == "--END--\n":
            break
    return text
