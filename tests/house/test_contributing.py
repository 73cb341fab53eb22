"""CONTRIBUTING is followed to the letter: each block, alone in a user's module, adds a part that is found and works."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
BLOCKS = {
    match["kind"]: match["code"]
    for match in re.finditer(
        r"\*\*(?P<kind>[a-zA-Z ]+)\*\*(?:(?!\*\*|```).)*```python\n(?P<code>.*?)```", TEXT, re.DOTALL
    )
}
MOST_LINES = 15
GRID = ("--env", "ltlc/Thesis5x5-v0")
LAKE = ("--env", "FrozenLake-v1")


@pytest.fixture
def ltlc(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """Runs a command line in a folder where mine.py is the block of a kind of part."""
    (tmp_path / "mine.py").write_text(BLOCKS[request.param], encoding="utf-8")
    environ = os.environ | {"LTLC_PLUGINS": "mine", "COLUMNS": "300"}

    def run(*arguments: str) -> str:
        command = [sys.executable, "-m", "ltlc", *arguments]
        done = subprocess.run(command, cwd=tmp_path, env=environ, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def follows(kind: str) -> Any:
    return pytest.mark.parametrize("ltlc", [kind], indirect=True)


def names(listing: str) -> list[str]:
    return [entry["name"] for entry in json.loads(listing)]


def test_every_kind_of_part_has_its_block() -> None:
    assert set(BLOCKS) == {"construction", "reward scheme", "agent", "format", "Labels", "environment"}
    for kind, code in BLOCKS.items():
        assert len([line for line in code.splitlines() if line.strip()]) <= MOST_LINES, kind


@follows("construction")
@pytest.mark.slow
def test_construction(ltlc: Any) -> None:
    assert "either-safra" in names(ltlc("translators", "--json"))
    assert "either-safra" in ltlc("compile", "--help")
    assert json.loads(ltlc("compile", "GF a -> GF b", "-t", "either-safra", "--json"))["translator"] == "either-safra"


@pytest.mark.slow
@follows("reward scheme")
def test_reward_scheme(ltlc: Any) -> None:
    assert "unit" in names(ltlc("rewards", "--json"))
    assert "unit" in ltlc("solve", "--help")
    rows = {row["name"]: row for row in json.loads(ltlc("faithful", "F A", *GRID, "--json"))["rows"]}
    assert rows["unit"]["satisfaction"] == pytest.approx(1)
    for name in ("unit", "mine:Unit"):
        assert json.loads(ltlc("solve", "F A", *GRID, "-r", name, "-s", "gamma=0.9", "--json"))["shortfall"] is None


@pytest.mark.slow
@follows("agent")
def test_agent(ltlc: Any) -> None:
    assert "wanderer" in names(ltlc("agents", "--json"))
    assert "wanderer" in ltlc("train", "--help")
    done = json.loads(ltlc("train", "F A", *GRID, "--agent", "wanderer", "-n", "3000", "--out", "run", "--json"))
    assert done["agent"] == "wanderer" and done["steps"] >= 3000
    assert "learned" in ltlc("evaluate", "run")


@pytest.mark.slow
@follows("format")
def test_format(ltlc: Any, tmp_path: Path) -> None:
    assert "csv" in names(ltlc("formats", "--json"))
    assert ".csv" in ltlc("compile", "--help") and ".csv" in ltlc("show", "--help")
    ltlc("compile", "F a", "-o", "dra.csv", "-o", "dra.json")
    text = (tmp_path / "dra.csv").read_text(encoding="utf-8")
    assert text.startswith("state,letters,target\n0,")
    assert ltlc("compile", "F a", "--format", "csv") == text
    ltlc("show", "dra.json", "-o", "again.csv")
    assert (tmp_path / "again.csv").read_text(encoding="utf-8") == text


@pytest.mark.slow
@follows("Labels")
def test_labels(ltlc: Any) -> None:
    assert "lake" in names(ltlc("labellers", "--json"))
    assert "lake" in ltlc("solve", "--help")
    by_name, by_module = (
        json.loads(ltlc("solve", "F goal & G !hole", *LAKE, "-l", labels, "--json")) for labels in ("lake", "mine:lake")
    )
    assert by_name == by_module
    assert by_name["maximum_satisfaction"][1] == pytest.approx(14 / 17)


@pytest.mark.slow
@follows("environment")
def test_environment(ltlc: Any) -> None:
    where = ("F end", "--env", "mine:Corridor-v0")
    assert json.loads(ltlc("solve", *where, "--json"))["maximum_satisfaction"] == [1, 1, 1]
    done = json.loads(ltlc("train", *where, "-n", "2000", "--out", "run", "--json"))
    assert done["steps"] >= 2000 and "optimal" in done
