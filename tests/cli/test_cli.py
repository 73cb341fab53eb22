"""The commands: what they print, where they write, and with which exit code they end."""

from __future__ import annotations

import io
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import ltlc
from ltlc.agents import AGENTS
from ltlc.cli.app import run
from ltlc.formats import from_hoa, from_json, read_hoa_stream
from ltlc.rewards import SCHEMES
from ltlc.translate import TRANSLATORS

ROOT = Path(__file__).parents[2]
needs_dot = pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
PHI_1 = "F(A & F B) & G!C & FG T"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Every test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def type_in(monkeypatch: pytest.MonkeyPatch):
    """Give a command its standard input."""
    return lambda text: monkeypatch.setattr(sys, "stdin", io.StringIO(text))


def process(*arguments: str, **options: object) -> subprocess.Popen[str]:
    """The command as a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "ltlc", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.Popen(command, env=environment, text=True, **pipes)  # type: ignore[call-overload]


def ask(child: subprocess.Popen[str], formula: str) -> str:
    """Give a batch one more line, and take the automaton that comes out."""
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdin.write(f"{formula}\n")
    child.stdin.flush()
    text = ""
    for line in iter(child.stdout.readline, ""):
        text += line
        if line == "--END--\n":
            break
    return text


@pytest.mark.slow
def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([]) == 0
    listing = capsys.readouterr().out
    for command in ("compile", "show", "check", "translators"):
        assert command in listing
        assert run([command, "--help"]) == 0
        text = capsys.readouterr().out
        assert command == "translators" or f"ltlc {command}" in text[text.index("Examples:") :]


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"ltlc {ltlc.__version__}\n"


def test_shell_completion(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shellingham.detect_shell", lambda *_: ("bash", "/bin/bash"))  # there may be none around
    assert run(["--show-completion", "bash"]) == 0
    assert "_LTLC_COMPLETE=complete_bash" in capsys.readouterr().out
    monkeypatch.setenv("_LTLC_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", "ltlc compile --translator au")
    monkeypatch.setenv("COMP_CWORD", "3")
    assert run([]) == 0
    assert capsys.readouterr().out.split() == ["auto"]


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

    def test_dash_is_standard_input(self, capsys: pytest.CaptureFixture[str], type_in) -> None:
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

    def test_a_bad_line_is_reported_and_the_rest_goes_on(self, capsys: pytest.CaptureFixture[str], type_in) -> None:
        type_in(self.LINES)
        assert run(["compile", "-F", "-"]) == 2
        out, err = capsys.readouterr()
        assert out.count("HOA: v1") == out.count("--END--") == 3
        assert err.startswith("ltlc: standard input: line 5, column 5:")
        assert "  F a &\n" in err

    def test_a_limit_on_a_line(self, capsys: pytest.CaptureFixture[str], type_in) -> None:
        type_in("true\nGF a & GF b\ntrue\n")
        assert run(["compile", "-F", "-", "--max-states", "1"]) == 2
        out, err = capsys.readouterr()
        assert out.count("HOA: v1") == 2
        assert err.startswith("ltlc: standard input: line 2: ")

    def test_a_limit_on_the_time_of_a_line(self, capsys: pytest.CaptureFixture[str], type_in) -> None:
        hard = " xor ".join(f"GF p{i}" for i in range(10))
        type_in(f"F a\n{hard}\nF b\n")
        assert run(["compile", "-F", "-", "--timeout", "0.3"]) == 2
        out, err = capsys.readouterr()
        assert out.count("HOA: v1") == 2
        assert err.startswith("ltlc: standard input: line 2: GF p0 xor GF p1 xor")
        assert "is not done after 0.3 s" in err

    def test_into_a_file(self, folder: Path, type_in) -> None:
        type_in("F a\nG b\n")
        assert run(["compile", "-F", "-", "-o", "all.hoa"]) == 0
        assert [path.name for path in folder.iterdir()] == ["all.hoa"]
        assert len(list(read_hoa_stream(Path("all.hoa").read_text()))) == 2

    def test_summaries_a_line_each(self, capsys: pytest.CaptureFixture[str], type_in) -> None:
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

    def test_automaton_on_standard_input(self, capsys: pytest.CaptureFixture[str], type_in) -> None:
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

    def test_word_on_standard_input(self, type_in) -> None:
        type_in("cycle{a}")
        assert run(["check", "F a", "--word", "-"]) == 0

    def test_a_proposition_nobody_knows(self, capsys: pytest.CaptureFixture[str]) -> None:
        for source in ("F a", str(ltlc.compile("F a").save("a.json"))):
            assert run(["check", source, "--word", "b; cycle{a}"]) == 0
            assert capsys.readouterr().err == f"ltlc: warning: nothing in {source} depends on b\n"


@pytest.mark.parametrize(
    ("command", "registry", "says"),
    [
        ("translators", TRANSLATORS, "description"),
        ("rewards", SCHEMES, "guarantee"),
        ("agents", AGENTS, "hyperparameters"),
    ],
)
def test_registries(command: str, registry: dict[str, object], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command]) == 0
    listing = capsys.readouterr().out.splitlines()
    assert run([command, "--json"]) == 0
    entries = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in entries] == list(registry)
    for entry in entries:
        assert entry["name"] in listing
        assert entry["citation"]
        assert entry[says]


class TestProcess:
    @pytest.mark.slow
    def test_compile_loads_nothing_heavy(self) -> None:
        heavy = ["torch", "gymnasium", "scipy", "matplotlib", "graphviz", "rich"]
        code = (
            "import sys; from ltlc.cli.app import run; "
            f"run(['compile', {PHI_1!r}, '-o', 'dra.json']); print(*[m for m in {heavy} if m in sys.modules])"
        )
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout.splitlines()[-1] == ""

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
