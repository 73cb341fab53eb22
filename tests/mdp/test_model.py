"""What an MDP may look like, and what the messages say when it does not."""

from __future__ import annotations

import numpy as np
import pytest
from mdp_cases import automaton, phi, tables, thesis_tables, thesis_world

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp import LabelledMDP, Product, RewardProduct, induced_chain, satisfaction_probability

FLIP = np.array([[0.0, 1.0], [1.0, 0.0]])


def test_from_arrays_with_labels_and_names():
    mdp = LabelledMDP.from_arrays(
        [FLIP, [[1, 0], [0, 0]]], aps="ab", labels={1: {"a": 0.5, "b": 1.0}}, state_names=("left", "right")
    )
    assert (mdp.n_states, mdp.n_actions) == (2, 2)
    assert mdp.available.tolist() == [[True, True], [True, False]]
    assert mdp.letters.tolist() == [0, 2, 3]
    assert mdp.label_probability.toarray().tolist() == [[1, 0, 0], [0, 0.5, 0.5]]
    assert mdp.explicit.choice_action.tolist() == [0, 1, 0]
    relabelled = mdp.with_labels(["goal"], [[], "goal"])
    assert relabelled.aps == ("goal",)
    assert relabelled.letters.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("arrays", "fields", "message"),
    [
        ([[[0.5, 0.4], [0, 1]]], {}, r"state 0, action 0: probabilities sum to 0.9"),
        ([[[1.5, -0.5], [0, 1]]], {"action_names": ("go",)}, r"state 0, action 0 \(go\): 1.5 is not a probability"),
        ([[[np.nan, 1], [0, 1]]], {}, "nan is not a probability"),
        ([[[1, 0], [0, 0]]], {"state_names": ("x", "y")}, r"state 1 \(y\) has no available action"),
        ([FLIP, np.eye(3)], {}, r"action 1: shape \(3, 3\), expected \(2, 2\)"),
        ([FLIP], {"initial_state": 2}, "initial state 2 of 2 states"),
        ([FLIP], {"initial_distribution": np.array([0.5, 0.4])}, "initial_distribution"),
        ([FLIP], {"terminal": np.array([True, False])}, "terminal state 0: action 0 leaves it"),
        ([FLIP], {"labels": {5: "a"}, "aps": "a"}, "label is given for state 5"),
        ([FLIP], {"labels": {0: {"a": 1.2}}, "aps": "a"}, "probability 1.2"),
        ([], {}, "at least one action"),
    ],
)
def test_wrong_models_are_refused(arrays, fields, message):
    with pytest.raises(InvalidArgumentError, match=message):
        LabelledMDP.from_arrays(arrays, **fields)


def test_unknown_propositions_are_refused():
    with pytest.raises(UnknownNameError, match="gaol"):
        LabelledMDP.from_arrays([FLIP], aps=["goal"], labels={0: ["gaol"]})
    mdp = LabelledMDP.from_arrays([FLIP], aps=["goal"], labels={0: ["goal"]})
    with pytest.raises(UnknownNameError, match="Did you mean goal"):
        Product(mdp, automaton(["goall"], 1, lambda q, x: 0, []))


def test_table_with_termination():
    table = {
        0: {0: [(0.5, 0, 0.0, False), (0.5, 1, 1.0, True)]},
        1: {0: [(1.0, 0, 0.0, False)]},
    }
    mdp = LabelledMDP.from_table(table)
    assert mdp.terminal.tolist() == [False, True]
    assert mdp.transitions[0].toarray().tolist() == [[0.5, 0.5], [0, 1]]
    table[0][0].append((0.0, 1, 0.0, False))
    LabelledMDP.from_table(table)
    table[0][0] = [(0.5, 1, 0.0, False), (0.5, 1, 1.0, True)]
    with pytest.raises(InvalidArgumentError, match="both with and without"):
        LabelledMDP.from_table(table)


def test_policies_are_checked():
    product = Product(thesis_world(5), phi(3))
    with pytest.raises(InvalidArgumentError, match="takes action 7 in state 0"):
        satisfaction_probability(product, np.full(product.n_states, 7))
    with pytest.raises(InvalidArgumentError, match="one action"):
        satisfaction_probability(product, np.zeros(3, dtype=int))
    with pytest.raises(InvalidArgumentError, match="not a probability distribution"):
        satisfaction_probability(product, np.zeros((product.n_states, 5)))
    with pytest.raises(InvalidArgumentError, match="neither"):
        product.lift(np.zeros(7, dtype=int))


def test_lifting_policies():
    product = Product(thesis_world(5), phi(3))
    rng = np.random.default_rng(0)
    flat, per_mode = rng.integers(5, size=25), rng.integers(5, size=(25, 4))
    assert np.array_equal(product.lift(flat), flat[product.mdp_state])
    assert np.array_equal(product.lift(per_mode), per_mode[product.mdp_state, product.automaton_state])
    uniform = product.lift(np.full((25, 5), 0.2))
    assert uniform.shape == (product.n_states, 5)
    assert np.allclose(induced_chain(product, uniform).matrix.sum(axis=1), 1)


def test_initial_label_is_read_unless_skipped():
    mdp = LabelledMDP.from_arrays([FLIP], aps="a", labels={0: {"a": 0.25}})
    first_letter = automaton(
        "a", 3, lambda q, x: q or (1 if "a" in x else 2), [(lambda q, x: False, lambda q, x: q == 1)]
    )
    product = Product(mdp, first_letter)
    policy = np.zeros(product.n_states, dtype=int)
    assert satisfaction_probability(product, policy).probability == 0.25
    skipped = Product(mdp, first_letter, initial_label="skip")
    assert satisfaction_probability(skipped, np.zeros(skipped.n_states, dtype=int)).probability == 0.0
    with pytest.raises(InvalidArgumentError, match="initial_label"):
        Product(mdp, first_letter, initial_label="maybe")


def test_holding_needs_rewards_by_state():
    world, dra = thesis_world(10, dynamic=True), phi(1)
    with pytest.raises(InvalidArgumentError, match="reward depends on the entered state"):
        noisy = np.random.default_rng(0).random(dra.delta.shape)
        RewardProduct(world, tables(dra, reward=noisy), miss="hold")
    with pytest.raises(InvalidArgumentError, match="miss"):
        RewardProduct(world, thesis_tables(dra, 0), miss="forget")
