"""A task in temporal logic, from its text to a picture, a trained policy and an exact verdict; `make demo` runs it.

The task is the first one of the source work: visit A and later B, never enter C, and in the end stay at T.

    python examples/demo.py [--quick]
"""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from ltlc.cli.app import run

TASK = "F(A & F B) & G!C & FG T"
FOLDER = Path("demo")


def ltlc(*arguments: str) -> int:
    """Show a command line and run it."""
    print(f"\n$ ltlc {shlex.join(arguments)}", flush=True)
    code = run(arguments)
    if code == 1:
        print("(exit code 1: rejected)")
    return code


def main(*options: str) -> int:
    FOLDER.mkdir(exist_ok=True)
    automaton, picture, learned = str(FOLDER / "task.json"), str(FOLDER / "task.svg"), str(FOLDER / "learned")
    ltlc("compile", TASK, "-o", automaton)
    drawn = ltlc("show", automaton, "-o", picture) == 0
    ltlc("check", automaton, "--word", "A; B; cycle{T}")
    ltlc("check", TASK, "--word", "A; C; B; cycle{T}")
    code = ltlc("reproduce", "case1", "--dynamic", "--out", learned, *options)
    print(f"\nThe automaton is in {automaton}{f', its picture in {picture}' if drawn else ''}.")
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
