"""The single wrapper against the reward tables, and what it says about wrong labels."""

from __future__ import annotations

import pickle
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv, follow, no_sink_automaton
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordEpisodeStatistics, RecordVideo, TimeLimit

from ltlc.envs import GridWorld, LabelFunction, LTLWrapper, thesis_world
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.rewards import get_scheme
from ltlc.task import Task

MODES = ("dict", "flat", "index", "none")


def tasks() -> list[Task]:
    return [
        Task("!b U a", "zeta-discount"),
        Task("G F a & G !(a & b)", "thesis"),
        Task("G F a", get_scheme("thesis", terminate_on_accept=False)),
        Task("G F a", "frontier"),
        Task(no_sink_automaton(3), "thesis-code"),
        Task(no_sink_automaton(8), "sadigh", shaping=2.0, on_deadlock="initial"),
    ]


def letters_of(log: list[dict[str, Any]], aps: tuple[str, ...]) -> list[int]:
    return [sum(1 << i for i, name in enumerate(aps) if name in info["labels"]) for info in log]


@pytest.mark.parametrize("number", range(6))
@pytest.mark.parametrize("skip", [False, True])
def test_an_episode_is_what_the_tables_say(number: int, skip: bool) -> None:
    task = tasks()[number]
    env = LTLWrapper(RandomEnv(end=0.0), task, initial_label="skip" if skip else "read")
    for seed in range(20):
        _, info = env.reset(seed=seed)
        log, paid, ended = [info], [], []
        for _ in range(15):
            _, reward, terminated, truncated, info = env.step(0)
            assert not truncated
            log.append(info)
            paid.append(reward)
            ended.append(terminated)
        expected = follow(task.tables, letters_of(log, task.aps), skip)
        assert log[0]["ltl"]["state"] == expected[0]["state"]
        for got, reward, end, want in zip(log[1:], paid, ended, expected[1:], strict=True):
            assert end == want.pop("stop")
            names = frozenset(name for i, name in enumerate(task.aps) if want["label"] >> i & 1)
            assert got["ltl"] == want | {"label_names": names, "base_terminated": False}
            assert reward == want["reward"]


def test_the_first_label_is_read_unless_skipped() -> None:
    world = GridWorld(("a.",), start=(0, 0), actions=4)
    for mode, state in (("read", 1), ("skip", 0)):
        env = LTLWrapper(world, Task("F a", "eventual"), initial_label=mode)
        _, info = env.reset()
        assert info["ltl"]["label"] == 1
        assert (info["ltl"]["progress"] == 1) == bool(state)
        assert (info["ltl"]["reward"], info["ltl"]["discount"]) == (0, 1)


def test_a_violation_is_paid_for_and_forgiven() -> None:
    env = LTLWrapper(GridWorld(("S.x",), actions=4), Task("G !x & F G !x", reward="thesis"))
    before, _ = env.reset()
    env.step(1)
    after, reward, terminated, _, info = env.step(1)
    assert (reward, terminated, info["ltl"]["violated"]) == (-100, False, True)
    assert after["automaton"] == before["automaton"] == env.automaton_state
    assert not env.step(3)[4]["ltl"]["violated"]


def test_acceptance_ends_only_where_it_is_settled_or_asked_for() -> None:
    ends = {}
    for formula, scheme in (("F a", "eventual"), ("G F a", "eventual"), ("G F a", "thesis")):
        env = LTLWrapper(GridWorld(("Sa",), actions=4), Task(formula, scheme))
        env.reset()
        _, _, terminated, _, info = env.step(1)
        assert info["ltl"]["accepting"]
        ends[formula, scheme] = terminated
    assert ends == {("F a", "eventual"): True, ("G F a", "eventual"): False, ("G F a", "thesis"): True}


def test_a_task_knows_whether_one_discount_will_do() -> None:
    assert Task("G F a", get_scheme("thesis", gamma=0.9)).discount == 0.9
    assert Task("G F a", "eventual").discount is None
    assert "G(F a)" in repr(Task("G F a")) or "G F a" in repr(Task("G F a"))
    with pytest.raises(InvalidArgumentError, match="wrap a scheme object in Shaped"):
        Task("G F a", get_scheme("thesis"), shaping=1.0)


