"""What the command line loads, and how it ends when it is interrupted or left alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from cli_process import ROOT, ask, process

from ltlc.cli.app import run

PHI_1 = "F(A & F B) & G!C & FG T"
OTHER_WAYS = [
    "ltlc.automata.forms",
    "ltlc.automata.parity",
    "ltlc.ltl.english",
    "ltlc.minimize",
    "ltlc.translate.determinisation",
    "ltlc.translate.finite",
    "ltlc.translate.general",
    "ltlc.translate.memory",
]
"""what a formula that progression translates does without."""


class TestProcess:
    @pytest.mark.slow
    @pytest.mark.parametrize(("arguments", "heavy"), [
        (["compile", "F a"], ["typer", "rich", "numpy", *OTHER_WAYS]),
        (["compile", "F(a & F b) & G !c", "-o", "dra.json"], ["typer", "rich", "numpy", *OTHER_WAYS]),
        (["compile", "a U (b & X c)", "--format", "hoa"], ["typer", "rich", "numpy"]),
        (["compile", PHI_1], ["typer", "rich"]),
        (["compile", PHI_1, "-o", "dra.json"], ["typer", "rich"]),
        (["compile", PHI_1, "--format", "hoa"], ["typer", "rich", "ltlc.formats.hoa_reader", "ltlc.formats.dot"]),
        (["--version"], ["rich", "numpy", "ltlc.ltl", "ltlc.automata"]),
        (["--help"], ["numpy", "ltlc.ltl", "ltlc.automata"]),
    ])  # fmt: skip
    def test_nothing_heavy_is_loaded(self, arguments: list[str], heavy: list[str]) -> None:
        never = ["torch", "gymnasium", "scipy", "matplotlib", "graphviz", "lark", "importlib.metadata"]
        code = (
            "import sys; from ltlc.cli.app import run; "
            f"run({arguments}); print(); print(*[m for m in {never + heavy} if m in sys.modules])"
        )
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "120"}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout.splitlines()[-1] == ""

    @pytest.mark.slow
    def test_files_of_others_are_written_to_the_end(self, tmp_path: Path) -> None:
        (tmp_path / "sensors.py").write_text(
            "class Sensors:\n"
            "    def __init__(self):\n"
            "        self.file, self.cycle = open('seen.txt', 'w'), self\n"
            "    def see(self, state):\n"
            "        self.file.write(f'{state}\\n')\n"
            "        return {'goal'} if state == 15 else set()\n"
            "label = Sensors().see\n"
        )
        arguments = ["solve", "F goal", "-e", "FrozenLake-v1", "-l", "sensors:label"]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-m", "ltlc", *arguments]
        subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, check=True)
        assert (tmp_path / "seen.txt").read_text().split()[-1] == "15"

    @pytest.mark.slow
    @pytest.mark.parametrize("arguments", [
        ["agents"],
        ["rewards"],
        ["faithful", "F A", "-e", "ltlc/Thesis5x5-v0", "-r", "eventual"],
        ["solve", "F A", "-e", "ltlc/Thesis5x5-v0", "-o", "policy.png"],
    ])  # fmt: skip
    def test_only_learning_loads_torch(self, arguments: list[str]) -> None:
        code = f"import sys; from ltlc.cli.app import run; print(run({arguments!r}), 'torch' in sys.modules)"
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout.splitlines()[-1] == "0 False"

    @pytest.mark.slow
    def test_a_reader_that_goes_away(self) -> None:
        Path("many.txt").write_text("GF a & GF b & FG !c\n" * 2000)
        child = process("compile", "-F", "many.txt")
        assert child.stdout is not None
        assert child.stderr is not None
        assert child.stdout.readline() == "HOA: v1\n"
        child.stdout.close()
        assert child.stderr.read() == ""
        assert child.wait(timeout=60) == -signal.SIGPIPE
        child.stderr.close()

    @pytest.mark.slow
    def test_interrupted(self, folder: Path) -> None:
        child = process("compile", "-F", "-", "-o", "-", "-o", "all.hoa", stdin=subprocess.PIPE)
        assert ask(child, "F a").endswith("--END--\n")  # and then it waits for the next line
        child.send_signal(signal.SIGINT)
        _, error = child.communicate(timeout=60)
        assert child.returncode == 130
        assert "Traceback" not in error
        assert not list(folder.iterdir())

    def test_a_bug_is_told_from_a_negative_answer(
        self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("ltlc.compiler.translate", lambda *_, **__: 1 / 0)
        assert run(["compile", "F a"]) == 70
        error = capsys.readouterr().err
        assert "ZeroDivisionError" in error
        assert error.endswith("ltlc: this is a bug; please report it with the lines above\n")


@pytest.mark.slow
@pytest.mark.parametrize("columns", ["0", "1", "nonsense"])
def test_a_width_in_which_nothing_can_be_read_is_none(columns: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    out, err = process("compile", "F a").communicate()
    assert "2 states, 1 pair, state-based" in out
    assert err == ""
