"""Proved bounds: that they hold in exact arithmetic, and that they are narrow where runs may dawdle."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from mdp_cases import sequence
from mdp_exact import ExactTask
from random_models import random_mdp, storm_value
from scipy import sparse
from suite_tasks import DOWN, LEFT, RIGHT, STAY, UP, grid, intended

from ltlc import compile
from ltlc.cli.verdicts import between
from ltlc.mdp import LabelledMDP, Product, max_reachability, max_satisfaction_probability, satisfaction_probability
from ltlc.mdp.certified import best_policy
from ltlc.mdp.explicit import ExplicitMDP
from ltlc.mdp.gauss_seidel import GaussSeidel
from ltlc.mdp.induction import ReachAvoid
from ltlc.mdp.topological_blocks import topological_blocks

MOVES = [UP, RIGHT, DOWN, LEFT, STAY]


def scaled_world(side: int, chance: float, *, blocks: bool = False, start: tuple[int, int] = (4, 1)) -> LabelledMDP:
    """The thesis' 10x10 map with every coordinate multiplied; with `blocks`, obstacles and places grow too."""
    factor = side // 10
    map_ = {(2, 7): "A", (5, 2): "B", (8, 8): "T", **{(i, i): "C" for i in range(2, 7)}}
    size = factor if blocks else 1
    labels = {
        (factor * row + i, factor * column + j): name
        for (row, column), name in map_.items()
        for i in range(size)
        for j in range(size)
    }
    start = (start[0] * factor, start[1] * factor)
    return grid(side, side, intended(MOVES, chance), labels, aps=tuple("ABCT"), start=start)


@pytest.mark.parametrize("tiny", [False, True])
@pytest.mark.parametrize("seed", range(30))
def test_bounds_hold_the_exact_value(seed, tiny):
    task = ExactTask(seed, tiny=tiny)
    exact = task.probabilities()
    product = Product(task.model(), task.automaton)
    truth = [exact[int(s), int(q)] for s, q in zip(product.mdp_state, product.automaton_state, strict=True)]
    assert len(exact) == product.n_states
    best = max_satisfaction_probability(product)
    attained = satisfaction_probability(product, best.policy)
    for found in (best, attained):  # an optimal policy attains the optimum
        assert all(Fraction(x) <= p for x, p in zip(found.state_lower.tolist(), truth, strict=True))
        assert all(abs(Fraction(x) - p) < 1e-9 for x, p in zip(found.state_probability.tolist(), truth, strict=True))
        assert all(Fraction(x) >= p for x, p in zip(found.state_upper.tolist(), truth, strict=True))
        assert (found.state_upper - found.state_lower).max() < 1e-9


@pytest.mark.parametrize(
    ("side", "chance", "blocks"),
    [(10, 0.6, False), (30, 0.6, False), (30, 0.3, True), (30, 0.2, True), (50, 0.4, True)],
)
def test_bounds_are_narrow_where_policies_may_dawdle(side, chance, blocks):
    """From a corner, a policy can make a run last for more steps than a double has digits for."""
    product = Product(scaled_world(side, chance, blocks=blocks), sequence("ABT", "C"))
    best = max_satisfaction_probability(product)
    assert (best.state_upper - best.state_lower).max() < 1e-8
    assert (best.state_lower <= best.state_probability).all()
    assert (best.state_probability <= best.state_upper).all()
    attained = satisfaction_probability(product, best.policy)
    assert attained.probability == pytest.approx(best.probability, abs=1e-9)
    assert attained.upper - attained.lower < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize(("chance", "blocks"), [(0.6, False), (0.4, True), (0.2, True)])
def test_large_processes_are_solved_in_parts(monkeypatch, chance, blocks):
    product = Product(scaled_world(30, chance, blocks=blocks), sequence("ABT", "C"))
    whole = max_satisfaction_probability(product)
    monkeypatch.setattr("ltlc.mdp.topological_blocks.SMALLEST", 500)
    monkeypatch.setattr("ltlc.mdp.certified.LINEAR_SOLVE_LIMIT", 0)
    apart = max_satisfaction_probability(product)
    assert apart.state_probability == pytest.approx(whole.state_probability, abs=1e-9)
    attained = satisfaction_probability(product, apart.policy)
    for found in (apart, attained):
        assert (found.state_upper - found.state_lower).max() < 1e-8
        assert (found.state_lower <= whole.state_upper).all()
    assert (apart.state_upper >= whole.state_lower).all()


def choose(*rows: list[float], n: int) -> ExplicitMDP:
    """State 0 has the given choices; all others are absorbing."""
    matrices = np.tile(np.eye(n), (len(rows), 1, 1))
    matrices[:, 0] = rows
    return LabelledMDP.from_arrays(matrices).explicit


