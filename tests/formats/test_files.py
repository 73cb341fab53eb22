"""Files: format by suffix or content, all or nothing."""

from __future__ import annotations

import os
import re
import stat
import sys
from pathlib import Path

import numpy as np
import pytest
from random_automata import random_automaton

import ltlc
from ltlc.atomic import atomic_write
from ltlc.automata import DRA, canonical, equivalent, to_parity
from ltlc.envs import recorded_automaton
from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.formats import from_json, read, read_hoa_stream, to_dot, to_hoa, to_json, to_mermaid, write


def automaton() -> DRA:
    return random_automaton(np.random.default_rng(5), 4, 2, 2, "transition")


@pytest.mark.parametrize(
    ("suffix", "content"), [(".json", to_json), (".hoa", to_hoa), (".dot", to_dot), (".mmd", to_mermaid)]
)
def test_suffix_names_the_format(tmp_path: Path, suffix: str, content: object) -> None:
    path = write(automaton(), tmp_path / f"a{suffix}")
    assert path.read_text("utf-8") == content(automaton())  # type: ignore[operator]


def test_markdown_fence(tmp_path: Path) -> None:
    text = write(automaton(), tmp_path / "a.md").read_text("utf-8")
    assert text == f"```mermaid\n{to_mermaid(automaton())}```\n"


@pytest.mark.parametrize("suffix", [".json", ".hoa", ".JSON"])
def test_read_back(tmp_path: Path, suffix: str) -> None:
    path = write(automaton(), tmp_path / f"a{suffix}")
    assert to_json(read(path)) == to_json(automaton())


def test_content_decides_without_a_known_suffix(tmp_path: Path) -> None:
    for text in (to_json(automaton()), to_hoa(automaton()), "\ufeff /* x */ " + to_hoa(automaton())):
        path = tmp_path / "automaton"
        path.write_text(text, encoding="utf-8")
        assert to_json(read(path)) == to_json(automaton())


def test_errors_name_the_file(tmp_path: Path) -> None:
    path = tmp_path / "wrong.json"
    path.write_text('{"format": "ltlc-dra", "version": "3.1"}')
    with pytest.raises(FileFormatError, match=re.escape(f"{path}: version: the file has version 3.1")):
        read(path)
    path = tmp_path / "wrong.txt"
    path.write_text("never mind")
    with pytest.raises(FileFormatError, match=r"neither JSON .* nor HOA"):
        read(path)
    path.write_bytes(b"HOA: v1 \xff")
    with pytest.raises(FileFormatError, match=r"not UTF-8 text \(byte 8\)"):
        read(path)
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "missing.hoa")


def test_unknown_suffix(tmp_path: Path) -> None:
    message = r"'\.xml'; known are \.json \.hoa \.dot \.mmd \.md \.svg \.png \.pdf"
    with pytest.raises(InvalidArgumentError, match=message):
        write(automaton(), tmp_path / "a.xml")
    assert list(tmp_path.iterdir()) == []


def test_failure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.json"
    path.write_text("old")

    def fail(*_: object) -> None:
        raise OSError("the disk is gone")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="the disk is gone"):
        write(automaton(), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        atomic_write(tmp_path / "no" / "a.json", "x")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX permissions")
def test_permissions(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        new = atomic_write(tmp_path / "new", "x")
    finally:
        os.umask(before)
    assert stat.S_IMODE(new.stat().st_mode) == 0o640
    new.chmod(0o604)
    atomic_write(new, b"\x00y")
    assert stat.S_IMODE(new.stat().st_mode) == 0o604
    assert new.read_bytes() == b"\x00y"


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights on Windows")
def test_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    atomic_write(tmp_path / "link", "new\n")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new\n"


def test_every_automaton_can_write_itself(tmp_path: Path) -> None:
    """However it was made: compiled, recorded, read from a stream, or made by a transformation."""
    compiled = ltlc.compile("F a & G !b")
    made = [compiled, recorded_automaton("phi_1"), *read_hoa_stream(compiled.to_hoa())]
    made += [to_parity(compiled).automaton, canonical(compiled), from_json(compiled.to_json())]
    for i, dra in enumerate(made):
        assert isinstance(dra, ltlc.DRA)
        assert equivalent(ltlc.load(dra.save(tmp_path / f"{i}.json")), dra)
        assert equivalent(ltlc.load(dra.save(tmp_path / f"{i}.hoa")), dra)
        assert dra.to_dot().startswith("digraph") and dra.to_mermaid() and dra.size in repr(dra)
