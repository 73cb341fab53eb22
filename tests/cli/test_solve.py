"""`ltlc solve`, and the files for PRISM of what is solved or was learned."""

from __future__ import annotations

import json
import shlex
import textwrap
from pathlib import Path
from typing import Any

import pytest
from cli_worlds import GRID, LAKE, POLE, SENSORS, SMALL

from ltlc.cli.app import run


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Every test runs in a folder of its own, which holds the labels."""
    Path("sensors.py").write_text(textwrap.dedent(SENSORS))
    return folder


class TestSolve:
    @pytest.mark.slow
    def test_frozen_lake(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", *LAKE, "--json", "-o", "policy.png"]) == 0
        answer = json.loads(capsys.readouterr().out)
        assert answer["maximum_satisfaction"] == pytest.approx([14 / 17] * 3)
        assert answer["optimal"]["satisfaction"] == pytest.approx(14 / 17)
        assert answer["optimal"]["first_acceptance_steps"] == "inf"
        assert Path("policy.png").read_bytes().startswith(b"\x89PNG")

    def test_text(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", "F A", "--env", "ltlc/Thesis5x5-v0", "--gamma", "0.9"]) == 0
        out = capsys.readouterr().out
        assert "24 product states" in out and "expected return, discounted" in out

    def test_a_return_without_a_finite_optimum(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", "GF A", "--env", "ltlc/Thesis5x5-v0", "--reward", "accept", "--gamma", "1"]) in (0, 2)
        assert "Traceback" not in capsys.readouterr().err

    def test_unknown_dynamics(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", *POLE[:5]]) == 2
        assert "dynamics of CartPole-v1 are not known" in capsys.readouterr().err

    @pytest.mark.parametrize("labels", ["looks", "fails"])
    def test_labels_that_look_at_more_than_the_state(self, labels: str, capsys: pytest.CaptureFixture[str]) -> None:
        for env in ("FrozenLake-v1", "ltlc/Grid-v0"):
            assert run(["solve", "F goal", "--env", env, "--labels", f"sensors.py:{labels}"]) == 2
            assert "not known, because the labels look at more than the state" in capsys.readouterr().err

    def test_no_map(self, capsys: pytest.CaptureFixture[str]) -> None:
        Path("taxi.py").write_text(
            "def labels(observation, info):\n    return {'start'} if observation == 0 else set()\n"
        )
        taxi = ["F start", "--env", "Taxi-v4", "--labels", "taxi.py:labels"]
        assert run(["solve", *taxi, "-o", "policy.png"]) == 2
        assert "no map" in capsys.readouterr().err


class TestPrism:
    @staticmethod
    def recheck(answer: dict[str, Any]) -> float:
        """What Storm says of the files that are named in an answer."""
        stormpy = pytest.importorskip("stormpy")
        program, model, option, properties = shlex.split(answer["check"]["storm"])[1:]
        assert (program, option) == ("--prism", "--prop")
        parsed = stormpy.parse_prism_program(model)
        (wanted,) = stormpy.parse_properties(Path(properties).read_text(), parsed)
        built = stormpy.build_model(parsed, [wanted])
        result = stormpy.model_checking(built, wanted)
        start = built.initial_states[0]
        return result.get_value(start) if hasattr(result, "get_value") else result.at(start)

    @pytest.mark.slow
    @pytest.mark.parametrize("env", ["ltlc/Thesis5x5-v0", "ltlc/Thesis5x5Dynamic-v0"])
    def test_the_largest_probability(self, env: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", "!C U (A & (!C U B))", "--env", env, "--prism", "files", "--json"]) == 0
        answer = json.loads(capsys.readouterr().out)
        assert {path.suffix for path in Path("files").iterdir()} == {".prism", ".props", ".tra", ".lab", ".sta"}
        assert 0 < answer["maximum_satisfaction"][1] < 1
        assert self.recheck(answer) == pytest.approx(answer["maximum_satisfaction"][1], abs=1e-5)

    @pytest.mark.slow
    @pytest.mark.parametrize("agent", ["double-dqn", "q-learning", "wang"])
    def test_what_was_learned(self, agent: str, capsys: pytest.CaptureFixture[str]) -> None:
        coarse = ["--hyper", "accuracy=0.2"] if agent == "wang" else ["--steps", "3000"]
        task = ["!C U A", "--env", "ltlc/Thesis5x5Dynamic-v0", "--out", "here", "--quiet", *coarse]
        assert run(["train", *task, "--agent", agent, *(SMALL if agent == "double-dqn" else ())]) == 0
        assert run(["evaluate", "here", "--prism", "chain", "--json"]) == 0
        answer = json.loads(capsys.readouterr().out)
        assert self.recheck(answer) == pytest.approx(answer["learned"]["satisfaction"], abs=1e-5)
        assert run(["evaluate", "here", "--prism", "chain"]) == 0
        assert "prism chain/policy.prism chain/policy.props" in capsys.readouterr().out

    @pytest.mark.slow
    def test_what_cannot_be_written(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["compile", "F goal", "-o", "task.json"]) == 0
        nameless = json.loads(Path("task.json").read_text())
        del nameless["formula"]
        Path("task.json").write_text(json.dumps(nameless))
        assert run(["solve", "task.json", *GRID[1:], "--prism", "files"]) == 2
        assert "no formula that another program could check" in capsys.readouterr().err
        assert run(["train", *POLE, "--steps", "60", "--episode-steps", "20", "--out", "pole", "-q", *SMALL]) == 0
        assert run(["evaluate", "pole", "--prism", "files"]) == 2
        assert "no Markov chain to write" in capsys.readouterr().err
        assert not Path("files").exists()
