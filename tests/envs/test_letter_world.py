"""LetterWorld: maps, views and exact optima against slow definitions."""

from __future__ import annotations

from collections import Counter, deque
from typing import Any

import numpy as np
import pytest

from ltlc.compiler import compile
from ltlc.envs import LetterWorld, VectorLetterWorld
from ltlc.envs.letter_world import MOVES, _valid
from ltlc.errors import InvalidArgumentError, UnknownNameError


def is_valid(marked: set[int], size: int) -> bool:
    """Whether a search from (0, 0) that does not go on from marked cells sees all cells."""
    seen, queue = {0}, deque([0])
    while queue:
        cell = queue.popleft()
        if cell in marked:
            continue
        for dr, dc in MOVES:
            after = (cell // size + dr) % size * size + (cell % size + dc) % size
            if after not in seen:
                seen.add(after)
                queue.append(after)
    return len(seen) == size * size


@pytest.mark.parametrize(("size", "density"), [(2, 0.4), (3, 0.4), (5, 0.4), (7, 0.4), (8, 0.3)])
def test_valid_maps_are_those_of_the_search(size: int, density: float) -> None:
    draw = np.random.default_rng(0)
    chosen = draw.random((2_000, size * size)) < density
    chosen[:, 0] = False
    words = np.array([sum(1 << int(c) for c in np.flatnonzero(row)) for row in chosen], dtype=np.uint64)
    truth = [is_valid({*np.flatnonzero(row).tolist()}, size) for row in chosen]
    assert _valid(words, size).tolist() == truth
    assert 20 < sum(truth) < 1_980


@pytest.mark.parametrize("arguments", [{}, {"size": 5, "letters": ("x", "yy"), "each": 3}, {"size": 8, "each": 1}])
def test_maps_are_as_they_should_be(arguments: dict[str, Any]) -> None:
    world = VectorLetterWorld(50, **arguments)
    world.reset(seed=4)
    n_letters, each = len(world.propositions), arguments.get("each", 2)
    for row in world._map.tolist():
        count = Counter(row)
        assert [count[k] for k in range(1, n_letters + 1)] == [each] * n_letters
        assert row[0] == 0
        assert is_valid({cell for cell, kind in enumerate(row) if kind}, world.size)


@pytest.mark.slow
def test_all_valid_maps_are_equally_probable() -> None:
    """On 3 x 3 with three letters, against a list of all; 30 000 draws, to 5 standard errors."""
    world = VectorLetterWorld(30_000, size=3, letters="abc", each=1)
    world.reset(seed=0)
    counts = Counter(map(tuple, world._map.tolist()))
    valid = 6 * sum(is_valid({a, b, c}, 3) for a in range(1, 9) for b in range(1, a) for c in range(1, b))
    assert len(counts) == valid
    mean = 30_000 / valid
    assert all(abs(count - mean) < 5 * mean**0.5 for count in counts.values())


def test_moves_views_and_labels_follow_the_map() -> None:
    world = VectorLetterWorld(20, max_episode_steps=30)
    world.reset(seed=1)
    at = np.zeros((20, 2), dtype=int)
    draw = np.random.default_rng(3)
    for _ in range(30):
        actions = draw.integers(0, 4, 20)
        at = (at + np.array(MOVES)[actions]) % 7
        seen, *_, infos = world.step(actions)
        assert seen.dtype == np.uint8
        for i, (row, column) in enumerate(at.tolist()):
            grid = np.roll(world._map[i].reshape(7, 7), (3 - row, 3 - column), (0, 1))
            assert (seen[i] == (grid[:, :, None] == np.arange(1, 13))).all()
            assert infos["labels"][i] == (1 << int(grid[3, 3])) >> 1


def fewest(world: VectorLetterWorld, i: int, automaton: Any) -> int:
    """Breadth-first search on one map, a step at a time."""
    kinds = world._map[i].tolist()
    sinks = {*np.asarray(automaton.accepting_sinks).tolist()}
    start = (0, automaton.step(automaton.initial_state, set()))
    seen, queue = {start}, deque([(start, 0)])
    while queue:
        (cell, state), steps = queue.popleft()
        if state in sinks:
            return steps
        for dr, dc in MOVES:
            after = (cell // 7 + dr) % 7 * 7 + (cell % 7 + dc) % 7
            label = {world.propositions[kinds[after] - 1]} & {*automaton.aps} if kinds[after] else set()
            node = (after, automaton.step(state, label))
            if node not in seen:
                seen.add(node)
                queue.append((node, steps + 1))
    return -1


def test_optimal_steps_are_those_of_a_search() -> None:
    world = VectorLetterWorld(8)
    world.reset(seed=2)
    for formula in ("!a U (b & (!c U d))", "F(a & (!b U c)) & F d", "X a", "G a"):
        automaton = compile(formula)
        assert world.optimal_steps(automaton).tolist() == [fewest(world, i, automaton) for i in range(8)]
    with pytest.raises(UnknownNameError, match="zz"):
        world.optimal_steps("F zz")


@pytest.mark.filterwarnings("ignore:f is read:ltlc.ltl.LtlSyntaxWarning")
@pytest.mark.parametrize(("formula", "steps"), [
    ("F(a & (!b U c)) & F d", 6.70),
    ("(F d) & (!f U (d & F b))", 5.24),
    ("F((a | c | j) & F b) & F(c & F d) & F k", 8.29),
    ("!a U (b & (!c U (d & (!e U f))))", 7.84),
    ("((a | b | c | d) -> F(e & F(f & F g))) U (h & F i)", 5.30),
    ("F(d & (!(a | b) U (i & (!e U c)))) & F(!(f | g | h) U a)", 9.19),
    ("!(j | b | d) U (a & (!c U (f & F(g & (!d U e)))))", 10.31),
])  # fmt: skip
def test_the_means_of_the_optimum_are_known(formula: str, steps: float) -> None:
    """Means over 1 000 maps that were found elsewhere, to 5 standard errors of both."""
    world = VectorLetterWorld(1_000)
    world.reset(seed=0)
    found = world.optimal_steps(formula)
    assert (found > 0).all()
    assert abs(found.mean() - steps) < 5 * found.std() * (2 / 1_000) ** 0.5


@pytest.mark.parametrize(("arguments", "message"), [
    ({"size": 9}, "a torus of 9 x 9 cells"),
    ({"letters": "aa"}, "each named once"),
    ({"letters": ""}, "there is a letter"),
    ({"each": 0}, "on one cell at least"),
    ({"size": 2, "each": 4, "letters": "a"}, "4 cells with letters leave none free of 2 x 2"),
])  # fmt: skip
def test_wrong_worlds_are_explained(arguments: dict[str, Any], message: str) -> None:
    for make in (LetterWorld, VectorLetterWorld):
        with pytest.raises(InvalidArgumentError, match=message):
            make(**arguments)


def test_a_full_torus_is_explained() -> None:
    with pytest.raises(InvalidArgumentError, match="there is no valid map"):
        LetterWorld(size=3, each=4, letters="ab").reset(seed=0)
