"""The judge against numbers from the thesis and the literature: maps and automata are built here from facts."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from mdp_cases import (
    DOWN,
    LEFT,
    RIGHT,
    UP,
    automaton,
    grid,
    never,
    noisy,
    phi,
    safely,
    sequence,
    sideways,
    tables,
    thesis_tables,
    thesis_world,
    uniform_slip,
)

from ltlc.automata.rabin import RabinAutomaton
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


def judged(mdp: LabelledMDP, dra: RabinAutomaton) -> MaxSatisfaction:
    """Pmax, after checking that the bounds hold it and that the policy attains it."""
    product = Product(mdp, dra)
    best = max_satisfaction_probability(product)
    assert best.lower <= best.probability <= best.upper
    assert satisfaction_probability(product, best.policy).probability == pytest.approx(best.probability, abs=1e-9)
    return best


def pmax(mdp: LabelledMDP, dra: RabinAutomaton) -> float:
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
    world = thesis_world(size, intended=noise, dynamic=labels == "dynamic")
    deadlock = {1: 0, 2: 2}.get(formula)
    product = RewardProduct(world, thesis_tables(phi(formula), deadlock), initial_label="skip", miss=miss)
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
    cells = {(2, 7): "A", (5, 2): "B", (8, 8): "T", **{(i, i): "C" for i in range(2, 7)}}
    world = grid(10, 10, noisy([UP, RIGHT, DOWN, LEFT], intended), cells, aps="ABCT", start=(4, 1))
    assert pmax(world, U_FORM) == pytest.approx(expected, abs=1e-6)
    assert pmax(world, phi(1)) == 0.0


def test_four_moves_with_absorbing_t():
    cells = {(2, 7): "A", (5, 2): "B", (8, 8): "T", **{(i, i): "C" for i in range(2, 7)}}
    moves = noisy([UP, RIGHT, DOWN, LEFT], 0.7)
    world = grid(10, 10, moves, cells, aps="ABCT", start=(4, 1), absorbing=[(8, 8)])
    assert pmax(world, phi(1)) == pytest.approx(0.867571, abs=1e-6)


def frozen_lake(rows: list[str]) -> LabelledMDP:
    table = gymnasium.make("FrozenLake-v1", desc=rows, is_slippery=True).unwrapped.P
    labels = {i: {"H": ["hole"], "G": ["goal"]}.get(cell, []) for i, cell in enumerate("".join(rows))}
    return LabelledMDP.from_table(table, aps=["goal", "hole"], labels=labels)


def test_frozen_lake():
    lake = frozen_lake(["SFFF", "FHFH", "FFFH", "HFFG"])
    assert pmax(lake, sequence(["goal"], "hole", safe_for_ever=True)) == pytest.approx(14 / 17, abs=1e-12)
    assert pmax(lake, safely(["goal", "hole"], "never", [(lambda x: False, lambda x: "goal" in x)])) == pytest.approx(
        14 / 17
    )
    assert pmax(lake, safely(["goal", "hole"], "hole", [(lambda x: False, lambda x: True)])) == 1.0


def test_frozen_lake_8x8():
    rows = ["SFFFFFFF", "FFFFFFFF", "FFFHFFFF", "FFFFFHFF", "FFFHFFFF", "FHHFFFHF", "FHFFHFHF", "FFFHFFFG"]
    assert pmax(frozen_lake(rows), sequence(["goal"], "hole")) == 1.0


@pytest.mark.parametrize("slippery", [False, True])
def test_cliff_walking(slippery):
    table = gymnasium.make("CliffWalking-v1", is_slippery=slippery).unwrapped.P
    labels = {47: ["goal"], **{36 + i: ["cliff"] for i in range(1, 11)}}
    world = LabelledMDP.from_table(table, aps=["goal", "cliff"], labels=labels, initial_state=36)
    # who falls is put back to the start without showing the cliff, so the formula cannot fail here
    assert pmax(world, sequence(["goal"], "cliff")) == 1.0


def test_taxi_table_is_read():
    taxi = LabelledMDP.from_table(gymnasium.make("Taxi-v4").unwrapped.P, initial_state=1)
    assert taxi.n_states == 500
    assert taxi.terminal.sum() == 4


def test_safe_absorbing_grid_from_every_cell():
    """Csrl's first example, (FG a | FG b) & G !c: a published table."""
    labels = {(0, 2): "c", (1, 2): "a", (1, 3): "b", (2, 2): "c", (3, 0): "b", (3, 2): "a", (4, 1): "c", (4, 3): "c"}
    absorbing = [(1, 3), (3, 0), (3, 2)]
    world = grid(5, 4, sideways(0.8, 0.1), labels, aps="abc", blocked=[(2, 0)], absorbing=absorbing)
    stay_in = safely("abc", "c", [(lambda x, p=p: p not in x, lambda x, p=p: p in x) for p in "ab"])
    expected = [[1, 1, 0, 1], [1, 1, 0.8, 1], [None, 1, 0, 1], [1, 1, 1, 1], [1, 0, 0.8, 0]]
    for row, values in enumerate(expected):
        for column, value in enumerate(values):
            if value is not None:
                start = np.eye(20)[row * 4 + column]
                here = LabelledMDP(**{**vars_of(world), "initial_distribution": start})
                assert pmax(here, stay_in) == pytest.approx(value, abs=1e-6), (row, column)


