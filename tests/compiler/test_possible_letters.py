"""Formulas over possible letters: exclusive propositions, and lists of letters."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from random_ltl import random_formula

import ltlc
from ltlc.automata import DFA, counterexample, equivalent, included
from ltlc.errors import AlphabetLimitExceeded, FileFormatError, ImpossibleLetterError, InvalidArgumentError
from ltlc.formats import from_hoa
from ltlc.formats.json import from_json
from ltlc.ltl import And, LassoWord, parse, satisfies, satisfies_trace

NAMES = ("a", "b", "c")
ROOMS = [f"room{i}" for i in range(100)]


def sequence(names: Sequence[str]) -> str:
    return "".join(f"F({name} & " for name in names[:-1]) + f"F {names[-1]}" + ")" * (len(names) - 1)


def random_declaration(rng: random.Random) -> tuple[dict[str, object], list[frozenset[str]]]:
    """What is declared, and the letters over a, b, c that it leaves."""
    everything = [frozenset(n for i, n in enumerate(NAMES) if mask >> i & 1) for mask in range(8)]
    if rng.random() < 0.5:
        letters = rng.sample(everything, rng.randint(1, 7))
        return {"letters": letters}, letters
    groups = [set(rng.sample(NAMES, rng.randint(2, 3))) for _ in range(rng.randint(1, 2))]
    return {"exclusive": groups}, [a for a in everything if all(len(a & group) <= 1 for group in groups)]


def test_random_formulas_on_possible_words() -> None:
    rng = random.Random(0)
    n_fewer = 0
    for _ in range(150):
        formula = random_formula(rng, rng.randint(2, 9), NAMES)
        declaration, letters = random_declaration(rng)
        automaton = ltlc.compile(formula, acceptance=rng.choice(("state", "transition")), **declaration)  # type: ignore[call-overload]
        free = ltlc.compile(formula, acceptance=automaton.acceptance)
        assert automaton.n_states <= free.n_states + 1
        n_fewer += automaton.n_states < free.n_states
        for _ in range(20):
            word = LassoWord(
                tuple(rng.choice(letters) for _ in range(rng.randint(0, 3))),
                tuple(rng.choice(letters) for _ in range(rng.randint(1, 3))),
            )
            own = [[letter & set(automaton.aps) for letter in part] for part in (word.prefix, word.cycle)]
            assert automaton.accepts(*own) == satisfies(formula, word)
        assert equivalent(automaton, free)
        assert included(free, automaton)
    assert n_fewer > 20


def test_random_formulas_on_possible_traces() -> None:
    rng = random.Random(1)
    for _ in range(150):
        formula = random_formula(rng, rng.randint(2, 9), NAMES)
        declaration, letters = random_declaration(rng)
        dfa = ltlc.compile(formula, finite=True, **declaration)  # type: ignore[call-overload]
        again = dfa.minimal()
        assert again.n_states == dfa.n_states
        assert dfa.n_states <= ltlc.compile(formula, finite=True).n_states
        for _ in range(20):
            trace = tuple(rng.choice(letters) for _ in range(rng.randint(1, 5)))
            assert dfa.accepts([letter & set(dfa.aps) for letter in trace]) == satisfies_trace(formula, trace)


def test_files_say_which_letters_are_possible(tmp_path: Path) -> None:
    rng = random.Random(2)
    for number in range(60):
        formula = random_formula(rng, rng.randint(2, 8), NAMES)
        declaration, _ = random_declaration(rng)
        finite = number % 3 == 0
        automaton = ltlc.compile(formula, finite=finite, **declaration)  # type: ignore[call-overload]
        for suffix in ("json", "hoa"):
            read = ltlc.load(automaton.save(tmp_path / f"automaton.{suffix}"))
            assert isinstance(read, DFA) == finite
            assert read.possible == automaton.possible
            for name in ("delta", "letter_class", "fin", "inf"):
                assert np.array_equal(getattr(read, name), getattr(automaton, name)), (formula, declaration, suffix)
        automaton.to_dot(), automaton.to_mermaid()


@pytest.mark.peer
def test_files_are_about_possible_words_for_other_tools(tmp_path: Path) -> None:
    spot = pytest.importorskip("spot")
    for text, groups in (
        ("F(a & F b) & G c", [{"a", "b", "x"}]),
        ("GF a & GF b & (F x | G y)", [{"a", "b"}, {"b", "x", "y"}]),
        (" & ".join(f"GF r{i}" for i in range(7)), [{f"r{i}" for i in range(7)}]),
    ):
        automaton = ltlc.compile(text, exclusive=groups)
        path = automaton.save(tmp_path / "automaton.hoa")
        pairs = [(p, q) for group in groups for p in group for q in group if p < q]
        pairs = [pair for pair in pairs if set(pair) <= set(automaton.aps)]
        assert spot.are_equivalent(
            spot.automaton(str(path)), spot.formula(f"({text}) & G(!({') & !('.join(map(' & '.join, pairs))}))")
        )


def test_impossible_letters_are_named() -> None:
    automaton = ltlc.compile("F(a & F b) & G c", exclusive=[{"a", "b", "d"}])
    with pytest.raises(ImpossibleLetterError, match=r"\{a, b, c\} occurs, .* propositions \{a, b\} was") as caught:
        automaton.accepts([{"a", "b", "c"}])
    assert (caught.value.together, caught.value.letter) == ({"a", "b"}, {"a", "b", "c"})
    listed = ltlc.compile("F(a & b)", letters=[{"a"}, {"a", "b"}])
    assert listed.n_states == 2
    for letter in (set(), {"b"}):
        with pytest.raises(ImpossibleLetterError):
            listed.step(0, letter)


def test_hundreds_of_propositions() -> None:
    places = ltlc.compile(sequence(ROOMS[:50]), exclusive=[ROOMS])
    assert (places.n_states, places.n_classes) == (51, 51)
    patrol = ltlc.compile(" & ".join(f"GF {room}" for room in ROOMS[:20]), exclusive=[ROOMS], acceptance="transition")
    assert (patrol.n_states, patrol.n_classes) == (20, 21)
    assert patrol.accepts([], [{room} for room in ROOMS[:20]])
    assert not patrol.accepts([], [{room} for room in ROOMS[:19]])
    assert ltlc.compile(f"G({' | '.join(ROOMS)})", exclusive=[ROOMS]).n_states == 2
    assert ltlc.compile(sequence(ROOMS[:40]), exclusive=[ROOMS], finite=True).n_states == 41
    names = [f"x{i}" for i in range(300)]
    assert ltlc.compile(f"G({' | '.join(names)}) & F x7", exclusive=[names]).n_classes == 3


def test_too_many_letters() -> None:
    with pytest.raises(AlphabetLimitExceeded, match="declared which of them exclude each other"):
        ltlc.compile(" & ".join(f"GF {room}" for room in ROOMS))
    with pytest.raises(AlphabetLimitExceeded, match="more than 2097152 letters are possible"):
        ltlc.compile(" & ".join(f"GF {room}" for room in ROOMS), exclusive=[ROOMS[:5]])


def test_smaller_where_the_formula_allows() -> None:
    assert ltlc.compile("F(a & b)", exclusive=[{"a", "b"}]).n_states == 1
    assert ltlc.compile("G(a -> !b)", exclusive=[{"a", "b"}]).n_states == 1
    text = "!b U (a & F b)"
    assert ltlc.compile(text, letters=[{"a"}]).n_states < ltlc.compile(text).n_states
    patrol = " & ".join(f"GF r{i}" for i in range(4))
    free = ltlc.compile(patrol, acceptance="transition")
    one = ltlc.compile(patrol, acceptance="transition", exclusive=[{f"r{i}" for i in range(4)}])
    assert one.n_classes == 5 < free.n_classes


def test_comparing_is_about_letters_that_both_read() -> None:
    one, two = (ltlc.compile(text, exclusive=[{"a", "b"}]) for text in ("F a", "F(a & !b)"))
    assert equivalent(one, two)
    found = counterexample(ltlc.compile("F(a | b)", exclusive=[{"a", "b"}]), ltlc.compile("F a"))
    assert found is not None
    assert "b" in found.letters[0] | found.letters[-1] | set().union(*found.letters)
    with pytest.raises(InvalidArgumentError, match="no letter is possible in both"):
        equivalent(ltlc.compile("F a", letters=[{"a"}]), ltlc.compile("F a", letters=[set()]))


def test_past_and_forms() -> None:
    rng = random.Random(3)
    letters = [frozenset(), frozenset("a"), frozenset("b")]
    for text in ("G(a -> O b)", "F(b & Y a) & GF a", "G(a S b)"):
        formula = parse(text)
        for form in ("rabin", "parity"):
            automaton = ltlc.compile(formula, exclusive=[{"a", "b"}], form=form)  # type: ignore[call-overload]
            for _ in range(100):
                prefix, cycle = ([rng.choice(letters) for _ in range(rng.randint(n, 3))] for n in (0, 1))
                assert automaton.accepts(prefix, cycle) == satisfies(formula, LassoWord(tuple(prefix), tuple(cycle)))


def test_monitor_many_and_cache() -> None:
    monitor = ltlc.Monitor("G(a -> X !a) & F b", exclusive=[{"a", "b"}])
    assert [monitor.step(letter).value for letter in ({"a"}, {"b"}, {"a"}, {"a"})][-1] == "violated"
    assert monitor.run([monitor.letter(letter) for letter in ({"a"}, {"b"}, {"a"}, {"a"})]).tolist() == [3, 2, 3, 1]
    with pytest.raises(ImpossibleLetterError):
        monitor.step({"a", "b"})
    texts = ["F(a & F b)", "F(x & F y)", "F(a & F x)"]
    cache: dict[object, ltlc.DRA] = {}
    many = ltlc.compile_many(texts, exclusive=[{"a", "b"}], cache=cache)  # type: ignore[arg-type]
    assert [automaton.n_classes for automaton in many] == [3, 4, 4]
    assert len(cache) == 2
    single = ltlc.compile(texts[0], exclusive=[{"b", "a"}], cache=cache)  # type: ignore[arg-type]
    assert len(cache) == 2
    assert np.array_equal(single.letter_class, many[0].letter_class)
    assert ltlc.compile(texts[0], cache=cache).n_classes == 4  # type: ignore[arg-type]
    renamed = replace(many[0], aps=("p", "q"))
    assert renamed.accepts([{"p"}], [{"q"}])


def test_a_proposition_that_no_letter_has() -> None:
    automaton = ltlc.compile(And(parse("F a"), parse("G !b")), letters=[{"a"}, set()])
    assert automaton.accepts([{"a"}], [set()])
    with pytest.raises(ImpossibleLetterError):
        automaton.letter({"b"})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('[[[], ["a"], ["b"]]]', '[[[], ["a"], ["z"]]]', "possible[0][2][0]: 'z' is not one of aps"),
        ('[[[], ["a"], ["b"]]]', '[[[], ["a"]], [[], ["a"]]]', "possible: expected parts that have no proposition"),
        ('[[[], ["a"], ["b"]]]', "[[]]", "possible: expected parts"),
        ('[[[], ["a"], ["b"]]]', '[[[], ["a"], ["b"], ["a", "b"]]]', "not deterministic"),
        ('"guard": "a"', '"guard": "a & !a"', "not complete: state 0 has no transition for the letter a & !b"),
    ],
)
def test_damaged_json(old: str, new: str, message: str) -> None:
    text = ltlc.compile("F(a & F b)", exclusive=[{"a", "b"}]).to_json()
    text = text.replace('"guard": "!a"', '"guard": "!a | b"')  # the same, among possible letters
    assert from_json(text).n_states == 3
    assert old in text
    with pytest.raises(FileFormatError, match=re.escape(message)):
        from_json(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('possible: "" "0" "1"', 'possible: "" "0" "7"', "a combination is a string of numbers of propositions"),
        ('possible: "" "0" "1"', 'possible: "" 0 "1"', "a combination is a string"),
        ('possible: "" "0" "1"', "possible:", "a part of the alphabet has combinations"),
        ('possible: "" "0" "1"', 'possible: "" "0"\npossible: "" "0" "1"', "no proposition of another part"),
        (
            "[@possible & (0)] 1\n",
            "",
            "line 13, column 8: state 0 has no edge for the letter a & !b, which the headers",
        ),
    ],
)
def test_damaged_hoa(old: str, new: str, message: str) -> None:
    text = ltlc.compile("F(a & F b)", exclusive=[{"a", "b"}]).to_hoa()
    assert old in text
    with pytest.raises(FileFormatError, match=re.escape(message)):
        from_hoa(text.replace(old, new, 1))


def test_the_schema_knows_possible_letters() -> None:
    content = json.loads(resources.files("ltlc.formats").joinpath("dra.schema.json").read_text("utf-8"))
    schema = jsonschema.Draft202012Validator(content)
    document = json.loads(ltlc.compile(" & ".join(f"GF {room}" for room in ROOMS[:30]), exclusive=[ROOMS]).to_json())
    schema.validate(document)
    assert document["version"] == "1.1"
    del document["possible"]
    assert not schema.is_valid(document)
