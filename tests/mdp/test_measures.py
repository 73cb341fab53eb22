"""Returns, counts and long-run frequencies on chains small enough to compute by hand; and the sampled estimates."""

from __future__ import annotations

import doctest
import importlib

import numpy as np
import pytest
from mdp_cases import automaton, never, tables

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp import (
    LabelledMDP,
    RewardProduct,
    acceptances_per_1000_steps,
    estimate,
    expected_count,
    expected_return,
    expected_steps,
    expected_violations,
    first_acceptance,
    max_reachability,
    optimal_return,
    policy_iteration,
    value_iteration,
    violations_per_step,
)

RECURRENCE = automaton("a", 1, lambda q, x: 0, [(never, lambda q, x: "a" in x)])
PAID = RECURRENCE.edge_inf[0].astype(float)


def chain(rows, **fields):
    return LabelledMDP.from_arrays([rows], aps="a", **fields)


def only_policy(product):
    return np.zeros(product.n_states, dtype=int)


def test_long_run_of_a_cycle():
    """0 -> 1 -> 2 -> 0 with an `a` on 1, which half the visits show."""
    product = RewardProduct(chain(np.roll(np.eye(3), 1, axis=1), labels={1: {"a": 0.5}}), tables(RECURRENCE))
    assert acceptances_per_1000_steps(product, only_policy(product)) == pytest.approx(1000 / 6)
    found = first_acceptance(product, only_policy(product))
    assert found.probability == 1.0
    assert found.steps == pytest.approx(1 + 3)  # rounds of 3, one missed on average
    assert expected_steps(product, only_policy(product)) == np.inf


def test_long_run_averages_over_the_components_that_may_be_entered():
    rows = [[0, 0.25, 0.75], [0, 1, 0], [0, 0, 1]]
    product = RewardProduct(chain(rows, labels={1: "a"}), tables(RECURRENCE, violated=RECURRENCE.edge_inf[0]))
    assert acceptances_per_1000_steps(product, only_policy(product)) == pytest.approx(250)
    assert violations_per_step(product, only_policy(product)) == pytest.approx(0.25)
    assert expected_violations(product, only_policy(product)) == np.inf
    assert first_acceptance(product, only_policy(product)).probability == pytest.approx(0.25)
    assert first_acceptance(product, only_policy(product)).steps == np.inf


def test_episodes_that_end_are_followed_by_new_ones():
    """Two steps an episode, the second accepts and stops."""
    rows = [[0, 1], [0, 1]]
    product = RewardProduct(chain(rows, labels={1: {"a": 0.5}}), tables(RECURRENCE, stop=PAID, reward=-1 + 3 * PAID))
    policy = only_policy(product)
    assert expected_steps(product, policy) == pytest.approx(2)
    assert expected_return(product, policy) == pytest.approx(-1 + 2)
    assert expected_return(product, policy, discount=0.5) == pytest.approx(2 / 3)
    assert acceptances_per_1000_steps(product, policy) == pytest.approx(500)
    assert expected_count(product, policy, product.acceptance) == pytest.approx(1)
    assert first_acceptance(product, policy).steps == pytest.approx(2)


def test_terminal_states_end_the_episode():
    mdp = chain([[0.5, 0.5], [0, 1]], labels={1: "a"}, terminal=np.array([False, True]))
    product = RewardProduct(mdp, tables(RECURRENCE, reward=PAID - 1))
    assert product.n_states == 1
    assert expected_steps(product, [0]) == pytest.approx(2)
    assert expected_return(product, [0]) == pytest.approx(-1)
    assert first_acceptance(product, [0]).probability == 1.0


def test_returns_that_never_converge_say_so():
    product = RewardProduct(chain([[1.0]]), tables(RECURRENCE, reward=np.full((1, 2), -1.0)))
    assert expected_return(product, [0]) == -np.inf
    assert optimal_return(product).value.tolist() == [-np.inf]
    assert expected_return(product, [0], discount=0.9) == pytest.approx(-10)
    assert optimal_return(product, discount=0.9).value.tolist() == pytest.approx([-10])
    paid = RewardProduct(chain([[1.0]]), tables(RECURRENCE, reward=np.ones((1, 2))))
    assert expected_return(paid, [0]) == np.inf
    with pytest.raises(InvalidArgumentError, match=r"paid 1 again and again without end.*discount"):
        optimal_return(paid)
    with pytest.raises(InvalidArgumentError, match="not in"):
        optimal_return(paid, discount=1.5)
    with pytest.raises(InvalidArgumentError, match="goes on for ever"):
        policy_iteration(paid, paid.reward)


