"""The tables of the documents say what the registries hold; where one differs, its right lines are shown."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pytest

from ltlc.agents import AGENTS
from ltlc.envs import LABELLERS
from ltlc.rewards import SCHEMES
from ltlc.translate import TRANSLATORS

DOCS = Path(__file__).parents[2] / "docs"


def table(document: str, heading: str) -> list[str]:
    """The lines of the table with a heading, without it."""
    text = (DOCS / document).read_text(encoding="utf-8")
    _, _, rest = text.partition(f"\n{heading}\n")
    return [line for line in rest.partition("\n\n")[0].splitlines() if not line.startswith("|---")]


def lines(rows: Iterable[tuple[str, ...]]) -> list[str]:
    return [f"| `{name}` | {' | '.join(cells)} |" for name, *cells in rows]


@pytest.mark.parametrize(
    ("document", "heading", "rows"),
    [
        (
            "semantics.md",
            "| scheme | requires | guarantee |",
            [(name, scheme.requires, scheme.guarantee) for name, scheme in SCHEMES.items()],
        ),
        (
            "architecture.md",
            "| construction | takes |",
            [(name, construction.description) for name, construction in TRANSLATORS.items()],
        ),
    ],
)
def test_table(document: str, heading: str, rows: list[tuple[str, ...]]) -> None:
    assert table(document, heading) == lines(rows), "\n".join(lines(rows))


def test_table_of_agents() -> None:
    told = {
        name: goes_by.strip()
        for names, _, goes_by in (row.split("|")[1:4] for row in table("runs.md", "| agent | learns | goes by |"))
        for name in re.findall(r"`([\w-]+)`", names)
    }
    assert told == {name: "rewards" if entry.uses_rewards else "automaton" for name, entry in AGENTS.items()}


def test_there_is_no_table_of_labels() -> None:
    assert not LABELLERS  # but what users and installed packages register
