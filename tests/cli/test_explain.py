"""`ltlc explain`: sentences, what is often meant otherwise, and words that tell formulas apart."""

from __future__ import annotations

import json

import pytest

import ltlc
from ltlc.cli.app import run


def test_a_formula(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "request -> F grant"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "request -> F grant",
        "  if request holds, then (at some step from now on grant holds)",
        "  mind: request -> F grant is about the first step only; for every step write G(request -> F grant)",
    ]
    assert run(["explain", "--finite", "WX a & F last", "--json"]) == 0
    (answer,) = json.loads(capsys.readouterr().out)["formulas"]
    assert answer["english"].startswith("(at the next step, if there is one, a holds), and (")


def test_two_formulas(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "a U b", "a W b", "--json"]) == 1
    apart = json.loads(capsys.readouterr().out)["apart"]
    assert apart["the first and not the second"] is None
    word = ltlc.parse_word(apart["the second and not the first"])
    assert ltlc.satisfies(ltlc.parse("a W b & !(a U b)"), word)
    assert run(["explain", "a U b", "b R (a | b) & F b"]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "the first and not the second: no word",
        "the second and not the first: no word",
    ]


def test_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "a &"]) == 2
    assert "has no right operand" in capsys.readouterr().err
    assert run(["explain", "--finite", "a", "b"]) == 2
    assert "on infinite words only" in capsys.readouterr().err
    assert run(["explain", "a", "GF a & GF b & FG c", "--max-states", "1"]) == 3
