"""Automata over finite traces, against the textbook's definition, and minimal by filling a table."""

from __future__ import annotations

import random
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from by_definition import finite, random_finite, random_traces

import ltlc
from ltlc.automata import DFA, DRA, equivalent
from ltlc.errors import (
    AlphabetLimitExceeded,
    FileFormatError,
    InvalidArgumentError,
    InvalidAutomatonError,
    StateLimitExceeded,
)
from ltlc.formats import from_hoa, from_json, to_dot, to_hoa, to_json, to_mermaid
from ltlc.ltl import Proposition, parse, propositions, satisfies_trace
from ltlc.translate import translate_finite


def test_automata_agree_with_the_definition() -> None:
    assert Counter(finite(random.Random(1), 150, 20)) == {None: 3000}


@pytest.mark.slow
def test_many_automata_agree_with_the_definition() -> None:
    assert Counter(finite(random.Random(2), 1000, 20)) == {None: 20_000}


def n_residuals(automaton: DFA) -> int:
    """The number of states of the smallest automaton, by filling a table of pairs that are told apart."""
    rows, accepting = automaton.delta.tolist(), automaton.accepting.tolist()
    reached = [automaton.initial_state]
    for state in reached:
        reached += [target for target in dict.fromkeys(rows[state]) if target not in reached]
    apart = {(p, q) for p in reached for q in reached if accepting[p] != accepting[q]}
    while True:
        more = {
            (p, q)
            for p, q in product(reached, reached)
            if (p, q) not in apart and any((s, t) in apart for s, t in zip(rows[p], rows[q], strict=True))
        }
        if not more:
            return len({frozenset(q for q in reached if (p, q) not in apart) for p in reached})
        apart |= more


def minimal(seed: int, n: int) -> None:
    rng = random.Random(seed)
    for _ in range(n):
        automaton = translate_finite(random_finite(rng, rng.randint(1, 9), "abc"[: rng.randint(1, 3)]))
        assert automaton.n_states == n_residuals(automaton), automaton
        again = automaton.minimal()
        assert np.array_equal(again.delta, automaton.delta)
        assert np.array_equal(again.letter_class, automaton.letter_class)
        assert np.array_equal(again.accepting, automaton.accepting)


def test_automata_are_minimal() -> None:
    minimal(3, 150)


@pytest.mark.slow
def test_many_automata_are_minimal() -> None:
    minimal(4, 1000)


def test_one_language_has_one_automaton() -> None:
    for texts in (
        ("F a", "true U a", "!G !a", "a | X F a"),
        ("last", "WX false", "!X true", "N false", "!X[!] true"),
        ("G F a", "F G a", "F(a & last)"),
        ("a & Y b", "false", "X a & last"),
        ("F(last & O b)", "F b"),
        ("F(last & (a S b))", "F(b & WX G a)"),
        ("G[0:1] a", "a & WX a"),
        ("F[0:1] a", "a | X a"),
    ):
        padded = (parse(f"(a | !a) & (b | !b) & ({text})", finite=True) for text in texts)
        assert len({to_json(translate_finite(formula, text="")) for formula in padded}) == 1, texts


@pytest.mark.parametrize(
    ("text", "states"),
    [("F a", 2), ("G a", 3), ("last", 3), ("F last", 2), ("X true", 3), ("false", 1), ("true", 2), ("F(a & WX b)", 3)],
)
def test_small_automata(text: str, states: int) -> None:
    automaton = ltlc.compile(text, finite=True)
    assert isinstance(automaton, DFA)
    assert automaton.n_states == states


def test_annotations() -> None:
    automaton = ltlc.compile("a & X(b & last | c & G c)", finite=True)
    traces = {q: list(random_traces(random.Random(q), "abc", 300)) for q in range(automaton.n_states)}
    for q in range(automaton.n_states):
        ends = set()
        for trace in traces[q]:
            state = q
            for letter in trace:
                state = automaton.step(state, letter)
            ends.add(bool(automaton.accepting[state]))
        assert (q in automaton.deadlocks) == (ends == {False} and not automaton.accepting[q])
        assert (q in automaton.accepting_sinks) == (ends == {True} and bool(automaton.accepting[q]))
        assert (automaton.annotations.distance[q] == 0) == bool(automaton.accepting[q])
    assert automaton.size.endswith("states, finite traces")
    assert repr(automaton).startswith("<DFA of a & X(")


