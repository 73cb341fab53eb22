"""Counts, known states and planning of the tabular learners, against models that are known."""

from __future__ import annotations

import numpy as np
import pytest
from random_automata import random_automata

from ltlc.agents.tabular.config import FuTopcuConfig, WangConfig
from ltlc.agents.tabular.experience import Experience
from ltlc.agents.tabular.model import EmpiricalModel
from ltlc.agents.tabular.planning import accepting_components, as_table, cut, reach_and_stay
from ltlc.agents.tabular.wang import Wang
from ltlc.agents.thesis.runtime import RuntimeRow, runtime_comparison
from ltlc.envs import GridWorld, LTLVectorWrapper, VectorGridWorld, grid_map, labelled_mdp, thesis_world
from ltlc.errors import UnknownNameError
from ltlc.mdp import (
    LabelledMDP,
    Product,
    accepting_end_components,
    max_satisfaction_probability,
    satisfaction_probability,
)
from ltlc.task import Task

MAP = grid_map(["S.a", "b.#"], labels={"a": 0.7, "b": "b"}, slip=0.3)


def experience(n_envs: int = 32, seed: int = 0) -> Experience:
    return Experience(LTLVectorWrapper(VectorGridWorld(MAP, n_envs), Task("F a & F b", reward="accept")), seed)


@pytest.mark.slow
def test_counts_become_the_model() -> None:
    seen, generator = experience(), np.random.default_rng(0)
    model = EmpiricalModel(seen)
    counted = np.zeros((6, 5, 6), dtype=np.int64)
    for _ in range(3000):
        batch = seen.step(generator.integers(5, size=seen.n_envs))
        model.add(batch)
        np.add.at(counted, (batch.state, batch.action, batch.next_state), 1)
    assert seen.steps == model.visits.sum()
    np.testing.assert_array_equal(model.visits, counted.sum(axis=2))
    learned, true = model.labelled_mdp(), labelled_mdp(GridWorld(MAP))
    for action in range(5):
        estimate = learned.transitions[action].toarray()[:5]  # cell 5 is a wall, never entered
        np.testing.assert_allclose(estimate, counted[:5, action] / counted[:5, action].sum(axis=1, keepdims=True))
        assert np.abs(estimate - true.transitions[action].toarray()[:5]).max() < 0.05
    a = [i for i, letter in enumerate(learned.letters) if letter >> learned.aps.index("a") & 1]
    assert np.asarray(learned.label_probability.todense())[2, a].sum() == pytest.approx(0.7, abs=0.02)
    assert learned.start[0] == 1
    assert learned.transitions[0].toarray()[5, 5] == 1


@pytest.mark.slow
def test_knowledge_grows_and_is_usually_right() -> None:
    accuracy, delta = 0.1, 0.05
    wrong, estimates = 0, 0
    true = [matrix.toarray() for matrix in labelled_mdp(GridWorld(MAP)).transitions]
    for seed in range(5):
        explorer = Wang(experience(seed=seed), WangConfig(accuracy=accuracy, delta=delta, refresh_every=1))
        explorer.generator = np.random.default_rng(seed)
        before = 0
        while not explorer.finished:
            explorer.step()
            assert explorer.known.sum() >= before
            before = int(explorer.known.sum())
        assert explorer.known.tolist() == [True] * 5 + [False]
        learned = explorer.model.labelled_mdp()
        error = np.array([np.abs(learned.transitions[a].toarray() - true[a])[:5] for a in range(5)])
        wrong += int((error > accuracy).sum())
        estimates += int((np.array(true)[:, :5] > 0).sum())
        visits = explorer.model.visits[:5]
        assert visits.min() >= 30 and visits.max() < 20 * visits.min()
    assert wrong <= delta * estimates


def test_the_bound_of_the_paper_takes_longer_than_anyone_has() -> None:
    config = FuTopcuConfig(accuracy=None, epsilon=0.1, time_horizon=100)
    assert config.accuracy_for(25) == pytest.approx(0.1 / 2500)
    assert FuTopcuConfig(accuracy=0.2).accuracy_for(25) == 0.2


