"""The judge against slow truths on random small MDPs, and against Storm where it is installed."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from mdp_cases import automaton, tables
from random_models import random_automaton, random_mdp, storm_value

from ltlc.mdp import (
    ExplicitMDP,
    LabelledMDP,
    Product,
    RewardProduct,
    expected_return,
    expected_steps,
    induced_chain,
    max_reachability,
    max_satisfaction_probability,
    maximal_end_components,
    optimal_return,
    policy_evaluation,
    policy_iteration,
    satisfaction_probability,
    value_iteration,
)


def policies(mdp: ExplicitMDP):
    return itertools.product(*(mdp.actions_in(s).tolist() for s in range(mdp.n_states)))


def naive_end_components(mdp: ExplicitMDP) -> set[frozenset[int]]:
    """By definition: all sets of states that are closed and strongly connected under the choices that stay inside."""
    dense = mdp.matrix.toarray() > 0
    found = []
    for size in range(1, mdp.n_states + 1):
        for inside in itertools.combinations(range(mdp.n_states), size):
            outside = np.setdiff1d(np.arange(mdp.n_states), inside)
            staying = ~dense[:, outside].any(axis=1) & (mdp.exit_probability == 0)
            edge = np.zeros((mdp.n_states, mdp.n_states), dtype=int)
            np.add.at(edge, mdp.choice_state[staying], dense[staying])
            reach = np.linalg.matrix_power((edge > 0) + np.eye(mdp.n_states, dtype=int), mdp.n_states) > 0
            active = all(staying[mdp.choice_state == s].any() for s in inside)
            if active and reach[np.ix_(inside, inside)].all():
                found.append(frozenset(inside))
    return {c for c in found if not any(c < other for other in found)}


@pytest.mark.parametrize("seed", range(40))
def test_end_components_agree_with_their_definition(seed):
    rng = np.random.default_rng(seed)
    mdp = random_mdp(rng, 6, 2).explicit
    components = maximal_end_components(mdp)
    found = {frozenset(np.flatnonzero(components.component == k).tolist()) for k in range(components.n_components)}
    assert found == naive_end_components(mdp)
    firsts = [np.flatnonzero(components.component == k)[0] for k in range(components.n_components)]
    assert firsts == sorted(firsts)


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("method", ["policy", "interval"])
def test_pmax_is_the_best_of_all_memoryless_policies(seed, method):
    rng = np.random.default_rng(seed)
    product = Product(random_mdp(rng, 4, 2), random_automaton(rng, 2, 1 + seed % 2))
    best = max_satisfaction_probability(product, method=method, precision=1e-8)
    every = np.array([satisfaction_probability(product, np.array(p)).state_probability for p in policies(product)])
    assert best.state_probability == pytest.approx(every.max(axis=0), abs=1e-7)
    assert (best.state_lower <= best.state_upper).all()
    assert (best.state_lower <= every.max(axis=0) + 1e-12).all()
    assert (best.state_upper >= every.max(axis=0) - 1e-12).all()
    attained = satisfaction_probability(product, best.policy).state_probability
    assert attained == pytest.approx(best.state_probability, abs=1e-7)


@pytest.mark.parametrize("seed", range(10))
def test_satisfaction_under_a_policy_agrees_with_simulation_of_the_chain(seed):
    """Rabin acceptance decided on long finite runs of the product, by counting marks in the second half."""
    rng = np.random.default_rng(seed)
    product = Product(random_mdp(rng, 5, 2), random_automaton(rng, 2, 2))
    policy = np.array([rng.choice(product.actions_in(s)) for s in range(product.n_states)])
    weights = np.zeros((product.n_states, product.n_actions))
    for s in range(product.n_states):
        weights[s, product.actions_in(s)] = 1 / len(product.actions_in(s))
    for given in (policy, weights):
        exact = satisfaction_probability(product, given)
        chain = induced_chain(product, given)
        dense = np.linalg.matrix_power(chain.matrix.toarray(), 2**16)
        assert exact.probability == pytest.approx(float(product.initial @ dense @ exact.accepting), abs=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_policy_values_agree_with_a_dense_solve(seed):
    rng = np.random.default_rng(seed)
    mdp = random_mdp(rng, 8, 3).explicit
    reward = rng.normal(size=mdp.n_choices)
    policy = np.array([rng.choice(mdp.actions_in(s)) for s in range(mdp.n_states)])
    chosen = mdp.choices_of(policy)
    dense = np.linalg.solve(np.eye(8) - 0.9 * mdp.matrix.toarray()[chosen], reward[chosen])
    assert policy_evaluation(mdp, reward, policy, discount=0.9) == pytest.approx(dense)
    assert policy_evaluation(mdp, reward, policy, discount=0.9, tolerance=1e-10) == pytest.approx(dense, abs=1e-8)


@pytest.mark.parametrize("seed", range(20))
def test_three_ways_to_the_optimum(seed):
    rng = np.random.default_rng(seed)
    mdp = random_mdp(rng, 5, 2).explicit
    reward = rng.normal(size=mdp.n_choices)
    best = max(
        (policy_evaluation(mdp, reward, np.array(p), discount=0.9) for p in policies(mdp)), key=lambda v: v.sum()
    )
    iterated = value_iteration(mdp, reward, discount=0.9, tolerance=1e-8)
    improved = policy_iteration(mdp, reward, discount=0.9)
    assert np.abs(iterated.value - best).max() <= iterated.error_bound + 1e-12 <= 1e-8 + 1e-12
    assert improved.value == pytest.approx(best)
    assert policy_evaluation(mdp, reward, improved.policy, discount=0.9) == pytest.approx(best)
    assert policy_evaluation(mdp, reward, iterated.policy, discount=0.9) == pytest.approx(best, abs=1e-6)


@pytest.mark.parametrize("seed", range(30))
def test_undiscounted_optimum_is_the_best_of_all_policies(seed):
    """Costs and free steps, episodes that end: the optimum may be finite, or -inf where leaving is not possible."""
    rng = np.random.default_rng(seed)
    world = random_mdp(rng, 4, 2)
    dra = random_automaton(rng, 2, 1)
    reward = -rng.integers(3, size=dra.delta.shape).astype(float)
    stop = rng.choice([0.0, 0.0, 0.0, 0.5, 1.0], size=dra.delta.shape)
    product = RewardProduct(world, tables(dra, reward=reward, stop=stop))
    best = optimal_return(product, discount=1)
    every = [policy_evaluation(product, product.reward, np.array(p)) for p in policies(product)]
    assert best.value == pytest.approx(np.max(every, axis=0))
    assert policy_evaluation(product, product.reward, best.policy) == pytest.approx(best.value)


@pytest.mark.parametrize("seed", range(20))
def test_product_transitions_agree_with_their_definition(seed):
    rng = np.random.default_rng(seed)
    world, dra = random_mdp(rng, 5, 2), random_automaton(rng, 3, 1)
    product = Product(world, dra, initial_label="skip")
    label = world.label_probability.toarray()
    for c in range(product.n_choices):
        s, q = product.mdp_state[product.choice_state[c]], product.automaton_state[product.choice_state[c]]
        row = np.zeros(product.n_states)
        fin = inf = False
        for t, p in enumerate(world.transitions[product.choice_action[c]].toarray()[s]):
            for k, letter in enumerate(world.letters):
                if p * label[t, k] > 0:
                    row[product.state_index(t, dra.delta[q, letter])] += p * label[t, k]
                    fin |= dra.edge_fin[0, q, letter]
                    inf |= dra.edge_inf[0, q, letter]
        assert product.matrix[[c]].toarray()[0] == pytest.approx(row)
        assert (product.choice_fin[0, c], product.choice_inf[0, c]) == (fin, inf)


@pytest.mark.parametrize("seed", range(5))
def test_returns_agree_with_rollouts(seed):
    """An independent walk through MDP and tables, letter by letter."""
    rng = np.random.default_rng(seed)
    world, dra = random_mdp(rng, 4, 2), random_automaton(rng, 2, 1)
    shape = dra.delta.shape
    paid = tables(dra, reward=rng.normal(size=shape), stop=np.full(shape, 0.3), stop_reward=rng.normal(size=shape),
                  discount=rng.uniform(0.5, 1, size=shape))  # fmt: skip
    product = RewardProduct(world, paid)
    policy = np.zeros(4, dtype=int)
    label, rows = world.label_probability.toarray(), world.transitions[0].toarray()

    def draw(p):
        return rng.choice(len(p), p=p)

    totals = np.zeros((3, 3000))
    for episode in range(totals.shape[1]):
        s, factor = 0, 1.0
        q = dra.delta[0, world.letters[draw(label[s])]]
        while True:
            s = draw(rows[s])
            here = q, world.letters[draw(label[s])]
            stops = rng.random() < paid.stop[here]
            gain = paid.reward[here] + stops * paid.stop_reward[here]
            totals[:, episode] += (gain, factor * gain, 1)
            if stops:
                break
            factor *= paid.discount[here]
            q = dra.delta[here]
    lifted = product.lift(policy)
    exact = [
        expected_return(product, lifted, discount=1),
        expected_return(product, lifted),
        expected_steps(product, lifted),
    ]
    error = totals.std(axis=1) / np.sqrt(totals.shape[1])
    assert (np.abs(totals.mean(axis=1) - exact) < 5 * error).all()


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.peer
def test_storm_agrees(seed, tmp_path):
    stormpy = pytest.importorskip("stormpy")
    rng = np.random.default_rng(seed)
    chance = [[ap for ap in "ab" if rng.random() < 0.3] for _ in range(12)]
    mdp = random_mdp(rng, 12, 2, labels=False).with_labels("ab", chance)
    until = automaton("ab", 3, lambda q, x: q if q else 1 if "b" in x else 0 if "a" not in x else 2,
                      [(lambda q, x: False, lambda q, x: q == 1)])  # fmt: skip
    recurrence = automaton("ab", 1, lambda q, x: 0, [(lambda q, x: "a" in x, lambda q, x: "b" in x)])
    for text, dra in [('Pmax=? [!"a" U "b"]', until), ('Pmax=? [(F G !"a") & (G F "b")]', recurrence)]:
        value = storm_value(stormpy, tmp_path, mdp, text)
        assert max_satisfaction_probability(Product(mdp, dra)).probability == pytest.approx(value, abs=1e-5)


@pytest.mark.slow
def test_reachability_bounds_on_a_slow_walk():
    """A gambler's ruin of 100 states: plain value iteration would stop far too early."""
    n = 101
    up, down = np.eye(n, k=1), np.eye(n, k=-1)
    walk = 0.5 * up + 0.5 * down
    walk[[0, -1]] = np.eye(n)[[0, -1]]
    mdp = LabelledMDP.from_arrays([walk], initial_state=1).explicit
    target = np.arange(n) == n - 1
    for method in ("policy", "interval"):
        reach = max_reachability(mdp, target, method=method, precision=1e-7)
        assert np.allclose(reach.value, np.arange(n) / 100, atol=1e-7)
        assert (reach.lower <= np.arange(n) / 100 + 1e-13).all()
        assert (reach.upper >= np.arange(n) / 100 - 1e-13).all()