def test_a_hold_repeats_the_state() -> None:
    world = GridWorld(("Sa",), labels={"a": {"a": 0.0}}, miss="hold", actions=4)
    with pytest.raises(InvalidArgumentError, match="make the task with hold='hold'"):
        LTLWrapper(world, Task("F a"))
    env = LTLWrapper(world, Task("X X a & F G !a", hold="hold"))
    first, _ = env.reset()
    second = env.step(1)[0]
    assert second["automaton"] == first["automaton"]
    assert env.step(3)[0]["automaton"] != first["automaton"]
    with pytest.raises(InvalidArgumentError, match="occurs in the formula"):
        Task("F hold", hold="hold")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("kind", ["discrete", "box", "multi", "dict"])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasium_checks_every_observation_mode(mode: str, kind: str) -> None:
    if mode == "index" and kind in ("box", "dict"):
        with pytest.raises(InvalidArgumentError, match="observation mode 'index' needs a Discrete"):
            LTLWrapper(RandomEnv(kind), Task("G F a"), observation=mode)
        return
    env = LTLWrapper(RandomEnv(kind), Task("F a & G F b", "eventual"), observation=mode)
    check_env(env, skip_render_check=True)
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("mode", MODES)
def test_gymnasium_checks_registered_environments_with_their_spec(mode: str) -> None:
    env = gym.make("ltlc/Thesis5x5Dynamic-v0", disable_env_checker=True, max_episode_steps=50)
    wrapped = LTLWrapper(env, Task("F A & G !C"), observation=mode)
    assert wrapped.spec is not None
    check_env(wrapped)


def test_flat_observations_are_those_of_gymnasium_with_a_one_hot_state() -> None:
    task = Task("F a & G F b", "eventual")
    for kind in ("discrete", "box", "multi", "dict"):
        inner = RandomEnv(kind)
        env = LTLWrapper(RandomEnv(kind), task, observation="flat")
        plain, _ = inner.reset(seed=4)
        flat, info = env.reset(seed=4)
        assert flat[: -task.tables.n_states] == pytest.approx(gym.spaces.flatten(inner.observation_space, plain))
        assert np.flatnonzero(flat[-task.tables.n_states :]).tolist() == [info["ltl"]["state"]]
        assert env.observation_space.contains(flat)


def test_index_observations_tell_every_pair_apart() -> None:
    task = Task("F a & G F b", "eventual")
    for kind in ("discrete", "multi"):
        inner, env = RandomEnv(kind), LTLWrapper(RandomEnv(kind), task, observation="index")
        inner.reset(seed=1)
        env.reset(seed=1)
        seen: dict[int, Any] = {}
        for _ in range(300):
            plain = tuple(np.atleast_1d(inner.step(0)[0]).tolist())
            index, *_, info = env.step(0)
            assert env.observation_space.contains(index)
            assert seen.setdefault(int(index), (plain, info["ltl"]["state"])) == (plain, info["ltl"]["state"])
        assert len(seen) == len(set(seen.values()))


def test_what_becomes_of_the_base_reward() -> None:
    task = Task("G F a", "eventual")
    runs = {}
    for mode in ("replace", "add", "info"):
        env = LTLWrapper(RandomEnv(), task, reward=mode)
        env.reset(seed=7)
        _, reward, _, _, info = env.step(0)
        runs[mode] = reward, info["ltl"]["reward"], info["ltl"].get("base_reward")
    base = runs["info"][2]
    assert runs["info"][0] == runs["info"][1] == runs["replace"][0] == runs["replace"][1]
    assert runs["add"][0] == runs["replace"][0] + base
    assert runs["replace"][2] is None


