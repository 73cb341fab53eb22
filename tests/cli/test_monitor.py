"""`ltlc monitor`: letters on standard input, a verdict for each."""

from __future__ import annotations

import io
import json

import pytest

from ltlc.cli.app import run

FORMULA = "G(request -> F grant) & G !error"


def monitored(monkeypatch: pytest.MonkeyPatch, text: str, *arguments: str) -> int:
    monkeypatch.setattr("sys.stdin", io.StringIO(text))
    return run(["monitor", *arguments])


def test_verdicts(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    text = 'request\n\ngrant & !error\n["request"]\n{"grant": true, "error": false}\n1\nerror, request\nnever read ('
    assert monitored(monkeypatch, text, FORMULA) == 1
    assert capsys.readouterr().out.splitlines() == [
        "presumably violated",
        "presumably satisfied",
        "presumably violated",
        "presumably satisfied",
        "presumably satisfied",
        "violated",
    ]


def test_what_is_satisfied_ends_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert monitored(monkeypatch, "b\na\nnot & read", "F a", "--json") == 0
    out, err = capsys.readouterr()
    assert [json.loads(line) for line in out.splitlines()] == [
        {"letter": 1, "verdict": "presumably violated"},
        {"letter": 2, "verdict": "satisfied"},
    ]
    assert err == "ltlc: warning: nothing in F a depends on b\n"


@pytest.mark.parametrize(
    ("text", "finite", "code"),
    [("a", False, 0), ("a", True, 0), ("b", False, 0), ("b", True, 1), ("", False, 0), ("\n", True, 2)],
)
def test_exit_codes(text: str, finite: bool, code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    flags = ["--finite"] if finite else []
    assert monitored(monkeypatch, text, "G (a | b & X a)", *flags) == code


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("a b(", "'(' is no name (column 4)"),
        ("a | b", "'| b' is no name (column 3)"),
        ("a & !a", "'a' cannot be true and false in one letter (column 5)"),
        ("F a;", "';' is no name (column 4)"),
        ("2a", "'2a' is no name (column 1)"),
        ('"a', "'\"a' is no name (column 1)"),
        ("[1]", "expected a list of names"),
        ('["a", ""]', "expected a list of names"),
        ('{"a": 1}', "expected a list of names"),
        ('{"a": true', "not JSON: Expecting"),
        ("[" * 100_000, "not JSON"),
    ],
)
def test_wrong_letters(
    line: str, message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert monitored(monkeypatch, f"a\n{line}\n", "G (a | b)") == 2
    error = capsys.readouterr().err
    assert error.startswith("ltlc: letter on line 2: ") or "warning" in error
    assert message in error


def test_a_table_of_numbers(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    formula = 'G("speed > 5" -> F "speed < 1") & G "car.v < 5" & G ok'
    table = "t,speed,ok,car.v,note\n0,3,1,2,a\n1,6,true,2,\n\n2,0.5,TRUE,2,x\n3,0,0,2,x\n"
    assert monitored(monkeypatch, table, formula, "--csv") == 1
    said = ["presumably satisfied", "presumably violated", "presumably satisfied", "violated"]
    assert capsys.readouterr().out.splitlines() == said
    for between in "\t;":
        assert monitored(monkeypatch, table.replace(",", between), formula, "--csv") == 1
        assert capsys.readouterr().out.splitlines() == said


def test_numbers_in_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [
        '{"speed": 3, "car": {"v": [1, 4]}, "name": "x", "ok": true}',
        '{"speed": -7, "car": {"v": 9}, "ok": true}',
    ]
    formula = 'G "abs(speed) < 5" & G ok'
    assert monitored(monkeypatch, "\n".join(lines), formula) == 1
    assert capsys.readouterr().out.splitlines() == ["presumably satisfied", "violated"]
    assert monitored(monkeypatch, lines[1], 'F "car.v > 5"') == 0
    assert capsys.readouterr().out.splitlines() == ["satisfied"]
