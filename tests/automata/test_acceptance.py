"""Acceptance conditions by truth table, and Rabin pairs and cycle decompositions against them."""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import reduce as fold

import pytest

from ltlc.automata.acceptance import (
    ALWAYS,
    NEVER,
    Acceptance,
    Clause,
    conjunction,
    disjunction,
    holds,
    negation,
    restrict,
    simplify,
    without_implied,
)
from ltlc.automata.cycles import CycleDecomposition
from ltlc.automata.emptiness import MarkedEdge
from ltlc.automata.rabin_pairs import Counters, CycleMemory


def random_condition(rng: random.Random, n_marks: int, n_promises: int = 0) -> Acceptance:
    def some() -> int:
        return sum(1 << m for m in range(n_marks) if rng.random() < 0.3)

    def promises() -> Iterator[tuple[int, int]]:
        for _ in range(rng.randint(0, n_promises)):
            yield 1 << rng.randrange(n_marks), 1 << rng.randrange(n_marks)

    return tuple(Clause(some(), some(), tuple(promises())) for _ in range(rng.randint(0, 4)))


@pytest.mark.slow
def test_conditions_by_truth_table() -> None:
    rng = random.Random(9)
    n_marks = 4
    for _ in range(400):
        a, b = random_condition(rng, n_marks, 2), random_condition(rng, n_marks, 2)
        possible = rng.randrange(1 << n_marks)
        certain = possible & rng.randrange(1 << n_marks)
        for seen in range(1 << n_marks):
            x, y = holds(a, seen), holds(b, seen)
            assert holds(simplify(a), seen) == x
            assert holds(negation(a), seen) == (not x)
            assert holds(negation(a, with_promises=True), seen) == (not x)
            assert holds(conjunction(a, b), seen) == (x and y)
            assert holds(disjunction(a, b), seen) == (x or y)
            if not seen & ~possible and not certain & ~seen:
                assert holds(restrict(a, possible, certain), seen) == x
    for _ in range(400):
        edges = [rng.randrange(1 << n_marks) for _ in range(rng.randint(1, 4))]
        implied = {m: fold(int.__and__, (e for e in edges if e >> m & 1), -1) for m in range(n_marks)}
        a = random_condition(rng, n_marks, 2)
        for chosen in range(1, 1 << len(edges)):
            seen = fold(int.__or__, (e for i, e in enumerate(edges) if chosen >> i & 1))
            assert holds(without_implied(a, implied), seen) == holds(a, seen)
    assert negation(ALWAYS) == NEVER and negation(NEVER) == ALWAYS


# -- Rabin pairs ------------------------------------------------------------------------------------------------------


def cycle_memory(condition: Acceptance, edges: list[MarkedEdge]) -> CycleMemory:
    return CycleMemory(CycleDecomposition(condition, edges, 1000))


def run_memory(memory: Counters | CycleMemory, cycle: list[MarkedEdge]) -> bool:
    """Whether the pairs accept the cycle taken for ever."""
    at = memory.start(cycle[0][0])
    rounds: list[list[int]] = []
    starts: list[int] = []
    while at not in starts:
        starts.append(at)
        rounds.append([])
        for edge in cycle:
            at, marks = memory.move(at, edge)
            rounds[-1].append(marks)
    seen = fold(int.__or__, [marks for of_round in rounds[starts.index(at) :] for marks in of_round])
    return any(seen >> 2 * i & 3 == 2 for i in range(memory.n_pairs))


def test_pairs_express_any_condition_on_any_component() -> None:
    """Random strong components, random walks around them: counters and cycle decomposition agree with the condition."""
    rng = random.Random(10)
    for _ in range(250):
        n = rng.randint(1, 4)
        edges = [(q, (q + 1) % n, rng.randrange(16)) for q in range(n)]
        edges += [(rng.randrange(n), rng.randrange(n), rng.randrange(16)) for _ in range(rng.randint(0, 5))]
        edges = list(dict.fromkeys(edges))
        condition = simplify(random_condition(rng, 4))
        memories = Counters(condition), cycle_memory(condition, edges)
        for _ in range(12):
            walk = [rng.choice([e for e in edges if e[0] == 0])]
            while walk[-1][1] != 0 or rng.random() < 0.6:
                walk.append(rng.choice([e for e in edges if e[0] == walk[-1][1]]))
            truth = holds(condition, fold(int.__or__, (marks for _, _, marks in walk)))
            assert [run_memory(memory, walk) for memory in memories] == [truth, truth], (condition, walk)


def test_cycle_decomposition_by_hand() -> None:
    loops = [(0, 0, 1 << m) for m in range(3)]
    needs_all = (Clause(0, 0b111),)
    assert cycle_memory(needs_all, loops).size([0]) == 3  # one leaf for each pair of loops that lacks one
    assert Counters(needs_all).size([0]) == 3
    assert cycle_memory((Clause(0, 1), Clause(0, 2), Clause(0, 4)), loops).size([0]) == 1
    parity_like = (Clause(0, 0b001), Clause(0b010, 0b100))
    assert cycle_memory(parity_like, loops).size([0]) == 1
    streett = (Clause(0b001, 0), Clause(0, 0b110))  # Fin(0) | Inf(1) & Inf(2)
    assert cycle_memory(streett, loops).n_pairs >= 1
    everything = cycle_memory(ALWAYS, loops)
    assert (everything.n_pairs, everything.size([0])) == (1, 1)


def test_clauses_with_equal_lists_share_a_counter() -> None:
    assert Counters((Clause(0b100, 0b011), Clause(0b1000, 0b011))).size([0, 1]) == 4
    assert Counters((Clause(0b100, 0b011), Clause(0b100, 0b11000))).size([0, 1]) == 8
    assert Counters((Clause(0, 1), Clause(2, 4))).size([0, 1]) == 2
