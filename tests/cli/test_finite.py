"""Finite traces on the command line."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

import pytest
from cli_worlds import LAKE, SENSORS

import ltlc
from ltlc.cli.app import run


def test_compile_show_and_check(capsys: pytest.CaptureFixture[str]) -> None:
    targets = ["-o", "dfa.json", "-o", "dfa.hoa", "-o", "dfa.dot"]
    assert run(["compile", "--finite", "G(a -> WX b) & F last", *targets]) == 0
    assert capsys.readouterr().out == "dfa.json, dfa.hoa, dfa.dot: 4 states, finite traces\n"
    for source in ("dfa.json", "dfa.hoa"):
        assert isinstance(ltlc.load(source), ltlc.DFA)
        assert run(["show", source]) == 0
        assert "end in a state with +0" in capsys.readouterr().out
        assert run(["check", source, "-w", "a; b", "-w", "a; 1"]) == 1
        assert capsys.readouterr().out == "accepted: a; b\nrejected: a; 1\n"
    assert run(["show", "--finite", "F a & last", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["words"], summary["n_states"], summary["accepting"]) == ("finite", 3, [2])


def test_check_formula(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "--finite", "F a", "--word", "b & !a; a"]) == 0
    assert capsys.readouterr().out == "accepted: b & !a; a\n"
    assert run(["check", "--finite", "F a & X X a", "--word", "a; a"]) == 1
    assert capsys.readouterr().out == "rejected: a; a  (does not satisfy X X a)\n"


def test_streams(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "formulas.txt").write_text("F a\nG(a -> WX b)  # weak\n")
    assert run(["compile", "--finite", "-F", "formulas.txt"]) == 0
    automata = list(ltlc.formats.read_hoa_stream(capsys.readouterr().out))
    assert [automaton.formula for automaton in automata] == ["F a", "G(a -> WX b)"]


def test_solve(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """To reach the goal of FrozenLake, exactly, in both readings."""
    (folder / "sensors.py").write_text(textwrap.dedent(SENSORS))
    for formula in (["!hole U goal"], ["--finite", "G !hole & F goal"], ["--finite", "!hole U (goal & last)"]):
        assert run(["solve", *formula, *LAKE[1:5], "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["maximum_satisfaction"] == pytest.approx([14 / 17] * 3)
    assert run(["solve", "--finite", "F goal", *LAKE[1:5], "--prism", "files"]) == 2
    assert "no formula that another program could check" in capsys.readouterr().err


def test_goals(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """FrozenLake ends in a hole or at the goal; on the way it can be put off for ever, and then it does not end."""
    (folder / "sensors.py").write_text(textwrap.dedent(SENSORS))
    for formula, best in (("F hole", 1.0), ("G !hole", 14 / 17), ("F(last & goal)", 14 / 17), ("false", 0.0)):
        assert run(["solve", "--finite", "--goal", "end", formula, *LAKE[1:5], "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["maximum_satisfaction"] == pytest.approx([best] * 3)
    assert run(["solve", "--finite", "--goal", "begin", "F hole", *LAKE[1:5]]) == 2
    assert "'begin'" in capsys.readouterr().err


@pytest.mark.slow
def test_train(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "sensors.py").write_text(textwrap.dedent(SENSORS))
    command = ["train", "--finite", "--goal", "end", "F goal", *LAKE[1:5], "--agent", "q-learning", "--steps", "2000"]
    assert run([*command, "--out", "run", "--quiet"]) in (0, 1)
    assert run(["evaluate", "run", "--json"]) in (0, 1)


def test_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "G(b -> O a)", "--word", "a; cycle{b; 1}", "--table"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "accepted: a; cycle{b; 1}",
        "               a  b  -  | b  -",
        "  b            .  1  .  | 1  .",
        "  a            1  .  .  | .  .",
        "  O a          1  1  1  | 1  1",
        "  b -> O a     1  1  1  | 1  1",
        "  G(b -> O a)  1  1  1  | 1  1",
    ]
    assert run(["check", "--finite", "X b", "-w", "a; b", "-w", "b", "--table"]) == 1
    assert capsys.readouterr().out.splitlines()[1:4] == ["       a  b", "  b    .  1", "  X b  1  ."]
    assert run(["check", "a", "-w", "cycle{a}", "--table", "--json"]) == 2
    assert "--table is for people" in capsys.readouterr().err
    assert run(["compile", "F a", "-o", "a.json"]) == 0
    assert run(["check", "a.json", "-w", "cycle{a}", "--table"]) == 2
    assert "--table is about the parts of a formula" in capsys.readouterr().err
