"""`ltlc compile`, for one formula and for a file of formulas."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from cli_process import ROOT, ask, process

import ltlc
from ltlc.cli.app import run
from ltlc.formats import from_hoa, from_json, read_hoa_stream
from ltlc.translate import TRANSLATORS

needs_dot = pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
PHI_1 = "F(A & F B) & G!C & FG T"


class TestCompile:
    def test_summary_by_default(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["compile", PHI_1]) == 0
        out = capsys.readouterr().out
        assert out.startswith(str(ltlc.parse(PHI_1)))
        for fact in (
            "deterministic Rabin",
            "state-based",
            "persistence",
            "+0 infinitely often",
            "A B C T",
            "deadlocks",
            "distance",
            "nothing is accepted",
        ):
            assert fact in out

    @needs_dot
    def test_files_by_suffix(self, capsys: pytest.CaptureFixture[str], folder: Path) -> None:
        names = ["a.json", "a.hoa", "a.dot", "a.mmd", "a.svg", "A.PNG", "a.pdf"]
        assert run(["compile", "F a", *(word for name in names for word in ("-o", name))]) == 0
        assert sorted(path.name for path in folder.iterdir()) == sorted(names)
        assert capsys.readouterr().out == f"{', '.join(names)}: 2 states, 1 pair, state-based\n"
        assert ltlc.load("a.json").to_hoa() == ltlc.load("a.hoa").to_hoa() == ltlc.compile("F a").to_hoa()

    @pytest.mark.parametrize(
        ("form", "start"),
        [
            ("hoa", b"HOA: v1"),
            ("json", b"{"),
            ("dot", b"digraph"),
            pytest.param("svg", b"<?xml", marks=needs_dot),
            pytest.param("png", b"\x89", marks=needs_dot),
        ],
    )
    def test_format_on_standard_output(
        self, form: str, start: bytes, capfdbinary: pytest.CaptureFixture[bytes], folder: Path
    ) -> None:
        assert run(["compile", "F a", "--format", form]) == 0
        assert capfdbinary.readouterr().out.startswith(start)
        assert not list(folder.iterdir())

    def test_dash_is_standard_output(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["compile", "F a", "-o", "-", "-o", "a.json"]) == 0
        assert from_hoa(capsys.readouterr().out).n_states == 2
        assert Path("a.json").exists()

    def test_dash_is_standard_input(self, capsys: pytest.CaptureFixture[str], type_in: Callable[[str], None]) -> None:
        type_in("F a\n")
        assert run(["compile", "-", "--format", "json"]) == 0
        assert from_json(capsys.readouterr().out).formula == "F a"

    def test_json_summary(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["compile", "F a & G !b", "--json"]) == 0
        summary = json.loads(capsys.readouterr().out)
        dra = ltlc.compile("F a & G !b")
        assert summary["n_states"] == dra.n_states
        assert summary["deadlocks"] == list(dra.deadlocks)
        assert summary["pairs"] == [{"B": sorted(pair.fin), "G": sorted(pair.inf)} for pair in dra.pairs]
        assert summary["distance"][0] == 1

    def test_acceptance_and_translator(self, capsys: pytest.CaptureFixture[str]) -> None:
        for name in TRANSLATORS:
            code = run(["compile", "F a", "--acceptance", "transition", "--translator", name, "--json"])
            assert code == 0
            summary = json.loads(capsys.readouterr().out)
            assert summary["acceptance"] == "transition"

    def test_a_limit_leaves_nothing_behind(self, capsys: pytest.CaptureFixture[str], folder: Path) -> None:
        assert run(["compile", "GF a & GF b & FG c", "--max-states", "1", "-o", "a.json"]) == 3
        assert not list(folder.iterdir())
        error = capsys.readouterr().err
        assert error.startswith("ltlc: ")
        assert "max" in error

    def test_a_failed_write_keeps_the_old_file(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        Path("a.json").write_text("old")

        def fail(*_: object) -> None:
            raise OSError(28, "No space left on device", "a.json")

        monkeypatch.setattr(os, "replace", fail)
        assert run(["compile", "F a", "-o", "a.json"]) == 2
        assert [path.read_text() for path in folder.iterdir()] == ["old"]

    @pytest.mark.slow
    def test_same_bytes_for_every_hash_seed(self) -> None:
        outputs = set()
        for seed in ("0", "1", "2"):
            environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
            command = [sys.executable, "-m", "ltlc", "compile", "GF a -> G(b -> F c)", "--format", "json"]
            outputs.add(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
        assert len(outputs) == 1


class TestBatch:
    LINES = "# tasks\nF a\n\nG !b   // stay\nF a &\nGF c\n"

    def test_stream_of_hoa(self, capsys: pytest.CaptureFixture[str]) -> None:
        Path("tasks.txt").write_text("F a\nG !b\nGF c\n")
        assert run(["compile", "-F", "tasks.txt", "--format", "hoa"]) == 0
        automata = list(read_hoa_stream(capsys.readouterr().out))
        assert [automaton.formula for automaton in automata] == ["F a", "G !b", "G F c"]

    def test_a_bad_line_is_reported_and_the_rest_goes_on(
        self, capsys: pytest.CaptureFixture[str], type_in: Callable[[str], None]
    ) -> None:
        type_in(self.LINES)
        assert run(["compile", "-F", "-"]) == 2
        out, err = capsys.readouterr()
        assert out.count("HOA: v1") == out.count("--END--") == 3
        assert err.startswith("ltlc: standard input: line 5, column 5:")
        assert "  F a &\n" in err

    def test_a_limit_on_a_line(self, capsys: pytest.CaptureFixture[str], type_in: Callable[[str], None]) -> None:
        type_in("true\nGF a & GF b\ntrue\n")
        assert run(["compile", "-F", "-", "--max-states", "1"]) == 2
        out, err = capsys.readouterr()
        assert out.count("HOA: v1") == 2
        assert err.startswith("ltlc: standard input: line 2: ")

    def test_a_limit_on_the_time_of_a_line(
        self, capsys: pytest.CaptureFixture[str], type_in: Callable[[str], None]
    ) -> None:
        hard = " xor ".join(f"GF p{i}" for i in range(10))
        type_in(f"F a\n{hard}\nF b\n")
        assert run(["compile", "-F", "-", "--timeout", "0.3"]) == 2
        out, err = capsys.readouterr()
        assert out.count("HOA: v1") == 2
        assert err.startswith("ltlc: standard input: line 2: GF p0 xor GF p1 xor")
        assert "is not done after 0.3 s" in err

    def test_into_a_file(self, folder: Path, type_in: Callable[[str], None]) -> None:
        type_in("F a\nG b\n")
        assert run(["compile", "-F", "-", "-o", "all.hoa"]) == 0
        assert [path.name for path in folder.iterdir()] == ["all.hoa"]
        assert len(list(read_hoa_stream(Path("all.hoa").read_text()))) == 2

    def test_summaries_a_line_each(self, capsys: pytest.CaptureFixture[str], type_in: Callable[[str], None]) -> None:
        type_in("F a\nG b\n")
        assert run(["compile", "-F", "-", "--json"]) == 0
        assert [json.loads(line)["formula"] for line in capsys.readouterr().out.splitlines()] == ["F a", "G b"]

    @pytest.mark.slow
    def test_each_result_comes_before_the_next_line_is_read(self) -> None:
        child = process("compile", "-F", "-", stdin=subprocess.PIPE)
        for formula in ("F a", "G b"):
            assert f'name: "{formula}"' in ask(child, formula)
        child.communicate()
        assert child.returncode == 0


def test_a_limit_names_itself_and_the_way_out(capsys: pytest.CaptureFixture[str]) -> None:
    for flags, names in ((["--max-states", "1"], ["1", "max_states"]), (["--timeout", "1e-9"], ["timeout"])):
        assert run(["compile", "GF a & GF b & FG c", *flags, "-o", "a.json"]) == 3
        error = capsys.readouterr().err
        assert all(name in error for name in names)
        assert not Path("a.json").exists()


def test_names_that_look_like_operators(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "F Goal", "--json"]) == 0
    assert " ".join(capsys.readouterr().err.split()) == (
        'ltlc: warning: Goal is read as G oal; write that, or "Goal" in quotes for one proposition'
    )
