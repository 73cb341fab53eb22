"""JSON: round trips, the schema, versions, and every message of a wrong file."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from random_automata import random_automata

from ltlc.automata import DRA
from ltlc.automata.compare import equivalent
from ltlc.errors import FileFormatError
from ltlc.formats import from_json, to_json
from ltlc.version import __version__

ODD_NAMES = ("x < 1", 'say "hi"', "back\\slash", "Goal", "t", "naïve ∧", "new\nline")


def example() -> dict[str, Any]:
    """F a and never b: two pairs, a deadlock, marks on states."""
    automaton = DRA(
        aps=("a", "b"),
        delta=[[0, 1, 2], [1, 1, 2], [2, 2, 2]],
        letter_class=[0, 1, 2, 2],
        fin=[[1, 0, 0], [0, 0, 1]],
        inf=[[0, 1, 0], [0, 0, 0]],
        formula="F a & G !b",
        translator="by hand",
    )
    return dict(json.loads(to_json(automaton)))


@pytest.mark.slow
def test_round_trip_is_stable_and_keeps_the_language() -> None:
    for automaton in random_automata(60, max_aps=3):
        text = to_json(automaton)
        again = from_json(text)
        assert to_json(again) == text
        assert again.acceptance == automaton.acceptance
        assert again.n_states == automaton.n_states
        assert equivalent(again, automaton)


def test_odd_names_survive() -> None:
    n_letters = 2 ** len(ODD_NAMES)
    automaton = DRA(
        aps=ODD_NAMES,
        delta=[[0, 1], [1, 0]],
        letter_class=[letter.bit_count() % 2 for letter in range(n_letters)],
        fin=[[0, 1]],
        inf=[[1, 0]],
        formula='G "x < 1"',
        state_names=('"quoted"', "Ω"),
    )
    again = from_json(to_json(automaton))
    assert (again.aps, again.state_names, again.formula) == (ODD_NAMES, automaton.state_names, automaton.formula)
    assert to_json(again) == to_json(automaton)


def test_text_is_readable() -> None:
    lines = json.dumps(example())
    text = to_json(from_json(lines))
    assert '    {"source": 0, "target": 1, "guard": "a & !b"},\n' in text
    assert '    {"id": 2, "distance": null, "deadlock": true}\n' in text
    assert '    {"B": [0], "G": [1]},\n' in text
    assert '  "deadlocks": [2],\n' in text


@pytest.mark.slow
def test_schema_holds_for_what_is_written() -> None:
    for automaton in random_automata(20):
        schema().validate(json.loads(to_json(automaton)))


def schema() -> jsonschema.Draft202012Validator:
    content = json.loads(resources.files("ltlc.formats").joinpath("dra.schema.json").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(content)
    return jsonschema.Draft202012Validator(content)


@pytest.mark.parametrize(
    "change",
    [
        {"format": "dra"},
        {"version": "2.0"},
        {"n_states": 0},
        {"aps": ["a", "a"]},
        {"acceptance": "edge"},
        {"states": []},
    ],
)
def test_schema_refuses(change: dict[str, object]) -> None:
    assert not schema().is_valid(example() | change)


def test_minor_versions_load() -> None:
    """A newer minor version may add keys anywhere; they are passed over."""
    newer = example() | {"version": "1.7", "colour": "red"}
    newer["states"][0]["mood"] = {"deep": [1]}
    newer["transitions"][0]["probability"] = 1
    schema().validate(newer)
    assert equivalent(from_json(json.dumps(newer)), from_json(json.dumps(example())))


def test_what_is_computed_need_not_be_there() -> None:
    short = example()
    for key in ("tool", "formula", "translator", "deadlocks", "accepting_sinks"):
        del short[key]
    for state in short["states"]:
        del state["distance"]
    schema().validate(short)
    assert equivalent(from_json(json.dumps(short)), from_json(json.dumps(example())))


def put(path: str, value: object) -> dict[str, Any]:
    """The example with one value changed; `path` as in messages."""
    document = example()
    keys = path.replace("[", ".").replace("]", "").split(".")
    place: Any = document
    for key in keys[:-1]:
        place = place[int(key) if key.isdigit() else key]
    last = keys[-1]
    place[int(last) if last.isdigit() else last] = value
    return document


WRONG_DOCUMENTS = [
    ({"a": 1}, "the key 'format' is missing"),
    ([], "expected an object with the key 'format'"),
    (put("format", "dot"), "format: expected 'ltlc-dra', found \"dot\""),
    (put("version", "2.0"), "version: the file has version 2.0, this is ltlc"),
    (put("version", "0.9"), "version: there is no version 0.9"),
    (put("version", "one"), "version: expected a version like '1.0'"),
    (put("version", 1.0), "version: expected a string, found 1.0"),
    (put("aps", "ab"), 'aps: expected a list, found "ab"'),
    (put("aps", ["a", 3]), "aps[1]: expected a string, found 3"),
    (put("aps", ["a", ""]), "aps[1]: a proposition needs a name"),
    (put("aps", ["a", "a"]), "aps: a proposition is listed twice"),
    (put("aps", [str(i) for i in range(22)]), "aps: 22 propositions; at most 21"),
    (put("aps", ["a", "\ud800"]), "aps[1]: half of a surrogate pair"),
    (put("acceptance", "both"), "acceptance: expected 'state' or 'transition', found \"both\""),
    (put("initial_state", 3), "initial_state: 3 is out of range, there are 3 states"),
    (put("initial_state", -1), "initial_state: -1 is negative"),
    (put("initial_state", True), "initial_state: expected a number, found true"),
    (put("initial_state", 0.5), "initial_state: expected a number, found 0.5"),
    (put("n_states", 4), "n_states: there are 3 states"),
    (put("n_pairs", 1), "n_pairs: there are 2 pairs"),
    (put("states", []), "states: there is no state"),
    (put("states[1].id", 2), "states[1].id: states are listed in order, so this one is 1"),
    (put("states[1].name", "x"), "states: either all states have a name or none"),
    (put("states[1]", 7), "states[1]: expected an object, found 7"),
    (put("transitions[3]", None), "transitions[3]: expected an object, found null"),
    (put("transitions[3]", {"source": 0}), "transitions[3]: the key 'target' is missing"),
    (put("transitions[0].source", 9), "transitions[0].source: 9 is out of range, there are 3 states"),
    (put("transitions[0].target", 10**40), "transitions[0].target: a huge number is out of range"),
    (put("transitions[0].guard", "a &"), "transitions[0].guard: column 3: '&'"),
    (put("transitions[0].guard", "c"), "transitions[0].guard: 'c' is not one of aps"),
    (put("transitions[0].guard", "F a"), "transitions[0].guard: a guard is about one letter"),
    (put("transitions[0].guard", "a U b"), "cannot hold the temporal operator U"),
    (
        put("transitions[0].guard", "false"),
        "transitions: not complete: state 0 has no transition for the letter !a & !b",
    ),
    (put("transitions[0].guard", "true"), "transitions[1].guard: not deterministic: state 0 has this transition and "),
    (put("pairs[1].B", [0, 3]), "pairs[1].B[1]: 3 is out of range, there are 3 states"),
    (put("pairs[0]", {"B": []}), "pairs[0]: the key 'G' is missing"),
    (put("formula", 5), "formula: expected a string, found 5"),
]


@pytest.mark.parametrize(("document", "message"), WRONG_DOCUMENTS)
def test_wrong_document(document: object, message: str) -> None:
    with pytest.raises(FileFormatError) as caught:
        from_json(json.dumps(document))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1, column 1: not JSON: Expecting value"),
        ('{"format": "ltlc-dra",\n "version" "1.0"}', "line 2, column 12: not JSON"),
        ('{"a": 1, "a": 2}', "the key 'a' occurs twice in one object"),
        ('{"format": NaN}', "NaN is not a JSON number"),
        ('{"format": -Infinity}', "-Infinity is not a JSON number"),
        ("[" * 100_000, "nested too deeply"),
        ('{"n_states": ' + "9" * 10_000 + "}", "not JSON that can be read"),
    ],
)
def test_not_json(text: str, message: str) -> None:
    with pytest.raises(FileFormatError) as caught:
        from_json(text)
    assert message in str(caught.value)


def test_transition_marks_are_checked() -> None:
    document = example() | {"acceptance": "transition", "n_pairs": 1}
    for transition in document["transitions"]:
        transition |= {"B": [], "G": [0]}
    schema().validate(document)
    assert from_json(json.dumps(document)).inf.all()
    document["transitions"][2]["G"] = [1]
    with pytest.raises(FileFormatError, match=r"transitions\[2\]\.G\[0\]: 1 is out of range, there are 1 pairs"):
        from_json(json.dumps(document))
    with pytest.raises(FileFormatError, match="n_pairs: too many pairs"):
        from_json(json.dumps(document | {"n_pairs": 10**30}))


def test_the_example_of_the_documentation() -> None:
    page = Path(__file__).parents[2] / "docs" / "formats.md"
    text = page.read_text("utf-8").split("```json\n")[1].split("```")[0]
    assert to_json(from_json(text)) == text.replace('"ltlc 0.1.0"', f'"ltlc {__version__}"')
    schema().validate(json.loads(text))