def test_value_iteration_says_what_it_does_not_know():
    waiting = chain([[0, 1, 0], [0, 0.5, 0.5], [0, 0, 1]], labels={2: "a"})
    product = RewardProduct(waiting, tables(RECURRENCE, stop=PAID, reward=PAID))
    assert value_iteration(product, product.reward).error_bound == np.inf
    endless = RewardProduct(chain([[1.0]]), tables(RECURRENCE, reward=np.ones((1, 2))))
    with pytest.raises(LimitExceeded, match="still moved"):
        value_iteration(endless, endless.reward, max_iterations=50)


def test_interval_iteration_refuses_to_guess():
    walk = 0.5 * np.eye(50, k=1) + 0.5 * np.eye(50, k=-1)
    walk[[0, -1]] = np.eye(50)[[0, -1]]
    mdp = LabelledMDP.from_arrays([walk]).explicit
    with pytest.raises(LimitExceeded, match="apart after 10 iterations"):
        max_reachability(mdp, np.arange(50) == 49, method="interval", max_iterations=10)
    with pytest.raises(InvalidArgumentError, match="method"):
        max_reachability(mdp, np.arange(50) == 49, method="magic")


def test_zero_reward_loops_may_be_kept_for_ever():
    """Waiting costs nothing, leaving costs 1 and pays 3 with one half: worth it; with a pay of 1, not."""
    loop, leave = np.eye(2), np.array([[0.0, 1.0], [0.0, 1.0]])
    mdp = LabelledMDP.from_arrays([loop, leave], aps="a", labels={1: {"a": 0.5}}, terminal=np.array([False, True]))
    table = tables(RECURRENCE, reward=np.array([[0.0, 3.0]]))
    assert optimal_return(RewardProduct(mdp, table)).value.tolist() == pytest.approx([1.5])
    costly = tables(RECURRENCE, reward=np.array([[0.0, -3.0]]))
    best = optimal_return(RewardProduct(mdp, costly))
    assert best.value.tolist() == [0.0]
    assert best.policy.tolist() == [0]


def test_doctests():
    for name in ("estimate", "explicit"):
        assert doctest.testmod(importlib.import_module(f"ltlc.mdp.{name}")).failed == 0


class TestEstimates:
    def test_probability_intervals(self):
        wilson = estimate.probability(0, 10)
        assert (wilson.value, wilson.low) == (0.0, 0.0)
        assert wilson.high == pytest.approx(0.2775, abs=1e-4)
        exact = estimate.probability(8, 10, method="clopper-pearson")
        assert (exact.low, exact.high) == pytest.approx((0.4439, 0.9748), abs=1e-4)
        assert estimate.probability(10, 10, method="clopper-pearson").high == 1.0

    def test_intervals_cover_the_truth_as_often_as_they_say(self):
        rng = np.random.default_rng(0)
        covered = 0
        for _ in range(500):
            found = estimate.mean(rng.normal(2.0, 3.0, size=12))
            covered += found.low <= 2.0 <= found.high
        assert 460 <= covered <= 490

    def test_bootstrap_and_ratio(self):
        rng = np.random.default_rng(1)
        sample = rng.exponential(size=400)
        by_t, by_bootstrap = estimate.mean(sample), estimate.mean(sample, method="bootstrap", resamples=2000)
        assert by_bootstrap.low == pytest.approx(by_t.low, abs=0.02)
        assert by_bootstrap.high == pytest.approx(by_t.high, abs=0.02)
        found = estimate.ratio(2 * sample, sample)
        assert (found.low, found.value, found.high) == pytest.approx((2, 2, 2))

    @pytest.mark.parametrize(
        "call",
        [
            lambda: estimate.probability(3, 0),
            lambda: estimate.probability(3, 2),
            lambda: estimate.probability(1, 2, confidence=1.0),
            lambda: estimate.mean([1.0]),
            lambda: estimate.mean([1.0, np.nan]),
            lambda: estimate.mean([1.0, 2.0], method="guess"),
            lambda: estimate.ratio([1.0, 2.0], [0.0, 0.0]),
        ],
    )
    def test_bad_samples_are_refused(self, call):
        with pytest.raises(InvalidArgumentError):
            call()
