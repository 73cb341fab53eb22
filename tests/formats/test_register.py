"""Formats of users: by suffix, by name, read back, and refused where they clash."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from ltlc import compile
from ltlc.automata import DRA
from ltlc.automata.formats import format_of_suffix
from ltlc.errors import FileFormatError, InvalidArgumentError, UnknownNameError
from ltlc.formats import FORMATS, Format, from_json, read, register_format, to_json, write


def as_backwards(automaton: DRA) -> str:
    return "<<" + to_json(automaton)[::-1]


def from_backwards(text: str) -> DRA:
    if not text.startswith("<<"):
        raise FileFormatError("does not begin with <<")
    return from_json(text[2:][::-1])


BACKWARDS = Format("backwards", (".nosj",), "JSON from its end.", as_backwards, from_backwards, ("<<",))


@pytest.fixture
def registered() -> Iterator[None]:
    register_format(BACKWARDS)
    yield
    FORMATS.remove("backwards")


@pytest.mark.usefixtures("registered")
def test_users_format_is_written_and_read(tmp_path: Path) -> None:
    automaton = compile("F a & G !b")
    path = write(automaton, tmp_path / "dra.NOSJ")
    assert path.read_text(encoding="utf-8") == as_backwards(automaton)
    assert to_json(read(path)) == to_json(automaton)
    nameless = path.rename(tmp_path / "dra")
    assert to_json(read(nameless)) == to_json(automaton)  # the content says what it is
    nameless.write_text("what?", encoding="utf-8")
    with pytest.raises(FileFormatError, match="backwards"):
        read(nameless)


@pytest.mark.parametrize("name", list(FORMATS))
def test_every_format_says_what_it_is(name: str) -> None:
    form = FORMATS[name]
    assert form.name == name and form.help.endswith(".")
    assert all(format_of_suffix(suffix.upper()) is form for suffix in form.suffixes)
    if form.reader is not None:
        automaton = compile("GF a -> GF b")
        text = form.write(automaton).decode("utf-8")
        assert text.startswith(form.begins)
        assert form.write(form.read(text)).decode("utf-8") == text


def test_the_manual_has_every_suffix_and_says_what_is_read_back() -> None:
    text = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1:4] for line in text.splitlines() if line.startswith("| `.")]
    told = {suffix: back.strip() == "yes" for which, _, back in rows for suffix in re.findall(r"`(\.\w+)`", which)}
    assert told == {suffix: form.reader is not None for form in FORMATS.values() for suffix in form.suffixes}


@pytest.mark.parametrize("suffixes", [(".hoa",), ("hoa",), (".HOAX",), (".",), (), ".hoax"])
def test_suffixes_that_cannot_be(suffixes: tuple[str, ...]) -> None:
    with pytest.raises(InvalidArgumentError, match="suffix"):
        register_format(Format("new", suffixes, "New.", as_backwards))
    assert "new" not in FORMATS


def test_what_is_no_format() -> None:
    with pytest.raises(InvalidArgumentError, match=r"no ltlc\.formats\.Format"):
        register_format(as_backwards)  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="format"):
        FORMATS["hao"]
    with pytest.raises(InvalidArgumentError, match="nothing reads the format 'dot'; json and hoa are read"):
        FORMATS["dot"].read("digraph {}")
