"""The example of the bundled agent runs, and learns what it says."""

import re
import runpy
from pathlib import Path

import pytest


@pytest.mark.slow
def test_example_is_solved_and_judged(capsys: pytest.CaptureFixture[str]) -> None:
    script = Path(__file__).parents[2] / "examples" / "train_bundled.py"
    runpy.run_path(str(script), run_name="__main__")
    printed = capsys.readouterr().out
    found = re.search(r"exactly: .* regret ([\d.]+)%; violations per episode ([\d.]+)", printed)
    assert found and float(found[1]) < 2 and float(found[2]) < 0.2
    assert "watched:  violations per episode 0.1" in printed