def vars_of(mdp: LabelledMDP) -> dict[str, object]:
    return {name: getattr(mdp, name) for name in mdp.__dataclass_fields__}


def from_moves(n: int, moves: list[tuple[int, str, dict[int, float]]], **labels: object) -> LabelledMDP:
    """An MDP from (state, action, {next state: probability})."""
    names = sorted({action for _, action, _ in moves})
    matrices = np.zeros((len(names), n, n))
    for state, action, outcomes in moves:
        for target, p in outcomes.items():
            matrices[names.index(action), state, target] = p
    return LabelledMDP.from_arrays(matrices, action_names=names, **labels)


def test_risk_reward():
    moves = [(0, "risky", {2: 0.9, 3: 0.1}), (0, "safe", {1: 1.0})]
    moves += [(s, "reset", {0: 1.0}) for s in (1, 2, 3)] + [(s, "stay", {s: 1.0}) for s in (0, 2, 3)]
    world = from_moves(4, moves, aps="gb", labels={1: "g", 2: "g", 3: "b"})
    dra = safely("gb", "b", [(lambda x: False, lambda x: "g" in x)])
    assert pmax(world, dra) == 1.0
    risky = world.action_names.index("risky")
    product = Product(world, dra)
    policy = np.where(product.mdp_state == 0, risky, world.action_names.index("reset"))
    assert satisfaction_probability(product, policy).probability == 0.0
    policy = np.where(product.mdp_state == 2, world.action_names.index("stay"), policy)
    assert satisfaction_probability(product, policy).probability == pytest.approx(0.9)


def test_two_pairs_need_both_pairs():
    moves = []
    for cell in range(4):
        row, column = divmod(cell, 2)
        flips = {(1 - row) * 2 + column: 0.5, row * 2 + 1 - column: 0.5}
        moves += [(cell, "move", flips), (cell, "rest", {cell: 1.0})]
    world = from_moves(4, moves, aps=["goal0", "goal1", "trap"], labels={2: ["goal0"], 1: ["goal1"], 3: ["trap"]})
    pairs = [(lambda x, p=p: p not in x, lambda x, p=p: p in x) for p in ("goal0", "goal1")]
    aps = ["goal0", "goal1", "trap"]
    assert pmax(world, safely(aps, "trap", pairs)) == 1.0
    assert pmax(world, safely(aps, "trap", pairs[:1])) == pytest.approx(2 / 3, abs=1e-9)


