"""Training: what is learned (judged exactly), determinism, callbacks and threads."""

import dataclasses
import signal
import threading
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv
from short_training import MAP, QUICK, SHORT, TASK, assert_same, grid, rows

from ltlc.agents import (
    CHECKPOINT_FILE,
    POLICY_FILE,
    DoubleDQN,
    DQNConfig,
    FittedQConfig,
    Progress,
    TrainingResult,
    greedy_policy,
    rollout,
    train,
)
from ltlc.envs import (
    FlatWorld,
    GridWorld,
    LTLVectorWrapper,
    VectorFlatWorld,
    VectorGridWorld,
    labelled_mdp,
    recorded_automaton,
    thesis_vector_world,
    thesis_world,
)
from ltlc.errors import TrainingDiverged
from ltlc.judging import judge
from ltlc.mdp import Judge
from ltlc.task import Task


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"double": False},
        {"state_input": "one-hot", "hidden": (64,), "total_steps": 8_000},
        {"counterfactual": False, "total_steps": 12_000},
    ],
    ids=["default", "single", "one-hot", "own state only"],
)
def test_learned_policy_is_nearly_optimal_by_the_exact_judge(changes: dict[str, Any]) -> None:
    result = train(grid(), DQNConfig(**(QUICK | changes)))
    judge = Judge(labelled_mdp(GridWorld(MAP, slip=0.05)), TASK)
    assert judge.regret(greedy_policy(result.agent)) < 0.02


@pytest.mark.slow
def test_what_is_learned_from_held_actions_holds_them() -> None:
    circles, task = [("red", 0.5, 0.0, 0.3)], Task("!outside U red")

    def world(copies: int) -> LTLVectorWrapper:
        flat = VectorFlatWorld(copies, circles=circles, half_width=1.0, stride=0.05, max_episode_steps=100)
        return LTLVectorWrapper(flat, task)

    agent = train(world(16), DQNConfig(total_steps=8_000, hidden=(64,), action_repeat=3, seed=0)).agent
    assert rollout(agent, world(50), 200).satisfied.value > 0.93
    single = FlatWorld(circles=circles, half_width=1.0, stride=0.05)
    assert judge(agent, single, task, episodes=50, max_steps=100).satisfaction > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("observation", ["dict", "index", "flat"])
def test_every_observation_mode_is_learned(observation: str) -> None:
    result = train(grid(observation=observation), DQNConfig(**QUICK))
    every = np.arange(9)
    shown = np.eye(9, dtype=np.float32) if observation == "flat" else every
    policy = greedy_policy(result.agent, shown)
    judge = Judge(labelled_mdp(GridWorld(MAP, slip=0.05)), TASK)
    assert judge.regret(policy) < 0.02


@pytest.mark.slow
def test_thesis_network_learns_a_short_way() -> None:
    env = LTLVectorWrapper(VectorGridWorld("S.A", 1, observation="coordinates", max_episode_steps=20), "F A")
    config = DQNConfig.thesis(total_steps=1_500, epsilon_steps=1_000, hidden=(20, 10), tau=0.01, seed=1)
    result = train(env, config)
    assert result.agent.updates == 1_500 - 63  # one per step, once there is a batch
    policy = greedy_policy(result.agent)
    assert policy[:2, result.agent.tables.initial_state].tolist() == [1, 1]


@pytest.mark.slow
def test_environment_without_a_task_is_learned_from_its_own_rewards() -> None:
    agent = train(SyncVectorEnv([Corridor] * 4), DQNConfig(**(QUICK | {"total_steps": 4_000, "gamma": 0.9}))).agent
    values = agent.q_values(np.arange(4), np.zeros(4, dtype=np.int64))
    exact = np.array([-(1 - 0.9**steps) / 0.1 for steps in (4, 3, 2, 1)])
    assert values.argmax(axis=1).tolist() == [1] * 4
    assert np.allclose(values.max(axis=1), exact, atol=0.1)


class Corridor(gym.Env[int, int]):
    """Cells 0..4; action 1 goes right, 0 left; each step costs 1, the right end terminates, 20 steps truncate."""

    observation_space = spaces.Discrete(5)
    action_space = spaces.Discrete(2)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.cell, self.time = 0, 0
        return 0, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.cell = max(self.cell + 2 * int(action) - 1, 0)
        self.time += 1
        return self.cell, -1.0, self.cell == 4, self.time == 20, {}


