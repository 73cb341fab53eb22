"""What each reward scheme really optimises: published examples, exact probabilities."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

from ltlc.cli.app import run
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.faithful import Candidate, faithfulness
from ltlc.pictures.faithfulness import draw_faithfulness


@pytest.fixture(scope="module")
def table() -> ModuleType:
    """The benchmark, whose maps and candidates these tests share."""
    path = Path(__file__).parents[2] / "benchmarks" / "faithful.py"
    spec = importlib.util.spec_from_file_location("benchmark_faithful", path)
    assert spec and spec.loader
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


LOSES = {
    "risk-reward": {
        "sadigh .99": 0.9, "accept .99": 0.9, "sadigh .9999": 0.9, "code, reset": 0.9, "code, end": 0.9,
    },
    "devious": {
        "sadigh .99": 0.75, "sadigh .9999": 0.75, "code, reset": 0.75, "code, end": 0.75, "parity .1": 0.75,
        "two-discount .99 .999": 0.75,
    },
    "safe-absorbing": {
        "sadigh .99, marks only": 0.843392, "code, reset": 0.779108, "code, end": 0.797832, "parity .1": 0.779108,
        "parity .01": 0.843392, "parity .001": 0.914286,
    },
    "two-pairs": {"sadigh, pair 0": 2 / 3},
    "gate": {"code, reset": 0.0},
    "frozen-8x8": {
        "sadigh .99": 0.899214, "code, reset": 0.262922, "code, end": 0.899214, "parity .1": 0.802322,
        "two-discount .9 .999": 0.994178,
    },
    "four-moves-until": {
        "sadigh .99, marks only": 0.851231, "sadigh .9999, marks only": 0.950560, "code, reset": 0.753085,
        "accept .99": 0.851231, "accept .9999": 0.950560, "code, end": 0.851231, "parity .1": 0.851231,
        "parity .01": 0.950560, "two-discount .99 .999": 0.948681, "two-discount .99 .9999": 0.950560,
        "two-discount .99 .99999": 0.950696, "two-discount .9 .999": 0.948681,
    },
    "frozen-lake-4x4-until": {"code, reset": 0.0},
}  # fmt: skip

ATTAINS = {
    "risk-reward": ["parity .1", "parity .01", "parity .001", "two-discount .99 .999", "two-discount .9 .999"],
    "devious": ["parity .01", "parity .001", "two-discount .99 .9999", "two-discount .9 .999"],
    "gate": ["sadigh .99", "code, end", "parity .1", "parity .01"],
    "frozen-8x8": ["sadigh .9999", "parity .01", "two-discount .99 .999", "two-discount .99 .99999"],
    "four-moves-until": ["parity .001"],
    "frozen-lake-4x4-until": ["accept .99", "sadigh .99", "code, end", "parity .1", "two-discount .99 .999"],
    "two-pairs": ["sadigh .99", "accept .99", "code, reset", "code, end", "parity .1", "two-discount .99 .999"],
    "safe-absorbing": ["sadigh .9999, marks only", "two-discount .99 .9999", "two-discount .99 .99999"],
}
GUARANTEED = ["zeta-reach .9", "zeta-reach .99", "zeta-discount .99", "eventual .9", "eventual .99", "frontier"]


@pytest.mark.parametrize("task", LOSES)
def test_schemes_lose_what_they_are_known_to_lose(table: ModuleType, task: str) -> None:
    found = table.report(task, list(LOSES[task]))
    assert found.maximum == pytest.approx(table.TASKS[task].pmax, abs=1e-6)
    for row, expected in zip(found.rows, LOSES[task].values(), strict=True):
        assert row.satisfaction == pytest.approx(expected, abs=1e-5), row.name
        assert row.faithful is False


@pytest.mark.parametrize("task", ATTAINS)
def test_schemes_attain_the_maximum_where_they_are_known_to(table: ModuleType, task: str) -> None:
    names = ATTAINS[task] + GUARANTEED
    found = table.report(task, names)
    assert found.maximum == pytest.approx(table.TASKS[task].pmax, abs=1e-6)
    assert {row.name: row.faithful for row in found.rows} == {row.name: True for row in found.rows}


def test_a_scheme_that_does_not_apply_says_why(table: ModuleType) -> None:
    (row,) = faithfulness(
        table.TASKS["gate"].model, table.TASKS["gate"].formula, [Candidate.from_name("sadigh", pair=7)]
    ).rows
    assert row.satisfaction is row.gap is row.faithful is None
    assert "pair 7" in row.problem


def test_a_return_without_a_maximum_is_reported(table: ModuleType) -> None:
    candidate = Candidate.from_name("accept", gamma=1.0)
    (row,) = faithfulness(table.TASKS["risk-reward"].model, "G F g & G !b", [candidate]).rows
    assert row.objective is None
    assert row.problem == "its return has no finite maximum"


def test_candidates_are_called_after_their_parameters() -> None:
    assert Candidate.from_name("parity", "stay", epsilon=0.1).name == "parity epsilon=0.1 deadlock=stay"
    with pytest.raises(UnknownNameError):
        Candidate.from_name("paritty")


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_pictures_are_drawn(table: ModuleType, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"bars.{suffix}"
    draw_faithfulness(
        path, table.report("safe-absorbing", ["code, reset", "code, end", "eventual .9"]), subtitle="a grid"
    )
    first = path.read_bytes()
    assert len(first) > 1000
    with pytest.raises(InvalidArgumentError, match="suffix"):
        draw_faithfulness(tmp_path / "bars.txt", table.report("gate", ["code, end"]))


@pytest.mark.slow
def test_the_command_prints_tables_json_and_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = ["faithful", "!C U A", "--env", "ltlc/Thesis10x10-v0"]
    assert run([*task, "-r", "accept,gamma=0.9", "-r", "eventual", "-o", str(tmp_path / "bars.svg")]) == 0
    out = capsys.readouterr().out
    assert "accept gamma=0.9" in out
    assert "P(satisfied)" in out
    assert (tmp_path / "bars.svg").exists()
    assert run([*task, "-r", "eventual", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    low, best, high = values["maximum_satisfaction"]
    assert low <= best <= high
    assert values["rows"][0]["satisfaction"] == pytest.approx(best, abs=1e-6)
    assert values["rows"][0]["faithful"] is True
    assert run(["faithful", "F x", "--env", "Pendulum-v1", "--labels", "math:sqrt"]) == 2
