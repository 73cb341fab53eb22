"""`ltlc check`: which words a formula or an automaton accepts, and why not."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

import ltlc
from ltlc.cli.app import run

PHI_1 = "F(A & F B) & G!C & FG T"


class TestCheck:
    def test_a_limit_on_time(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["check", "F a", "--word", "cycle{a}", "--timeout", "1e-9"]) == 3
        assert "F a is not done after 1e-09 s" in capsys.readouterr().err

    @pytest.mark.parametrize(("word", "code"), [("a; b; cycle{!a}", 0), ("a; cycle{!a}", 1), ("cycle{a; b}", 0)])
    def test_formula_and_files_agree(self, word: str, code: int) -> None:
        formula = "G(a -> F b)"
        dra = ltlc.compile(formula)
        for source in (formula, str(dra.save("a.json")), str(dra.save("a.hoa"))):
            assert run(["check", source, "--word", word]) == code

    def test_says_which_part_fails(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["check", PHI_1, "--word", "A; C; B; cycle{T}"]) == 1
        out = capsys.readouterr().out
        assert out.startswith("rejected: ")
        assert "G !C" in out
        assert "F G T" not in out

    def test_a_formula_that_could_be_a_file(self) -> None:
        assert run(["check", " & ".join(["F a.b"] * 100), "--word", "cycle{a.b}"]) == 0

    def test_several_words(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["check", "F a", "-w", "cycle{a}", "-w", "cycle{!a}"]) == 1
        assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == ["accepted", "rejected"]

    def test_json(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["check", "F a & G b", "--json", "--word", "cycle{b}"]) == 1
        [verdict] = json.loads(capsys.readouterr().out)
        assert (verdict["accepted"], verdict["violated"]) == (False, ["F a"])

    def test_word_on_standard_input(self, type_in: Callable[[str], None]) -> None:
        type_in("cycle{a}")
        assert run(["check", "F a", "--word", "-"]) == 0

    def test_a_proposition_nobody_knows(self, capsys: pytest.CaptureFixture[str]) -> None:
        for source in ("F a", str(ltlc.compile("F a").save("a.json"))):
            assert run(["check", source, "--word", "b; cycle{a}"]) == 0
            assert capsys.readouterr().err == f"ltlc: warning: nothing in {source} depends on b\n"
