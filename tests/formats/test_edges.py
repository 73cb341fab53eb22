"""Edges of wide tables are those of narrow ones, and guards say exactly which letters they are of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ltlc
from ltlc.automata import DRA, wide
from ltlc.formats import edges as edges_module
from ltlc.formats import from_hoa, from_json, to_hoa, to_json, wide_edges
from ltlc.formats.edges import LabelledEdge, edges, letters_of
from ltlc.ltl import parse

NAMES = tuple("abcdefg")


def by_definition(automaton: DRA) -> dict[tuple[int, int, tuple[int, ...], tuple[int, ...]], int]:
    """The letters of each source, target and marks, in the order of edges."""
    found: dict[tuple[int, int, tuple[int, ...], tuple[int, ...]], int] = {}
    on_edges = automaton.acceptance == "transition"
    for q in range(automaton.n_states):
        for letter, c in enumerate(automaton.letter_class.tolist()):
            pairs = [np.flatnonzero(t[:, q, c]).tolist() if on_edges else [] for t in (automaton.fin, automaton.inf)]
            key = q, int(automaton.delta[q, c]), tuple(pairs[0]), tuple(pairs[1])
            found[key] = found.get(key, 0) | 1 << letter
    return found


def check(automaton: DRA) -> list[LabelledEdge]:
    found = edges(automaton)
    universe = automaton.letter_numbers.all
    holding = {name: automaton.letter_numbers.holding(i) for i, name in enumerate(automaton.aps)}
    read = {
        (e.source, e.target, e.fin, e.inf): letters_of(parse(e.guard), holding.__getitem__, universe) for e in found
    }
    wanted = by_definition(automaton)
    assert list(read.items()) == list(wanted.items())
    assert len(read) == len(found)
    return found


def random_automaton(seed: int) -> DRA:
    """From few values in a row to many, with classes of one letter or of many, in any order."""
    rng = np.random.default_rng(seed)
    n_states, n_letters = int(rng.integers(1, 9)), 1 << len(NAMES)
    n_classes = int(rng.choice([20, 64, 100, n_letters]))
    numbers = np.concatenate([np.arange(n_classes), rng.integers(n_classes, size=n_letters - n_classes)])
    letter_class = numbers if seed % 3 == 0 else rng.permutation(numbers)
    delta = rng.integers(n_states, size=(n_states, n_classes))
    if seed % 2:  # guards that are conjunctions, clauses and others over few propositions
        letters = np.arange(n_letters)
        bits = letters[:, None] >> rng.permutation(len(NAMES))[None, : n_states - 1] & 1
        letter_class = np.unique(letters & int(rng.integers(1, n_letters)), return_inverse=True)[1]
        letter_class = rng.permutation(int(letter_class.max()) + 1)[letter_class]
        first = np.unique(letter_class, return_index=True)[1]
        steps = np.where(bits.any(axis=1), bits.argmax(axis=1), n_states - 1) if n_states > 1 else 0 * letters
        delta = np.array([(steps[first] + q) % n_states for q in range(n_states)])
    n_pairs = int(rng.integers(0, 4))
    acceptance = ["state", "transition"][int(rng.integers(2))]
    shape = (n_pairs, n_states) if acceptance == "state" else (n_pairs, *delta.shape)
    fin, inf = (rng.random(shape) < rng.choice([0, 0.05, 0.5]) for _ in range(2))
    return DRA(NAMES, delta, letter_class, fin, inf, acceptance=acceptance)  # type: ignore[arg-type]


@pytest.mark.parametrize("long", [1, 1 << 11])
@pytest.mark.parametrize("seed", range(30))
def test_edges_are_those_of_the_table(seed: int, long: int, monkeypatch: pytest.MonkeyPatch) -> None:
    automaton = random_automaton(seed)
    monkeypatch.setattr(edges_module, "_LARGE", 1 << 20)
    few = check(automaton)
    texts = to_json(automaton), to_hoa(automaton)
    graph, components = automaton.marked_graph, automaton.scc
    for module in (wide, wide_edges):
        monkeypatch.setattr(module, "LONG", long)
        monkeypatch.setattr(module, "FEW", 5)
    for module in (wide, edges_module):
        monkeypatch.setattr(module, "_LARGE", 1)
        monkeypatch.setattr(module, "_WIDE", 1)
    monkeypatch.setattr(wide_edges, "_MANY", 1)
    automaton = replace(automaton)
    assert edges(automaton) == few
    assert (to_json(automaton), to_hoa(automaton)) == texts
    assert (automaton.marked_graph, automaton.scc) == (graph, components)
    for again in (from_json(texts[0]), from_hoa(texts[1])):
        assert isinstance(again, DRA)
        assert (to_json(again).splitlines()[6:], edges(again)) == (texts[0].splitlines()[6:], few)


RESPONSES = " & ".join(f"G({a} -> F {b})" for a, b in ("ad", "be", "ch"))
CLAUSE = "F(a & X d) & F(b & X e) & G(c | h | g)"
EXCEPTION = f"{RESPONSES} & G !g"


@pytest.mark.parametrize("formula", [RESPONSES, CLAUSE, EXCEPTION, "F a & F b & F c & G !(d | e | g | h)"])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_products_of_conditions(formula: str, acceptance: str, monkeypatch: pytest.MonkeyPatch) -> None:
    automaton = ltlc.compile(formula, acceptance=acceptance)
    monkeypatch.setattr(edges_module, "_LARGE", 1 << 20)
    few = check(automaton)
    monkeypatch.setattr(edges_module, "_LARGE", 1)
    monkeypatch.setattr(edges_module, "_WIDE", 1)
    monkeypatch.setattr(wide_edges, "_MANY", 1)
    assert edges(automaton) == few


@pytest.mark.parametrize("n_pairs", [0, 1, 3, 16, 17, 40])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_any_number_of_marks(n_pairs: int, acceptance: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(n_pairs)
    shape = (n_pairs, 33) if acceptance == "state" else (n_pairs, 33, 128)
    fin, inf = (rng.random(shape) < 0.05 for _ in range(2))
    delta, letter_class = rng.integers(5, size=(33, 128)), rng.permutation(128)
    automaton = DRA(NAMES, delta, letter_class, fin, inf, acceptance=acceptance)  # type: ignore[arg-type]
    found = check(automaton)
    monkeypatch.setattr(edges_module, "_LARGE", 1 << 20)
    assert edges(automaton) == found
