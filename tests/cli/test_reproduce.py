"""`ltlc reproduce`: the figures of the thesis beside ours, and what its pictures say."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ltlc.agents.thesis import runtime
from ltlc.cli import reproduce
from ltlc.cli.app import run
from ltlc.envs import recorded_automaton
from ltlc.envs.spec import EnvSpec
from ltlc.mdp import Judge
from ltlc.pictures.policy import waits_for
from ltlc.rewards import get_scheme
from ltlc.task import Task


@pytest.mark.slow
def test_case_1(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduce, "QUICK", 500)
    assert run(["reproduce", "case1", "--static", "--quick"]) == 0
    out = capsys.readouterr().out
    assert "thesis" in out and "3 h" in out and "-792.4" in out and "-563.9" in out
    assert "Not learned in these steps: " in out and "% of the optimal discounted return is lost" in out
    assert {path.name for path in Path("reproduce/case1").iterdir()} == {
        "static-0",
        "figure-5.2.png",
        "learning.png",
    }


@pytest.mark.slow
def test_run_time_comparison(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runtime, "CASES", [("10x10", "phi_3"), ("5x5", "phi_4")])
    monkeypatch.setattr(runtime, "SYSTEMS", ("sadigh", "fu-topcu"))
    assert run(["reproduce", "runtime", "--quick", "--out", "here"]) == 0
    out = capsys.readouterr().out
    assert "(table 5.1)" in out and ">25 h" in out and "(table 5.2)" in out and "375" in out
    assert Path("here/runtime.png").read_bytes().startswith(b"\x89PNG")
    monkeypatch.setattr(runtime, "SECONDS", 0.0)
    assert run(["reproduce", "runtime", "--seeds", "2", "--json", "--out", "here"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["thesis_product_states"] for row in rows] == [400, 400, 375, 375]
    assert all(row["runs"] == 2 and row["reached"] < 2 for row in rows[:2])


@pytest.mark.slow
def test_case_2(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduce, "QUICK", 3000)
    assert run(["reproduce", "case2", "--dynamic", "--quick", "--out", "there", "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)
    assert entry["thesis_hours"] == 17.0
    assert entry["optimal"]["total_return"] == pytest.approx(-979.2, abs=0.05)
    assert Path("there/figure-5.4.png").exists()


def test_wrong_options(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["reproduce", "runtime", "--static"]) == 2
    assert run(["reproduce", "case1", "--seeds", "0"]) == 2


def test_what_the_states_of_the_thesis_wait_for() -> None:
    env_spec = EnvSpec(env="ltlc/Thesis10x10-v0", initial_label="skip")
    task = Task(recorded_automaton("phi_1"), reward="thesis")
    assert env_spec.model is not None
    judge = Judge(env_spec.model, task, initial_label="skip")
    waits = waits_for(task.automaton, judge.letter_classes)
    assert waits[:5] == ["violated", *(f"waits for {name} & !C" for name in "ABTT")]
    assert waits_for(recorded_automaton("phi_3"), np.arange(2))[3] == "cannot accept here"


@pytest.mark.parametrize("name", ["frontier", "two-discount", "zeta-reach"])
def test_the_judge_and_schemes_whose_states_refine_the_automaton(name: str) -> None:
    env_spec = EnvSpec(env="ltlc/Thesis5x5-v0", arguments={"slip": 0.1})
    assert env_spec.model is not None
    task = Task("GF A & G !C", get_scheme(name))
    judge = Judge(env_spec.model, task)
    assert judge.maximum.probability == pytest.approx(0.0)
    task = Task("GF A & GF B", get_scheme(name))
    judge = Judge(env_spec.model, task)
    assert judge.maximum.probability == 1
    assert judge.optimum is not None and judge.optimum.satisfaction == 1
