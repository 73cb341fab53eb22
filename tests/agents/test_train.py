"""Training: what is learned (judged exactly), determinism, checkpoints, and everything that can go wrong."""

import csv
import dataclasses
import errno
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.agents import (
    CHECKPOINT_FILE,
    POLICY_FILE,
    DoubleDQN,
    DQNConfig,
    FittedQConfig,
    Progress,
    TrainingResult,
    greedy_policy,
    train,
)
from ltlc.envs import (
    GridWorld,
    LTLVectorWrapper,
    VectorGridWorld,
    labelled_mdp,
    recorded_automaton,
    thesis_vector_world,
    thesis_world,
)
from ltlc.errors import FileFormatError, InvalidArgumentError, TrainingDiverged
from ltlc.mdp import Judge
from ltlc.task import Task

MAP = "S..\n.C.\nA.B"
TASK = Task("F(A & F B) & G !C", reward="thesis", on_deadlock="stay")
QUICK: dict[str, Any] = {
    "hidden": (32,), "batch_size": 256, "buffer_size": 20_000, "learning_starts": 256, "epsilon_steps": 2_000,
    "total_steps": 6_000, "log_every": 1_000, "checkpoint_every": 2_500, "learning_rate": 3e-3, "averaging": 0.02,
    "train_frequency": 4, "tau": 0.1,
}  # fmt: skip


SHORT: dict[str, Any] = {
    "hidden": (16,), "batch_size": 32, "buffer_size": 1_500, "learning_starts": 100, "epsilon_steps": 1_000,
    "total_steps": 2_500, "log_every": 250, "checkpoint_every": 1_000,
}  # fmt: skip
"""A run with two checkpoints before its end, and a buffer that overflows; it does not learn much."""


def grid(**options: Any) -> LTLVectorWrapper:
    env = VectorGridWorld(MAP, 4, slip=0.05, max_episode_steps=200)
    return LTLVectorWrapper(env, TASK, **({"observation": "none"} | options))


def weights(agent: DoubleDQN) -> dict[str, torch.Tensor]:
    parts = {"q": agent.q_network, "target": agent.target_network, "policy": agent.policy_network}
    found = {f"{name}.{key}": value for name, part in parts.items() for key, value in part.state_dict().items()}
    for i, slot in agent.optimizer.state_dict()["state"].items():
        found |= {f"optimizer.{i}.{key}": torch.as_tensor(value) for key, value in slot.items()}
    return found


def assert_same(one: DoubleDQN, other: DoubleDQN) -> None:
    mine, theirs = weights(one), weights(other)
    assert mine.keys() == theirs.keys()
    assert all(torch.equal(mine[name], theirs[name]) for name in mine)


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "metrics.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


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


def test_same_seed_same_weights_other_seed_others() -> None:
    config = DQNConfig(**SHORT | {"total_steps": 500})
    one, two = train(grid(), config), train(grid(), config)
    assert_same(one.agent, two.agent)
    other = train(grid(), dataclasses.replace(config, seed=1))
    assert not torch.equal(*(next(r.agent.q_network.parameters()) for r in (one, other)))


@pytest.fixture(scope="module")
def whole() -> TrainingResult:
    """A short run that nothing interrupts, without a folder."""
    return train(grid(), DQNConfig(**SHORT))


class Killed(Exception):
    """Stands for a kill: nothing of the run gets a chance to clean up."""


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{}, {"optimizer": "sgd", "batch_norm": True, "counterfactual": False}])
def test_resumed_run_is_bit_identical(tmp_path: Path, changes: dict[str, Any]) -> None:
    config = DQNConfig(**SHORT | changes)
    whole = train(grid(), config, folder=tmp_path / "whole")
    alone = train(grid(), config)

    def kill(progress: Progress) -> None:
        if progress.row.steps >= 1_500:
            raise Killed

    with pytest.raises(Killed):
        train(grid(), config, folder=tmp_path / "parts", callback=kill)
    resumed = train(grid(), folder=tmp_path / "parts", resume=True)
    assert_same(whole.agent, resumed.agent)
    assert_same(whole.agent, alone.agent)
    assert rows(tmp_path / "whole") == rows(tmp_path / "parts")
    assert resumed.steps == whole.steps and not resumed.interrupted


