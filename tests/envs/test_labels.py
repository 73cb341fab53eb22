"""Labels: what a labelling function may take, and that it means the same in both wrappers."""

from __future__ import annotations

import functools
import math
import operator
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium import spaces
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv
from vector_rollouts import RESETS, TASKS, run

from ltlc.envs import LabelFunction, LTLVectorWrapper, LTLWrapper
from ltlc.envs.batch import SubInfo
from ltlc.envs.labels import arity
from ltlc.errors import InvalidArgumentError
from ltlc.task import Task

N = 5
KINDS = ("discrete", "box", "multi", "dict")


def total(observation: Any) -> float:
    """A number that depends on all of an observation, whatever its space."""
    if isinstance(observation, dict):
        return sum(total(part) for part in observation.values())
    return float(np.sum(observation))


def names(a: Any, b: Any) -> set[str]:
    return {name for name, holds in (("a", a), ("b", b)) if holds}


def by_observation(observation: Any) -> set[str]:
    return names(total(observation) % 1 < 0.5, total(observation) > 1)


def by_info(observation: Any, info: Any) -> set[str]:
    return names(info["coin"] > 1, total(observation) > 1)


def by_env(observation: Any, info: Any, env: Any) -> set[str]:
    return names(info["coin"] > 1, env.unwrapped.last > 0.5)


class Watched(RandomEnv):
    """A random environment with something to see that is in neither observation nor info."""

    last = 0.0

    def step(self, action: Any) -> Any:
        self.last = float(self.np_random.random())
        return super().step(action)

    def reset(self, **arguments: Any) -> Any:
        self.last = 0.0
        return super().reset(**arguments)


LABELLERS: list[Any] = [
    by_observation,
    by_info,
    by_env,
    {"a": lambda o: total(o) % 1 < 0.5, "b": lambda o, info: bool(info["coin"] > 1)},
    {"a": lambda o, info, env: env.unwrapped.last > 0.5, "b": lambda o: total(o) > 1},
    "test_envs_labels:by_info",
    LabelFunction(by_observation, ("a", "b")),
    LabelFunction(lambda o: int(total(o) > 1), ("b", "a")),
]


def vectors(task: Task, mode: AutoresetMode, kind: str, **arguments: Any) -> tuple[Any, Any]:
    one_by_one = SyncVectorEnv([lambda: LTLWrapper(Watched(kind), task, **arguments)] * N, autoreset_mode=mode)
    together = LTLVectorWrapper(SyncVectorEnv([partial(Watched, kind)] * N, autoreset_mode=mode), task, **arguments)
    return one_by_one, together


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.parametrize("number", range(len(LABELLERS)))
def test_labels_mean_the_same_in_both_wrappers(
    number: int, mode: AutoresetMode, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "test_envs_labels", sys.modules[__name__])
    if mode == AutoresetMode.SAME_STEP and number in (2, 4):
        with pytest.raises(InvalidArgumentError, match="in its next episode already"):
            vectors(TASKS[1](), mode, "discrete", labels=LABELLERS[number])
        return
    for kind in KINDS:
        run(*vectors(TASKS[1](), mode, kind, labels=LABELLERS[number]), 40, mode)


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.slow
def test_labels_over_processes(mode: AutoresetMode) -> None:
    task = Task("G F a & G F b", "eventual")
    one_by_one = SyncVectorEnv([lambda: LTLWrapper(Watched(), task, by_info)] * N, autoreset_mode=mode)
    together = LTLVectorWrapper(AsyncVectorEnv([Watched] * N, autoreset_mode=mode), task, by_info)
    run(one_by_one, together, 20, mode)
    with pytest.raises(InvalidArgumentError, match=r"by_env.*asks for the environment.*processes of their own"):
        LTLVectorWrapper(together.env, task, by_env)
    together.close()


def test_functions_of_one_observation_where_there_are_as_many_environments_as_numbers_in_it() -> None:
    """Called with the batch, such a function would look at the first environment and never say so."""
    envs = gym.make_vec("CartPole-v1", num_envs=4, vectorization_mode="sync")
    env = LTLVectorWrapper(envs, Task("G F left", "eventual"), {"left": lambda o: o[0] < 0})
    observations, infos = env.reset(seed=1)
    for _ in range(20):
        assert infos["ltl"]["label"].tolist() == (observations["observation"][:, 0] < 0).astype(int).tolist()
        observations, *_, infos = env.step(env.action_space.sample())


def test_labels_and_batch_labels_exclude_each_other() -> None:
    with pytest.raises(InvalidArgumentError, match="labels and batch_labels are both given"):
        LTLVectorWrapper(SyncVectorEnv([RandomEnv]), "F a", lambda o: "a", batch_labels=lambda o: ["a"])


