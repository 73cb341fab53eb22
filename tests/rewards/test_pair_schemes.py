"""Every scheme on every automaton: tables by hand, and exact satisfaction probabilities of optimal policies."""

from __future__ import annotations

import numpy as np
import pytest
from mdp_cases import safely
from pair_policies import true_satisfaction
from random_models import random_automaton, random_mdp

from ltlc.automata import DRA
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import (
    LabelledMDP,
    Product,
    RewardProduct,
    max_satisfaction_probability,
    optimal_return,
    state_return,
)
from ltlc.rewards import SCHEMES, RewardScheme, RewardTables, get_scheme
from ltlc.task import Task

GUARANTEED = {
    "zeta-reach": get_scheme("zeta-reach", zeta=0.9999),
    "zeta-discount": get_scheme("zeta-discount", zeta=0.9999),
    "two-discount": get_scheme("two-discount", gamma_accept=0.999, gamma=0.9999999),
    "eventual": get_scheme("eventual", gamma=0.9999),
    "frontier": get_scheme("frontier", eta=0.9999),
    "parity, adaptive": get_scheme("parity", epsilon=0.005),
    "parity, terminate": get_scheme("parity", epsilon=0.005, mode="terminate"),
}
TWO_PAIRS = "(FG goal0 | FG goal1) & G !trap"


def two_pairs_world() -> LabelledMDP:
    """2x2 cells; moving flips the row or the column, by chance; resting stays (Mungojerrie's twoPairs)."""
    p = np.zeros((2, 4, 4))
    for cell in range(4):
        row, column = divmod(cell, 2)
        p[0, cell, [(1 - row) * 2 + column, row * 2 + 1 - column]] = 0.5
        p[1, cell, cell] = 1
    aps = ("goal0", "goal1", "trap")
    return LabelledMDP.from_arrays(p, aps=aps, labels={2: "goal0", 1: "goal1", 3: "trap"})


def both_pairs() -> DRA:
    """The formula as an automaton with one pair for each goal."""
    pairs = [(lambda x, p=p: p not in x, lambda x, p=p: p in x) for p in ("goal0", "goal1")]
    return safely(["goal0", "goal1", "trap"], "trap", pairs)


def optimal(mdp: LabelledMDP, tables: RewardTables) -> tuple[float, np.ndarray]:
    """The optimal return from the start, and an optimal policy on (MDP state, table state)."""
    product = RewardProduct(mdp, tables)
    solution = optimal_return(product)
    policy = np.zeros((mdp.n_states, tables.n_states), dtype=int)
    policy[product.mdp_state, product.machine_state] = solution.policy
    return float(product.initial @ solution.value), policy


@pytest.mark.parametrize("scheme", GUARANTEED)
@pytest.mark.parametrize("kind", ["state", "transition", "two pairs"])
def test_two_pairs_are_satisfied_surely(scheme: str, kind: str) -> None:
    task = Task(
        both_pairs() if kind == "two pairs" else TWO_PAIRS,
        GUARANTEED[scheme],
        acceptance="state" if kind == "state" else "transition",
    )
    world = two_pairs_world()
    value, policy = optimal(world, task.tables)
    assert true_satisfaction(world, task.automaton, task.tables, policy) == 1.0
    best = task.scheme.steps(task.scheme.refinement(task.automaton).automaton).satisfaction
    assert value == pytest.approx(best, rel=2e-2)


def test_the_first_pair_alone_is_not_enough() -> None:
    world, automaton = two_pairs_world(), both_pairs()
    fixed = Task(automaton, get_scheme("sadigh", pair=0, gamma=0.999, weight_fin=1000.0))
    assert true_satisfaction(world, automaton, fixed.tables, optimal(world, fixed.tables)[1]) == pytest.approx(2 / 3)
    chosen = Task(automaton, get_scheme("sadigh", gamma=0.999, weight_fin=1000.0))
    assert chosen.tables.n_choices == 2
    assert true_satisfaction(world, automaton, chosen.tables, optimal(world, chosen.tables)[1]) == 1.0


