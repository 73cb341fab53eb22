"""The vector wrapper against as many single wrappers, in every autoreset mode."""

from __future__ import annotations

import pickle
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from vector_rollouts import RESETS, TASKS, N, assert_same, run

from ltlc.envs import GridWorld, LabelFunction, LTLVectorWrapper, LTLWrapper, VectorGridWorld
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.task import Task


def single(task: Task, kind: str, **arguments: Any) -> gym.Env:
    return LTLWrapper(RandomEnv(kind), task, **arguments)


def pair_of_envs(task: Task, mode: AutoresetMode, kind: str = "discrete", **arguments: Any) -> tuple[Any, Any]:
    """N wrapped environments in a vector, and a wrapped vector of N environments."""
    one_by_one = SyncVectorEnv([partial(single, task, kind, **arguments)] * N, autoreset_mode=mode)
    together = LTLVectorWrapper(SyncVectorEnv([partial(RandomEnv, kind)] * N, autoreset_mode=mode), task, **arguments)
    return one_by_one, together


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.parametrize("number", range(len(TASKS)))
@pytest.mark.parametrize("skip", ["read", "skip"])
def test_it_equals_single_wrappers_exactly(number: int, mode: AutoresetMode, skip: str) -> None:
    seen = run(*pair_of_envs(TASKS[number](), mode, initial_label=skip), 150, mode)
    assert min(seen["terminated"], seen["truncated"]) > 10


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.parametrize(
    ("kind", "observation"),
    [
        (kind, observation)
        for kind in ("discrete", "box", "multi", "dict")
        for observation in ("dict", "flat", "index", "none")
        if observation != "index" or kind in ("discrete", "multi")
    ],
)
def test_it_equals_single_wrappers_in_every_observation_mode(kind: str, observation: str, mode: AutoresetMode) -> None:
    run(*pair_of_envs(TASKS[1](), mode, kind, observation=observation), 40, mode)


@pytest.mark.parametrize("reward", ["replace", "add", "info"])
@pytest.mark.parametrize("mode", RESETS)
def test_it_treats_the_base_reward_alike(reward: str, mode: AutoresetMode) -> None:
    run(*pair_of_envs(TASKS[2](), mode, reward=reward), 60, mode)


def test_it_takes_a_seed_for_each_sub_environment() -> None:
    mode = AutoresetMode.NEXT_STEP
    run(*pair_of_envs(TASKS[2](), mode), 60, mode, seed=[5, 3, 8, 1, 2])


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.slow
def test_it_works_over_processes(mode: AutoresetMode) -> None:
    """The task ends no episode here, so that the processes make no step too many and all is equal."""
    task = Task("G F a", "eventual")
    inner = AsyncVectorEnv([RandomEnv] * N, autoreset_mode=mode)
    one_by_one = SyncVectorEnv([partial(single, task, "discrete")] * N, autoreset_mode=mode)
    together = LTLVectorWrapper(inner, task)
    assert run(one_by_one, together, 40, mode)["terminated"] > 5
    together.close()


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.slow
def test_the_task_can_end_episodes_over_processes(mode: AutoresetMode) -> None:
    env = LTLVectorWrapper(
        AsyncVectorEnv([partial(GridWorld, ("Sa",))] * 2, autoreset_mode=mode), Task("F a", "eventual")
    )
    env.reset(seed=0)
    for _ in range(3):
        observations, rewards, terminated, _, infos = env.step(np.array([1, 4]))
        assert terminated.tolist() == [True, False]
        assert rewards.tolist() == [100.0000000000001, 0] or rewards[0] == pytest.approx(100)
        final = infos["final_obs"][0] if mode == AutoresetMode.SAME_STEP else {k: v[0] for k, v in observations.items()}
        assert final["observation"] == 1
        if mode == AutoresetMode.NEXT_STEP:
            observations, rewards, terminated, truncated, infos = env.step(np.array([1, 4]))
            assert infos["ltl"]["valid"].tolist() == [False, True]
            assert not (rewards.any() or terminated.any() or truncated.any())
        elif mode == AutoresetMode.DISABLED:
            observations, _ = env.reset(options={"reset_mask": np.array([True, False])})
        assert observations["observation"].tolist() == [0, 0]
    env.close()


