"""What a Rabin automaton checks of its arrays, and copies of it that are not checked again."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from ltlc.automata import DRA
from ltlc.errors import InvalidAutomatonError
from ltlc.ltl import parse
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
    named = source.named("this", "that")
    plain = replace(source, formula="this", translator="that")
    assert "rows" not in vars(named)
    for name in (field.name for field in fields(DRA)):
        assert np.array_equal(getattr(named, name), getattr(plain, name))
    assert not named.forms
    assert not named.has_languages
    assert source.formula == str(parse("G F a & F G b"))