@pytest.mark.slow
def test_resumed_run_of_another_kind_of_environment_is_bit_identical(tmp_path: Path) -> None:
    def lake() -> LTLVectorWrapper:
        env = gym.make_vec("FrozenLake-v1", num_envs=4, vectorization_mode="sync")
        labels = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}
        return LTLVectorWrapper(env, "F goal & G !hole", labels)

    config = DQNConfig(**SHORT)

    def kill(progress: Progress) -> None:
        if progress.row.steps >= 1_500:
            raise Killed

    whole = train(lake(), config)
    with pytest.raises(Killed):
        train(lake(), config, folder=tmp_path, callback=kill)
    assert_same(whole.agent, train(lake(), folder=tmp_path, resume=True).agent)


SCRIPT = """
    import os, signal, sys
    import ltlc.atomic
    from ltlc.agents import DQNConfig, train
    from ltlc.envs import LTLVectorWrapper, VectorGridWorld
    from ltlc.task import Task

    true_replace, writes = os.replace, []

    def replace(source, target):
        writes.append(target)
        if sum(str(target).endswith("checkpoint.ltlc") for target in writes) == 3:  # the first is of the beginning
            os.kill(os.getpid(), signal.SIGKILL)  # all is written under a temporary name, nothing is in place
        true_replace(source, target)

    os.replace = replace
    env = LTLVectorWrapper(VectorGridWorld("S.A", 4, max_episode_steps=20), Task("F A", reward="thesis"))
    config = DQNConfig(hidden=(8,), batch_size=8, buffer_size=500, learning_starts=0, total_steps=1_200,
                       checkpoint_every=400, log_every=200)
    train(env, config, folder=sys.argv[1])
"""


@pytest.mark.slow
def test_kill_during_a_checkpoint_leaves_the_previous_one(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(textwrap.dedent(SCRIPT))
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, str(script), str(tmp_path / "run")], env=environment, check=False)
    assert done.returncode == -signal.SIGKILL
    env = LTLVectorWrapper(VectorGridWorld("S.A", 4, max_episode_steps=20), Task("F A", reward="thesis"))
    seen: list[int] = []
    resumed = train(env, folder=tmp_path / "run", resume=True, callback=lambda p: seen.append(p.row.steps))
    assert 600 <= seen[0] < 604 and resumed.steps >= 1_200  # a row comes with the first step of 4 that is due
    assert_same(resumed.agent, train(env, resumed.agent.config).agent)


@pytest.mark.slow
def test_ctrl_c_stops_cleanly_and_can_be_resumed(tmp_path: Path, whole: TrainingResult) -> None:
    config = DQNConfig(**SHORT)

    def interrupt(progress: Progress) -> None:
        if 1_500 <= progress.row.steps < 1_600:
            signal.raise_signal(signal.SIGINT)

    first = train(grid(), config, folder=tmp_path, callback=interrupt)
    assert first.interrupted and 1_500 <= first.steps < 1_600
    assert f"interrupted; {first.saved_steps} are in" in str(first) and first.saved_steps <= first.steps
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    second = train(grid(), folder=tmp_path, resume=True)
    assert second.steps >= 2_500 and not second.interrupted
    assert_same(second.agent, whole.agent)
    assert "interrupted" not in str(second)
    assert "nothing was written" in str(TrainingResult(second.agent, 1, 9, 1.0, True))


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


@pytest.fixture(scope="module")
def trained_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trained") / "run"
    train(grid(), DQNConfig(**SHORT | {"total_steps": 500}), folder=folder)
    return folder


@pytest.fixture
def short_run(trained_once: Path, tmp_path: Path) -> Path:
    """A copy that a test may damage."""
    return shutil.copytree(trained_once, tmp_path / "run")


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "other"])
def test_damaged_checkpoint_is_recognised(short_run: Path, damage: str) -> None:
    path = short_run / CHECKPOINT_FILE
    whole = path.read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    path.write_bytes({"cut": whole[:middle], "flip": flipped, "empty": b"", "other": b"PK\3\4 some archive\n"}[damage])
    with pytest.raises(FileFormatError, match=r"checkpoint\.ltlc: .*damaged"):
        train(grid(), folder=short_run, resume=True)


