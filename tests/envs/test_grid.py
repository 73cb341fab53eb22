"""Grid worlds against their exact models, and the models against known probabilities."""

from __future__ import annotations

import warnings
from collections import Counter
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import newest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from ltlc.envs import (
    GridWorld,
    LabelFunction,
    LTLWrapper,
    VectorGridWorld,
    grid_map,
    labelled_mdp,
    register_envs,
    thesis_map,
)
from ltlc.envs.grid_map import StepSampler
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp import Product, max_satisfaction_probability
from ltlc.task import Task

MAP = ("S.a", ".#.", "b.c")


def test_moves_are_clamped_and_walls_stop() -> None:
    env = GridWorld(MAP, observation="coordinates")
    here, _ = env.reset()
    assert here.tolist() == [0, 0]
    trail = [env.step(action)[0].tolist() for action in (0, 3, 1, 2, 1, 1, 2, 2, 4, 3, 0)]
    assert trail == [[0, 0], [0, 0], [0, 1], [0, 1], [0, 2], [0, 2], [1, 2], [2, 2], [2, 2], [2, 1], [2, 1]]


def test_labels_are_read_on_entering_and_on_staying() -> None:
    env = GridWorld(MAP)
    assert env.reset()[1]["labels"] == frozenset()
    assert [set(env.step(action)[4]["labels"]) for action in (1, 1, 4, 2, 2)] == [set(), {"a"}, {"a"}, set(), {"c"}]


def test_the_thesis_map_is_where_the_thesis_says() -> None:
    layout = thesis_map("10x10")
    where = {
        name: [tuple(layout.coordinates[c].tolist()) for c, t in enumerate("".join(layout.text)) if t == name]
        for name in "ABTC"
    }
    assert where == {"A": [(2, 7)], "B": [(5, 2)], "T": [(8, 8)], "C": [(2, 2), (3, 3), (4, 4), (5, 5), (6, 6)]}
    assert layout.coordinates[layout.start].tolist() == [4, 1]
    assert layout.executed[0].tolist() == pytest.approx([0.6, 0.1, 0.1, 0.1, 0.1])


def frequencies(samples: Any) -> dict[Any, float]:
    counts = Counter(samples)
    return {key: count / counts.total() for key, count in counts.items()}


def test_single_and_native_worlds_follow_the_model() -> None:
    """10^5 draws of a cell with slip and probabilistic labels against the exact distribution, to 5 standard errors."""
    layout = grid_map(MAP, labels={"a": {"a": 0.3, "x": 0.5}, "b": 0.8}, slip=[0.4, 0.2, 0.0, 0.1, 0.3])
    mdp = labelled_mdp(GridWorld(layout))
    start, action = 1, 1
    exact = {
        (cell, int(letter)): float(mdp.transitions[action][start, cell] * p)
        for cell in range(layout.n_cells)
        for letter, p in zip(mdp.letters, mdp.label_probability[[cell]].toarray()[0], strict=True)
        if mdp.transitions[action][start, cell] * p > 0
    }
    vector = VectorGridWorld(layout, 100_000)
    vector.reset(seed=5)
    vector._cell[:] = start
    cells, *_, infos = vector.step(np.full(100_000, action))
    drawn = frequencies(zip(cells.tolist(), infos["labels"].tolist(), strict=True))
    assert set(drawn) == set(exact)
    for outcome, p in exact.items():
        assert abs(drawn[outcome] - p) < 5 * np.sqrt(p * (1 - p) / 100_000)


def test_one_copy_draws_the_same_numbers_as_a_single_world() -> None:
    single, vector = (make(thesis_map("5x5", dynamic=True)) for make in (GridWorld, VectorGridWorld))
    names = single.propositions
    single.reset(seed=9)
    vector.reset(seed=9)
    for action in np.random.default_rng(0).integers(0, 5, 200).tolist():
        cell, *_, info = single.step(action)
        cells, *_, infos = vector.step(np.array([action]))
        assert cells.tolist() == [cell]
        assert {name for i, name in enumerate(names) if infos["labels"][0] >> i & 1} == info["labels"]


