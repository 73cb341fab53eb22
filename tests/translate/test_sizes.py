"""Sizes of automata over the formulas of tests/formulas/, against those recorded in tests/golden/sizes.json.

`python tests/translate/test_sizes.py --regenerate` records them anew, and says what became smaller and larger.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from formula_families import families

from ltlc.automata.rabin import AcceptanceKind
from ltlc.errors import InvalidArgumentError, StateLimitExceeded
from ltlc.ltl import parse
from ltlc.translate import TRANSLATORS, Options, translate

HERE = Path(__file__).parents[1]
GOLDEN = HERE / "golden" / "sizes.json"
MAX_STATES = 60
"""for a single construction; "auto" has no limit, so every formula has a size."""
REGENERATE = "python tests/translate/test_sizes.py --regenerate"

Row = dict[str, int | None]
"""column -> states, None where the construction does not apply or has more than `MAX_STATES` on the way."""


def measured(text: str) -> Row:
    """Transition-based states without the rejecting sink per construction, and all states of state-based output."""
    row: Row = {"state-based": size(text, "auto", "state")}
    row |= {name: size(text, name, "transition") for name in ("auto", *TRANSLATORS)}
    return row


def size(text: str, translator: str, acceptance: AcceptanceKind) -> int | None:
    limit = 100_000 if translator == "auto" else MAX_STATES
    try:
        automaton = translate(parse(text), Options(translator=translator, acceptance=acceptance, max_states=limit))
    except (InvalidArgumentError, StateLimitExceeded):
        return None
    sink = len(automaton.deadlocks) if acceptance == "transition" else 0
    return automaton.n_states - sink


def changes(old: dict[str, Row], new: dict[str, Row]) -> Iterator[tuple[bool, str]]:
    """(is it larger?, what changed) for each size that is not the recorded one; None counts as larger than any."""
    for text, row in new.items():
        for column, now in row.items():
            before = old.get(text, {}).get(column)
            if now != before:
                larger = before is not None and (now is None or now > before)
                yield larger, f"{text}: {column} has {now} states, recorded {before}"


@pytest.mark.slow
@pytest.mark.parametrize("family", families())
def test_sizes(family: str) -> None:
    golden: dict[str, Row] = json.loads(GOLDEN.read_text(encoding="utf-8")).get(family, {})
    texts = families()[family]
    assert sorted(golden) == sorted(texts), f"other formulas than recorded; {REGENERATE}"
    found = list(changes(golden, {text: measured(text) for text in texts}))
    larger = [what for is_larger, what in found if is_larger]
    assert not larger, "\n".join(["larger than recorded:", *larger])
    assert not found, "\n".join([f"smaller than recorded, so record it: {REGENERATE}", *(what for _, what in found)])


def test_auto_is_the_smallest_of_all() -> None:
    """But for the single constructions it leaves out; those must not be what a family needs."""
    for texts in json.loads(GOLDEN.read_text(encoding="utf-8")).values():
        for text, row in texts.items():
            assert row.keys() >= {"auto", *TRANSLATORS}, f"not all constructions are recorded; {REGENERATE}"
            others = [row[name] for name in TRANSLATORS if row[name] is not None]
            assert row["auto"] is not None
            assert not others or row["auto"] <= min(others), text


def regenerate() -> None:
    old = json.loads(GOLDEN.read_text(encoding="utf-8")) if GOLDEN.exists() else {}
    new = {family: {text: measured(text) for text in texts} for family, texts in families().items()}
    for family, rows in new.items():
        for is_larger, what in changes(old.get(family, {}), rows):
            print("larger " if is_larger else "smaller", what)
    blocks = []
    for family, rows in new.items():
        lines = (f"  {json.dumps(text)}: {json.dumps(row)}" for text, row in rows.items())
        blocks.append(f" {json.dumps(family)}: {{\n" + ",\n".join(lines) + "\n }")
    GOLDEN.parent.mkdir(exist_ok=True)
    GOLDEN.write_text("{\n" + ",\n".join(blocks) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:] != ["--regenerate"]:
        sys.exit(f"usage: {REGENERATE}")
    regenerate()
