"""Comparisons of numbers as propositions, against Python's own arithmetic."""

from __future__ import annotations

import math
import operator
import pickle
import random
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ltlc
from ltlc.envs import Comparison, comparisons
from ltlc.envs.comparisons import Path, Variables, is_comparison
from ltlc.envs.spec import EnvSpec
from ltlc.errors import InvalidArgumentError, LtlSyntaxError, UnknownNameError

PLACES: dict[str, Path] = {"x": 0, "y": 1, "v.x": 2}


Row = np.ndarray[Any, Any]
Term = tuple[str, Callable[[Row], Any]]
LEAVES: list[Term] = [
    ("x", lambda row: row[0]),
    ("y", lambda row: row[1]),
    ("v.x", lambda row: row[2]),
    *((text, lambda row, text=text: np.float64(text)) for text in ("2", "0.5", ".25", "1e1", "3.")),
]


def random_term(rng: random.Random, depth: int) -> Term:
    """A text with its value, which Python's own operators give."""
    if depth == 0 or rng.random() < 0.2:
        return rng.choice(LEAVES)
    (left, f), (right, g) = random_term(rng, depth - 1), random_term(rng, depth - 1)
    kinds: list[Term] = [
        (f"{left} + ({right})", lambda row: f(row) + g(row)),
        (f"{left}-({right})", lambda row: f(row) - g(row)),
        (f"({left}) * ({right})", lambda row: f(row) * g(row)),
        (f"({left})/({right})", lambda row: f(row) / g(row)),
        (f"abs({left})", lambda row: abs(f(row))),
        (f"-({left})", lambda row: -f(row)),
        (f"+({left})", f),
        (f"2 - 3 * ({left}) / 4 - {rng.choice('xy')} * 0", lambda row: np.float64(2) - 3 * f(row) / 4),
    ]
    return rng.choice(kinds)


def test_random_comparisons() -> None:
    rng, numbers = random.Random(1), np.random.default_rng(2)
    outcomes = []
    for _ in range(400):
        (left, f), (right, g) = random_term(rng, 3), random_term(rng, 2)
        sign, relation = rng.choice(
            (
                ("<", operator.lt),
                ("<=", operator.le),
                (">", operator.gt),
                (">=", operator.ge),
                ("==", operator.eq),
                ("!=", operator.ne),
            )
        )
        text = f"{left} {sign} {right}"
        compare = Comparison(text, PLACES)
        batch = numbers.integers(-3, 4, size=(6, 3)) / 2
        if not compare.names:
            continue
        found = compare(batch)
        with np.errstate(all="ignore"):
            assert found.tolist() == [bool(relation(f(row), g(row))) for row in batch], text
        assert [compare(row) for row in batch] == found.tolist()
        assert pickle.loads(pickle.dumps(compare))(batch).tolist() == found.tolist()
        outcomes += found.tolist()
    assert 0.2 < np.mean(outcomes) < 0.8


@pytest.mark.parametrize(
    ("text", "x", "holds"),
    [
        ("0 < x < 1", 0.5, True),
        ("0 < x < 1", 1.0, False),
        ("x >= 1 > 0", 1.0, True),
        ("2 - 1 - 1 == 0", 0.0, True),
        ("8 / 2 / 2 == 2", 0.0, True),
        ("1 + 2 * 3 == 7", 0.0, True),
        ("--x == x", 3.0, True),
        ("-x < 0", 3.0, True),
        ("x / 0 > 1", 1.0, True),
        ("x == x", math.nan, False),
        ("x != x", math.nan, True),
        ("abs(-2) == 2", 0.0, True),
    ],
)
def test_meaning(text: str, x: float, holds: bool) -> None:
    assert Comparison(text, {"x": 0})([x]) is holds


def test_a_variable_may_be_called_abs() -> None:
    assert Comparison("abs > abs(abs) - 1", {"abs": ()})(2.0)


@pytest.mark.parametrize(
    ("path", "observation", "value"),
    [
        (0, [4.0, 5.0], 4.0),
        (-1, np.array([4, 5]), 5.0),
        ((), 4, 4.0),
        ((1, 0), np.array([[1, 2], [4, 3]]), 4.0),
        ("speed", {"speed": np.float32(4)}, 4.0),
        (("car", 1), {"car": [0, 4]}, 4.0),
        ((1, "at", 0), (7, {"at": np.array([4.0])}), 4.0),
        ((), True, 1.0),
    ],
)
def test_places(path: Path, observation: Any, value: float) -> None:
    assert Comparison(f"v == {value}", {"v": path})(observation) is True
    assert Comparison(f"v > {value}", {"v": path})(observation) is False


