"""Help, version, completion, and the lists of what there is."""

from __future__ import annotations

import json

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