@pytest.mark.slow
def test_same_seed_same_weights_other_seed_others() -> None:
    config = DQNConfig(**SHORT | {"total_steps": 500})
    one, two = train(grid(), config), train(grid(), config)
    assert_same(one.agent, two.agent)
    other = train(grid(), dataclasses.replace(config, seed=1))
    assert not torch.equal(*(next(r.agent.q_network.parameters()) for r in (one, other)))


def test_second_ctrl_c_stops_at_once() -> None:
    def interrupt(progress: Progress) -> None:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        train(grid(), DQNConfig(**SHORT), callback=interrupt)


@pytest.mark.slow
def test_training_works_outside_of_the_main_thread() -> None:
    results: list[TrainingResult] = []
    config = DQNConfig(**SHORT | {"total_steps": 500})
    worker = threading.Thread(target=lambda: results.append(train(grid(), config)))
    worker.start()
    worker.join()
    assert results[0].steps >= 500


@pytest.mark.slow
def test_callback_can_stop_the_training(tmp_path: Path) -> None:
    result = train(grid(), DQNConfig(**SHORT), folder=tmp_path, callback=lambda p: p.row.steps >= 500)
    assert 500 <= result.steps < 600 and not result.interrupted
    assert (tmp_path / POLICY_FILE).exists() and len(rows(tmp_path)) == 2


@pytest.mark.slow
def test_progress_estimates_the_time_left() -> None:
    seen: list[Progress] = []
    train(grid(), DQNConfig(**SHORT), callback=lambda p: bool(seen.append(p)))
    assert seen[4].seconds_left == pytest.approx(seen[4].row.seconds, rel=0.05)
    assert seen[-1].seconds_left == pytest.approx(0, abs=0.1)


def test_threads_of_torch_are_put_back() -> None:
    before = torch.get_num_threads()
    seen: list[int] = []
    config = DQNConfig(**SHORT | {"total_steps": 200, "log_every": 100, "threads": 2 if before == 1 else 1})
    train(grid(), config, callback=lambda p: bool(seen.append(torch.get_num_threads())))
    assert before not in seen and torch.get_num_threads() == before


class Poisoned(gym.Env[int, int]):
    """Pays NaN after 300 steps."""

    observation_space = spaces.Discrete(2)
    action_space = spaces.Discrete(2)
    time = 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        return 0, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.time += 1
        return int(action), 1.0 if self.time < 300 else float("nan"), False, False, {}


@pytest.mark.slow
def test_loss_that_is_not_a_number_stops_the_training(tmp_path: Path) -> None:
    config = DQNConfig(**QUICK | {"learning_starts": 64, "checkpoint_every": 200})
    with pytest.raises(TrainingDiverged, match=r"loss is nan at update \d+ .*reward that is not finite"):
        train(SyncVectorEnv([Poisoned]), config, folder=tmp_path)
    assert (tmp_path / CHECKPOINT_FILE).exists()


@pytest.mark.slow
def test_thesis_task_phi_3_is_solved_within_one_percent() -> None:
    task = Task(recorded_automaton("phi_3"), reward="thesis")
    env = thesis_vector_world("5x5", 64, max_episode_steps=500)
    wrapped = LTLVectorWrapper(env, task, initial_label="skip", extra_labels="ignore")
    result = train(wrapped, FittedQConfig(total_steps=60_000))
    judge = Judge(labelled_mdp(thesis_world("5x5")), task, initial_label="skip")
    assert judge.regret(greedy_policy(result.agent)) < 0.01


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no accelerator")
def test_training_on_an_accelerator(tmp_path: Path) -> None:
    result = train(grid(), DQNConfig(**QUICK | {"device": "cuda"}), folder=tmp_path)
    judge = Judge(labelled_mdp(GridWorld(MAP, slip=0.05)), TASK)
    assert judge.regret(greedy_policy(result.agent)) < 0.02
    again = train(grid(), folder=tmp_path, resume=True)
    assert next(again.agent.q_network.parameters()).device.type == "cuda"
    assert DoubleDQN.load(tmp_path / POLICY_FILE, device="cpu").config.device == "cpu"
