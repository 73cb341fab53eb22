"""The site without Sphinx: cells run, pages are all in a table of contents, links lead to pages, every part has one.

`make docs` builds it as well, strictly, and looks at what was built.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import gymnasium
import pytest
from site_check import problems

from ltlc.agents import AGENTS
from ltlc.cli.app import run
from ltlc.rewards import SCHEMES
from ltlc.translate import TRANSLATORS

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "generated" not in path.parts)
CELL = re.compile(r"^```\{code-cell\} python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NOTEBOOKS = [path for path in PAGES if CELL.search(path.read_text(encoding="utf-8"))]


def name(path: Path) -> str:
    return path.relative_to(DOCS).with_suffix("").as_posix()


@cache
def generated() -> dict[str, str]:
    from site_pages import generated_pages

    return {f"generated/{path}": text for path, text in generated_pages()}


@cache
def texts() -> dict[str, str]:
    """Every page of the site by its path beneath docs."""
    return generated() | {path.relative_to(DOCS).as_posix(): path.read_text(encoding="utf-8") for path in PAGES}


@pytest.mark.slow
@pytest.mark.parametrize("page", NOTEBOOKS, ids=name)
def test_cells_run(page: Path, tmp_path: Path) -> None:
    cells = [re.sub(r"(?m)^:[\w-]+: .*\n", "", cell) for cell in CELL.findall(page.read_text(encoding="utf-8"))]
    (tmp_path / "page.py").write_text("\n\n".join(cells), encoding="utf-8")
    environ = os.environ | {"MPLBACKEND": "Agg", "PYTHONPATH": str(DOCS.parent)}
    command = [sys.executable, "-W", "ignore", "page.py"]
    done = subprocess.run(command, cwd=tmp_path, env=environ, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr


def test_a_newcomer_writes_25_lines() -> None:
    page = (DOCS / "howto" / "own-environment.md").read_text(encoding="utf-8").partition("## Make the answer exact")[0]
    lines = [line for cell in CELL.findall(page) for line in cell.splitlines() if line.strip()]
    assert len(lines) <= 25, f"{len(lines)} lines"


@pytest.mark.slow
def test_every_page_is_in_a_table_of_contents() -> None:
    listed = set()
    for path, text in texts().items():
        for body in re.findall(r"(?ms)^```\{toctree\}\n(.*?)^```$", text):
            for line in body.splitlines():
                if line.strip() and not line.startswith(":"):
                    entry = re.sub(r"^.*<(.*)>$", r"\1", line.strip())
                    listed.add(os.path.normpath(Path(path).parent / entry).replace(os.sep, "/") + ".md")
    assert listed == set(texts()) - {"index.md"}


@pytest.mark.slow
def test_links_lead_to_pages() -> None:
    lost = []
    for path, text in texts().items():
        prose = re.sub(r"(?ms)^```.*?^```$", "", text)
        for target in re.findall(r"\]\((?!https?:)([^)#\s]+)", prose):
            there = os.path.normpath(Path(path).parent / target).replace(os.sep, "/")
            known = there in texts() or (DOCS / there).exists() or there.endswith(".png")
            if not known and not there.startswith("../") and there not in ("CHANGELOG.md", "README.md"):
                lost.append(f"{path}: {target}")
    assert not lost


@pytest.mark.slow
def test_every_part_has_a_page() -> None:
    worlds = [world.replace("/", "-") for world in gymnasium.registry if world.startswith("ltlc/")]
    assert len(worlds) >= 8
    for folder, parts in (("worlds", worlds), ("rewards", SCHEMES), ("agents", AGENTS), ("constructions", TRANSLATORS)):
        assert {f"generated/{folder}/{part}.md" for part in parts} <= set(generated())


COMMANDS = re.compile(r"^ltlc .*$", re.MULTILINE)


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["worlds", "rewards", "agents", "constructions"])
def test_the_commands_and_programs_of_parts_run(
    folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import shlex
    import warnings

    monkeypatch.chdir(tmp_path)
    for path, text in generated().items():
        if not path.startswith(f"generated/{folder}/"):
            continue
        for command in re.findall(r"(?m)^```sh\n(.*)\n```$", text):
            words = shlex.split(re.sub(r" --steps \d+", "", command))[1:]
            short = ["--steps", "300", "--episode-steps", "20", "--quiet", "--force"] if words[0] == "train" else []
            assert run([*words, *short]) in (0, 1), f"{command}\n{capsys.readouterr().err}"
        for program in re.findall(r"(?ms)^```python\n(.*?)^```$", text):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                exec(compile(program, path, "exec"), {})  # a page of our own


def test_a_damaged_site_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<h1 id="top-of-a"></h1><a href="b.html#here">b</a><a href="c.html">c</a><a href="#top-of-a">up</a>'
        '<script src="https://cdn.example/x.js"></script><a href="https://example.org">out</a>'
    )
    (tmp_path / "b.html").write_text('<link rel="stylesheet" href="b.css">')
    (tmp_path / "b.css").write_text("@import url(https://fonts.example/f.css);")
    assert problems(tmp_path) == [
        "a.html: asks another host: https://cdn.example/x.js",
        "a.html: no such anchor: b.html#here",
        "a.html: leads nowhere: c.html",
        "b.css: asks another host: https://fonts.example/f.css",
    ]