def test_seed_and_options_reach_the_environment() -> None:
    env = LTLWrapper(RandomEnv(), Task("G F a"))
    first, _ = env.reset(seed=3, options={"x": 1})
    assert env.unwrapped.options == {"x": 1}
    again, _ = env.reset(seed=3)
    assert first == again


def test_chance_is_seeded() -> None:
    def ends(seed: int) -> list[int]:
        env = LTLWrapper(RandomEnv(end=0.0), Task("G F a", get_scheme("zeta-reach", zeta=0.8)))
        lengths = []
        for episode in range(30):
            env.reset(seed=seed if episode == 0 else None)
            length = 1
            while not env.step(0)[2]:
                length += 1
            lengths.append(length)
        return lengths

    assert ends(1) == ends(1) != ends(2)
    assert 6 < np.mean(ends(1) + ends(2) + ends(3)) < 14  # every second letter has a, one in five of those ends


def test_it_pickles_in_the_middle_of_an_episode() -> None:
    env = LTLWrapper(RandomEnv(), Task("G F a", "zeta-reach"))
    env.reset(seed=1)
    env.step(0)
    twin = pickle.loads(pickle.dumps(env))
    for _ in range(20):
        assert env.step(0) == twin.step(0)


def test_it_works_inside_other_wrappers(tmp_path: Any) -> None:
    env: gym.Env = LTLWrapper(RandomEnv(end=0.0, render_mode="rgb_array"), Task("G F a", "eventual"))
    env = RecordEpisodeStatistics(TimeLimit(env, 7))
    env.reset(seed=1)
    total, truncated = 0.0, False
    while not truncated:
        _, reward, _, truncated, info = env.step(0)
        total += reward
    assert (info["episode"]["l"], info["episode"]["r"]) == (7, pytest.approx(total))
    inner = LTLWrapper(TimeLimit(RandomEnv(end=0.0), 3), Task("G F a", "eventual"))
    inner.reset(seed=1)
    assert [inner.step(0)[3] for _ in range(3)] == [False, False, True]


def test_it_works_under_record_video(tmp_path: Any) -> None:
    pytest.importorskip("moviepy", reason="RecordVideo needs moviepy: pip install 'gymnasium[other]'")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        wrapped = LTLWrapper(thesis_world("5x5", render_mode="rgb_array"), Task("F A & G !C"))
        env = RecordVideo(TimeLimit(wrapped, 5), str(tmp_path), episode_trigger=lambda _: True)
        env.reset(seed=0)
        for _ in range(5):
            env.step(0)
        env.close()
    assert list(tmp_path.glob("*.mp4"))


def test_predicates_label_observations() -> None:
    env = LTLWrapper(
        gym.make("CartPole-v1"),
        Task("G F left & G F right", "eventual"),
        {"left": lambda observation: observation[0] < 0, "right": lambda observation: observation[0] > 0},
    )
    _, info = env.reset(seed=0)
    assert info["ltl"]["label"] in (1, 2)


WRONG_LABELS: list[tuple[Any, str]] = [
    (lambda o, i: None, r"a label is None \(NoneType\); expected a set of names"),
    (lambda o, i: 3.5, r"a label is 3.5 \(float\)"),
    (lambda o, i: True, r"a label is True \(bool\)"),
    (lambda o, i: {"a": float("nan")}, r"the label 'a' is nan \(float\); a predicate must say True or False"),
    (lambda o, i: {"a": 1}, r"the label 'a' is 1 \(int\)"),
    (lambda o, i: [1, 2], r"a label contains 1 \(int\)"),
    (lambda o, i: 1, "bitmask and boolean-array labels need a vocabulary"),
    (lambda o, i: np.array([0.5, np.nan]), "labels are NaN"),
    (lambda o, i: {"aa"}, "formula does not mention it.*'aa'. Did you mean a"),
    (lambda o, i: "a, bb", "formula does not mention it.*'bb'. Did you mean b"),
    (lambda o, i: {"bb": False, "a": True}, "proposition in the formula .*no label produces it.*'b'. Did you mean bb"),
    (LabelFunction(lambda o, i: {"a": True, "c": True}, ("a", "b")), "not among the declared ones.* 'c'. Known: a, b"),
    (LabelFunction(lambda o, i: {"c"}, ("a", "b")), "not among the declared ones.* 'c'. Known: a, b"),
    (LabelFunction(lambda o, i: 7, ("b", "a")), "a bitmask label is outside 0..3"),
    (LabelFunction(lambda o, i: np.ones(3, dtype=bool), ("a", "b")), r"boolean labels have shape \(1, 3\)"),
]


