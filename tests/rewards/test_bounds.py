"""Bounds of values against all words up to a length, and against words that go round for ever."""

import dataclasses

import numpy as np
import pytest

from ltlc import Task
from ltlc.rewards import RewardTables, get_scheme
from ltlc.rewards.bounds import value_bounds

TASKS = ["F a & G !b", "GF a | FG b", "a U b", "FG a | GF b", "(a -> F b) U (b & !a)"]


def random_tables(seed: int, *, most: float = 0.5) -> RewardTables:
    g = np.random.default_rng(seed)
    n, k = 4, 2
    stop = np.where(g.random((n, k)) < 0.2, 1.0, g.choice([0.0, 0.25], (n, k)))
    select_pair = np.full((n, 2), -1)
    select_pair[0] = [2, 3 if g.random() < 0.5 else -1]
    following = g.integers(n, size=(n, k))
    following[2:] = g.integers(2, n, size=(2, k))  # a choice is made once
    return RewardTables(
        aps=("a",), letter_class=np.array([0, 1]), initial_state=0, next_state=following,
        reward=g.integers(-3, 4, (n, k)) / 2, discount=most * g.random((n, k)), stop=stop,
        stop_reward=g.integers(-2, 3, (n, k)) / 1.0, violated=np.zeros((n, k), bool), accepted=np.zeros((n, k), bool),
        automaton_state=np.arange(n), progress=np.zeros(n), select_pair=select_pair, closing=g.normal(size=(n, k)),
    )  # fmt: skip


def by_words(tables: RewardTables, length: int, *, best: bool) -> np.ndarray:
    """What each state is worth if a word of so many letters is the best or the worst, and nothing follows."""
    take = max if best else min

    def act(state: int, left: int) -> float:
        if left == 0:
            return 0.0
        values = []
        for c in range(tables.n_classes):
            weight = tables.expected_discount[state, c]
            for following in (stand(int(tables.next_state[state, c]), left - 1), tables.final_value[state, c]):
                values.append(tables.expected_reward[state, c] + weight * following)
        return float(take(values))

    def stand(state: int, left: int) -> float:
        if (state, left) not in known:
            options = [state, *(int(i) for i in tables.select_pair[state] if i >= 0)]
            known[state, left] = max(act(option, left) for option in options)
        return known[state, left]

    known: dict[tuple[int, int], float] = {}
    return np.array([act(state, length) for state in range(tables.n_states)])


@pytest.mark.parametrize("seed", range(30))
def test_bounds_equal_the_best_and_the_worst_of_all_long_words(seed: int) -> None:
    tables = random_tables(seed)
    bounds = value_bounds(tables)
    assert np.allclose(bounds.largest, by_words(tables, 40, best=True), rtol=0, atol=1e-9)
    least = by_words(tables, 40, best=False)
    assert (bounds.least <= least + 1e-9).all()
    alone = dataclasses.replace(tables, select_pair=np.zeros((4, 0), dtype=np.int32))
    assert np.allclose(value_bounds(alone).least, by_words(alone, 40, best=False), rtol=0, atol=1e-9)


@pytest.mark.parametrize("formula", TASKS)
@pytest.mark.parametrize("scheme", ["two-discount", "zeta-reach"])
def test_values_of_probabilities_lie_in_the_unit_interval(formula: str, scheme: str) -> None:
    tables = Task(formula, scheme).tables
    bounds = value_bounds(tables)
    assert (bounds.least >= -1e-9).all() and (bounds.largest <= 1 + 1e-9).all()
    assert bounds.largest[tables.initial_state] > 0.97
    assert (bounds.least <= bounds.largest).all()


@pytest.mark.parametrize("formula", TASKS)
def test_undiscounted_waiting_is_worth_nothing_and_ends(formula: str) -> None:
    tables = Task(formula, get_scheme("two-discount", gamma=1.0)).tables
    assert np.allclose(value_bounds(tables).largest[tables.initial_state], 1)
    assert value_bounds(tables).least[tables.initial_state] == 0


def test_pay_without_end_has_no_bound_and_pay_that_can_be_left_has() -> None:
    tables = Task("F a", get_scheme("thesis", gamma=1.0)).tables
    bounds = value_bounds(tables)
    assert bounds.least[tables.initial_state] == -np.inf
    assert bounds.largest[tables.initial_state] == -1  # at once
    discounted = Task("F a", "thesis").tables
    assert np.isclose(value_bounds(discounted).least[discounted.initial_state], -100)


def test_an_unbounded_state_is_seen_from_where_it_can_be_reached() -> None:
    tables = dataclasses.replace(random_tables(0), reward=np.ones((4, 2)), discount=np.ones((4, 2)),
                                 stop=np.zeros((4, 2)), stop_reward=np.zeros((4, 2)))  # fmt: skip
    assert np.isinf(value_bounds(tables).largest).all()
