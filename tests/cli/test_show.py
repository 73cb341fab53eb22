"""`ltlc show`: the summary of an automaton."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import ltlc
from ltlc.cli.app import run

needs_dot = pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")


class TestShow:
    def test_the_same_summary_for_formula_and_files(self, capsys: pytest.CaptureFixture[str]) -> None:
        summaries = []
        dra = ltlc.compile("G(a -> F b)")
        for source in ("G(a -> F b)", str(dra.save("a.json")), str(dra.save("a.hoa"))):
            assert run(["show", source, "--json"]) == 0
            summary = json.loads(capsys.readouterr().out)
            del summary["translator"]  # HOA does not say
            summaries.append(summary)
        assert summaries[0] == summaries[1] == summaries[2]

    @needs_dot
    def test_picture(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["show", "F a", "-o", "a.svg"]) == 0
        assert "<svg" in Path("a.svg").read_text()
        assert capsys.readouterr().out.startswith("F a\n")

    def test_automaton_on_standard_input(
        self, capsys: pytest.CaptureFixture[str], type_in: Callable[[str], None]
    ) -> None:
        for text in (ltlc.compile("F a").to_hoa(), ltlc.compile("F a").to_json(), "F a"):
            type_in(text)
            assert run(["show", "-", "--json"]) == 0
            assert json.loads(capsys.readouterr().out)["formula"] == "F a"

    def test_many_states_are_cut_short(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["show", f"{'X ' * 80}a"]) == 0
        assert "more states; --json lists them all" in capsys.readouterr().out

    def test_transition_marks(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["show", "GF a", "--acceptance", "transition"]) == 0
        assert "a → 0 +0" in capsys.readouterr().out

    @pytest.mark.slow
    def test_a_limit_on_the_time_of_a_file(self, capsys: pytest.CaptureFixture[str]) -> None:
        ltlc.compile("X " * 300 + "a").save("a.hoa")
        for options in (["-o", "a.json"], ["--json"], []):
            assert run(["show", "a.hoa", "--timeout", "1e-9", *options]) == 3
            assert "a.hoa is not done after 1e-09 s" in capsys.readouterr().err
        assert not Path("a.json").exists()
        assert run(["show", "a.hoa", "--timeout", "0"]) == 2
