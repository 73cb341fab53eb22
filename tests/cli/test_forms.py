"""`ltlc compile --form`."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from ltlc.cli.app import run


@pytest.mark.parametrize(
    ("form", "name"), [("parity", "parity max odd 2"), ("buchi", "Buchi"), ("rabin", "Rabin 1"), ("co-buchi", None)]
)
def test_forms(form: str, name: str | None, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "G F a", "--form", form, "--format", "hoa"]) == (2 if name is None else 0)
    out, err = capsys.readouterr()
    assert f"acc-name: {name}\n" in out or "it is no persistence property" in err


@pytest.mark.parametrize(
    ("form", "name"),
    [
        ("emerson-lei", "generalized-Buchi 2"),
        ("generalized-rabin", "generalized-Rabin 1 2"),
        ("streett", "Streett 2"),
        ("limit-deterministic", "Buchi"),
    ],
)
def test_forms_that_are_written_as_hoa(form: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["compile", "G F a & G F b", "--form", form]
    assert run([*command, "--format", "hoa"]) == 0
    assert f"acc-name: {name}\n" in capsys.readouterr().out
    assert run(command) == 0
    assert "accepted runs: " in capsys.readouterr().out
    assert run([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["form"] == form
    assert run([*command, "-f", "json"]) == 2
    assert f"automata of the form {form} are written as hoa" in capsys.readouterr().err


def test_determinise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / "choosing.hoa")
    assert run(["compile", "F G a | G F b", "--form", "limit-deterministic", "-o", path]) == 0
    assert run(["show", path]) == 2
    assert "made deterministic when they are read with determinise" in capsys.readouterr().err
    assert run(["show", path, "--determinise"]) == 0
    assert "1 state, 2 pairs" in capsys.readouterr().out
    assert run(["check", path, "--determinise", "-w", "cycle{a; b}", "-w", "cycle{1}"]) == 1
    assert capsys.readouterr().out.splitlines() == ["accepted: cycle{a; b}", "rejected: cycle{1}"]
    monkeypatch.setattr("sys.stdin", io.StringIO(Path(path).read_text()))
    assert run(["show", "-", "--determinise", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_states"] == 1


def test_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "F a", "--finite", "--form", "buchi"]) == 2
    assert "--form is about infinite words" in capsys.readouterr().err
    assert run(["compile", "F a", "--form", "strett"]) == 2
    assert "'strett'" in capsys.readouterr().err
