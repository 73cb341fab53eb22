"""What a Rabin automaton checks of its arrays, and copies of it that are not checked again."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest
from random_automata import random_automata

from ltlc.automata import DRA, canonical, simplify_marks, to_transition_based
from ltlc.automata.parity import to_parity
from ltlc.errors import InvalidAutomatonError
from ltlc.ltl import parse
from ltlc.minimize import collapse, lower_bound, reduce, to_state_based
from ltlc.minimize.reduce import normalized
from ltlc.translate import Options, translate


def automaton(n_aps: int, letter_class: list[int], delta: list[list[int]]) -> DRA:
    marks = np.zeros((1, len(delta), len(delta[0])), dtype=np.bool_)
    names = tuple(f"p{i}" for i in range(n_aps))
    return DRA(names, np.array(delta), np.array(letter_class), marks, marks, acceptance="transition")


@pytest.mark.parametrize("n_aps", [2, 8])
def test_classes_of_letters_are_all_in_use_and_no_others(n_aps: int) -> None:
    n_letters = 1 << n_aps
    right = [0, 2, 1, *[0] * (n_letters - 3)]
    assert automaton(n_aps, right, [[0, 0, 0]]).n_classes == 3
    for wrong in ([-1, *right[1:]], [3, *right[1:]], [0] * n_letters, [1, *right[1:-1], -(2**31)]):
        with pytest.raises(InvalidAutomatonError, match=r"not exactly 0\.\.2"):
            automaton(n_aps, wrong, [[0, 0, 0]])


@pytest.mark.parametrize("target", [-1, 2, -(2**31), 2**31 - 1])
def test_next_states_are_states(target: int) -> None:
    with pytest.raises(InvalidAutomatonError, match="outside the states"):
        automaton(1, [0, 1], [[0, 1], [target, 0]])


@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_another_name_is_all_that_changes(acceptance: str) -> None:
    source = translate(parse("G F a & F G b"), Options(acceptance=acceptance))  # type: ignore[arg-type]
    source = source.annotated("some form", languages=source.languages)
    assert source.rows
    assert source.languages.size
    named = source.named("this", "that")
    plain = replace(source, formula="this", translator="that")
    for name in (field.name for field in fields(DRA) if field.init):
        assert np.array_equal(getattr(named, name), getattr(plain, name))
    assert not named.forms
    assert not named.has_languages
    assert source.formula == str(parse("G F a & F G b"))


def listed(source: DRA) -> DRA:
    """The same automaton, given as lists."""
    others = {"initial_state": source.initial_state, "acceptance": source.acceptance}
    made = DRA.from_lists(source.aps, source.rows, source.mark_lists, source.class_list, source.n_pairs, **others)
    assert made.is_listed
    assert not source.is_listed
    return made


def parity(source: DRA) -> DRA:
    return to_parity(source).automaton


def test_lists_and_arrays_are_the_same_automaton() -> None:
    """What is made from either is the same to the byte, and so is what is known about it."""
    for source in random_automata(150, max_aps=3):
        other = listed(source)
        for form in (canonical, simplify_marks, normalized, reduce, to_state_based, to_transition_based, parity):
            expected, got = form(source), form(other)
            assert got.to_json() == expected.to_json()
            assert got.to_hoa() == expected.to_hoa()
        assert other.to_json() == source.to_json()
        assert other.pairs == source.pairs
        assert np.array_equal(other.languages, source.languages)
        assert np.array_equal(other.annotations.live_pairs, source.annotations.live_pairs)
        assert lower_bound(other) == lower_bound(source)
        assert collapse(other).automaton.to_hoa() == collapse(source).automaton.to_hoa()
        for name in ("delta", "letter_class", "fin", "inf"):
            table, expected_table = getattr(listed(source), name), getattr(source, name)
            assert table.dtype == expected_table.dtype
            assert not table.flags.writeable
            assert np.array_equal(table, expected_table)


def test_copies_of_a_listed_automaton() -> None:
    for source in map(listed, random_automata(10)):
        for copied in (copy.copy(source), copy.deepcopy(source), pickle.loads(pickle.dumps(source)), replace(source)):
            assert copied.to_hoa() == source.to_hoa()
            assert np.array_equal(copied.fin, source.fin)
        with pytest.raises(AttributeError, match="no attribute 'color'"):
            source.color  # noqa: B018
        with pytest.raises(InvalidAutomatonError, match="listed twice"):
            source.named("F a", aps=("a", "a"))