def test_batch_labels_of_some_sub_environments() -> None:
    """With spaces that Gymnasium batches as tuples, too."""

    def batched(observations: Any) -> list[str]:
        assert len(observations["text"]) == len(observations["n"])
        return [text if n else "" for text, n in zip(observations["text"], observations["n"], strict=True)]

    for mode in RESETS:
        one_by_one = SyncVectorEnv(
            [lambda: LTLWrapper(Texts(), "G F a", lambda o: o["text"] if o["n"] else "")] * N, autoreset_mode=mode
        )
        together = LTLVectorWrapper(SyncVectorEnv([Texts] * N, autoreset_mode=mode), "G F a", batch_labels=batched)
        run(one_by_one, together, 30, mode)


class Letter(spaces.Space[str]):
    """A space of somebody's own, which Gymnasium cannot flatten."""

    def __init__(self) -> None:
        super().__init__()

    def sample(self, mask: Any = None, probability: Any = None) -> str:
        return "a" if self.np_random.random() < 0.5 else ""

    def contains(self, x: Any) -> bool:
        return x in ("a", "")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Letter)

    __hash__ = None


class Texts(gym.Env):
    """Shows a text and a number."""

    def __init__(self) -> None:
        self.observation_space = spaces.Dict({"text": Letter(), "n": spaces.Discrete(2)})
        self.action_space = spaces.Discrete(2)

    def _see(self) -> Any:
        return {"text": "a" if self.np_random.random() < 0.5 else "", "n": int(self.np_random.integers(2))}

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        return self._see(), {}

    def step(self, action: Any) -> Any:
        return self._see(), 0.0, bool(self.np_random.random() < 0.1), bool(self.np_random.random() < 0.1), {}


def test_a_space_that_cannot_be_flattened_is_named() -> None:
    with pytest.raises(
        InvalidArgumentError, match=r"cannot flatten the observation\['text'\], which is .*Letter.* 'dict'"
    ):
        LTLWrapper(Texts(), "F a", lambda o: o["text"], observation="flat")
    with pytest.raises(InvalidArgumentError, match="cannot flatten the observation, which is Sequence"):
        LTLWrapper(gym.wrappers.TransformObservation(Texts(), list, spaces.Sequence(spaces.Discrete(2))), "F a",
                   lambda o: "", observation="flat")  # fmt: skip


@pytest.mark.parametrize("mode", RESETS)
def test_texts_can_be_flattened_in_batches(mode: AutoresetMode) -> None:
    def make() -> gym.Env:
        text = spaces.Text(1, min_length=0, charset="ab")
        return gym.wrappers.TransformObservation(Texts(), lambda o: o["text"], text)

    task = Task("G F a")
    one_by_one = SyncVectorEnv(
        [lambda: LTLWrapper(make(), task, lambda o: o, observation="flat")] * N, autoreset_mode=mode
    )
    inner = SyncVectorEnv([make] * N, autoreset_mode=mode)
    run(one_by_one, LTLVectorWrapper(inner, task, lambda o: o, observation="flat"), 20, mode)


class Method:
    """Callable in several ways."""

    def __call__(self, observation: Any, info: Any) -> str:
        return ""

    def bound(self, observation: Any) -> str:
        return ""

    @staticmethod
    def static(observation: Any, info: Any, env: Any) -> str:
        return ""


@functools.lru_cache
def cached(observation: Any, info: Any = None) -> str:
    return ""


@pytest.mark.parametrize(("function", "expected"), [
    (lambda o: "", 1), (lambda o, i: "", 2), (lambda o, i, e: "", 3), (lambda *a: "", 1), (lambda o, *a: "", 1),
    (lambda o, goal=3: "", 1), (lambda o, info=None: "", 2), (lambda o, info=None, env=None: "", 3),
    (lambda o, i, env=None: "", 3), (lambda o, env=None: "", 1), (lambda o, *, scale=1: "", 1), (lambda o=0: "", 1),
    (Method(), 2), (Method().bound, 1), (Method.static, 3), (cached, 2), (math.sqrt, 1), (str, 1), (frozenset, 1),
    (partial(lambda goal, o: "", 3), 1), (partial(lambda o, goal: "", goal=3), 1), (operator.itemgetter(0), 1),
    (LabelFunction(lambda o: "", ()), 1), (LabelFunction(lambda o, i, e: "", ()), 3),
])  # fmt: skip
def test_arities(function: Callable[..., Any], expected: int) -> None:
    assert arity(function) == expected


@pytest.mark.parametrize(("function", "takes"), [
    (lambda: "", r"\(\)"), (lambda o, i, e, x: "", r"\(o, i, e, x\)"), (lambda o, *, scale: "", r"\(o, \*, scale\)"),
    (lambda **o: "", r"\(\*\*o\)"), (LabelFunction(lambda: "", ()), r"\(\)"),
])  # fmt: skip
def test_functions_of_something_else_are_refused_when_the_wrapper_is_made(function: Any, takes: str) -> None:
    accepted = r"\(observation\), \(observation, info\) or \(observation, info, env\)"
    expected = rf"takes {takes}; a labelling function takes {accepted}"
    with pytest.raises(InvalidArgumentError, match=expected):
        LTLWrapper(RandomEnv(), "F a", function)
    with pytest.raises(InvalidArgumentError, match=expected):
        LTLVectorWrapper(SyncVectorEnv([RandomEnv]), "F a", {"a": function})
    with pytest.raises(InvalidArgumentError, match=r"takes \(observations\) or \(observations, infos\)"):
        LTLVectorWrapper(SyncVectorEnv([RandomEnv]), "F a", batch_labels=function)


