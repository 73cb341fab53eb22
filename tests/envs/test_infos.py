"""What infos tell of labels and of success, the same in both wrappers."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TimeLimit
from gymnasium.wrappers.vector import DictInfoToList
from vector_rollouts import RESETS, TASKS, run

from ltlc.automata import DRA
from ltlc.envs import LTLVectorWrapper, LTLWrapper, VectorGridWorld
from ltlc.envs.letters import LabelNames
from ltlc.envs.success import accepted_forever
from ltlc.task import Task

N = 5


def vectors(task: Task, mode: AutoresetMode, **arguments: Any) -> tuple[Any, Any]:
    one_by_one = SyncVectorEnv([lambda: LTLWrapper(RandomEnv(), task, **arguments)] * N, autoreset_mode=mode)
    return one_by_one, LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N, autoreset_mode=mode), task, **arguments)


@pytest.mark.parametrize("shift", [False, True])
def test_names_of_labels(shift: bool) -> None:
    names = LabelNames(("a", "b"), np.array([0, 1, 3]))
    each = [frozenset(), frozenset("a"), frozenset("ab")]
    if shift:
        names, each = names[1:], each[1:]
    for same in (names, copy.deepcopy(names), copy.copy(names), pickle.loads(pickle.dumps(names)), names.copy()):
        assert isinstance(same, LabelNames)
        assert list(same) == same.tolist() == each
        assert same[-1] == same.item(-1) == each[-1] and same[np.array([0])].tolist() == each[:1]
    assert repr(names[:0]) == "LabelNames([])"


def test_names_in_infos() -> None:
    task = Task("G F a & G F b")
    env = LTLWrapper(RandomEnv(end=0.0), task)
    vector = LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N), task)
    info, infos = env.reset(seed=1)[1], vector.reset(seed=1)[1]
    for _ in range(20):
        assert info["ltl"]["label_names"] == info["labels"]
        assert list(infos["ltl"]["label_names"]) == list(infos["labels"])
        for kept in (dict(infos["ltl"]), copy.deepcopy(infos["ltl"]), pickle.loads(pickle.dumps(infos["ltl"]))):
            assert list(kept["label_names"]) == list(infos["labels"])
        info, infos = env.step(0)[4], vector.step(np.zeros(N, dtype=int))[4]


@pytest.mark.skipif(
    [*map(int, gym.__version__.split(".")[:2])] < [1, 2],
    reason="Gymnasium 1.1 asks for a mask beside each entry, nested ones too",
)
def test_names_in_lists_of_infos() -> None:
    listed = DictInfoToList(LTLVectorWrapper(VectorGridWorld("S.a", 3), "F a")).reset(seed=1)[1]
    assert listed[0]["ltl"]["label_names"] == frozenset() and listed[0]["ltl"]["label"] == 0


def test_flat_keys_repeat_the_nested_ones() -> None:
    pairs = {"ltl_state": "state", "ltl_accepted": "accepting", "ltl_violated": "violated", "ltl_discount": "discount"}
    env = LTLWrapper(RandomEnv(), Task("G F a & G !(a & b)"), flat_info=True)
    _, info = env.reset(seed=1)
    for _ in range(30):
        assert {key: info[key] for key in pairs} == {key: info["ltl"][entry] for key, entry in pairs.items()}
        assert "is_success" not in info
        info = env.step(0)[4]
    assert not any(key.startswith(("ltl_", "is_")) for key in LTLWrapper(RandomEnv(), "F a & F b").reset()[1])


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.parametrize("number", range(len(TASKS)))
@pytest.mark.parametrize("skip", ["read", "skip"])
def test_success_and_flat_keys_equal_those_of_single_wrappers(number: int, mode: AutoresetMode, skip: str) -> None:
    arguments = {"success_key": True, "flat_info": True, "initial_label": skip}
    run(*vectors(TASKS[number](), mode, **arguments), 60, mode)


@pytest.mark.parametrize("skip", [False, True])
@pytest.mark.parametrize("on_deadlock", ["stay", "initial"])
def test_success_is_what_the_formula_says_of_the_word_that_goes_on_with_its_last_letter(
    skip: bool, on_deadlock: str
) -> None:
    seen = set()
    for formula in ("F a & G !(a & b)", "G F a", "F G b", "a U b", "X X a", "G(a -> X b)", "F(a & X F b)"):
        task = Task(formula, "thesis", on_deadlock=on_deadlock)
        env = LTLWrapper(RandomEnv(end=0.0), task, initial_label="skip" if skip else "read", success_key=True,
                         extra_labels="ignore")  # fmt: skip
        for seed in range(15):
            word = [env.reset(seed=seed)[1]["labels"] & set(task.aps)]
            for _ in range(8):
                *_, info = env.step(0)
                word.append(info["labels"] & set(task.aps))
                satisfied = task.automaton.accepts(word[skip:], [word[-1]])
                assert info["is_success"] is info["ltl"]["success"] is satisfied
                seen.add((formula, satisfied))
    assert len(seen) == 14


def test_words_that_repeat_a_letter() -> None:
    from rewards_reference import random_automaton

    for seed in range(60):
        automaton: DRA = random_automaton(seed, n_states=1 + seed % 7, n_pairs=seed % 4, density=0.3)
        accepted = accepted_forever(automaton)
        for state in range(automaton.n_states):
            for letter, c in enumerate(automaton.letter_class.tolist()):
                at, marks = state, []
                for _ in range(3 * automaton.n_states):
                    marks.append((automaton.edge_fin[:, at, c], automaton.edge_inf[:, at, c]))
                    at = int(automaton.delta[at, c])
                fin, inf = (np.any([m[i] for m in marks[automaton.n_states :]], axis=0) for i in (0, 1))
                assert accepted[state, c] == (inf & ~fin).any(), (seed, state, letter)


def test_success_keys_are_what_monitors_read() -> None:
    results = set()
    for seed in range(40):
        env = LTLWrapper(TimeLimit(RandomEnv(), 20), Task("!b U a"), success_key=True, flat_info=True)
        env.reset(seed=seed)
        over = False
        while not over:
            *_, terminated, truncated, info = env.step(0)
            over = terminated or truncated
        results.add(info["is_success"])
        assert type(info["is_success"]) is bool and type(info["ltl_state"]) is int
    assert results == {False, True}
