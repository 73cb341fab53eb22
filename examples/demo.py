"""A task in temporal logic, from its text to a picture, a learned policy and an exact verdict; `make demo` runs it.

The task: visit A, then B, then T, and never enter C on the way. The robot slips, so even the best policy may fail.

    python examples/demo.py
"""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path

from ltlc.cli.app import run

TASK = "!C U (A & (!C U (B & (!C U T))))"
WORLD = "ltlc/Thesis10x10-v0"
STEPS = 100_000
FOLDER = Path("demo")


def ltlc(*arguments: object) -> int:
    """Show a command line and run it."""
    words = [str(argument) for argument in arguments]
    print(f"\n$ ltlc {shlex.join(words)}", flush=True)
    code = run(words)
    if code == 1:
        print("(exit code 1: rejected)")
    return code


def main() -> int:
    FOLDER.mkdir(exist_ok=True)
    automaton, picture, learned = FOLDER / "task.json", FOLDER / "task.svg", FOLDER / "learned"
    ltlc("compile", TASK, "-o", automaton)
    drawn = ltlc("show", automaton, "-o", picture) == 0
    ltlc("check", automaton, "--word", "A; B; cycle{T}")
    ltlc("check", automaton, "--word", "A; C; B; cycle{T}")
    code = ltlc("train", automaton, "--env", WORLD, "--steps", STEPS, "--out", learned, "--force")
    if code:
        return code
    result = json.loads((learned / "result.json").read_text(encoding="utf-8"))
    print(
        f"\nThe learned policy satisfies the task with probability {result['learned']['satisfaction']:.4f}; "
        f"the largest possible is {result['maximum_satisfaction'][1]:.4f}."
    )
    print(f"The policy: {learned / 'policy.png'}{f'; the automaton: {picture}' if drawn else ''}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
