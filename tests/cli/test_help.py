"""Help, version, completion, and the lists of what there is."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import ltlc
from ltlc.agents import AGENTS
from ltlc.cli.app import run
from ltlc.rewards import SCHEMES
from ltlc.translate import TRANSLATORS


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


SENSORS = """
import gymnasium as gym
gym.register("mine/Corridor-v0", print)
gym.register(id="mine/Ring-v0", entry_point=print)
table = {"goal": lambda state: state == 15}
_hidden, LIMIT = {}, 3
def lake(state):
    return set()
"""


@pytest.mark.parametrize(
    ("words", "answers"),
    [
        (["--labels", ""], ["sensors:table", "sensors:lake"]),
        (["--labels", "sensors:l"], ["sensors:lake"]),
        (["--labels", "sensors", ":", "l"], ["lake"]),  # as bash has them
        (["--labels", "sensors", ":"], ["table", "lake"]),
        (["--labels", "sensors.py:ta"], ["sensors.py:table"]),
        (["--labels", "sub/more:"], ["sub/more:far"]),
        (["--labels", "sub/"], ["sub/more.py:far"]),
        (["--labels", "broken:"], []),
        (["--env", "sensors:"], ["sensors:mine/Corridor-v0", "sensors:mine/Ring-v0"]),
        (["--env", "sensors", ":", "mine/R"], ["mine/Ring-v0"]),
        (["--env", "ltlc/Thesis5"], ["ltlc/Thesis5x5-v0", "ltlc/Thesis5x5Dynamic-v0"]),
        (["--env", "Frozen"], ["FrozenLake-v1", "FrozenLake8x8-v1"]),
        (["-l", "sensors:lake", "--agent", "fit"], ["fitted-q"]),
    ],
)
def test_completion_of_environments_and_labels(
    words: list[str],
    answers: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sensors.py").write_text(SENSORS)
    (tmp_path / "broken.py").write_text("def (")
    (tmp_path / "sub" / "more.py").write_text("def far(state): ...")
    line = ["ltlc", "train", "F goal", *words]
    monkeypatch.setenv("_LTLC_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", "\n".join(f'"{word}"' if " " in word else word for word in line))
    monkeypatch.setenv("COMP_CWORD", str(len(line) - 1))
    assert run([]) == 0
    assert capsys.readouterr().out.splitlines() == answers


@pytest.mark.parametrize("option", ["--env", "--labels"])
def test_completion_imports_nothing_slow(option: str) -> None:
    code = (
        "import sys; from ltlc.cli.app import run; code = run([]); "
        "slow = {'torch', 'scipy', 'matplotlib'} & set(sys.modules); sys.exit(str(slow) if slow or code else 0)"
    )
    words = {"_LTLC_COMPLETE": "complete_bash", "COMP_WORDS": f"ltlc\ntrain\n{option}\n", "COMP_CWORD": "3"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=os.environ | words, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


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