@pytest.mark.parametrize("scheme", GUARANTEED)
def test_guarantees_hold_on_random_tasks(scheme: str) -> None:
    """The optimal policy for the rewards satisfies as probably as any, whatever the automaton and the process."""
    refined = 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        mdp, automaton = random_mdp(rng, 5, 2), random_automaton(rng, 3, 1 + seed % 3)
        tables = GUARANTEED[scheme].compile(automaton)
        best = max_satisfaction_probability(Product(mdp, automaton)).probability
        _, policy = optimal(mdp, tables)
        assert true_satisfaction(mdp, automaton, tables, policy) == pytest.approx(best, abs=2e-3), seed
        refined += tables.n_states > automaton.n_states
    assert refined > 1


def test_parity_weights_that_rounding_would_swallow_are_refused() -> None:
    automaton = Task("(GF a | FG b) & (GF c | FG d)").automaton
    get_scheme("parity").compile(automaton)
    with pytest.raises(InvalidArgumentError, match=r"take epsilon 0\.00"):
        get_scheme("parity", epsilon=1e-6).compile(automaton)


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_takes_every_automaton(name: str) -> None:
    for seed in range(40):
        automaton = random_automaton(np.random.default_rng(seed), 4, 1 + seed % 3)
        for mode in ("stay", "initial", "terminate"):
            tables = get_scheme(name, shaping=float(seed % 2)).compile(automaton, mode)  # type: ignore[arg-type]
            behind = tables.automaton_state
            entered = automaton.delta[behind]
            assert tables.letter_class.tolist() == automaton.letter_class.tolist()
            assert behind[tables.initial_state] == automaton.initial_state
            assert (tables.violated == np.isin(entered, automaton.deadlocks)).all()
            kept = ~tables.violated | (mode == "terminate")
            assert (behind[tables.next_state] == entered)[kept].all()
            made = tables.select_pair >= 0
            assert (behind[tables.select_pair] == behind[:, None])[made].all()
            assert (tables.progress[tables.select_pair] == tables.progress[:, None])[made].all()


def test_a_broken_promise_ends_the_episode_and_is_no_violation() -> None:
    fg = DRA(("a",), [[0, 0]], [0, 1], [[[1, 0]]], [[[0, 1]]], acceptance="transition", formula="FG a")
    tables = get_scheme("zeta-discount", zeta=0.9).compile(fg)
    assert tables.select_pair.tolist() == [[1], [-1]]
    assert tables.reward.tolist() == [[0, 0], [0, 1]]
    assert tables.stop.tolist() == [[0, 0], [1, 0]]
    assert tables.next_state.tolist() == [[0, 0], [0, 1]]
    assert not tables.violated.any()
    assert tables.accepted.tolist() == [[False, False], [False, True]]


def test_one_pair_changes_nothing() -> None:
    for name in ("thesis", "thesis-code", "sadigh", "accept", "parity"):
        task = Task("FG a", name)
        assert task.tables.n_choices == 0
        assert task.tables.automaton_state.tolist() == list(range(task.automaton.n_states))


def test_shaping_with_choices_keeps_optimal_policies() -> None:
    world, automaton = two_pairs_world(), both_pairs()
    shaped: RewardScheme = get_scheme("zeta-discount", zeta=0.99, shaping=5.0)
    plain = RewardProduct(world, get_scheme("zeta-discount", zeta=0.99).compile(automaton))
    other = RewardProduct(world, shaped.compile(automaton))
    policy = np.array([plain.actions_in(s)[-1] for s in range(plain.n_states)])
    difference = state_return(other, policy) - state_return(plain, policy)
    tables = shaped.compile(automaton)
    assert difference == pytest.approx(-5.0 * tables.progress[other.machine_state])