def _random_mdp(rng: np.random.Generator, aps: tuple[str, ...], n_states: int, n_actions: int) -> LabelledMDP:
    transitions = []
    for _ in range(n_actions):
        weight = np.zeros((n_states, n_states))
        for _ in range(2):
            weight[np.arange(n_states), rng.integers(n_states, size=n_states)] += rng.random(n_states)
        weight[-2:] = np.eye(n_states)[-2:]  # to get lost in
        transitions.append(weight / weight.sum(axis=1, keepdims=True))
    labels = [[name for name in aps if rng.random() < 0.4] for _ in range(n_states)]
    return LabelledMDP.from_arrays(transitions, aps=aps, labels=labels)


@pytest.mark.slow
def test_planning_on_the_true_model_attains_the_largest_probability() -> None:
    rng = np.random.default_rng(1)
    between = 0
    for automaton in random_automata(60, max_aps=2):
        mdp = _random_mdp(rng, automaton.aps, 8, 2)
        product = Product(mdp, automaton)
        everything = np.ones(mdp.n_states, dtype=np.bool_)
        components = accepting_components(product, everything, 0.99)
        assert components.n_components == sum(c.n_components for c in accepting_end_components(product))
        best = max_satisfaction_probability(product).probability
        if not components.n_components:
            assert best == 0
            continue
        plan = reach_and_stay(components, everything, 0.99)
        assert plan.probability == pytest.approx(best, abs=1e-6)
        policy = product.lift(as_table(product, plan.policy))
        assert satisfaction_probability(product, policy).probability == pytest.approx(best, abs=1e-6)
        between += 0 < best < 1
    assert between > 0


def test_unknown_states_count_as_lost() -> None:
    task = Task("F G a", reward="accept")
    layout = grid_map(["S.a"])
    product = Product(labelled_mdp(GridWorld(layout)), task.automaton)
    known = np.array([True, False, True])
    components = accepting_components(product, known, 0.99)
    assert components.n_components == 1
    assert reach_and_stay(components, known, 0.99).probability == 0
    components = accepting_components(product, np.array([True, True, False]), 0.99)
    assert components.n_components == 0


def test_cut_choices_leave() -> None:
    mdp = labelled_mdp(thesis_world("5x5")).explicit
    allowed = np.arange(mdp.n_choices) % 5 != 2
    process = cut(mdp, allowed)
    np.testing.assert_array_equal(process.exit_probability, ~allowed)
    np.testing.assert_allclose(process.matrix.sum(axis=1) + process.exit_probability, 1)
    np.testing.assert_allclose(mdp.matrix.sum(axis=1), 1)


def test_a_policy_with_zeros_leaves_the_process_as_it_was() -> None:
    product = Product(labelled_mdp(GridWorld(MAP)), Task("F a & F b", reward="accept").automaton)
    before = product.choice_start.copy()
    policy = np.zeros((product.n_states, 5))
    policy[:, 1] = 1.0
    product.policy_matrix(policy)
    np.testing.assert_array_equal(product.choice_start, before)


@pytest.mark.slow
def test_runtime_rows() -> None:
    rows: list[RuntimeRow] = []
    systems = ("q-learning", "fu-topcu", "sadigh")
    table = runtime_comparison(quick=True, systems=systems, cases=[("5x5", "phi_3")], progress=rows.append)
    assert rows == table
    assert [row.system for row in rows] == list(systems)
    for row in rows:
        assert row.reached == row.runs == 1
        assert row.regret <= 0.01 and row.probability == row.max_probability == 1
        assert row.product_states is not None
        assert 0 < row.product_states <= row.reachable_states <= row.thesis_product_states == 100
        assert 0 < row.fastest == row.seconds == row.slowest < 60
    assert [row.thesis_hours for row in rows] == [None, "0.22", None]
    late = runtime_comparison(systems=["sadigh"], cases=[("10x10", "phi_3")], limit=0.0, seeds=[0])
    assert (late[0].reached, late[0].runs) == (0, 1)
    with pytest.raises(UnknownNameError, match="fu-topcu"):
        runtime_comparison(systems=["fu-topku"])