def test_the_sampler_is_exact() -> None:
    """The slots of each row, weighed, give the distribution back."""
    rng = np.random.default_rng(1)
    rows = []
    for _ in range(50):
        p = rng.dirichlet(np.ones(rng.integers(1, 9)))
        rows.append([(i, 7, float(q)) for i, q in enumerate(p)])
    sampler = StepSampler.from_rows(rows)
    for i, row in enumerate(rows):
        mass = np.zeros(len(row))
        for slot in range(i * sampler.width, (i + 1) * sampler.width):
            mass[sampler.cell[slot]] += sampler.threshold[slot] / sampler.width
            mass[sampler.cell[sampler.alias[slot]]] += (1 - sampler.threshold[slot]) / sampler.width
        assert mass == pytest.approx([entry[2] for entry in row], abs=1e-12)


def test_a_miss_is_empty_or_held() -> None:
    for miss, seen in (("empty", set()), ("hold", {"hold"})):
        env = GridWorld(("Sa",), labels={"a": 0.0}, miss=miss)
        env.reset()
        assert env.step(1)[4]["labels"] == seen
        assert env.step(3)[4]["labels"] == set()
    with pytest.raises(UnknownNameError, match=r"unknown miss mode 'holdd'. Did you mean hold"):
        GridWorld(MAP, miss="holdd")


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_native_episodes_are_truncated_and_begin_again(mode: AutoresetMode) -> None:
    env = VectorGridWorld(("S..",), 2, max_episode_steps=2, autoreset_mode=mode)
    env.reset()
    go = np.array([1, 4])
    assert env.step(go)[3].tolist() == [False, False]
    cells, _, _, truncated, infos = env.step(go)
    assert truncated.tolist() == [True, True]
    if mode == AutoresetMode.SAME_STEP:
        assert cells.tolist() == [0, 0]
        assert infos["final_obs"].tolist() == [2, 0]
        assert env.step(go)[0].tolist() == [1, 0]
        return
    assert cells.tolist() == [2, 0]
    if mode == AutoresetMode.DISABLED:
        with pytest.raises(InvalidArgumentError, match="must be reset before it is stepped"):
            env.step(go)
        assert env.reset(options={"reset_mask": np.array([True, False])})[0].tolist() == [0, 0]
        with pytest.raises(InvalidArgumentError, match="reset_mask must be a boolean array of shape"):
            env.reset(options={"reset_mask": [True, False]})
        return
    cells, _, _, truncated, _ = env.step(go)
    assert (cells.tolist(), truncated.tolist()) == ([0, 0], [False, False])
    assert env.step(go)[3].tolist() == [False, False]
    assert env.step(go)[3].tolist() == [True, True]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", ["Grid", "Thesis10x10", "Thesis10x10Dynamic", "Thesis5x5", "Thesis5x5Dynamic"])
def test_registered_worlds(name: str) -> None:
    register_envs()
    check_env(gym.make(f"ltlc/{name}-v0").unwrapped)
    envs = gym.make_vec(f"ltlc/{name}-v0", num_envs=3, max_episode_steps=4)
    assert isinstance(envs.unwrapped, VectorGridWorld)
    envs.reset(seed=0)
    for _ in range(4):
        *_, truncated, _ = envs.step(np.zeros(3, dtype=int))
    assert truncated.all()
    coordinates = gym.make(f"ltlc/{name}-v0", observation="coordinates") if name != "Grid" else None
    assert coordinates is None or coordinates.reset()[0].shape == (2,)


def test_pictures() -> None:
    env = GridWorld(MAP, render_mode="ansi")
    env.reset()
    env.step(1)
    env.step(1)
    assert env.render() == "..@\n.#.\nb.c\nlabel: a\n"
    pixels = GridWorld(MAP, render_mode="rgb_array")
    pixels.reset()
    first = pixels.render()
    assert first.shape == (3 * 48, 3 * 48, 3)
    assert first.dtype == np.uint8
    pixels.step(1)
    second = pixels.render()
    assert (first != second)[:48, :96].any()
    assert not (first != second)[48:].any()
    assert len(VectorGridWorld(MAP, 2, render_mode="rgb_array").render()) == 2
    assert VectorGridWorld(MAP, 2, render_mode="ansi").render()[0].startswith("@.a")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert GridWorld(MAP).render() is None
    assert "needs a render mode" in str(caught[0].message)


