"""Tables without rich: the same bytes as with it."""

from __future__ import annotations

import random
import sys

import pytest

from ltlc.cli import tables
from ltlc.cli.tables import Column, Row, Table, print_line, print_table

WORDS = ("", "a", "a b", "!a & b", "→ 12", "−0 +1", "∞", "enough for a line of its own", "[bold]", ":smile:", "b" * 30)
NOT_PLAIN = ("\t", "ü", "宇宙", "\x1b[1m", "a\u0301")


def random_table(rng: random.Random, words: tuple[str, ...]) -> Table:
    columns = [Column(rng.choice(("", "state", "marks")), rng.random() < 0.5) for _ in range(rng.randint(1, 5))]
    rows = [
        Row(["\n".join(rng.choices(words, k=rng.randint(1, 3))) for _ in columns], rng.choice(("", "red", "dim")))
        for _ in range(rng.randint(1, 4))
    ]
    return Table(columns, rows, ruled=rng.random() < 0.5)


@pytest.mark.parametrize("columns", ["", "0", "20", "60", "200"])
@pytest.mark.parametrize("words", [WORDS, WORDS + NOT_PLAIN])
def test_plain_text_is_what_rich_prints(
    words: tuple[str, ...], columns: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = random.Random(columns)
    monkeypatch.setenv("COLUMNS", columns)
    for _ in range(60):
        table, line = random_table(rng, words), " ".join(rng.choices(words, k=3))
        print_table(table)
        print_line(line, style="bold")
        found = capsys.readouterr().out
        with monkeypatch.context() as without:
            without.setattr(tables, "_plain_width", lambda: None)
            print_table(table)
            print_line(line, style="bold")
        assert found == capsys.readouterr().out


@pytest.mark.parametrize("name", ["FORCE_COLOR", "TTY_COMPATIBLE"])
def test_what_is_styled_is_left_to_rich(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(name, "1")
    monkeypatch.setenv("TERM", "xterm")
    print_line("F a", style="bold")
    assert capsys.readouterr().out == "\x1b[1mF a\x1b[0m\n"


def test_signs_that_cannot_be_encoded_are_left_to_rich(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(sys.stdout), "encoding", "latin-1", raising=False)
    assert tables._plain_width() is None