def test_devious():
    index = {(b, n): b * 8 + n for b in range(4) for n in range(8)}
    moves = []
    for (b, n), s in index.items():
        found = {}
        if b == 0:
            found = {"a": {index[1, n]: 1.0}, "b": {index[2, n]: 0.75, index[3, n]: 0.25}}
        elif b > 1:
            found = {"c": {s: 1.0}}
        else:
            steps = {0: [("d", 1)], 1: [("e", 2), ("f", 5)]}.get(
                n, [("g", (n + 1) % 5)] if n <= 4 else [("h", min(n + 1, 7))]
            )
            found = {name: {index[1, to]: 1.0} for name, to in steps}
        moves += [(s, name, outcomes) for name, outcomes in found.items()]
    good = {s: "g" for (b, n), s in index.items() if b == 2 or (b == 1 and n in (0, 5, 6))}
    world = from_moves(32, moves, aps="g", labels=good)
    assert pmax(world, automaton("g", 1, lambda q, x: 0, [(never, lambda q, x: "g" in x)])) == 1.0


def test_gate():
    """Shao and Kwiatkowska's gate, FG a & G !c."""
    right = {RIGHT: 1.0}
    cross = sideways(0.8, 0.1)
    special = {(0, c): [right] * 4 for c in range(9)} | {(2, 0): [{RIGHT: 0.8, DOWN: 0.2}] * 4}
    labels = {(0, c): "a" for c in range(9)} | {(2, 9): "a", (3, 0): "c"}
    absorbing = [(0, 9), (2, 9), (3, 0)]
    blocked = [(1, c) for c in range(1, 10)] + [(3, c) for c in range(1, 10)]
    world = grid(4, 10, cross, labels, aps="ac", start=(1, 0), blocked=blocked, absorbing=absorbing, special=special)
    dra = safely("ac", "c", [(lambda x: "a" not in x, lambda x: "a" in x)])
    assert pmax(world, dra) == pytest.approx(0.8, abs=1e-6)


HOLES_8 = [(2, 3), (3, 5), (4, 3), (5, 1), (5, 2), (5, 6), (6, 1), (6, 4), (6, 6), (7, 3)]


def test_shao_frozen_lake():
    labels = dict.fromkeys(HOLES_8, "h") | {(4, 6): "b", (7, 7): "a"}
    world = grid(8, 8, sideways(0.34, 0.33), labels, aps="abh")
    dra = safely("abh", "h", [(lambda x: False, lambda x: "a" in x or "b" in x)])
    assert pmax(world, dra) == 1.0


def box(rows: tuple[int, int], columns: tuple[int, int], label: str) -> dict[tuple[int, int], str]:
    return {(r, c): label for r in range(*rows) for c in range(*columns)}


class TestLcrl:
    """LCRL's tasks: `stated` is F goal & G !unsafe, `until` is !unsafe U goal."""

    def test_gridworld_1(self):
        unsafe = box((25, 33), (7, 15), "u") | box((7, 15), (25, 33), "u")
        labels = unsafe | box((15, 25), (15, 25), "1") | box((33, 40), (0, 7), "2")
        world = grid(40, 40, uniform_slip(0.15), labels, aps="12u")
        assert pmax(world, sequence("12", "u", safe_for_ever=True)) == 0.0
        assert pmax(world, sequence("12", "u")) == pytest.approx(1.0, abs=1e-6)

    def test_frozen_lake_1(self):
        labels = box((3, 5), (3, 5), "u") | box((4, 6), (7, 9), "1") | box((7, 9), (7, 9), "2")
        labels |= box((6, 8), (3, 5), "3") | box((7, 9), (0, 2), "4")
        world = grid(12, 10, uniform_slip(0.1), labels, aps="1234u", start=(0, 5), absorbing=[(4, 7), (5, 8)])
        assert pmax(world, sequence("1", "u", safe_for_ever=True)) == pytest.approx(0.999998, abs=1e-6)
        assert pmax(world, sequence("1", "u")) == pytest.approx(1.0, abs=1e-5)
        world = grid(12, 10, uniform_slip(0.1), labels, aps="1234u", start=(0, 5), absorbing=[(7, 8), (0, 1)])
        assert pmax(world, sequence("1234", "u", safe_for_ever=True)) == pytest.approx(0.998374, abs=1e-6)

    def test_frozen_4x4(self):
        labels = dict.fromkeys([(1, 1), (1, 3), (2, 3), (3, 0)], "u") | {(0, 3): "1", (3, 3): "2"}
        world = grid(4, 4, uniform_slip(0.05), labels, aps="12u", absorbing=[(3, 3)])
        assert pmax(world, sequence("2", "u", safe_for_ever=True)) == pytest.approx(0.949052, abs=1e-6)
        assert pmax(world, sequence("12", "u", safe_for_ever=True)) == pytest.approx(0.935959, abs=1e-6)
        assert pmax(world, sequence("1", "u")) == pytest.approx(0.986520, abs=1e-6)

    def test_frozen_8x8(self):
        labels = dict.fromkeys(HOLES_8, "u") | {(0, 7): "1", (7, 7): "2"}
        world = grid(8, 8, uniform_slip(0.05), labels, aps="12u", absorbing=[(7, 7)])
        assert pmax(world, sequence("2", "u", safe_for_ever=True)) == pytest.approx(0.973860, abs=1e-6)