@pytest.mark.slow
def test_single_wrappers_work_in_processes() -> None:
    envs = AsyncVectorEnv([partial(single, Task("G F a", "zeta-reach"), "discrete")] * 2)
    envs.reset(seed=1)
    for _ in range(10):
        _, rewards, *_ = envs.step(np.zeros(2, dtype=int))
        assert rewards.shape == (2,)
    envs.close()


@pytest.mark.parametrize("mode", RESETS)
@pytest.mark.parametrize("number", range(3))
def test_native_grids_and_the_task_agree_on_when_episodes_end(number: int, mode: AutoresetMode) -> None:
    """On a deterministic grid the native vector equals single grids under TimeLimit."""
    task = [Task("F b", "eventual"), Task("!a U b", "thesis-code"), Task("G F a & F G !b")][number]
    grid = ("S.a", ".#.", "b..")

    def alone() -> gym.Env:
        return LTLWrapper(gym.wrappers.TimeLimit(GridWorld(grid), 9), task)

    one_by_one = SyncVectorEnv([alone] * N, autoreset_mode=mode)
    together = LTLVectorWrapper(VectorGridWorld(grid, N, max_episode_steps=9, autoreset_mode=mode), task)
    rng = np.random.default_rng(3)
    one_by_one.reset(seed=1)
    together.reset(seed=1)
    for _ in range(120):
        actions = rng.integers(0, 5, N)
        left, right = one_by_one.step(actions), together.step(actions)
        for part in range(4):
            assert_same(left[part], right[part])
        assert_same(left[4]["ltl"], right[4]["ltl"])
        if "final_obs" in left[4]:
            assert_same(
                list(left[4]["final_obs"][left[4]["_final_obs"]]), list(right[4]["final_obs"][left[4]["_final_obs"]])
            )
            assert_same(left[4]["final_info"]["ltl"], right[4]["final_info"]["ltl"])
        finished = left[2] | left[3]
        if mode == AutoresetMode.DISABLED and finished.any():
            for env in (one_by_one, together):
                env.reset(options={"reset_mask": finished.copy()})


def test_statistics_outside_count_the_episodes_of_the_task() -> None:
    env = RecordEpisodeStatistics(LTLVectorWrapper(VectorGridWorld(("Sa",), 2), Task("F a", "eventual")))
    env.reset(seed=0)
    *_, infos = env.step(np.array([1, 4]))
    assert infos["episode"]["l"].tolist() == [1, 0]
    assert infos["episode"]["r"][0] == pytest.approx(100)


def test_it_pickles() -> None:
    env = LTLVectorWrapper(VectorGridWorld(("S.a",), 3, slip=0.3), Task("G F a", "zeta-reach"))
    env.reset(seed=1)
    twin = pickle.loads(pickle.dumps(env))
    for _ in range(5):
        actions = np.array([0, 1, 2])
        for left, right in zip(env.step(actions), twin.step(actions), strict=True):
            assert_same(left, right)


BATCHED: list[Any] = [
    lambda o, i: {"a": o > 3, "b": o < 6},
    LabelFunction(lambda o, i: np.stack([o < 6, o > 3], axis=1), ("b", "a")),
    LabelFunction(lambda o, i: (o > 3) + 2 * (o < 6), ("a", "b")),
    LabelFunction(lambda o, i: 2 * (o > 3) + 1 * (o < 6), ("b", "a")),
    lambda o, i: np.array([" ".join("a" * int(x > 3) + "b" * int(x < 6)) for x in o]),
    lambda o, i: [{"a"} & {"a" * bool(x > 3)} | {"b"} & {"b" * bool(x < 6)} for x in o],
    lambda o: {"a": o > 3, "b": o < 6},
    {"a": lambda o: o > 3, "b": lambda o: o < 6},
]


