"""Letter classes and guards."""

from __future__ import annotations

import random

import numpy as np
import pytest

from ltlc.automata import Alphabet, guard_text
from ltlc.automata.alphabet import BoolArray, Guard, shortest_guard
from ltlc.automata.columns import (
    grouped,
    grouped_partitions,
    letter_classes,
    project,
    support,
    truth_column,
    truth_table,
)
from ltlc.automata.guards import conjunction, irredundant_cover


def proposition_table(index: int, n_aps: int) -> int:
    """The letters that contain proposition `index`, as a truth table (bit k = value at letter k)."""
    width = 1 << index
    table = ((1 << width) - 1) << width
    while width < 1 << n_aps:
        width *= 2
        table |= table << width
    return table & ((1 << (1 << n_aps)) - 1)


def proposition(index: int, n_aps: int) -> BoolArray:
    return truth_column(proposition_table(index, n_aps), 2**n_aps)


def value(guard: Guard, letter: int) -> bool:
    terms = [[bool(letter >> i & 1) == sign for i, sign in term] for term in guard.terms]
    return any(map(all, terms)) if guard.disjunctive else all(map(any, terms))


@pytest.mark.parametrize("n_aps", [0, 1, 2, 3])
def test_guards_are_exact_and_irredundant_for_every_function(n_aps: int) -> None:
    n_letters = 2**n_aps
    for table in range(2**n_letters):
        guard = shortest_guard(table, n_aps)
        assert [value(guard, letter) for letter in range(n_letters)] == [bool(table >> k & 1) for k in range(n_letters)]
        terms = irredundant_cover(table, n_aps)
        for drop in range(len(terms)):
            fewer = Guard(True, tuple(t for i, t in enumerate(terms) if i != drop))
            assert any(value(fewer, letter) != bool(table >> letter & 1) for letter in range(n_letters))


def test_guards_of_random_functions_of_eight_propositions_are_exact() -> None:
    rng = np.random.default_rng(1)
    for density in (0.02, 0.5, 0.98):
        column = rng.random(256) < density
        guard = shortest_guard(truth_table(column), 8)
        assert [value(guard, letter) for letter in range(256)] == column.tolist()


@pytest.mark.parametrize(
    ("letter_class", "classes", "text"),
    [
        ([0, 0, 0, 1], [0], "!a | !b"),
        ([0, 0, 0, 1], [1], "a & b"),
        ([0, 0, 0, 1], [0, 1], "true"),
        ([0, 0, 0, 1], [], "false"),
        ([0, 1, 0, 1], [1], "a"),
        ([0, 0, 1, 0], [1], "!a & b"),
        ([0, 1, 1, 0], [1], "a & !b | !a & b"),
        ([0, 0, 0, 0, 0, 1, 1, 1], [1], "c & (a | b)"),
    ],
)
def test_guard_text(letter_class: list[int], classes: list[int], text: str) -> None:
    aps = ("a", "b", "c")[: len(letter_class).bit_length() - 1]
    assert guard_text(Alphabet(aps, np.array(letter_class)), classes) == text


def test_names_are_quoted_where_they_need_it() -> None:
    alphabet = Alphabet(("U", "at home", 'say "hi"', "door_1"), np.arange(16))
    assert guard_text(alphabet, [15]) == '"U" & "at home" & "say \\"hi\\"" & door_1'


def test_other_names_for_other_formats() -> None:
    guard = Alphabet(("a", "b"), np.array([0, 1, 1, 1])).guard([1])
    assert guard.text(["0", "1"]) == "0 | 1"
    assert Guard(True, ((),)).text([], true="t") == "t"
    assert Guard(False, ((),)).text([], false="f") == "f"


def test_guards_over_twenty_propositions() -> None:
    names = tuple(f"a{i}" for i in range(20))
    every = np.ones(2**20, dtype=bool)
    for i in range(20):
        every &= proposition(i, 20)
    classes, first = letter_classes([every], 2**20)
    assert first.tolist() == [0, 2**20 - 1]
    alphabet = Alphabet(names, classes)
    assert guard_text(alphabet, [1]) == " & ".join(names)
    assert guard_text(alphabet, [0]) == " | ".join("!" + name for name in names)
    two = Alphabet(names, (proposition(3, 20) & proposition(17, 20)).astype(np.int32))
    assert two.relevant == (3, 17)
    assert guard_text(two, [1]) == "a3 & a17"


