"""Closing values, where one letter is read for ever, against long simulations."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace

import numpy as np
import pytest
from random_ltl import random_formula
from rewards_reference import random_automaton

import ltlc
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.rewards import SCHEMES, RewardTables, Shaped, get_scheme, shape
from ltlc.rewards.closing import closing_values

MODES = ("stay", "initial", "terminate")
DISCOUNTED = {
    "thesis": get_scheme("thesis", gamma=0.9),
    "thesis-code": get_scheme("thesis-code", gamma=0.9),
    "sadigh": get_scheme("sadigh", gamma=0.9),
    "accept": get_scheme("accept", gamma=0.9),
    "zeta-reach": get_scheme("zeta-reach", zeta=0.8),
    "zeta-discount": get_scheme("zeta-discount", zeta=0.8),
    "two-discount": get_scheme("two-discount", gamma_accept=0.8, gamma=0.95),
    "eventual": get_scheme("eventual", gamma=0.8),
    "frontier": get_scheme("frontier", eta=0.8),
    "parity": get_scheme("parity", epsilon=0.4),
    "parity, terminate": get_scheme("parity", epsilon=0.4, mode="terminate"),
}
SEVERAL_PAIRS = ("FG a | GF b", "(FG a & GF b) | (FG !a & FG b)", "(FG a | GF b) & (FG b | GF !a)", "X(FG a | FG b)")


def simulated(tables: RewardTables, steps: int = 3000) -> np.ndarray:
    """The rewards of reading class c for so long from state q, discounted, when no pair is chosen any more."""
    c = np.arange(tables.n_classes)
    paid, weight = tables.reward + tables.stop * tables.stop_reward, (1 - tables.stop) * tables.discount
    total = np.zeros_like(paid)
    for _ in range(steps):
        total, before = paid + weight * total[tables.next_state, c], total
        if np.array_equal(total, before):
            break
    return total


def best_simulated(tables: RewardTables) -> np.ndarray:
    """The best of choosing a pair after any number of steps, and of never choosing."""
    later = simulated(tables)
    best = later.copy()
    for start, c in entries(tables):
        q, total, weight = start, 0.0, 1.0
        for _ in range(2 * tables.n_states):
            options = [total + weight * later[p, c] for p in tables.select_pair[q].tolist() if p >= 0]
            best[start, c] = max([best[start, c], *options])
            total += weight * (tables.reward[q, c] + tables.stop[q, c] * tables.stop_reward[q, c])
            weight *= (1 - tables.stop[q, c]) * tables.discount[q, c]
            q = int(tables.next_state[q, c])
    return best


def entries(tables: RewardTables) -> itertools.product[tuple[int, int]]:
    return itertools.product(range(tables.n_states), range(tables.n_classes))


@pytest.mark.slow
@pytest.mark.parametrize("name", DISCOUNTED)
def test_a_letter_for_ever_is_worth_what_a_long_simulation_earns(name: str) -> None:
    rng = random.Random(name)
    for case in range(25):
        dra = ltlc.compile(rng.choice(SEVERAL_PAIRS) if case % 3 == 0 else random_formula(rng, rng.randint(2, 8)))
        tables = DISCOUNTED[name].compile(dra, MODES[case % 3])
        assert tables.on_termination == "repeat"
        assert tables.closing == pytest.approx(best_simulated(tables), abs=1e-9, rel=1e-9)


def random_tables(rng: np.random.Generator, n: int, discounts: tuple[float, ...], choices: bool) -> RewardTables:
    """Tables without a meaning; with choices, those of the first half lead to the second half, which stays there."""
    shape = n, 2
    next_state = rng.integers(n, size=shape)
    select_pair = np.full((n, 2), -1)
    if choices:
        half = n // 2
        next_state[:half], next_state[half:] = rng.integers(half, size=(half, 2)), rng.integers(half, n, (n - half, 2))
        select_pair[:half] = rng.integers(half, n, size=(half, 2))
        select_pair[rng.random((n, 2)) < 0.5] = -1
    return RewardTables(
        aps=("a",), letter_class=[0, 1], initial_state=0, next_state=next_state,
        reward=rng.choice([-1.0, 0.0, 0.0, 2.0], size=shape), discount=rng.choice(discounts, size=shape),
        stop=rng.choice([0.0, 0.0, 0.2, 1.0], size=shape), stop_reward=rng.choice([0.0, 3.0, -1.0], size=shape),
        violated=np.zeros(shape), accepted=np.zeros(shape), automaton_state=np.zeros(n), progress=np.zeros(n),
        select_pair=select_pair,
    )  # fmt: skip


@pytest.mark.parametrize("choices", [False, True])
def test_any_tables_against_simulation(choices: bool) -> None:
    rng = np.random.default_rng(7)
    for _ in range(150):
        tables = random_tables(rng, int(rng.integers(2, 9)), (0.0, 0.5, 0.9), choices)
        values = closing_values(tables)
        assert values is not None
        assert values == pytest.approx(best_simulated(tables), abs=1e-9)


def pays_for_ever(tables: RewardTables, q: int, c: int) -> bool:
    """Whether reading class c from q ends in a cycle that pays, and neither discounts nor stops."""
    for _ in range(tables.n_states):
        q = int(tables.next_state[q, c])
    paid, weight, start = False, 1.0, q
    while True:
        paid |= bool(tables.expected_reward[q, c] != 0)
        weight *= tables.expected_discount[q, c]
        q = int(tables.next_state[q, c])
        if q == start:
            return paid and weight == 1


@pytest.mark.slow
def test_sums_without_a_value_are_found() -> None:
    rng = np.random.default_rng(1)
    found = {True: 0, False: 0}
    for _ in range(300):
        tables = random_tables(rng, int(rng.integers(1, 6)), (0.5, 1.0, 1.0, 1.0), False)
        endless = any(pays_for_ever(tables, q, c) for q, c in entries(tables))
        values = closing_values(tables)
        assert (values is None) == endless
        found[endless] += 1
        if values is not None:
            assert values == pytest.approx(simulated(tables), abs=1e-9)
    assert min(found.values()) > 50


def test_a_long_cycle_that_hardly_discounts() -> None:
    """One step in 10 007 pays and is discounted by 1 - 1e-9: the value is that of a geometric series."""
    n = 10_007
    zero, at = np.zeros((n, 1)), np.arange(n)[:, None] == n - 1
    tables = RewardTables(
        aps=(), letter_class=[0], initial_state=0, next_state=(np.arange(n)[:, None] + 1) % n, reward=1.0 * at,
        discount=np.where(at, 1 - 1e-9, 1.0), stop=zero, stop_reward=zero, violated=zero, accepted=zero,
        automaton_state=zero[:, 0], progress=zero[:, 0],
    )  # fmt: skip
    values = closing_values(tables)
    assert values is not None
    assert values[:, 0] == pytest.approx(1 / (1 - (1 - 1e-9)), rel=1e-12)


def test_undiscounted_pay_for_ever_stops_and_says_so() -> None:
    for scheme in (get_scheme("thesis", gamma=1.0), get_scheme("accept", gamma=1.0)):
        tables = scheme.compile(ltlc.compile("G F a"))
        assert tables.on_termination == "cut"
        assert not tables.closing.any()
    assert get_scheme("zeta-discount").compile(ltlc.compile("G F a")).on_termination == "repeat"


def test_what_never_choosing_costs_without_end_choosing_may_save() -> None:
    """State 0 pays -1 for ever, undiscounted; the pair that can be chosen pays nothing."""
    zero = np.zeros((2, 1))
    tables = RewardTables(
        aps=(), letter_class=[0], initial_state=0, next_state=[[0], [1]], reward=[[-1.0], [0.0]], discount=zero + 1,
        stop=zero, stop_reward=zero, violated=zero, accepted=zero, automaton_state=[0, 0], progress=[0, 0],
        select_pair=[[1], [-1]],
    )  # fmt: skip
    values = closing_values(tables)
    assert values is not None
    assert values.tolist() == [[0.0], [0.0]]


@pytest.mark.parametrize("name", sorted(SCHEMES))
def test_cut_leaves_nothing_behind(name: str) -> None:
    dra = ltlc.compile("G F a & F b")
    repeat, cut = (get_scheme(name).compile(dra, on_termination=mode) for mode in ("repeat", "cut"))
    assert cut.on_termination == "cut"
    assert not cut.closing.any()
    assert not cut.final_value.any()
    assert repeat.on_termination == "repeat"
    for column in ("reward", "discount", "stop", "stop_reward", "next_state"):
        assert np.array_equal(getattr(repeat, column), getattr(cut, column))


def test_shaping_takes_the_potential_back_at_the_end() -> None:
    """Whatever follows the end of the environment, shaping changes a step that ends there by the potential before."""
    rng = np.random.default_rng(3)
    for choices in (False, True):
        tables = random_tables(rng, 6, (0.5, 0.9, 1.0), choices)
        tables = replace(tables, closing=rng.normal(size=(6, 2)))
        potential = np.repeat(rng.normal(size=1), 6) if choices else rng.normal(size=6)
        shaped = shape(tables, potential)
        plain, changed = (t.expected_reward + t.expected_discount * t.final_value for t in (tables, shaped))
        assert changed == pytest.approx(plain - potential[:, None])


def test_shaped_closing_values_are_those_of_the_shaped_rewards() -> None:
    """Where everything is discounted, the closing value of the shaped tables is also what their rewards add up to."""
    rng = random.Random(5)
    for _ in range(20):
        dra = ltlc.compile(random_formula(rng, rng.randint(3, 8)))
        tables = Shaped(DISCOUNTED["two-discount"], 2.0).compile(dra)
        values = closing_values(tables)
        assert values is not None
        assert tables.closing == pytest.approx(values, abs=1e-12)


def test_final_values_are_those_of_the_state_entered() -> None:
    tables = DISCOUNTED["eventual"].compile(random_automaton(4))
    for q, c in entries(tables):
        assert tables.final_value[q, c] == tables.closing[tables.next_state[q, c], c]


def test_bad_input() -> None:
    dra = ltlc.compile("G F a")
    with pytest.raises(UnknownNameError, match=r"unknown termination mode 'stop'.*"):
        get_scheme("eventual").compile(dra, on_termination="stop")
    tables = get_scheme("eventual").compile(dra)
    with pytest.raises(InvalidArgumentError, match="closing has an entry that is not finite"):
        replace(tables, closing=np.full_like(tables.closing, np.inf))
    with pytest.raises(InvalidArgumentError, match="closing has shape"):
        replace(tables, closing=np.zeros((7, 1)))
    with pytest.raises(InvalidArgumentError, match="on_termination is 'stop'"):
        replace(tables, on_termination="stop")