def test_simple_mdp_of_voloshin():
    moves = [(0, name, {1: 0.9, 2: 0.1}) for name in "01"] + [(0, "2", {1: 0.5, 2: 0.5})]
    moves += [(1, "0", {3: 1.0}), (3, "0", {1: 1.0}), (2, "0", {2: 1.0})]
    world = from_moves(4, moves, aps="a", labels={1: "a", 3: "a"})
    assert pmax(world, automaton("a", 1, lambda q, x: 0, [(never, lambda q, x: "a" in x)])) == pytest.approx(
        0.9, abs=1e-9
    )


MINECRAFT = {
    **{(r, 5): "obstacle" for r in range(3)}, **{(2, c): "obstacle" for c in range(7, 10)},
    **dict.fromkeys([(0, 0), (4, 5), (8, 1), (8, 7)], "grass"),
    **dict.fromkeys([(2, 2), (7, 3), (5, 7), (9, 9)], "wood"),
    **dict.fromkeys([(0, 3), (4, 0), (6, 8), (9, 4)], "iron"), **dict.fromkeys([(6, 1), (6, 5), (4, 9)], "work_bench"),
    **dict.fromkeys([(2, 4), (9, 0), (7, 7)], "tool_shed"), (0, 7): "gold",
}  # fmt: skip


def test_minecraft_patrol():
    """GF(gold & X F work_bench) & G !obstacle."""
    moves = [{move: 1.0} for move in (UP, RIGHT, DOWN, LEFT)]
    labels = {cell: [name] for cell, name in MINECRAFT.items()}
    aps = ["grass", "wood", "iron", "work_bench", "tool_shed", "gold", "obstacle"]
    world = grid(10, 10, moves, labels, aps=aps, start=(9, 2))
    read = ("gold", "work_bench", "obstacle")

    def step(q, x):
        if q == 2 or "obstacle" in x:
            return 2
        return 1 if "gold" in x else 0 if "work_bench" in x else q

    dra = automaton(read, 3, step, [(never, lambda q, x: q == 1 and "work_bench" in x and step(q, x) != 2)])
    assert pmax(world, dra) == 1.0


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
    moves = [{move: 1.0} for move in (UP, RIGHT, DOWN, LEFT)]
    names = ["grass", "wood", "iron", "work_bench", "tool_shed", "gold", "obstacle"]
    blocked = [cell for cell, name in MINECRAFT.items() if name == "obstacle"]
    labels = {cell: [name] for cell, name in MINECRAFT.items()}
    world = grid(10, 10, moves, labels, aps=names, start=(9, 2), blocked=blocked)
    dra = sequence(goals)
    accepted = dra.edge_inf[0]
    product = RewardProduct(world, tables(dra, reward=-np.ones(dra.delta.shape), stop=accepted.astype(float)))
    best = optimal_return(product)
    assert float(product.initial @ best.value) == pytest.approx(-steps)
    assert expected_steps(product, best.policy) == pytest.approx(steps)