@pytest.mark.parametrize("text", ["F(a & WX b)", "false", "true", "last", 'G("a b" -> O c)'])
def test_files(text: str, tmp_path: Path) -> None:
    automaton = ltlc.compile(text, finite=True)
    for suffix in (".json", ".hoa"):
        automaton.save(tmp_path / f"dfa{suffix}")
        read = ltlc.load(tmp_path / f"dfa{suffix}")
        assert isinstance(read, DFA)
        assert to_json(read) == to_json(automaton)
        assert to_hoa(read) == to_hoa(automaton)
    assert "a trace ends in a state with" in to_dot(automaton)
    assert "flowchart" in to_mermaid(automaton)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Words: finite", "Words: some", "the header Words: says finite"),
        ("Words: finite", "Worte: finite", None),
        ("Words: finite", "Traces: finite", "may change what is accepted"),
        ("{1}", "{0 1}", "finite traces end in states of one Inf set, and no Fin set"),
    ],
)
def test_wrong_hoa(old: str, new: str, message: str | None) -> None:
    text = to_hoa(ltlc.compile("F a", finite=True)).replace(old, new)
    with pytest.raises(FileFormatError, match=message or "may change"):
        from_hoa(text)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"accepting": [1]', '"accepting": [2]', "accepting"),
        ('"accepting": [1],', "", "accepting"),
        ('"accepting": [1]', '"accepting": 1', "accepting"),
        ("ltlc-dfa", "ltlc-nfa", "expected 'ltlc-dra'"),
        ("ltlc-dfa", "ltlc-dra", "acceptance"),
    ],
)
def test_wrong_json(old: str, new: str, message: str) -> None:
    text = to_json(ltlc.compile("F a", finite=True))
    assert old in text
    with pytest.raises(FileFormatError, match=message):
        from_json(text.replace(old, new))


def test_reaching() -> None:
    rng = random.Random(5)
    for _ in range(60):
        names = "ab"
        automaton = translate_finite(random_finite(rng, rng.randint(1, 8), names))
        reached = automaton.reached()
        assert isinstance(reached, DRA)
        for trace in random_traces(rng, names, 20):
            word = [letter & set(automaton.aps) for letter in trace]
            begun = any(automaton.accepts(word[:i]) for i in range(1, len(word) + 1))
            state = reached.initial_state
            for letter in word:
                state = reached.step(state, letter)
            assert (state in reached.accepting_sinks) >= begun
            if begun:
                assert reached.accepts(word, [set()])
    assert ltlc.compile("a & last", finite=True).reached().formula == "reach(a & WX false)"


@pytest.mark.parametrize(
    ("finite", "infinite"),
    [
        ("G !hole & F(goal & last)", "!hole U (goal & !hole)"),
        ("F a & F b", "F a & F b"),
        ("G a", "a"),
        ("last", "true"),
        ("X true & G a", "a & X a"),
        ("a & X b", "a & X b"),
    ],
)
def test_reaching_as_a_formula(finite: str, infinite: str) -> None:
    task = ltlc.Task(finite, finite=True)
    names = parse(finite, finite=True)
    padded = f"({infinite})" + "".join(f" & ({p} | !{p})" for p in dict.fromkeys(propositions(names)))
    assert equivalent(task.automaton, ltlc.compile(padded))
    assert ltlc.Task(ltlc.compile(finite, finite=True)).automaton.n_states == task.automaton.n_states
    with pytest.raises(InvalidArgumentError, match="goal is 'start'; it can be 'reach' or 'end'"):
        ltlc.Task(finite, finite=True, goal="start")  # type: ignore[arg-type]


def test_errors() -> None:
    automaton = ltlc.compile("F a", finite=True)
    with pytest.raises(InvalidArgumentError, match="at least one letter"):
        automaton.accepts([])
    with pytest.raises(InvalidArgumentError, match="at least one letter"):
        satisfies_trace(Proposition("a"), [])
    with pytest.raises(StateLimitExceeded):
        ltlc.compile("X X X X X a", finite=True, max_states=3)
    with pytest.raises(AlphabetLimitExceeded):
        ltlc.compile(" & ".join(f"p{i}" for i in range(22)), finite=True)
    with pytest.raises(InvalidAutomatonError):
        DFA(("a",), np.zeros((1, 1), int), np.zeros(2, int), np.zeros(2, bool))  # type: ignore[arg-type]