def test_a_batch_function_is_not_given_the_environment() -> None:
    with pytest.raises(InvalidArgumentError, match=r"takes \(observations\) or \(observations, infos\)"):
        LTLVectorWrapper(SyncVectorEnv([RandomEnv]), "F a", batch_labels=lambda o, i, e: "")


def test_the_info_of_a_sub_environment() -> None:
    yes = np.array([True, True])
    first = np.array([True, False])
    infos = {"x": np.array([3, 4]), "_x": yes, "y": np.array([5, 0]), "_y": first, "note": "all",
             "_own": np.array([7, 8]), "deep": {"z": np.array(["q", None]), "_z": first}, "_deep": first}  # fmt: skip
    assert SubInfo(infos, 0) == {"x": 3, "y": 5, "note": "all", "_own": 7, "deep": {"z": "q"}}
    assert dict(SubInfo(infos, 1)) == {"x": 4, "note": "all", "_own": 8}
    assert SubInfo(infos, 1).get("y") is None and "_x" not in SubInfo(infos, 0)
    with pytest.raises(KeyError):
        SubInfo(infos, 1)["deep"]


def test_infos_in_which_some_labels_are_missing() -> None:
    class Sometimes(RandomEnv):
        def step(self, action: Any) -> Any:
            *step, _ = super().step(action)
            return *step, {} if action else {"labels": 1}

    env = LTLVectorWrapper(SyncVectorEnv([Sometimes] * 2), "F a & F b")
    env.reset()
    with pytest.raises(InvalidArgumentError, match="infos of 1 of 2 sub-environments have no entry 'labels'"):
        env.step(np.array([0, 1]))


def test_one_dict_of_labels_serves_several_formulas() -> None:
    """Of labels that state all their names some may go unused; one that lacks a proposition is misspelt."""

    def whole(observation: Any) -> dict[str, bool]:
        return {"a": bool(observation > 4), "b": bool(observation % 2), "c": True}

    def batch(observations: Any) -> dict[str, Any]:
        return {"a": observations > 4, "b": observations % 2 == 1, "c": observations >= 0}

    def named(observation: Any) -> set[str]:
        return {name for name, holds in whole(observation).items() if holds}

    named.propositions = ("a", "b", "c")
    for formula in ("F a", "F b & G c", "F(a & F(b & F c))"):
        task = Task(formula, "eventual")
        envs = [
            LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N), task, **labels)
            for labels in ({"labels": whole}, {"labels": named}, {"batch_labels": batch})
        ]
        for env in envs:
            env.reset(seed=3)
        for _ in range(10):
            labels = [env.step(np.zeros(N, dtype=np.int64))[4]["ltl"]["label"].tolist() for env in envs]
            assert labels[0] == labels[1] == labels[2]
    for labels in ({"labels": whole}, {"batch_labels": batch}):
        with pytest.raises(InvalidArgumentError, match=r"no label produces it.*'bb'. Did you mean b"):
            LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N), "F a & G !bb", **labels).reset(seed=3)
    with pytest.raises(InvalidArgumentError, match=r"f.propositions = .*'a'"):
        LTLWrapper(RandomEnv(), "F b", lambda o: {"a"}).reset(seed=3)


def test_labels_in_infos_that_are_dicts_serve_several_formulas() -> None:
    class Labelled(RandomEnv):
        def reset(self, **arguments: Any) -> Any:
            return super().reset(**arguments)[0], {"labels": {"a": True, "b": False}}

    for wrapped in (LTLWrapper(Labelled(), "F a"), LTLVectorWrapper(SyncVectorEnv([Labelled] * N), "F a")):
        assert np.all(wrapped.reset(seed=0)[1]["ltl"]["label"] == 1)
    with pytest.raises(InvalidArgumentError, match=r"no label produces it.*'c'"):
        LTLVectorWrapper(SyncVectorEnv([Labelled] * N), "F a & F c").reset(seed=0)


def test_negative_bitmasks_are_no_letters() -> None:
    for names in (("a", "b"), ("b", "a")):
        env = LTLWrapper(RandomEnv(), "F a & F b", LabelFunction(lambda o: -1, names))
        with pytest.raises(InvalidArgumentError, match=r"outside 0\.\.3"):
            env.reset()


def test_exceptions_of_labels_say_where() -> None:
    def bad(observation: Any) -> str:
        raise KeyError("goal")

    with pytest.raises(KeyError) as caught:
        LTLWrapper(RandomEnv(), "F a", bad).reset(seed=0)
    assert any("bad" in note and "observation" in note for note in caught.value.__notes__)
    with pytest.raises(IndexError) as raised:
        LTLVectorWrapper(SyncVectorEnv([RandomEnv]), "F a", lambda o: "a" * bool(o[:, 0] > 1)).reset()
    assert any("batch_labels" in note for note in raised.value.__notes__)