def test_letter_classes_are_the_coarsest_and_numbered_by_first_letter() -> None:
    rng = np.random.default_rng(2)
    for n_aps in range(5):
        columns = [rng.integers(0, 3, 2**n_aps) for _ in range(2)]
        classes, first = letter_classes(columns, 2**n_aps)
        keys = list(zip(*(column.tolist() for column in columns), strict=True))
        order = list(dict.fromkeys(keys))
        assert classes.tolist() == [order.index(key) for key in keys]
        assert first.tolist() == [keys.index(key) for key in order]
    assert letter_classes([], 4)[0].tolist() == [0, 0, 0, 0]


def test_support_and_projection() -> None:
    column = proposition(0, 3) | proposition(2, 3)
    assert support(column) == (0, 2)
    assert project(column, (0, 2)).tolist() == [False, True, True, True]
    assert truth_table(column) == 0b11111010


@pytest.mark.parametrize("size", [1, 7, 256, 257, 1000])  # lists up to 256, arrays above
def test_grouped_positions_are_those_that_no_table_tells_apart(size: int) -> None:
    rng = random.Random(size)
    tables = [rng.getrandbits(size) & rng.getrandbits(size) & rng.getrandbits(size) for _ in range(3)]
    group, sets = grouped(tables, size)
    keys = [tuple(table >> k & 1 for table in tables) for k in range(size)]
    first = [keys.index(key) for key in dict.fromkeys(keys)]
    assert list(group) == [list(dict.fromkeys(keys)).index(key) for key in keys]
    assert sets == [sum(1 << g for g, k in enumerate(first) if table >> k & 1) for table in tables]


@pytest.mark.parametrize("size", [1, 7, 256, 257, 1000])
def test_grouped_positions_are_those_that_no_partition_tells_apart(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(size)
    for at_once in (1, 3000, 1 << 24):
        monkeypatch.setattr("ltlc.automata.columns._MAX_BITS_AT_ONCE", at_once)
        rows = [[rng.randrange(count) for _ in range(size)] for count in (1, 2, 5)]
        partitions = [[sum(1 << k for k in range(size) if row[k] == place) for place in range(5)] for row in rows]
        group, places = grouped_partitions(partitions, size)
        keys = list(zip(*rows, strict=True))
        distinct = list(dict.fromkeys(keys))
        assert group.tolist() == [distinct.index(key) for key in keys]
        assert [row.tolist() for row in places] == [list(column) for column in zip(*distinct, strict=True)]


def test_conjunctions_are_written_as_the_covers_write_them() -> None:
    rng = random.Random(9)
    for _ in range(200):
        n_aps = rng.randint(1, 5)
        fixed = {i: rng.random() < 0.5 for i in range(n_aps) if rng.random() < 0.6}
        letters = [k for k in range(1 << n_aps) if all(bool(k >> i & 1) == sign for i, sign in fixed.items())]
        order = list(range(1 << n_aps))
        rng.shuffle(order)  # every letter is a class of its own, numbered in any order
        alphabet = Alphabet(tuple("abcde"[:n_aps]), np.array(order, dtype=np.int32))
        found = alphabet.guard([order[k] for k in letters])
        assert found == shortest_guard(sum(1 << k for k in letters), n_aps)


@pytest.mark.parametrize("seed", range(40))
def test_the_guard_of_a_conjunction_is_found_from_its_factors(seed: int) -> None:
    rng = random.Random(seed)
    n_aps = rng.randint(2, 6)
    names = rng.sample(range(n_aps), n_aps)
    cut = rng.randint(1, n_aps - 1)
    factors, whole = [], (1 << (1 << n_aps)) - 1
    for part in (sorted(names[:cut]), sorted(names[cut:])):
        everything = (1 << (1 << len(part))) - 1
        table = rng.randint(1, everything) | rng.choice([0, rng.randint(0, everything)])
        covers = [irredundant_cover(t, len(part)) for t in (table, everything & ~table)]
        factors.append(tuple([tuple((part[i], sign) for i, sign in term) for term in cover] for cover in covers))
        values = [sum((letter >> i & 1) << k for k, i in enumerate(part)) for letter in range(1 << n_aps)]
        whole &= sum(1 << letter for letter, value in enumerate(values) if table >> value & 1)
    assert conjunction(factors) == shortest_guard(whole, n_aps)  # type: ignore[arg-type]