def test_a_state_that_is_hardly_ever_left():
    """The linear system would lose four digits to 1 - (1 - 1e-12)."""
    reach = max_reachability(choose([1 - 1e-12, 5e-13, 5e-13], n=3), np.array([False, True, False]))
    assert reach.value[0] == pytest.approx(0.5, abs=1e-12)
    assert reach.lower[0] <= 0.5 <= reach.upper[0]
    assert reach.upper[0] - reach.lower[0] < 1e-12


def test_patience_pays():
    """Staying for 1e12 steps wins more often than going at once."""
    mdp = choose([1 - 1e-12, 0.99e-12, 0.01e-12], [0, 0.95, 0.05], n=3)
    reach = max_reachability(mdp, np.array([False, True, False]))
    assert reach.value[0] == pytest.approx(0.99, abs=1e-12)
    assert reach.choice[0] == 0


@pytest.mark.parametrize("rare", [1e-6, 1e-8, 1e-10])
def test_a_cycle_that_is_hardly_ever_left(rare):
    """The bounds may be wide here, but they hold."""
    walk = np.array([[0, 1 - rare, rare, 0], [1 - rare, 0, 0, rare], [0, 0, 1, 0], [0, 0, 0, 1]])
    reach = max_reachability(LabelledMDP.from_arrays([walk]).explicit, np.arange(4) == 2)
    exact = 1 / (2 - rare)
    assert reach.lower[0] <= exact <= reach.upper[0]
    assert reach.value[0] == pytest.approx(exact, abs=1e-6)


def race(seed: int, n: int) -> ReachAvoid:
    """Two choices per state, some of which may stay; all may end."""
    rng = np.random.default_rng(seed)
    weight = rng.random((2 * n, n + 2)) * (rng.random((2 * n, n + 2)) < 4 / n)
    weight[:, rng.integers(n, n + 2, size=2 * n)] += 1e-3
    weight /= weight.sum(axis=1, keepdims=True)
    gain, lose = weight[:, n], weight[:, n + 1]
    start, action = np.arange(0, 2 * n + 1, 2), np.tile([0, 1], n)
    return ReachAvoid(
        ExplicitMDP(sparse.csr_array(weight[:, :n]), start, action, np.zeros(n), exit_probability=gain + lose),
        gain,
        lose,
    )


@pytest.mark.parametrize("seed", range(10))
def test_a_race_without_loops_has_the_same_winner(seed):
    with_loops = best_policy(race(seed, 8))
    without = best_policy(race(seed, 8).without_loops())
    assert without.value == pytest.approx(with_loops.value, abs=1e-12)
    assert (without.upper - without.lower).max() < 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_improved_values_bound_the_probability(seed):
    """From anywhere below, and within a few quanta where it began at the truth."""
    given = race(seed, 12).without_loops()
    truth = best_policy(given)
    for start, far in ((np.zeros(12), 1e-3), (truth.value, 1e-5)):
        value = start.copy()
        assert given.improved(value, np.arange(12), 2.0**-30, 1e4)
        assert (value >= truth.lower).all()
        assert (value <= truth.upper + far).all()
        assert (given.drift(value, np.arange(24), 1) <= 0).all()
    assert not given.sinks_nowhere(truth.upper + 0.1, truth.chosen)
    assert not given.improved(np.zeros(12), np.arange(12), 2.0**-50, 1)


@pytest.mark.parametrize("chunk", [1, 7, 50, 10_000])
def test_drift_is_the_same_in_chunks(monkeypatch, chunk):
    given, value = race(0, 12), np.random.default_rng(0).random(12)
    gaps = value[None, :] - np.repeat(value, 2)[:, None]
    here = np.repeat(value, 2)
    exact = (given.mdp.matrix.toarray() * gaps).sum(axis=1) + given.gain * (1 - here) - given.lose * here
    monkeypatch.setattr("ltlc.mdp.induction._CHUNK", chunk)
    some = np.array([0, 3, 4, 17, 23])
    for choices in (np.arange(24), some):
        assert given.drift(value, choices, 0) == pytest.approx(exact[choices], abs=1e-14)
        assert (given.drift(value, choices, 1) > exact[choices]).all()
        assert (given.drift(value, choices, -1) < exact[choices]).all()


def test_parts_come_after_what_they_lead_to(monkeypatch):
    monkeypatch.setattr("ltlc.mdp.topological_blocks.SMALLEST", 100)
    product = Product(scaled_world(20, 0.6), sequence("ABT", "C"))
    found = list(topological_blocks(product))
    assert len(found) > 1
    assert sorted(np.concatenate(found).tolist()) == list(range(product.n_states))
    number = np.empty(product.n_states, dtype=int)
    for k, states in enumerate(found):
        number[states] = k
    edges = product.adjacency.tocoo()
    assert (number[edges.coords[1]] <= number[edges.coords[0]]).all()


