"""Environments whose propositions exclude each other: wrappers, rewards and judge over possible letters."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

import ltlc
from ltlc.envs.declared import declared_letters
from ltlc.envs.watched import MonitorWrapper
from ltlc.errors import ImpossibleLetterError
from ltlc.mdp import LabelledMDP

N = 100
ROOMS = tuple(f"room{i}" for i in range(N))


class Rooms(gymnasium.Env[int, int]):
    """A corridor of rooms, a proposition each; action 1 goes on, with a slip, and action 0 goes back."""

    observation_space, action_space = gymnasium.spaces.Discrete(N), gymnasium.spaces.Discrete(2)
    propositions, exclusive = ROOMS, [ROOMS]
    also: frozenset[str] = frozenset()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.room = 0
        return self.room, {"labels": {ROOMS[0]}}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.room = min(self.room + 1, N - 1) if action else max(self.room - 1, 0)
        return self.room, 0.0, self.room == N - 1, False, {"labels": {ROOMS[self.room], *self.also}}

    def labelled_mdp(self) -> LabelledMDP:
        on = 0.9 * np.eye(N)[np.minimum(np.arange(N) + 1, N - 1)] + 0.1 * np.eye(N)
        back = np.eye(N)[np.maximum(np.arange(N) - 1, 0)]
        return LabelledMDP.from_arrays([back, on], aps=ROOMS, labels=[[room] for room in ROOMS])


def walk(env: Any, actions: list[int]) -> tuple[list[Any], list[float]]:
    names, rewards = [], []
    for action in actions:
        _, reward, _, _, info = env.step(action)
        names.append(info["ltl"]["label_names"])
        rewards.append(float(reward))
    return names, rewards


FORMULA = "F(room1 & F(room2 & F room0)) & G !room50"


def test_a_formula_that_becomes_a_task_reads_declared_letters() -> None:
    env = ltlc.LTLWrapper(Rooms(), FORMULA, warn_discount=False)
    assert env.task.automaton.possible is not None
    free = ltlc.LTLWrapper(Rooms(), ltlc.Task(FORMULA), warn_discount=False)
    for each in (env, free):
        each.reset(seed=0)
    actions = [1, 1, 0, 0, 1]
    assert walk(env, actions) == walk(free, actions)
    assert env.automaton_state in env.task.automaton.annotations.deadlocks or env.task.automaton.n_states < 9


def test_a_vector_of_rooms() -> None:
    envs = SyncVectorEnv([Rooms] * 3)
    assert declared_letters(envs).exclusive == (frozenset(ROOMS),)
    wrapped = ltlc.LTLVectorWrapper(envs, "F(room1 & F room3) & G(room0 | !room0)", warn_discount=False)
    wrapped.reset(seed=0)
    infos: dict[str, Any] = {}
    for _ in range(3):
        infos = wrapped.step(np.ones(3, dtype=np.int64))[4]
    assert infos["ltl"]["label_names"].tolist() == [{"room3"}] * 3
    automaton = wrapped.task.automaton
    assert infos["ltl"]["label"].tolist() == [automaton.letter({"room3"})] * 3


def test_all_hundred_propositions_in_one_formula() -> None:
    text = f"F room{N - 1} & G({' | '.join(ROOMS)})"
    env = ltlc.LTLWrapper(Rooms(), text, warn_discount=False, success_key=True)
    env.reset(seed=0)
    for _ in range(N - 1):
        *_, info = env.step(1)
    assert info["is_success"]
    judge = ltlc.Judge(Rooms().labelled_mdp(), ltlc.Task(text, exclusive=[ROOMS]))
    assert judge.maximum.probability == pytest.approx(1)


@pytest.mark.parametrize("goal", ["reach", "end"])
def test_finite_traces_end_with_the_episode(goal: Any) -> None:
    task = ltlc.Task(f"F room3 & F(last & room{N - 1})", finite=True, goal=goal, exclusive=[ROOMS])
    env = ltlc.LTLWrapper(Rooms(), task, warn_discount=False)
    env.reset(seed=0)
    for _ in range(N - 1):
        *_, terminated, _, _ = env.step(1)
    assert terminated
    assert env.automaton_state in task.automaton.accepting_sinks


def test_labels_of_every_kind_mean_the_same() -> None:
    task = ltlc.Task("F(a & F b) & G(c | a | b)", exclusive=[{"a", "b"}])
    names = ("b", "x", "c", "a")
    letter = task.automaton.letter({"a", "c"})

    class Switch(gymnasium.Env[Any, Any]):
        observation_space, action_space = gymnasium.spaces.Discrete(2), gymnasium.spaces.Discrete(2)
        propositions = names

        def reset(self, **_: Any) -> tuple[int, dict[str, Any]]:
            return 0, {"labels": self.label}

    for label in ({"a", "c"}, ["c", "a"], {"a": True, "b": False, "c": True}, 0b1100, np.array([0, 0, 1, 1], bool)):
        Switch.label = label
        _, info = ltlc.LTLWrapper(Switch(), task, warn_discount=False).reset()
        assert (info["ltl"]["label"], info["ltl"]["label_names"]) == (letter, {"a", "c"})
    batches = [np.array([12, 4]), np.array([[0, 0, 1, 1], [0, 0, 1, 0]], dtype=bool), [{"a", "c"}, {"c"}]]
    for batch in [*batches, {"a": np.array([True, False]), "b": np.zeros(2, bool), "c": np.ones(2, bool)}]:
        envs = SyncVectorEnv([Rooms] * 2)
        wrapped = ltlc.LTLVectorWrapper(
            envs,
            task,
            batch_labels=ltlc.envs.LabelFunction(lambda _, batch=batch: batch, names),
            warn_discount=False,
        )
        assert wrapped.reset()[1]["ltl"]["label"].tolist() == [letter, task.automaton.letter({"c"})]


def test_an_impossible_letter_that_occurs_is_named() -> None:
    class Doors(Rooms):
        also = frozenset({"room7"})

    env = ltlc.LTLWrapper(Doors(), "F room1 & F room7", warn_discount=False)
    env.reset(seed=0)
    with pytest.raises(ImpossibleLetterError, match=r"the letter \{room1, room7\} occurs"):
        env.step(1)
    envs = ltlc.LTLVectorWrapper(SyncVectorEnv([Doors] * 2), "F room1 & F room7", warn_discount=False)
    envs.reset(seed=0)
    with pytest.raises(ImpossibleLetterError, match=r"the letter \{room1, room7\} occurs"):
        envs.step(np.ones(2, dtype=np.int64))
    watched = MonitorWrapper(Doors(), "F room1 & F room7")
    watched.reset(seed=0)
    with pytest.raises(ImpossibleLetterError, match=r"the letter \{room1, room7\} occurs"):
        watched.step(1)
    model = LabelledMDP.from_arrays([np.eye(2)], aps=["a", "b"], labels=[["a", "b"], []])
    with pytest.raises(ImpossibleLetterError, match=r"\{a, b\}"):
        ltlc.Judge(model, ltlc.Task("F a & F b", exclusive=[{"a", "b"}])).maximum.probability  # noqa: B018


def test_judge_and_rewards_agree_with_all_letters() -> None:
    model = Rooms().labelled_mdp()
    for text in (FORMULA, "G F room3 & G F room9", "!room5 U room2"):
        for scheme in ("two-discount", "parity", "thesis"):
            judges = [
                ltlc.Judge(model, ltlc.Task(text, reward=scheme, exclusive=groups)) for groups in ((), [ROOMS[:60]])
            ]
            assert judges[0].maximum.probability == pytest.approx(judges[1].maximum.probability, abs=1e-9)


def test_the_letters_that_an_environment_lists() -> None:
    class Listed(Rooms):
        exclusive: Any = None
        possible_letters = tuple({room} for room in ROOMS)

    env = ltlc.LTLWrapper(Listed(), f"G({' | '.join(ROOMS)})", warn_discount=False)
    assert env.task.automaton.n_states == 1
    assert len(env.task.automaton.letter_class) == N
