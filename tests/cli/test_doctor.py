"""The doctor finds what is missing, old or broken, and says what to do."""

from __future__ import annotations

import json
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from ltlc import doctor
from ltlc.cli.app import run


def findings(health: doctor.Health) -> dict[str, doctor.Finding]:
    return {finding.name: finding for finding in health.findings}


@pytest.mark.slow
def test_here_everything_that_is_needed_works(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["doctor", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["works"] and answer["devices"][0] == "cpu"
    assert {"numpy", "torch", "dot", "python-sat"} <= {finding["name"] for finding in answer["findings"]}
    assert run(["doctor"]) == 0
    assert "What is needed works." in capsys.readouterr().out


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only few packages are asked for, so that none that is large is imported."""
    needed = [
        "numpy>=2.0",
        "lark<0.1,>=0",
        "nothing-of-that-name>=1",
        'python-sat; extra == "sat"',
        'mypy; extra == "dev"',
    ]
    monkeypatch.setattr(metadata, "requires", lambda name: needed)


@pytest.mark.usefixtures("quick")
def test_what_is_missing_or_old_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["doctor"]) == 1
    out = capsys.readouterr().out
    assert "missing nothing-of-that-name" in out
    assert "pip install 'nothing-of-that-name>=1'" in out
    assert "old     lark" in out
    assert "nothing, because torch does not work" in out
    assert "mypy" not in out


@pytest.mark.usefixtures("quick")
def test_what_cannot_be_imported_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pysat", None)
    found = findings(doctor.examine())["python-sat"]
    assert (found.state, found.kind) == ("broken", "extra")
    assert "ModuleNotFoundError" in found.advice and "ltlc[sat]" in found.advice


@pytest.mark.usefixtures("quick")
def test_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    found = findings(doctor.examine())
    assert found["dot"].state == "missing" and "Graphviz" in found["dot"].advice
    monkeypatch.setattr(doctor.shutil, "which", lambda name: f"/bin/{name}")
    assert findings(doctor.examine())["dot"].works


def test_extras_are_those_of_the_package() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert set(doctor.EXTRAS) == set(project["optional-dependencies"]) - {"dev", "docs", "peers"}


@pytest.mark.parametrize(
    ("version", "bounds", "expected"),
    [("2.0", ">=2.0", True), ("1.9.9", ">=2.0", False), ("1.10", ">=1.9", True), ("0.29", ">=0.28,<0.29", False),
     ("2.13.0+cpu", ">=2.2", True), ("1.8.dev13", ">=1.8.dev13", True), ("3", "", True)],
)  # fmt: skip
def test_versions_are_compared_as_numbers(version: str, bounds: str, expected: bool) -> None:
    assert doctor.fits(version, bounds) is expected