@pytest.mark.parametrize("seed", range(5))
def test_gauss_seidel_agrees_with_a_dense_solve(seed):
    rng = np.random.default_rng(seed)
    matrix = rng.random((20, 20)) * (rng.random((20, 20)) < 0.3)
    matrix *= 0.95 / matrix.sum(axis=1, keepdims=True).clip(1e-9)
    gain = rng.random(20)
    chain = GaussSeidel(sparse.csr_array(matrix), rng.permutation(20))
    value, settled = chain.run(gain, np.zeros(20), 1e-13, 10_000)
    assert settled
    assert value == pytest.approx(np.linalg.solve(np.eye(20) - matrix, gain))
    assert not chain.run(gain, np.zeros(20), 1e-13, 2)[1]


@pytest.mark.parametrize("seed", range(20))
def test_the_walk_of_a_gambler(seed):
    """A fixed policy, biased to either side; compared with the formula."""
    n, up = 40, 0.3 + 0.02 * seed
    walk = up * np.eye(n + 1, k=1) + (1 - up) * np.eye(n + 1, k=-1)
    walk[[0, -1]] = np.eye(n + 1)[[0, -1]]
    reach = max_reachability(LabelledMDP.from_arrays([walk]).explicit, np.arange(n + 1) == n)
    odds = Fraction(1 - up) / Fraction(up)
    exact = [Fraction(i, n) if odds == 1 else (1 - odds**i) / (1 - odds**n) for i in range(n + 1)]
    assert all(Fraction(x) <= p + Fraction(1, 10**15) for x, p in zip(reach.lower.tolist(), exact, strict=True))
    assert all(Fraction(x) >= p - Fraction(1, 10**15) for x, p in zip(reach.upper.tolist(), exact, strict=True))
    assert (reach.upper - reach.lower).max() < 1e-9


@pytest.mark.parametrize("winning", [3, 8])
def test_bounds_hold_for_a_random_first_state(winning):
    labels = dict.fromkeys(range(winning), "a")
    world = LabelledMDP.from_arrays(np.eye(10)[None], aps=("a",), labels=labels, initial_distribution=np.full(10, 0.1))
    truth = winning * Fraction(0.1)
    product = Product(world, compile("F a"))
    policy = np.zeros(product.n_states, dtype=np.int64)
    for bounds in (max_satisfaction_probability(product), satisfaction_probability(product, policy)):
        assert Fraction(bounds.lower) <= truth <= Fraction(bounds.upper)
        assert bounds.upper - bounds.lower < 1e-13


@pytest.mark.parametrize("side", [10, 20])
@pytest.mark.peer
def test_storm_agrees_on_growing_grids(side, tmp_path):
    stormpy = pytest.importorskip("stormpy")
    world = scaled_world(side, 0.6, blocks=True, start=(0, 0))
    value = storm_value(stormpy, tmp_path, world, 'Pmax=? [!"C" U ("A" & (!"C" U ("B" & (!"C" U "T"))))]')
    best = max_satisfaction_probability(Product(world, sequence("ABT", "C")))
    assert best.probability == pytest.approx(value, abs=1e-6)
    assert best.upper - best.lower < 1e-9


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.peer
def test_storm_agrees_on_random_models(seed, tmp_path):
    stormpy = pytest.importorskip("stormpy")
    rng = np.random.default_rng(seed)
    chance = [[ap for ap in "ABCT" if rng.random() < 0.15] for _ in range(30)]
    mdp = random_mdp(rng, 30, 3, labels=False).with_labels("ABCT", chance)
    value = storm_value(stormpy, tmp_path, mdp, 'Pmax=? [!"C" U ("A" & (!"C" U ("B" & (!"C" U "T"))))]')
    best = max_satisfaction_probability(Product(mdp, sequence("ABT", "C")))
    assert best.probability == pytest.approx(value, abs=1e-6)
    assert best.upper - best.lower < 1e-9


@pytest.mark.parametrize(
    ("lower", "upper"), [(0.9236381609303, 0.9236381609415), (0.1, 0.9), (1 - 1e-10, 1.0), (0, 1e-9)]
)
def test_printed_bounds_are_rounded_outwards(lower, upper):
    _, down, _, up = between(lower, upper).split()
    assert float(down) <= lower < upper <= float(up)
    assert float(up) - float(down) < 1.3 * (upper - lower)
