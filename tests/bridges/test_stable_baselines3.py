"""What replay buffers of a task hold is what the wrapped environment would do, in every state of the automaton."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers import TimeLimit

import ltlc
from ltlc.bridges.counterfactual import JointObservations
from ltlc.envs import GridWorld, LTLWrapper, labelled_mdp
from ltlc.errors import FileFormatError, InvalidArgumentError, MissingProgramError, RewardWarning
from ltlc.mdp import Judge

sb3 = pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed", exc_type=ImportError)

DummyVecEnv = importlib.import_module("stable_baselines3.common.vec_env").DummyVecEnv
bridge = importlib.import_module("ltlc.bridges.stable_baselines3")
TaskDictReplayBuffer, TaskReplayBuffer = bridge.TaskDictReplayBuffer, bridge.TaskReplayBuffer
load_model, replay = bridge.load_model, bridge.replay

pytestmark = pytest.mark.peer

MAP = ("S..k", ".##.", "..x.", "...g")
GRID = {"k": "key", "g": "goal", "x": "pit"}
FORMULA = "F(key & F goal) & G !pit"
FAST = {"learning_starts": 50, "device": "cpu", "seed": 0}


def wrapped(mode: Any = "flat", reward: str = "two-discount", formula: str = FORMULA, **more: Any) -> LTLWrapper:
    world = GridWorld(MAP, labels=GRID, slip=0.0, actions=4)
    return LTLWrapper(world, ltlc.Task(formula, reward, **more), observation=mode)


def filled(env: LTLWrapper, counterfactual: bool, steps: int = 300) -> tuple[Any, list[tuple[Any, ...]]]:
    """A buffer after random steps in two environments, and the rows that were put in."""
    envs = DummyVecEnv(
        [lambda: TimeLimit(env, 40), lambda: TimeLimit(wrapped(env.observer.mode, env.task.scheme.name), 40)]
    )
    kind = replay(env, counterfactual=counterfactual)
    buffer = kind["replay_buffer_class"](
        2 * steps, envs.observation_space, envs.action_space, device="cpu", n_envs=2, **kind["replay_buffer_kwargs"]
    )
    random, rows = np.random.default_rng(1), []
    seen = envs.reset()
    for _ in range(steps):
        actions = random.integers(4, size=2)
        after, rewards, dones, infos = envs.step(actions)
        last = [
            info["terminal_observation"] if done else part(after, i)
            for i, (done, info) in enumerate(zip(dones, infos, strict=True))
        ]
        buffer.add(seen, joined(last), actions, rewards, dones, infos)
        rows += [(key(part(seen, i)), int(actions[i]), key(last[i]), infos[i]["ltl"]) for i in range(2)]
        seen = after
    return buffer, rows


def part(observations: Any, i: int) -> Any:
    return {k: v[i] for k, v in observations.items()} if isinstance(observations, dict) else observations[i]


def joined(observations: list[Any]) -> Any:
    if isinstance(observations[0], dict):
        return {k: np.stack([one[k] for one in observations]) for k in observations[0]}
    return np.stack(observations)


def key(observation: Any) -> tuple[float, ...]:
    if isinstance(observation, dict):
        return tuple(float(np.asarray(observation[k]).reshape(())) for k in sorted(observation))
    return tuple(np.asarray(observation, dtype=float).ravel())


def parts(mode: str, before: tuple[float, ...], n: int) -> tuple[int, int]:
    """The cell and the table state in an observation."""
    if mode == "flat":
        return int(np.argmax(before[:-n])), int(np.argmax(before[-n:]))
    return (int(before[1]), int(before[0])) if mode == "dict" else divmod(int(before[0]), n)


def sampled(buffer: Any, n: int) -> list[tuple[Any, ...]]:
    rows = buffer.sample(n)
    columns = rows.actions, rows.rewards, rows.dones, rows.discounts
    action, reward, done, discount = (column.numpy().reshape(-1) for column in columns)

    def shown(tensors: Any, i: int) -> tuple[float, ...]:
        return key(
            part({k: v.numpy() for k, v in tensors.items()} if isinstance(tensors, dict) else tensors.numpy(), i)
        )

    return [
        (shown(rows.observations, i), int(action[i]), shown(rows.next_observations, i), reward[i], done[i], discount[i])
        for i in range(n)
    ]


@pytest.mark.parametrize("mode", ["flat", "dict", "index"])
def test_rows_have_the_rewards_and_discounts_of_their_steps(mode: str) -> None:
    buffer, rows = filled(wrapped(mode), counterfactual=False)
    kept = {(before, action, after): ltl for before, action, after, ltl in rows}
    found = set()
    for before, action, after, reward, done, discount in sampled(buffer, 500):
        ltl = kept[before, action, after]
        found.add(round(float(discount), 6))
        violated = ltl["violated"]  # and the task ends the episode
        assert (reward, done, discount) == pytest.approx((ltl["reward"], 0, 0 if violated else ltl["discount"]))
    assert len(found) > 1  # discounts differ


@pytest.mark.parametrize("reward", ["two-discount", "zeta-discount", "zeta-reach"])
@pytest.mark.parametrize("mode", ["flat", "dict", "index"])
def test_counterfactual_rows_are_what_the_environment_does(mode: str, reward: str) -> None:
    buffer, _ = filled(wrapped(mode, reward), counterfactual=True)
    env = wrapped(mode, reward)
    tables, n = env.task.tables, env.task.tables.n_states
    states = set()
    for before, action, after, paid, done, discount in sampled(buffer, 300):
        cell, q = parts(mode, before, n)
        states.add(q)
        env.reset(seed=0)
        env.unwrapped._cell = cell  # type: ignore[attr-defined]
        env._state, env.stops = q, False
        seen, _, _, _, info = env.step(action)
        at = q, info["ltl"]["letter_class"]
        assert key(seen) == after
        assert paid == pytest.approx(tables.reward[at] + tables.stop[at] * tables.stop_reward[at])
        assert discount == pytest.approx(tables.discount[at] * (1 - tables.stop[at]))
        assert done == 0
    assert states == set(range(n))


def test_where_the_environment_ends_the_last_letter_counts_for_ever() -> None:
    labels = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}
    env = LTLWrapper(gym.make("FrozenLake-v1"), ltlc.Task("G !hole", "zeta-discount"), labels, observation="flat")
    joint = JointObservations.of(env)
    tables = env.task.tables
    safe = int(tables.letter_class[env.task.aps.index("hole") * 0])
    step = joint.step(np.array([0, 0]), np.array([0, 0]), np.array([safe, safe]), np.array([False, True]))
    assert step.discount.tolist() == [tables.discount[0, safe], 0]
    forever = step.reward[0] / (1 - step.discount[0])
    assert step.reward[1] == pytest.approx(forever)


@pytest.mark.parametrize("counterfactual", [False, True])
@pytest.mark.parametrize("mode", ["flat", "dict"])
def test_dqn_trains_and_is_judged(mode: str, counterfactual: bool) -> None:
    env = TimeLimit(wrapped(mode), 50)
    policy = "MultiInputPolicy" if mode == "dict" else "MlpPolicy"
    model = sb3.DQN(policy, env, **FAST, **replay(env, counterfactual=counterfactual)).learn(300)
    kind = TaskDictReplayBuffer if mode == "dict" else TaskReplayBuffer
    assert type(model.replay_buffer) is kind
    found = ltlc.judge(model, env)
    assert found.exact
    task, mdp = env.env.task, labelled_mdp(env)
    cells, states, shown = range(mdp.n_states), range(task.tables.n_states), env.env.observer.single
    table = np.array([[int(model.predict(shown(s, q), deterministic=True)[0]) for q in states] for s in cells])
    assert found.satisfaction == Judge(mdp, task).satisfaction(table)
    assert ltlc.judge(model, env.unwrapped, FORMULA).satisfaction == found.satisfaction  # finds the mode by itself


def test_sac_trains_with_counterfactual_replay() -> None:
    labels = {"up": lambda seen: seen[0] > 0.9}
    task = ltlc.Task("F G up", "parity")
    env = LTLWrapper(gym.make("Pendulum-v1"), task, labels, observation="flat")
    model = sb3.SAC("MlpPolicy", env, **FAST, **replay(env, counterfactual=True)).learn(80)
    found = ltlc.judge(model, env, episodes=2, max_steps=20)
    assert not found.exact
    assert "dynamics" in found.why_sampled


def test_a_stochastic_policy_is_judged_with_its_probabilities() -> None:
    env = wrapped("flat")
    model = sb3.PPO("MlpPolicy", env, n_steps=32, batch_size=32, device="cpu", seed=0)
    found = ltlc.judge(model, env, deterministic=False)
    assert found.policy is not None and found.policy.ndim == 3
    assert found.policy.sum(axis=2) == pytest.approx(1)
    assert 0 < found.policy[0, 0].min() < found.policy[0, 0].max() < 1


@pytest.mark.parametrize("vector", [False, True])
def test_maskable_ppo_chooses_pairs_that_there_are(vector: bool) -> None:
    contrib = pytest.importorskip("sb3_contrib", reason="sb3-contrib is not installed", exc_type=ImportError)

    def make() -> Any:
        return TimeLimit(wrapped("flat", "eventual", "(F G goal | F G key) & G !pit"), 30)

    env = DummyVecEnv([make] * 3) if vector else make()
    with pytest.warns(RewardWarning, match="discount for each step"):
        model = contrib.MaskablePPO("MlpPolicy", env, n_steps=32, batch_size=32, device="cpu", seed=0).learn(200)
    assert ltlc.judge(model, make()).exact


def test_choices_of_pairs_are_warned_of() -> None:
    with pytest.warns(RewardWarning, match='take the rewards "parity"'):
        replay(wrapped("flat", "eventual", "(F G goal | F G key) & G !pit"))


def test_success_is_told_to_monitors() -> None:
    from stable_baselines3.common.monitor import Monitor

    env = Monitor(TimeLimit(LTLWrapper(GridWorld(MAP, labels=GRID, actions=4), FORMULA, success_key=True), 20))
    model = sb3.DQN("MultiInputPolicy", env, **FAST, **replay(env)).learn(100)
    assert len(model.ep_success_buffer) >= 3


@pytest.mark.parametrize("name", ["DQN", "PPO", "A2C"])
def test_a_saved_model_is_loaded_by_its_algorithm(name: str, tmp_path: Path) -> None:
    env = wrapped()
    more: dict[str, Any] = replay(env) if name == "DQN" else {}
    model = getattr(sb3, name)("MlpPolicy", env, device="cpu", seed=0, **more)
    model.save(tmp_path / "model.zip")
    again = load_model(tmp_path / "model.zip")
    assert type(again) is type(model)
    assert ltlc.judge(again, env).satisfaction == ltlc.judge(model, env).satisfaction


def test_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "model.zip").write_text("nothing")
    with pytest.raises(FileFormatError, match="is not a model of Stable-Baselines3"):
        load_model(tmp_path / "model.zip")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: gym.make("CartPole-v1"), "not wrapped in an LTLWrapper"),
        (lambda: wrapped("none"), "does not show the state"),
        (lambda: gym.wrappers.TransformObservation(wrapped("index"), lambda s: s, gym.spaces.Discrete(99)), "changed"),
    ],
)
def test_environments_that_cannot_be_replayed(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        replay(make())


def test_a_missing_library_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.delitem(sys.modules, "ltlc.bridges.stable_baselines3")
    with pytest.raises(MissingProgramError, match="pip install stable-baselines3"):
        import ltlc.bridges.stable_baselines3  # noqa: F401