@pytest.mark.parametrize(("arguments", "message"), [
    ({"map": ()}, "the grid map has no cells"),
    ({"map": ("S.", "...")}, "row 1 has 3 cells, row 0 has 2"),
    ({"map": ("..",)}, "0 cells marked S"),
    ({"map": ("SS",)}, "2 cells marked S"),
    ({"map": ("S#",), "start": (0, 1)}, r"start \(0, 1\) is a wall or lies outside the 1 x 2 map"),
    ({"map": ("S.",), "start": (5, 0)}, r"start \(5, 0\) is a wall or lies outside"),
    ({"map": ("Sa",), "labels": {"b": 1.0}}, "unknown map character 'b'"),
    ({"map": ("Sa",), "labels": {"a": 1.5}}, "label 'a' of map character 'a' has probability 1.5"),
    ({"map": ("Sa",), "labels": {"a": {"x": float("nan")}}}, "has probability nan"),
    ({"map": ("Sa",), "actions": 8}, "8 actions; a grid world has 4"),
    ({"map": ("Sa",), "slip": -0.1}, "slip -0.1 does not give each of 5 actions"),
    ({"map": ("Sa",), "slip": float("nan")}, "slip nan does not give"),
    ({"map": ("Sa",), "slip": [0.1, 0.2]}, "slip has 2 entries for 5 actions"),
    ({"map": ("Sa",), "slip": np.ones((5, 5))}, "does not give each of 5 actions a probability distribution"),
    ({"map": ("Sa",), "observation": "pixels"}, "unknown observation of a grid world 'pixels'"),
    ({"map": ("Sa",), "render_mode": "human"}, "unknown render mode 'human'"),
])  # fmt: skip
def test_wrong_maps_are_explained(arguments: dict[str, Any], message: str) -> None:
    for make in (GridWorld, VectorGridWorld):
        with pytest.raises(InvalidArgumentError, match=message):
            make(**arguments)


def test_wrong_actions_and_sizes_are_explained() -> None:
    with pytest.raises(InvalidArgumentError, match=r"action 4 of a grid world with actions 0\.\.3"):
        GridWorld(MAP, actions=4).step(4)
    with pytest.raises(InvalidArgumentError, match=r"actions must be 2 numbers in 0\.\.4"):
        VectorGridWorld(MAP, 2).step(np.array([0, 5]))
    with pytest.raises(UnknownNameError, match=r"unknown autoreset mode 'NextStop'. Did you mean NextStep"):
        VectorGridWorld(MAP, 2, autoreset_mode="NextStop")
    with pytest.raises(InvalidArgumentError, match="num_envs is 0"):
        VectorGridWorld(MAP, 0)
    with pytest.raises(UnknownNameError, match="unknown thesis world '6x6'"):
        thesis_map("6x6")


LAKE = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}


@pytest.mark.parametrize(("formula", "probability"), [
    ("F goal & G !hole", 14 / 17), ("G F goal", 14 / 17), ("G !hole", 1.0)])  # fmt: skip
def test_frozen_lake_has_its_known_probabilities(formula: str, probability: float) -> None:
    lake = gym.make("FrozenLake-v1")
    task = Task(formula, extra := "thesis")
    assert extra == task.scheme.name
    wrapped = LTLWrapper(lake, task, LAKE, extra_labels="ignore")
    for mdp in (labelled_mdp(lake, LAKE), labelled_mdp(wrapped)):
        assert max_satisfaction_probability(Product(mdp, task.automaton)).probability == pytest.approx(
            probability, abs=1e-9
        )


def test_other_toy_texts_have_models_too() -> None:
    cliff = gym.make(newest("CliffWalking"))
    names = LabelFunction(
        lambda s, info: {"goal"} & {"goal" * int(s == 47)} | {"cliff"} & {"cliff" * int(37 <= s < 47)},
        ("goal", "cliff"),
    )
    mdp = labelled_mdp(cliff, names)
    assert (mdp.n_states, mdp.aps) == (48, ("cliff", "goal"))
    assert max_satisfaction_probability(Product(mdp, Task("!cliff U goal").automaton)).probability == pytest.approx(1)
    taxi = labelled_mdp(gym.make(newest("Taxi")), lambda state, info: "aboard" if (state // 4) % 5 == 4 else "")
    assert taxi.n_states == 500
    assert taxi.start.max() < 0.01


def test_an_unknown_model_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="the dynamics of CartPoleEnv are not known"):
        labelled_mdp(gym.make("CartPole-v1"), {})
    with pytest.raises(InvalidArgumentError, match="pass labels="):
        labelled_mdp(gym.make("FrozenLake-v1"))
