"""--exclusive and --letters, and environments that declare their letters, on the command line."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

import ltlc
from ltlc.cli.app import run

CELLS = [f"s{i}" for i in range(30)]
TASK = f"F s15 & G !(s5 | s7 | s11 | s12) & G({' | '.join(CELLS)})"
SENSORS = 'labels = {f"s{i}": (lambda i: lambda state: state == i)(i) for i in range(30)}\n'


def test_compile_and_show(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "task.json"
    assert run(["compile", "F(a & F b) & G c", "--exclusive", "a,b,x", "-o", str(target), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_states"] == 4
    assert ltlc.load(target).possible == ((0, 1, 2), (0, 4))
    assert run(["show", str(target)]) == 0
    assert "6, of which it tells" in capsys.readouterr().out
    assert run(["show", "F(a & F b)", "--letters", "a; b; 1"]) == 0
    assert "3, of which it tells 3 apart" in capsys.readouterr().out
    many = " & ".join(f"GF {cell}" for cell in CELLS)
    assert run(["compile", many, "--exclusive", ",".join(CELLS), "-f", "hoa", "-a", "transition"]) == 0
    assert "States: 30" in capsys.readouterr().out
    assert run(["compile", many]) == 3
    assert "exclude each other" in capsys.readouterr().err


def test_check_and_monitor_name_impossible_letters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "task.hoa"
    assert run(["compile", "F(a & F b)", "--exclusive", "a, b", "-o", str(target)]) == 0
    capsys.readouterr()
    for source in ([str(target)], ["F(a & F b)", "--exclusive", "a,b"]):
        assert run(["check", *source, "-w", "a; b; cycle{1}"]) == 0
        assert run(["check", *source, "-w", "a; cycle{a & b}"]) == 2
        assert "the letter {a, b} occurs" in capsys.readouterr().err
    monkeypatch.setattr("sys.stdin", io.StringIO("a\nb, a\n"))
    assert run(["monitor", "F(a & F b)", "--exclusive", "a,b"]) == 2
    assert "the letter {a, b} occurs" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--exclusive", "a"], "--exclusive 'a': expected two names or more"),
        (["--exclusive", "a,b", "--letters", "a"], "give either --exclusive or --letters"),
        (["--letters", "a; ("], "'(' is no name"),
        (["--letters", "a & !a"], "'a' cannot be true and false in one letter"),
    ],
)
def test_wrong_options(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "F a", *arguments]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_solve_and_train(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cells.py").write_text(SENSORS)
    world = ["--env", "FrozenLake-v1", "--labels", "cells.py:labels", "--exclusive", ",".join(CELLS)]
    assert run(["solve", TASK, *world]) == 0
    assert "0.823529" in capsys.readouterr().out
    assert run(["solve", TASK, *world[:-2]]) == 0  # more than 21 propositions: the letters of the model
    assert "0.823529" in capsys.readouterr().out
    for agent in ("fitted-q", "sadigh"):
        out = tmp_path / agent
        options = ["--agent", agent, "--steps", "400", "--out", str(out), "--num-envs", "2", "--quiet"]
        assert run(["train", TASK, *world, *options]) == 0
        capsys.readouterr()
        assert run(["evaluate", str(out), "--json"]) == 0
        assert "probability" in capsys.readouterr().out
