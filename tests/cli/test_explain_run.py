"""`ltlc explain RUN`."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

import pytest
from cli_worlds import LAKE, POLE, SENSORS, SMALL

from ltlc.cli.app import run


@pytest.fixture(autouse=True)
def labels(folder: Path) -> None:
    """The folder of a test holds the labels."""
    (folder / "sensors.py").write_text(textwrap.dedent(SENSORS))


@pytest.mark.slow
def test_a_known_world(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["train", *LAKE, "--steps", "4000", "--agent", "fitted-q", "--out", "lake", "--quiet"]) == 0
    capsys.readouterr()
    assert run(["explain", "lake", "-o", "lost.png"]) == 0
    out = capsys.readouterr().out
    assert "satisfied with probability" in out
    assert "Where lost runs stay:" in out
    assert "breaks G !hole" in out
    assert Path("lost.png").read_bytes().startswith(b"\x89PNG")
    assert run(["explain", "lake", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["loss"] == pytest.approx(1 - data["satisfaction"])
    assert data["entries_carry"] >= 0.9
    assert max(data["routes_carry"], data["paths_carry"]) >= 0.9 or data["why"]
    assert {"states", "probability", "breaks"} <= data["paths"][0].keys()


@pytest.mark.slow
def test_episodes_elsewhere(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["train", *POLE, "--steps", "300", *SMALL, "--out", "pole", "--quiet"]) in (0, 1)
    capsys.readouterr()
    assert run(["explain", "pole", "--episodes", "6"]) == 0
    assert "violated, in the end fallen; the shortest: 1; fallen" in capsys.readouterr().out
    assert run(["explain", "pole", "-n", "4", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kinds"][0]["word"][-1] == ["fallen"]
    assert run(["explain", "pole", "-o", "lost.png"]) == 2
    assert "the dynamics of this environment are not known" in capsys.readouterr().err


def test_errors(capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty").mkdir()
    assert run(["explain", "empty"]) == 2
    assert "is no run folder" in capsys.readouterr().err
    assert run(["explain", "empty", "F a"]) == 2
    assert "is a folder: explain it alone" in capsys.readouterr().err
    assert run(["explain", "F a", "-o", "lost.png"]) == 2
    assert "is no folder of a run" in capsys.readouterr().err