@pytest.mark.parametrize(("labels", "message"), WRONG_LABELS)
def test_wrong_labels_are_explained(labels: Any, message: str) -> None:
    env = LTLWrapper(RandomEnv(), Task("F a & G F b"), labels)
    with pytest.raises(InvalidArgumentError, match=message):
        env.reset()


@pytest.mark.parametrize(("labels", "letter"), [
    (lambda o, i: {"b"}, 2),
    (lambda o, i: ["a", "b"], 3),
    (lambda o, i: ("a",), 1),
    (lambda o, i: "", 0),
    (lambda o, i: "a & b", 3),
    (lambda o, i: "b;a", 3),
    (lambda o, i: {"a": np.True_, "b": False}, 1),
    (lambda o, i: {"a": np.array([True])}, 1),
    (LabelFunction(lambda o, i: 1, ("b", "a")), 2),
    (LabelFunction(lambda o, i: np.array([False, True]), ("b", "a")), 1),
    (LabelFunction(lambda o, i: {"b"}, ("a", "b")), 2),
    (LabelFunction(lambda o, i: {"b", "c"}, ("a", "b", "c")), 2),
    (LabelFunction(lambda o, i: {"b": True, "c": True}, ("a", "b", "c")), 2),
    (lambda o, i: {"a": False, "b": True, "c": True}, 2),
    (lambda o, i: {"b": True}, 2),
])  # fmt: skip
def test_labels_come_in_many_shapes(labels: Any, letter: int) -> None:
    env = LTLWrapper(RandomEnv(), Task("F a & G F b"), labels)
    assert env.reset()[1]["ltl"]["label"] == letter


def test_names_are_compared_at_construction() -> None:
    with pytest.raises(UnknownNameError, match=r"no label produces it.*'gaol'. Did you mean goal"):
        LTLWrapper(gym.make("ltlc/Grid-v0"), Task("F gaol"))
    always = {"goal": lambda o: True, "wal": lambda o: False}
    with pytest.raises(UnknownNameError, match=r"no label produces it.*'wall'. Did you mean wal"):
        LTLWrapper(RandomEnv(), Task("F goal & G !wall"), always)
    LTLWrapper(RandomEnv(), Task("F goal"), always)  # they serve other formulas, too
    LTLWrapper(thesis_world(), Task("F A"))  # what an environment declares itself may go unused
    with pytest.raises(UnknownNameError, match="Did you mean goal"):
        LTLWrapper(RandomEnv(), Task("F gol"), LabelFunction(lambda o, i: set(), ("goal",)))


@pytest.mark.parametrize(("arguments", "message"), [
    ({"observation": "dct"}, "unknown observation mode 'dct'. Did you mean dict"),
    ({"reward": "ad"}, "unknown treatment of the environment's reward 'ad'"),
    ({"initial_label": "skp"}, "unknown treatment of the first label 'skp'"),
    ({"extra_labels": "x"}, "unknown treatment of extra labels 'x'"),
    ({"labels": 5}, "labels must be a function of"),
    ({"labels": {"a": 5}}, "the predicate 'a' is 5, not a function"),
])  # fmt: skip
def test_wrong_arguments_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        LTLWrapper(RandomEnv(), Task("G F a"), **arguments)


def test_an_environment_without_labels_says_so() -> None:
    env = LTLWrapper(gym.make("FrozenLake-v1"), Task("G F a"))
    with pytest.raises(InvalidArgumentError, match=r"info has no entry 'labels' \(it has: 'prob'\)"):
        env.reset()