@pytest.mark.slow
def test_policy_is_no_checkpoint(short_run: Path) -> None:
    (short_run / CHECKPOINT_FILE).write_bytes((short_run / POLICY_FILE).read_bytes())
    with pytest.raises(FileFormatError, match="not a checkpoint file"):
        train(grid(), folder=short_run, resume=True)


@pytest.mark.slow
def test_checkpoint_of_something_else_is_refused(short_run: Path) -> None:
    with pytest.raises(InvalidArgumentError, match="holds a training run; pass resume=True"):
        train(grid(), folder=short_run)
    with pytest.raises(InvalidArgumentError, match="no checkpoint to resume from"):
        train(grid(), folder=short_run / "elsewhere", resume=True)
    with pytest.raises(InvalidArgumentError, match=r"batch_size 32, not 128.* resume with config=None"):
        train(grid(), DQNConfig(**SHORT | {"total_steps": 500, "batch_size": 128}), folder=short_run, resume=True)
    other = LTLVectorWrapper(VectorGridWorld(MAP, 4), Task("F A"), observation="none", extra_labels="ignore")
    with pytest.raises(InvalidArgumentError, match="other reward tables"):
        train(other, folder=short_run, resume=True)
    fewer = LTLVectorWrapper(VectorGridWorld(MAP, 2), TASK, observation="none")
    with pytest.raises(InvalidArgumentError, match="checkpoint is of 4 environments"):
        train(fewer, folder=short_run, resume=True)


@pytest.mark.slow
def test_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: TrainingResult) -> None:
    def fill_the_disk(progress: Progress) -> None:
        if progress.row.steps >= 1_500:
            monkeypatch.setattr("ltlc.agents.training.storage.atomic_write", full)

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    config = DQNConfig(**SHORT)
    with pytest.raises(OSError, match=r"cannot write the checkpoint .*No space left.* unharmed") as failure:
        train(grid(), config, folder=tmp_path, callback=fill_the_disk)
    assert failure.value.errno == errno.ENOSPC
    monkeypatch.undo()
    assert_same(train(grid(), folder=tmp_path, resume=True).agent, whole.agent)


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
def test_metrics_are_plain_csv(short_run: Path) -> None:
    text = (short_run / "metrics.csv").read_text().splitlines()
    assert text[0] == (
        "steps,updates,episodes,episode_return,episode_length,violations,acceptances,loss,epsilon,learning_rate,"
        "value,product_states,accepting_components,satisfaction,discounted_return"
    )
    assert len(text) == 3
    row = rows(short_run)[-1]
    assert int(row["steps"]) >= 500 and float(row["loss"]) > 0


@pytest.mark.slow
def test_metrics_file_of_something_else_is_not_touched(short_run: Path) -> None:
    (short_run / "metrics.csv").write_text("shopping,list\n")
    with pytest.raises(FileFormatError, match="line 1 is not the header"):
        train(grid(), folder=short_run, resume=True)
    assert (short_run / "metrics.csv").read_text() == "shopping,list\n"


@pytest.mark.slow
def test_policy_comes_back_from_its_file(short_run: Path) -> None:
    agent = DoubleDQN.load(short_run / POLICY_FILE)
    trained = train(grid(), DQNConfig(**SHORT | {"total_steps": 500})).agent
    assert np.array_equal(agent.q_values(np.arange(9)), trained.q_values(np.arange(9)))
    assert agent.encoder.space == trained.encoder.space and agent.config == trained.config
    with pytest.raises(FileFormatError, match="not a policy file"):
        DoubleDQN.load(short_run / CHECKPOINT_FILE)


def test_policies_of_all_spaces_come_back(tmp_path: Path) -> None:
    parts = {"b": spaces.Box(0.0, 1.0, (2,)), "d": spaces.Discrete(3, start=1), "m": spaces.MultiBinary(2)}
    space = spaces.Dict({"one": spaces.Dict(parts), "two": spaces.Tuple([spaces.MultiDiscrete([2, 3])])})
    agent = DoubleDQN(space, 2, TASK.tables, DQNConfig(hidden=(4,)))
    agent.save(tmp_path / "policy.ltlc")
    again = DoubleDQN.load(tmp_path / "policy.ltlc")
    assert again.encoder.space == space
    assert_same(agent, again)


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
