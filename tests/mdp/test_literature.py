"""The judge against numbers from the thesis and the literature: worlds of the suite, automata written by hand."""

from __future__ import annotations

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from mdp_cases import (
    automaton,
    never,
    phi,
    safely,
    sequence,
    tables,
    thesis_tables,
    thesis_world,
    world,
)
from suite_tasks import load_worlds

from ltlc.automata.rabin import DRA
from ltlc.mdp import (
    LabelledMDP,
    MaxSatisfaction,
    Product,
    RewardProduct,
    expected_return,
    expected_steps,
    expected_violations,
    max_satisfaction_probability,
    optimal_return,
    satisfaction_probability,
)


def judged(mdp: LabelledMDP, dra: DRA) -> MaxSatisfaction:
    """Pmax, after checking that the bounds hold it and that the policy attains it."""
    product = Product(mdp, dra)
    best = max_satisfaction_probability(product)
    assert best.lower <= best.probability <= best.upper
    assert satisfaction_probability(product, best.policy).probability == pytest.approx(best.probability, abs=1e-9)
    return best


def pmax(mdp: LabelledMDP, dra: DRA) -> float:
    return judged(mdp, dra).probability


SETTINGS = [
    (1, 10, 0.6, "static", "empty", -792.4, 72.8, 0.81),
    (1, 10, 0.6, "dynamic", "empty", -604.6, 59.4, 0.21),
    (1, 10, 0.6, "dynamic", "hold", -598.5, 58.8, 0.21),
    (2, 10, 0.6, "static", "empty", -1391.7, 234.3, 1.19),
    (2, 10, 0.6, "dynamic", "empty", -979.2, 156.0, 0.43),
    (3, 5, 0.6, "static", "empty", -32.2, 32.2, 0.0),
    (3, 10, 0.6, "static", "empty", -52.5, 52.5, 0.0),
    (3, 5, 1.0, "static", "empty", -16.0, 16.0, 0.0),
    (3, 10, 1.0, "static", "empty", -25.0, 25.0, 0.0),
    (4, 5, 0.6, "static", "empty", -605.5, 101.0, 0.0),
    (4, 10, 0.6, "static", "empty", -892.1, 134.8, 0.0),
    (4, 5, 1.0, "static", "empty", -304.0, 52.0, 0.0),
    (4, 10, 1.0, "static", "empty", -424.0, 64.0, 0.0),
]


@pytest.mark.parametrize(("formula", "size", "noise", "labels", "miss", "reward", "steps", "entries"), SETTINGS)
def test_thesis_settings(formula, size, noise, labels, miss, reward, steps, entries):
    grid = thesis_world(size, intended=noise, dynamic=labels == "dynamic")
    deadlock = {1: 0, 2: 2}.get(formula)
    product = RewardProduct(grid, thesis_tables(phi(formula), deadlock), initial_label="skip", miss=miss)
    policy = optimal_return(product, discount=0.99).policy
    assert expected_return(product, policy, discount=1) == pytest.approx(reward, abs=0.1)
    assert expected_steps(product, policy) == pytest.approx(steps, abs=0.1)
    assert expected_violations(product, policy) == pytest.approx(entries, abs=0.01)


@pytest.mark.parametrize("size", [5, 10])
@pytest.mark.parametrize("dynamic", [False, True])
@pytest.mark.parametrize(("formula", "expected"), [(1, 0.0), (2, 0.0), (3, 1.0), (4, 1.0)])
def test_thesis_satisfaction_is_exactly_zero_or_one(formula, expected, size, dynamic):
    assert pmax(thesis_world(size, dynamic=dynamic), phi(formula)) == expected


@pytest.mark.parametrize("formula", [1, 2, 3, 4])
def test_thesis_without_noise(formula):
    assert pmax(thesis_world(10, intended=1.0), phi(formula)) == 1.0


@pytest.mark.parametrize(("intended", "expected"), [(1.0, 1.0), (0.8, 0.978764), (0.6, 0.815708)])
def test_thesis_phi_1_with_absorbing_t(intended, expected):
    assert pmax(thesis_world(10, intended=intended, absorbing=[(8, 8)]), phi(1)) == pytest.approx(expected, abs=1e-6)


U_FORM = sequence("ABT", "C")