@pytest.mark.parametrize("number", range(len(BATCHED)))
def test_batched_labels_come_in_many_shapes(number: int) -> None:
    env = LTLVectorWrapper(
        SyncVectorEnv([RandomEnv] * N), Task("G F a & G F b", "thesis"), batch_labels=BATCHED[number]
    )
    observations, infos = env.reset(seed=0)
    for _ in range(20):
        x = observations["observation"]
        assert infos["ltl"]["label"].tolist() == ((x > 3) + 2 * (x < 6)).tolist()
        observations, *_, infos = env.step(np.zeros(N, dtype=int))


WRONG: list[tuple[Any, str]] = [
    (lambda o, i: None, "labels of 5 sub-environments are None; expected an array of bitmasks"),
    (lambda o, i: [{"a"}], "labels of 5 sub-environments are"),
    (lambda o, i: "a", "labels of 5 sub-environments are 'a'"),
    (lambda o, i: {"a": np.ones(3, dtype=bool)}, r"label 'a' of 5 sub-environments has shape \(3,\)"),
    (lambda o, i: {"a": np.full(5, np.nan)}, "'a' of 5 sub-environments has shape .* and type float64"),
    (lambda o, i: np.full(5, np.nan), "labels are NaN"),
    (lambda o, i: {"aa": np.ones(5, dtype=bool)}, "no label produces it.*'a'. Did you mean aa"),
    (lambda o, i: [{"aa"}] * 5, "'aa'. Did you mean a"),
    (LabelFunction(lambda o, i: np.full(5, 9), ("b", "a")), "a bitmask label is outside 0..3"),
    (LabelFunction(lambda o, i: np.zeros((5, 2), dtype=int), ("b", "a")), r"bitmask labels have shape \(5, 2\)"),
    (LabelFunction(lambda o, i: np.zeros((5, 3), dtype=bool), ("b", "a")), r"boolean labels have shape \(5, 3\)"),
]


@pytest.mark.parametrize(("labels", "message"), WRONG)
def test_wrong_batched_labels_are_explained(labels: Any, message: str) -> None:
    env = LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N), Task("G F a & G F b"), batch_labels=labels)
    with pytest.raises(InvalidArgumentError, match=message):
        env.reset()


def test_what_cannot_be_reset_alone_is_refused_if_the_task_ends_episodes() -> None:
    cart = gym.make_vec("CartPole-v1", num_envs=2, vectorization_mode="vector_entry_point")
    left = {"left": lambda observation: observation[:, 0] < 0}
    with pytest.raises(InvalidArgumentError, match="CartPoleVectorEnv cannot reset single sub-environments"):
        LTLVectorWrapper(cart, Task("F left"), batch_labels=left)
    env = LTLVectorWrapper(cart, Task("G F left", "eventual"), batch_labels=left)
    observations, infos = env.reset(seed=1)
    assert (infos["ltl"]["label"] == (observations["observation"][:, 0] < 0)).all()
    for _ in range(60):
        env.step(np.ones(2, dtype=int))


def test_finished_sub_environments_must_be_reset_where_autoreset_is_disabled() -> None:
    mode = AutoresetMode.DISABLED
    env = LTLVectorWrapper(
        SyncVectorEnv([partial(GridWorld, ("Sa",))] * 2, autoreset_mode=mode), Task("F a", "eventual")
    )
    env.reset()
    env.step(np.array([1, 4]))
    with pytest.raises(InvalidArgumentError, match=r"the episodes of sub-environments \[0\] are over"):
        env.step(np.array([1, 4]))


def test_names_are_compared_at_construction() -> None:
    with pytest.raises(UnknownNameError, match=r"'gaol'. Did you mean goal"):
        LTLVectorWrapper(gym.make_vec("ltlc/Grid-v0", num_envs=2), Task("F gaol"))
    with pytest.raises(UnknownNameError, match=r"'gaol'. Did you mean goal"):
        LTLVectorWrapper(SyncVectorEnv([partial(GridWorld, ("Sg",), labels={"g": "goal"})]), Task("F gaol"))
