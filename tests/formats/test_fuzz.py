"""Any text at all ends in an automaton or in an `LtlcError`."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_automata import random_automata

from ltlc.automata import DRA
from ltlc.errors import FileFormatError, LtlcError
from ltlc.formats import from_hoa, from_json, read, to_hoa, to_json

HOA_WORDS = re.findall(
    r"\S+",
    "HOA: v1 States: Start: AP: Alias: Acceptance: acc-name: tool: name: properties: --BODY-- State: --END-- --ABORT-- "
    '[ ] ( ) { } ! & | t f 0 1 2 17 99999999999 @a @b "a" "b" "" Fin Inf Fin(0) Inf(!1) Rabin v9 /* */ x-y : " \\ é',
)
JSON_VALUES: list[Any] = [
    None,
    True,
    0,
    -1,
    1,
    3.5,
    1e308,
    10**30,
    "",
    "a",
    "!",
    "F a",
    "(" * 2000,
    "\ud800",
    [],
    [[]],
    {},
]

pytestmark = pytest.mark.filterwarnings("ignore::ltlc.ltl.LtlSyntaxWarning")


def survives(read_text: Callable[[str], DRA], text: str) -> None:
    try:
        assert isinstance(read_text(text), DRA)
    except LtlcError as error:
        assert str(error)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.text())
def test_any_text(text: str) -> None:
    survives(from_hoa, text)
    survives(from_json, text)


@pytest.mark.slow
@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.lists(st.sampled_from(HOA_WORDS), max_size=40))
def test_any_words_of_hoa(words: list[str]) -> None:
    survives(from_hoa, " ".join(words))
    survives(from_hoa, f"HOA: v1 Start: 0 Acceptance: 2 Fin(0)&Inf(1) {' '.join(words)} --END--")
    survives(from_hoa, f'HOA: v1 Start: 0 AP: 1 "a" Acceptance: 2 Fin(0)&Inf(1) --BODY-- {" ".join(words)} --END--')


def mutated(rng: random.Random, text: str) -> str:
    """The text with a few characters or stretches deleted, doubled, or exchanged."""
    for _ in range(rng.randint(1, 3)):
        i, j = sorted(rng.randrange(len(text) + 1) for _ in range(2))
        j = min(j, i + rng.choice([1, 1, 5, 60]))
        new = rng.choice(["", text[i:j] * 2, rng.choice(HOA_WORDS), chr(rng.randrange(0x250)), str(rng.randrange(40))])
        text = text[:i] + new + text[j:]
    return text


@pytest.mark.parametrize(("write_text", "read_text"), [(to_hoa, from_hoa), (to_json, from_json)])
def test_broken_files(write_text: Callable[[DRA], str], read_text: Callable[[str], DRA]) -> None:
    rng = random.Random(1)
    for automaton in random_automata(25):
        text = write_text(automaton)
        for _ in range(25):
            survives(read_text, mutated(rng, text))


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of all values inside a JSON document."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [*([path] if path else []), *(place for key, item in inside for place in places(item, (*path, key)))]


@pytest.mark.slow
def test_json_with_values_of_other_types() -> None:
    for automaton in random_automata(3, max_states=3):
        text = to_json(automaton)
        for *path, last in places(json.loads(text)):
            for value in JSON_VALUES:
                document = json.loads(text)
                place = document
                for key in path:
                    place = place[key]
                place[last] = value
                survives(from_json, json.dumps(document))


def test_any_bytes_in_a_file(tmp_path: Path) -> None:
    rng = random.Random(2)
    for i, suffix in enumerate([".json", ".hoa", ".txt"] * 10):
        path = tmp_path / f"{i}{suffix}"
        path.write_bytes(rng.randbytes(200))
        with pytest.raises(FileFormatError, match=rf"{i}{suffix}: "):
            read(path)