@pytest.mark.parametrize(("intended", "expected"), [(1.0, 1.0), (0.8, 0.995533), (0.6, 0.923638)])
def test_until_form(intended, expected):
    assert pmax(thesis_world(10, intended=intended), U_FORM) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("intended", "expected"), [(0.7, 0.950719), (0.6, 0.831783), (0.8, 0.989645), (0.9, 0.999041)])
def test_until_form_with_four_moves(intended, expected):
    grid = world("four-moves-10x10", motion={"intended": intended})
    assert pmax(grid, U_FORM) == pytest.approx(expected, abs=1e-6)
    assert pmax(grid, phi(1)) == 0.0


def test_four_moves_with_absorbing_t():
    assert pmax(world("four-moves-10x10", absorbing="T"), phi(1)) == pytest.approx(0.867571, abs=1e-6)


@pytest.mark.parametrize("size", ["4x4", "8x8"])
def test_maps_of_frozen_lakes_are_those_of_gymnasium(size):
    lake = world(f"frozen-lake-{size}")
    table = gymnasium.make("FrozenLake-v1", map_name=size, is_slippery=True).unwrapped.P
    theirs = LabelledMDP.from_table(table)
    for ours, other in zip(sorted_actions(lake), sorted_actions(theirs), strict=True):
        assert np.abs(ours - other).max() < 1e-12
    assert theirs.terminal.nonzero()[0].tolist() == np.flatnonzero(lake.label_probability.argmax(axis=1)).tolist()


def sorted_actions(mdp: LabelledMDP) -> list[np.ndarray]:
    """The transition matrices in an order of their own: who goes right is nobody's business."""
    return sorted((matrix.toarray() for matrix in mdp.transitions), key=lambda p: p.tolist())


def test_frozen_lake():
    lake = world("frozen-lake-4x4")
    assert pmax(lake, sequence(["goal"], "hole", safe_for_ever=True)) == pytest.approx(14 / 17, abs=1e-12)
    assert pmax(lake, safely(["goal", "hole"], "never", [(lambda x: False, lambda x: "goal" in x)])) == pytest.approx(
        14 / 17
    )
    assert pmax(lake, safely(["goal", "hole"], "hole", [(lambda x: False, lambda x: True)])) == 1.0


def test_frozen_lake_8x8():
    assert pmax(world("frozen-lake-8x8"), sequence(["goal"], "hole")) == 1.0


@pytest.mark.parametrize("name", ["cliff-walking", "cliff-walking-slippery"])
def test_cliff_walking(name):
    # who falls is put back to the start without showing the cliff, so the formula cannot fail here
    assert pmax(world(name), sequence(["goal"], "cliff")) == 1.0


def test_taxi_table_is_read():
    taxi = LabelledMDP.from_table(gymnasium.make("Taxi-v4").unwrapped.P, initial_state=1)
    assert taxi.n_states == 500
    assert taxi.terminal.sum() == 4


def test_safe_absorbing_grid_from_every_cell():
    """Csrl's first example, (FG a | FG b) & G !c: a published table."""
    grid = world("safe-absorbing")
    stay_in = safely("abc", "c", [(lambda x, p=p: p not in x, lambda x, p=p: p in x) for p in "ab"])
    expected = [[1, 1, 0, 1], [1, 1, 0.8, 1], [None, 1, 0, 1], [1, 1, 1, 1], [1, 0, 0.8, 0]]
    for row, values in enumerate(expected):
        for column, value in enumerate(values):
            if value is not None:
                start = np.eye(20)[row * 4 + column]
                here = replace(grid, initial_distribution=start)
                assert pmax(here, stay_in) == pytest.approx(value, abs=1e-6), (row, column)


def test_risk_reward():
    risks = world("risk-reward")
    dra = safely("gb", "b", [(lambda x: False, lambda x: "g" in x)])
    assert pmax(risks, dra) == 1.0
    risky, reset, stay = (risks.action_names.index(name) for name in ("risky", "reset", "stay"))
    product = Product(risks, dra)
    policy = np.where(product.mdp_state == 0, risky, reset)
    assert satisfaction_probability(product, policy).probability == 0.0
    policy = np.where(product.mdp_state == risks.state_names.index("won"), stay, policy)
    assert satisfaction_probability(product, policy).probability == pytest.approx(0.9)


