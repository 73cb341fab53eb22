"""Comparisons of numbers on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ltlc.cli.app import run

CAR = ["--env", "MountainCar-v0"]


@pytest.mark.slow
def test_train_and_evaluate(capsys: pytest.CaptureFixture[str]) -> None:
    formula = 'F "x > -0.4" & G "abs(v) <= 0.5"'
    agent = ["--agent", "double-dqn", "--steps", "1200", "--quiet", "--out", "run"]
    assert run(["train", formula, *CAR, "--variables", "x=0", "--variables", "v=1", *agent]) in (0, 1)
    assert json.loads(Path("run/config.json").read_text())["env_spec"]["labels"] == "variables:x=0, v=1"
    assert run(["evaluate", "run", "--episodes", "2"]) in (0, 1)


@pytest.mark.slow
def test_robustness(capsys: pytest.CaptureFixture[str]) -> None:
    options = [*CAR, "--variables", "x=0", "--robustness", "0.5", "--steps", "1200", "--quiet", "--out", "run"]
    assert run(["train", 'F "x > -0.4"', *options]) in (0, 1)
    config = json.loads(Path("run/config.json").read_text())
    assert config["hyperparameters"]["robustness"] == 0.5
    assert config["hyperparameters"]["variables"] == "x=0"
    assert run(["train", "--resume", "--out", "run", "--quiet"]) in (0, 1)
    assert run(["evaluate", "run", "--episodes", "2"]) in (0, 1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "--robustness is about comparisons of numbers; say where they are: --variables x=0"),
        (["--variables", "x=0", "--agent", "fitted-q"], "the agent 'fitted-q' plans with all that it has seen"),
    ],
)
def test_robustness_that_does_nothing(options: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    formula = 'F "x > 1"' if options else "F goal"
    env = CAR if options else ["--env", "FrozenLake-v1", "--labels", "lake"]
    command = ["train", formula, *env, *options, "--robustness", "1", "--out", "run", "--steps", "100", "--quiet"]
    assert run(command) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("formula", "variables", "message"),
    [
        ('F "y > 1"', ["x=0"], "unknown variable 'y'. Known: x."),
        ("F goal", ["x=0"], "unknown variable 'goal'"),
        ('F "x >"', ["x=0"], "the comparison ends too early"),
        ('F "x = 1"', ["x=0"], "'=' does not belong into a comparison"),
        ('F "x > 1"', ["x"], "'x' is no variable with its place; write x=0"),
        ('F "x > 1"', ["x=0", "x=1"], "'x' is given twice"),
        ('F "x > 1"', ["x=7"], "the variable 'x' is no number at observation[7]"),
        ('F "x > 1"', ["x=speed"], "the variable 'x' is no number at observation['speed']"),
    ],
)
def test_errors(formula: str, variables: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    options = [part for variable in variables for part in ("--variables", variable)]
    assert run(["train", formula, *CAR, *options, "--steps", "100", "--quiet", "--out", "run"]) == 2
    assert message in capsys.readouterr().err


def test_two_kinds_of_labels(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["train", "F a", *CAR, "--variables", "x=0", "--labels", "m:f", "--out", "run"]) == 2
    assert "--labels and --variables are both given" in capsys.readouterr().err


def test_exact_answers_are_not_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["solve", 'F "x > 1"', "--env", "FrozenLake-v1", "--variables", "x="]) == 2
    assert "comparisons are about observations" in capsys.readouterr().err
