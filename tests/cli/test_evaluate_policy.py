"""`ltlc evaluate --policy`: policies from elsewhere."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

import pytest
from cli_worlds import SENSORS

from ltlc.cli.app import run

POLICY = """
    import numpy as np

    def act(seen):
        return [0, 3, 3, 3, 0, 0, 0, 0, 3, 1, 0, 0, 0, 2, 1, 0][seen["observation"]]

    def fails(seen):
        return seen["nothing"]

    def falls(seen):
        return 0

    table = np.zeros((16, 3), dtype=int)
"""
LAKE = ("F goal & G !hole", "--env", "FrozenLake-v1", "--labels", "sensors.py:labels_of_state")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    labels = '\n\ndef labels_of_state(state):\n    return {"H": {"hole"}, "G": {"goal"}}.get(MAP[state], set())\n'
    Path("sensors.py").write_text(textwrap.dedent(SENSORS) + labels)
    Path("policies.py").write_text(textwrap.dedent(POLICY))
    return tmp_path


def test_a_function_is_judged_exactly(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", *LAKE, "--policy", "policies.py:act", "--json", "--prism", "chain"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["exact"]
    assert answer["satisfaction"] == pytest.approx(14 / 17)
    assert answer["maximum_satisfaction"] == pytest.approx([14 / 17] * 3)
    assert Path("chain/policy.prism").is_file()
    assert "storm" in answer["check"]


def test_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", *LAKE, "--policy", "policies.py:table", "--prism", "chain"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("policies.py:table satisfies F goal & G !hole with probability 0 (the best policy: 0.8235).")
    assert "PRISM or Storm should find 0:" in out


def test_an_unknown_environment_is_sampled(capsys: pytest.CaptureFixture[str]) -> None:
    pole = ("evaluate", "G !fallen", "--env", "CartPole-v1", "--labels", "sensors.py:standing")
    assert run([*pole, "--policy", "policies.py:falls", "--episodes", "20"]) == 0
    out = capsys.readouterr().out
    assert "of 20 episodes, 0 satisfy it, 20 violate it, 0 were cut" in out
    assert "sampled, because the dynamics of CartPoleEnv are not known." in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((*LAKE, "--policy", "policies.py:nothing"), "unknown name in policies.py: 'nothing'"),
        ((*LAKE, "--policy", "policies"), "expected module:name"),
        ((*LAKE, "--policy", "policies.py:fails"), "the policy, fails on the observation"),
        (("F goal", "--policy", "policies.py:act"), "--policy needs --env"),
        (("runs/none", "--env", "FrozenLake-v1"), "--env goes with --policy"),
    ],
)
def test_wrong_input(arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", *arguments]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


@pytest.mark.peer
def test_a_saved_model(capsys: pytest.CaptureFixture[str]) -> None:
    sb3 = pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed", exc_type=ImportError)
    import gymnasium

    env = gymnasium.make("FrozenLake-v1")
    sb3.DQN("MlpPolicy", env, seed=0, device="cpu").save("model.zip")
    assert run(["evaluate", *LAKE, "--policy", "model.zip"]) == 0
    assert "model.zip satisfies F goal & G !hole with probability" in capsys.readouterr().out