def test_two_pairs_need_both_pairs():
    pairs = [(lambda x, p=p: p not in x, lambda x, p=p: p in x) for p in ("goal0", "goal1")]
    aps = ["goal0", "goal1", "trap"]
    assert pmax(world("two-pairs"), safely(aps, "trap", pairs)) == 1.0
    assert pmax(world("two-pairs"), safely(aps, "trap", pairs[:1])) == pytest.approx(2 / 3, abs=1e-9)


def test_devious():
    assert pmax(world("devious"), automaton("g", 1, lambda q, x: 0, [(never, lambda q, x: "g" in x)])) == 1.0


def test_gate():
    """Shao and Kwiatkowska's gate, FG a & G !c."""
    dra = safely("ac", "c", [(lambda x: "a" not in x, lambda x: "a" in x)])
    assert pmax(world("gate"), dra) == pytest.approx(0.8, abs=1e-6)


def test_shao_frozen_lake():
    dra = safely("abh", "h", [(lambda x: False, lambda x: "a" in x or "b" in x)])
    assert pmax(world("frozen-8x8"), dra) == 1.0


GOALS = ["goal1", "goal2", "goal3", "goal4"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes", "n_goals", "bad", "stated", "until"),
    [
        ("lcrl-gridworld-1", {}, 2, "unsafe", 0.0, 1.0),
        ("lcrl-frozen-lake", {}, 1, "unsafe", 0.999998, 0.999998),
        ("lcrl-frozen-lake", {"absorbing": [[7, 8], [0, 1]]}, 4, "unsafe", 0.998374, None),
        ("lcrl-frozen-4x4", {}, 2, "hole", 0.935959, None),
        ("lcrl-frozen-4x4", {}, 1, "hole", None, 0.986520),
    ],
)
def test_lcrl(name, changes, n_goals, bad, stated, until):
    """LCRL's tasks: `stated` is F goal & G !unsafe, `until` is !unsafe U goal."""
    grid, goals = world(name, **changes), GOALS[:n_goals]
    if stated is not None:
        assert pmax(grid, sequence(goals, bad, safe_for_ever=True)) == pytest.approx(stated, abs=1e-6)
    if until is not None:
        assert pmax(grid, sequence(goals, bad)) == pytest.approx(until, abs=1e-6)


@pytest.mark.parametrize(("name", "expected"), [("lcrl-frozen-4x4", 0.949052), ("lcrl-frozen-8x8", 0.973860)])
def test_lcrl_second_goals(name, expected):
    dra = sequence(["goal2"], "hole", safe_for_ever=True)
    assert pmax(world(name), dra) == pytest.approx(expected, abs=1e-6)


def test_simple_mdp_of_voloshin():
    dra = automaton("a", 1, lambda q, x: 0, [(never, lambda q, x: "a" in x)])
    assert pmax(world("simple-mdp"), dra) == pytest.approx(0.9, abs=1e-9)


def test_minecraft_patrol():
    """GF(gold & X F work_bench) & G !obstacle."""
    read = ("gold", "work_bench", "obstacle")

    def step(q, x):
        if q == 2 or "obstacle" in x:
            return 2
        return 1 if "gold" in x else 0 if "work_bench" in x else q

    dra = automaton(read, 3, step, [(never, lambda q, x: q == 1 and "work_bench" in x and step(q, x) != 2)])
    assert pmax(world("minecraft"), dra) == 1.0


@pytest.mark.parametrize(
    ("goals", "steps"),
    [
        (("wood", "tool_shed"), 7),
        (("grass", "tool_shed"), 4),
        (("wood", "grass", "iron", "tool_shed"), 13),
        (("wood", "work_bench"), 6),
        (("grass", "work_bench"), 4),
        (("iron", "wood", "work_bench"), 8),
        (("wood", "iron", "work_bench", "gold"), 18),
    ],
)
def test_minecraft_fewest_steps(goals, steps):
    dra = sequence(goals)
    obstacles_are_walls = world("minecraft", map=load_worlds()["minecraft"]["map"].replace("x", "#"), labels=ITEMS)
    product = RewardProduct(
        obstacles_are_walls, tables(dra, reward=-np.ones(dra.delta.shape), stop=dra.edge_inf[0].astype(float))
    )
    best = optimal_return(product)
    assert float(product.initial @ best.value) == pytest.approx(-steps)
    assert expected_steps(product, best.policy) == pytest.approx(steps)


ITEMS = {name: label for name, label in load_worlds()["minecraft"]["labels"].items() if label != "obstacle"}
