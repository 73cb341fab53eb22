"""Labels that are named: module and function, or file and function, in specs, pickles and models."""

from __future__ import annotations

import copy
import pickle
import sys
from collections import OrderedDict
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import SyncVectorEnv
from gymnasium.wrappers import TimeLimit
from vector_rollouts import assert_same

from ltlc.envs import GridWorld, LabelFunction, LTLVectorWrapper, LTLWrapper, VectorGridWorld, labelled_mdp
from ltlc.errors import InvalidArgumentError
from ltlc.task import Task

SENSORS = """
from ltlc.envs import LabelFunction
def labels(observation):
    return {"a"} if observation > 4 else set()
def high(observation, info):
    return bool(observation > 4)
predicates = {"a": "sensors:high"}
declared = LabelFunction(lambda observation: int(observation > 4), ("a",))
number = 3
nothing = None
class Sensors:
    @staticmethod
    def labels(observation):
        return "a" if observation > 4 else ""
"""


@pytest.fixture
def sensors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "sensors.py").write_text(SENSORS)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    sys.modules.pop("sensors", None)


TEXTS = ["sensors:labels", "sensors.py:labels", "sensors:Sensors.labels", "sensors:predicates", "sensors:declared",
         {"a": "sensors:high"}]  # fmt: skip


@pytest.mark.parametrize("labels", TEXTS)
def test_labels_by_name_come_through_specs_and_pickles(labels: Any, sensors: Path) -> None:
    env = LTLWrapper(TimeLimit(gym.make("FrozenLake-v1"), 7), "F a", labels, observation="index", success_key=True)
    spec = EnvSpec.from_json(env.spec.to_json())
    copies = [gym.make(spec), gym.make(env.spec), pickle.loads(pickle.dumps(env)), copy.deepcopy(env)]
    for other in copies:
        while not isinstance(other, LTLWrapper):
            other = other.env
        assert other.labels == labels
        env.reset(seed=3), other.reset(seed=3)
        for action in (0, 1, 2, 2, 1, 2):
            assert_same(
                dict(zip("osrti", env.step(action), strict=True)), dict(zip("osrti", other.step(action), strict=True))
            )
    vector = LTLVectorWrapper(SyncVectorEnv([partial(gym.make, "FrozenLake-v1")] * 3), "F a", labels)
    vector.reset(seed=1)
    twin = pickle.loads(pickle.dumps(vector))
    assert_same(vector.step(np.array([1, 2, 1]))[4]["ltl"], twin.step(np.array([1, 2, 1]))[4]["ltl"])


def test_functions_that_can_be_imported_come_through_specs(sensors: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(sensors))
    import sensors as module

    for labels, text in ((module.labels, "sensors:labels"), (module.Sensors.labels, "sensors:Sensors.labels")):
        env = LTLWrapper(gym.make("FrozenLake-v1"), "F a", labels)
        assert EnvSpec.from_json(env.spec.to_json()).additional_wrappers[-1].kwargs["labels"] == text
        assert gym.make(env.spec).get_wrapper_attr("labels") == text
    env = LTLWrapper(gym.make("FrozenLake-v1"), "F a", {"a": module.high})
    assert EnvSpec.from_json(env.spec.to_json()).additional_wrappers[-1].kwargs["labels"] == {"a": "sensors:high"}

    def local(observation: Any) -> str:
        return "a" * (observation > 4)

    for labels in ({"a": lambda o: o > 4}, local, LabelFunction(local, ("a",))):
        env = TimeLimit(LTLWrapper(gym.make("FrozenLake-v1"), "F a", labels), 7)
        with pytest.raises(InvalidArgumentError, match=r"LTLWrapper was made with labels=.* the text \"module:name\""):
            env.spec.to_json()
        gym.make(env.spec).reset()
    with pytest.raises(InvalidArgumentError, match="LTLWrapper was made with task="):
        LTLWrapper(gym.make("FrozenLake-v1"), Task("F a"), "sensors:labels").spec.to_json()


@pytest.mark.parametrize(("labels", "message"), [
    ("sensors", "expected module:name"), ("sensors:", "expected module:name"), ("sensor:labels", "no module sensor"),
    ("sensors:lables", "'lables'. Did you mean labels"), ("sensors:number", "'sensors:number' is 3"),
    ("sensors:nothing", "'sensors:nothing' is None"), ({"a": "sensors:number"}, "predicate 'a' is 3"),
])  # fmt: skip
def test_wrong_names_of_labels(labels: Any, message: str, sensors: Path) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        LTLWrapper(RandomEnv(), "F a", labels)


def test_models_of_labels_in_every_form(sensors: Path) -> None:
    lake = gym.make("FrozenLake-v1")
    models = [labelled_mdp(lake, labels) for labels in (*TEXTS, lambda s, i: "a" * (s > 4))]
    models.append(labelled_mdp(LTLWrapper(lake, "F a", "sensors:labels")))
    assert all(mdp.letters.tolist() == models[0].letters.tolist() for mdp in models)
    for labels in (lambda o, i: "a" * (i["prob"] > 0), lambda o, i: "a" * bool(i), lambda o, i: i.get("a", ""),
                   lambda o, i, e: ""):  # fmt: skip
        with pytest.raises(InvalidArgumentError, match="what holds in a state is not known"):
            labelled_mdp(lake, labels)


def test_models_of_grids_with_labels_of_the_user() -> None:
    """Such labels were left out without a word."""
    corner = {"corner": lambda cell: cell == 3}
    env = LTLWrapper(GridWorld(("Sa.", "b..")), "F corner", corner)
    vector = LTLVectorWrapper(VectorGridWorld(("Sa.", "b.."), 2), "F corner", corner)
    for mdp in (labelled_mdp(env), labelled_mdp(env.unwrapped, corner), labelled_mdp(vector)):
        assert mdp.aps == ("corner",)
        assert mdp.letters[mdp.label_probability.indices].tolist() == [0, 0, 0, 1, 0, 0]
    assert labelled_mdp(env.unwrapped).aps == ("a", "b")
    with pytest.raises(InvalidArgumentError, match="observations are not the states"):
        labelled_mdp(GridWorld(("Sa.", "b.."), observation="coordinates"), {"corner": lambda o: bool(o[0])})
    batched = LTLVectorWrapper(vector.env, "F corner", batch_labels={"corner": lambda o: np.zeros(2, dtype=bool)})
    with pytest.raises(InvalidArgumentError, match="labelled by batch_labels"):
        labelled_mdp(batched)


def test_ordered_and_nested_predicates_are_fine() -> None:
    env = LTLWrapper(RandomEnv(), "F a & F b", OrderedDict(a=lambda o: True, b=lambda o, info: info["coin"] == 3))
    _, info = env.reset(seed=2)
    assert info["ltl"]["label"] == 1 + 2 * (info["coin"] == 3)
