"""The recipes for environments of others train, where their packages are installed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "other-worlds.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^ltlc train (.*)$", PAGE, re.MULTILINE)
NEEDED = {"LunarLander": "Box2D", "mine:mine/": "minigrid", "mine:ALE/": "ale_py"}


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_a_recipe_trains(command: str, tmp_path: Path) -> None:
    packages = [package for name, package in NEEDED.items() if name in command]
    for package in packages:
        pytest.importorskip(package, reason=f"{package} is not installed")
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    absent = {"minigrid", "ale_py"} - set(packages)
    code = [block for block in blocks if not any(f"import {package}" in block for package in absent)]
    (tmp_path / "mine.py").write_text("\n\n".join(code))
    short = re.sub(r"--steps \d+", "--steps 200 --quiet", command) + " --episode-steps 20"
    done = subprocess.run(
        ["bash", "-c", f'exec "{sys.executable}" -m ltlc train {short}'],
        cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.glob("runs/*/policy.ltlc"))
