"""Whatever the documents tell a reader to type is typed here."""

from __future__ import annotations

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
GENERATED = ROOT / "docs" / "generated"
DOCUMENTS = sorted(path for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")] if GENERATED not in path.parents)
BLOCK = re.compile(r"^```([^`\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)")
PAGES = {"{code-cell} python", "{toctree}", "{include} ../README.md"}  # tests/house/test_docs.py


def blocks(language: str) -> list[tuple[str, str]]:
    """Every fenced block of a language, with the name of its document."""
    return [
        (document.name, body)
        for document in DOCUMENTS
        for found, body in BLOCK.findall(document.read_text(encoding="utf-8"))
        if found == language
    ]


@pytest.fixture
def shell(tmp_path: Path) -> dict[str, str]:
    """An environment in which `ltlc` is this checkout's command."""
    program = tmp_path / "bin" / "ltlc"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m ltlc "$@"\n')
    program.chmod(0o755)
    path = os.pathsep.join([str(program.parent), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}


@pytest.mark.parametrize(("document", "body"), blocks("sh"))
def test_shell_block(document: str, body: str, shell: dict[str, str], tmp_path: Path) -> None:
    lines = []
    for line in body.splitlines():
        if line.startswith("make "):
            target = line.split()[1]
            assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE), line
        elif line.startswith("pip install"):
            assert line == "pip install .", "tests/house/test_packaging.py covers this one only"
        else:
            lines.append(line)
    script = "set -eo pipefail\n" + "\n".join(lines)
    done = subprocess.run(
        ["bash", "-c", script], cwd=tmp_path, env=shell, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, f"{document}: {done.stdout}{done.stderr}"
    assert done.stderr == ""


@pytest.mark.parametrize(("document", "body"), blocks("pycon"))
def test_python_block(document: str, body: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import ltlc

    monkeypatch.chdir(tmp_path)
    example = doctest.DocTestParser().get_doctest(body, {"ltlc": ltlc}, document, document, 0)
    assert example.examples
    report: list[str] = []
    assert doctest.DocTestRunner().run(example, out=report.append).failed == 0, "".join(report)


@pytest.mark.parametrize(("document", "body"), blocks("json"))
def test_automaton_block(document: str, body: str) -> None:
    import ltlc
    from ltlc.formats import from_json, to_json

    automaton = from_json(body)
    assert to_json(automaton) == body
    assert automaton.formula is not None
    assert ltlc.compile(automaton.formula).to_json() == body  # what is written today, to the byte


def test_no_block_goes_untested() -> None:
    languages = {language for document in DOCUMENTS for language, _ in BLOCK.findall(document.read_text("utf-8"))}
    assert languages - PAGES <= {"sh", "pycon", "json", "python", "text"}  # python: test_contributing, test_recipes


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    targets = LINK.findall(document.read_text(encoding="utf-8"))
    paths = [(document.parent / target).resolve() for target in targets]
    assert not [path for path in paths if not path.exists() and GENERATED not in path.parents]