@pytest.mark.parametrize(
    ("path", "observation", "message"),
    [
        (2, [4.0, 5.0], "is no number at observation[2]"),
        ("speed", {"v": 1}, "is no number at observation['speed']"),
        ("speed", [1.0], "is no number"),
        (0, 3.0, "is no number"),
        (0, ["a"], "is no kind of number"),
        ((0, 0), [1.0], "is no number at observation[0][0]"),
    ],
)
def test_wrong_places(path: Path, observation: Any, message: str) -> None:
    with pytest.raises(InvalidArgumentError) as caught:
        Comparison("v > 0", {"v": path})(observation)
    assert message in str(caught.value)


@pytest.mark.parametrize("path", [1.5, True, None, (0, None), [[0]]])
def test_what_is_no_place(path: Any) -> None:
    with pytest.raises(InvalidArgumentError, match="a place is an index, a key, or a tuple of these"):
        Comparison("v > 0", {"v": path})


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("x >", 4, "ends too early: expected a number or a name"),
        ("", 1, "ends too early"),
        ("x", 2, "needs a relation"),
        ("> 1", 1, "'>' cannot stand here"),
        ("x > > 1", 5, "'>' cannot stand here"),
        ("x > 1 2", 7, "'2' cannot stand here"),
        ("x > 1)", 6, "')' cannot stand here"),
        ("(x > 1", 1, "bracket is never closed"),
        ("x > abs(1", 5, "bracket is never closed"),
        ("x = 1", 3, "'=' does not belong"),
        ("x > 3y", 5, "'3' does not belong"),
        ("x ** 2 > 1", 4, "'*' cannot stand here"),
        ("x > __import__('os')", 15, "'(' cannot stand here"),
        ("x > 'os'", 5, "does not belong"),
        ("x > " + "(" * 60 + "1", 55, "nested too deeply"),
        ("x > " + "-" * 60 + "1", 55, "nested too deeply"),
    ],
)
def test_errors(text: str, column: int, message: str) -> None:
    with pytest.raises((LtlSyntaxError, UnknownNameError)) as caught:
        Comparison(text, {"x": 0, "__import__": 0})
    assert message in str(caught.value)
    assert isinstance(caught.value, LtlSyntaxError)
    assert caught.value.column == column
    assert "a comparison reads" in caught.value.hint


def test_long_comparisons() -> None:
    assert Comparison(" + ".join(["x"] * 5000) + " > 4999", {"x": 0})([1.0])


def test_unknown_variables() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown variable 'sped'. Did you mean speed"):
        Comparison("sped > 0", {"speed": 0})


def test_labels_of_a_formula() -> None:
    text = 'GF "x > 0.45" & G "abs(v) <= 0.07" & F near'
    labels = comparisons(text, {"x": 0, "v": 1})
    assert list(labels) == ["x > 0.45", "abs(v) <= 0.07"]
    assert list(comparisons(ltlc.compile(text), {"x": 0, "v": 1})) == list(labels)
    assert list(comparisons(["v>1", "goal"], {"v": 1})) == ["v>1"]
    assert not is_comparison("a=b")
    with pytest.raises(InvalidArgumentError, match="variables"):
        comparisons(text, ["x"])  # type: ignore[arg-type]


def test_in_both_wrappers() -> None:
    task = ltlc.Task('F "x > -0.5" & G "abs(v) < 0.07"')
    labels = comparisons(task.automaton, {"x": 0, "v": 1})
    envs = gym.make_vec("MountainCar-v0", num_envs=3, vectorization_mode="sync")
    batch = ltlc.LTLVectorWrapper(envs, task, batch_labels=labels, warn_discount=False)
    single = ltlc.LTLWrapper(gym.make("MountainCar-v0"), task, labels, warn_discount=False)
    _, infos = batch.reset(seed=5)
    _, info = single.reset(seed=5)
    for _ in range(30):
        assert infos["ltl"]["label"][0] == info["ltl"]["label"]
        _, _, _, _, infos = batch.step(np.array([2, 0, 1]))
        _, _, _, _, info = single.step(2)


def test_variables_as_text() -> None:
    assert Variables("x=0, speed = car.1,all=").places == {"x": (0,), "speed": ("car", 1), "all": ()}
    for text, message in (("x", "'x' is no variable"), ("x=0,x=1", "given twice"), ("1=x", "no variable"), ("", "''")):
        with pytest.raises(InvalidArgumentError, match=message):
            Variables(text)
    with pytest.raises(LtlSyntaxError, match="needs a relation"):
        Variables("goal=0").labels(["goal"])


def test_in_a_specification() -> None:
    spec = EnvSpec(env="MountainCar-v0", labels="variables:x=0")
    envs = spec.vector(ltlc.Task('F "x > 0.45"'), 2)
    _, infos = envs.reset(seed=0)
    assert infos["ltl"]["label"].tolist() == [0, 0]
    assert EnvSpec(env="FrozenLake-v1", labels="variables:x=").model is None
    assert "comparisons are about observations" in EnvSpec(env="FrozenLake-v1", labels="variables:x=").why_no_model
