"""Comparison and reduction against words, and against each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from random_automata import random_automata, random_automaton, random_lassos, short_lassos

from ltlc.automata import (
    DRA,
    BuchiAutomaton,
    LetterEdge,
    canonical,
    counterexample,
    equivalent,
    equivalent_states,
    included,
    is_empty,
    simplify_marks,
    to_transition_based,
)
from ltlc.automata.compare import distinguishing_letters
from ltlc.automata.languages import languages_within
from ltlc.automata.marks import SIMPLE_MARKS
from ltlc.errors import AlphabetLimitExceeded, InvalidAutomatonError
from ltlc.minimize import merge_bisimilar, merge_by_trial, merge_equivalent, reduce, to_state_based
from ltlc.minimize.even_marks import even_marks
from ltlc.minimize.reduce import MERGED, NORMALIZED, merge_states, normalized
from ltlc.minimize.words import Words


def complement_by_letters(a: DRA) -> DRA:
    """The complement of an automaton with one pair: Inf of fin, or Fin of inf, as two pairs."""
    none, every = np.zeros_like(a.fin[0]), np.ones_like(a.fin[0])
    return replace(a, fin=np.array([none, a.inf[0]]), inf=np.array([a.fin[0], every]))


def always_eventually(name: str, aps: tuple[str, ...]) -> DRA:
    """GF of one proposition, over these propositions."""
    letters = np.arange(2 ** len(aps))
    return DRA(
        aps,
        np.zeros((1, 2)),
        letters >> aps.index(name) & 1,
        np.zeros((1, 1, 2)),
        np.array([[[0, 1]]]),
        0,
        "transition",
    )


@pytest.mark.slow
def test_verdicts_agree_with_words() -> None:
    both = {True: 0, False: 0}
    for seed in range(150):
        rng = np.random.default_rng(seed)
        n_states, n_aps = int(rng.integers(1, 4)), int(rng.integers(1, 3))
        kinds = [("state", "transition")[bit] for bit in (seed & 1, seed >> 1 & 1)]
        a, b = (random_automaton(rng, n_states, n_aps, int(rng.integers(1, 3)), kind, 0.4) for kind in kinds)
        lassos = random_lassos(rng, 2**n_aps, 60) + short_lassos(2**n_aps, 1, 2)
        verdicts = [(a.accepts_letters(u, v), b.accepts_letters(u, v)) for u, v in lassos]
        same = equivalent(a, b)
        both[same] += 1
        assert same == (included(a, b) and included(b, a))
        assert not included(a, b) or all(y for x, y in verdicts if x)
        assert not same or all(x == y for x, y in verdicts)
        assert is_empty(a) == (a.initial_state in a.deadlocks)
        assert not is_empty(a) or not any(x for x, _ in verdicts)
        word = counterexample(a, b)
        assert (word is None) == same
        if word is not None:
            assert a.accepts(word.prefix, word.cycle) != b.accepts(word.prefix, word.cycle)
    assert min(both.values()) > 2


def test_complement_is_disjoint_and_covers() -> None:
    for seed in range(40):
        rng = np.random.default_rng(seed)
        a = random_automaton(rng, 4, 2, 1, ("state", "transition")[seed % 2])
        other = complement_by_letters(a)
        assert not equivalent(a, other)
        assert equivalent(a, complement_by_letters(complement_by_letters(a))) if other.n_pairs == 1 else True
        assert included(a, other) == is_empty(a)
        assert included(other, a) == is_empty(other)


def test_other_orders_and_sets_of_propositions() -> None:
    one = always_eventually("a", ("a",))
    assert equivalent(one, always_eventually("a", ("b", "a")))
    assert equivalent(always_eventually("a", ("c", "a")), always_eventually("a", ("a", "b")))
    assert not included(one, always_eventually("b", ("b", "a")))
    word = counterexample(always_eventually("a", ("a", "b")), always_eventually("b", ("b",)))
    assert word is not None
    assert ("a" in set().union(*word.cycle)) != ("b" in set().union(*word.cycle))


def test_too_many_propositions_together_are_refused() -> None:
    def parity(prefix: str) -> DRA:
        aps = tuple(f"{prefix}{i}" for i in range(11))
        letter_class = np.array([letter.bit_count() % 2 for letter in range(2**11)])
        return DRA(aps, np.array([[0, 1], [1, 0]]), letter_class, np.zeros((1, 2)), np.array([[0, 1]]))

    with pytest.raises(AlphabetLimitExceeded, match="22 propositions"):
        equivalent(parity("a"), parity("b"))


def test_equivalent_states_are_those_with_equivalent_languages() -> None:
    merged = 0
    for automaton in random_automata(80, max_states=5):
        classes = equivalent_states(automaton)
        started = [replace(automaton, initial_state=q) for q in range(automaton.n_states)]
        for p, first in enumerate(started):
            for q in range(p):
                assert equivalent(first, started[q]) == (classes[p] == classes[q])
                merged += int(classes[p] == classes[q])
    assert merged > 50


def test_copies_are_known_without_a_product_however_many_pairs_there_are() -> None:
    rng = np.random.default_rng(0)
    one = random_automaton(rng, 40, 7, 40, "state")
    delta = np.concatenate([one.delta + 40 * rng.integers(2, size=one.delta.shape) for _ in range(2)])
    twice = replace(one, delta=delta, fin=np.tile(one.fin, 2), inf=np.tile(one.inf, 2))
    assert twice.entries is not None
    assert languages_within(twice, 0)[0] == [*range(40)] * 2


@pytest.mark.parametrize(
    "change",
    [simplify_marks, merge_bisimilar, merge_equivalent, merge_by_trial, reduce, to_state_based, to_transition_based],
)
def test_changes_preserve_the_language(change: Callable[[DRA], DRA]) -> None:
    kinds = {to_state_based: "state", to_transition_based: "transition"}
    for seed, automaton in enumerate(random_automata(80)):
        changed = change(automaton)
        assert changed.aps == automaton.aps
        assert changed.acceptance == kinds.get(change, automaton.acceptance)
        for u, v in random_lassos(np.random.default_rng(seed), 2 ** len(automaton.aps), 25):
            assert changed.accepts_letters(u, v) == automaton.accepts_letters(u, v)
        assert equivalent(changed, automaton)


def test_reduce_leaves_one_deadlock_one_sink_and_useful_pairs() -> None:
    for automaton in random_automata(80):
        small = reduce(automaton)
        again = reduce(small)
        assert again.n_states <= small.n_states <= automaton.n_states
        assert len(small.deadlocks) <= 1
        assert len(small.accepting_sinks) <= 1
        assert small.n_pairs <= max(1, automaton.n_pairs)
        for q in small.deadlocks:
            assert not small.edge_fin[:, q].any()
            assert not small.edge_inf[:, q].any()


@pytest.mark.parametrize("change", [merge_bisimilar, to_state_based])
@pytest.mark.slow
def test_forms_that_are_kept_are_right(change: Callable[[DRA], DRA]) -> None:
    simple = merged = 0
    for automaton in random_automata(200):
        changed = change(normalized(to_transition_based(automaton)))
        if SIMPLE_MARKS in changed.forms:
            again = simplify_marks(replace(changed))
            assert np.array_equal(again.fin, changed.fin)
            assert np.array_equal(again.inf, changed.inf)
            simple += 1
        if MERGED in changed.forms:
            assert merge_states(replace(changed)).n_states == changed.n_states
            merged += 1
        if NORMALIZED in changed.forms:
            assert normalized(replace(changed)).n_states == changed.n_states
    assert simple > 50
    assert merged > 50


def test_pairs_are_merged_where_one_suffices() -> None:
    # (FG !a & GF b) | GF b: the second pair alone.
    automaton = DRA(
        ("a", "b"),
        np.zeros((1, 4)),
        np.arange(4),
        np.array([[[0, 1, 0, 1]], [[0, 0, 0, 0]]]),
        np.array([[[0, 0, 1, 1]], [[0, 0, 1, 1]]]),
        0,
        "transition",
    )
    small = simplify_marks(automaton)
    assert small.n_pairs == 1
    assert not small.fin.any()


def test_state_based_sizes() -> None:
    assert to_state_based(always_eventually("a", ("a",))).n_states == 2
    # FG(a <-> X a): three states, although every combination of letter and mark would be four.
    changes = DRA(
        ("a",),
        np.array([[0, 1], [0, 1]]),
        np.arange(2),
        np.array([[[0, 1], [1, 0]]]),
        np.ones((1, 2, 2)),
        0,
        "transition",
    )
    assert to_state_based(changes).n_states == 3


def test_distinguishing_letters_are_over_the_propositions_that_matter() -> None:
    found = distinguishing_letters(always_eventually("a", ("c", "a")), always_eventually("b", ("b",)))
    assert found is not None
    assert found[0].aps == ("a", "b")


def test_many_pairs_fit() -> None:
    # GF(a) with 40 copies of its pair: marks need more than 64 bits.
    one = always_eventually("a", ("a",))
    many = replace(one, fin=np.repeat(one.fin, 40, axis=0), inf=np.repeat(one.inf, 40, axis=0))
    assert many.edge_marks[0][1] == sum(2 << 2 * i for i in range(40))
    assert equivalent(one, many)
    assert simplify_marks(many).n_pairs == 1
    assert equivalent_states(many).tolist() == [0]


def test_buchi_automata_accept_lassos() -> None:
    # FG a, guessing when: letter 1 is {a}.
    guess = BuchiAutomaton(
        n_letters=2, initial=(0,), edges=((LetterEdge(3, 0, 0), LetterEdge(2, 1, 1)), (LetterEdge(2, 1, 1),)), n_sets=1
    )
    for u, v in short_lassos(2, 2, 3):
        assert guess.accepts(u, v) == (set(v) == {1})
    # GF a & GF !a, both sets on one state.
    both = BuchiAutomaton(2, (0,), ((LetterEdge(1, 0, 1), LetterEdge(2, 0, 2)),), 2)
    for u, v in short_lassos(2, 1, 3):
        assert both.accepts(u, v) == (set(v) == {0, 1})
    assert not BuchiAutomaton(1, (0,), ((),), 0).accepts((), (0,))
    with pytest.raises(InvalidAutomatonError):
        BuchiAutomaton(1, (0,), ((LetterEdge(1, 1, 0),),), 0)


def test_words_that_are_known_spare_work_and_change_nothing() -> None:
    spared = 0
    for automaton in random_automata(60, max_states=6):
        words: Words = []
        alone = merge_by_trial(automaton, words=words)
        known = list(words)
        again = merge_by_trial(automaton, words=words)
        assert np.array_equal(again.delta, alone.delta)
        assert np.array_equal(again.letter_class, alone.letter_class)
        assert words == known
        spared += len(known)
    assert spared > 10


def test_even_marks_split_states_into_fewer_and_keep_the_language() -> None:
    fewer = 0
    for automaton in random_automata(80, max_states=4):
        automaton = normalized(to_transition_based(automaton))
        evened, is_complete = even_marks(automaton)
        assert is_complete
        assert equivalent(evened, automaton)
        entries = [len({edge for row in a.marked_graph for edge in row}) for a in (automaton, evened)]
        assert entries[1] <= entries[0]
        fewer += entries[1] < entries[0]
    assert fewer > 5


@pytest.mark.slow
def test_merging_is_judged_by_any_equivalent_automaton() -> None:
    """Another automaton of the language gives the same merges as the automaton itself, and they keep the language."""
    for automaton in random_automata(60, max_states=5):
        other = reduce(to_transition_based(automaton))
        alone = merge_by_trial(automaton)
        judged = merge_by_trial(automaton, reference=other)
        assert equivalent(judged, automaton)
        assert np.array_equal(judged.delta, alone.delta)
        assert merge_by_trial(automaton, least=automaton.n_states).n_states == canonical(automaton).n_states
