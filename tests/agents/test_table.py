"""The agent with a table of values: it learns exactly, explores what it has not tried, and resumes bit by bit."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.agents import (
    DoubleDQN,
    DQNConfig,
    FittedQ,
    FittedQConfig,
    Progress,
    choose_agent,
    greedy_policy,
    train,
)
from ltlc.agents.double_dqn.places import Places
from ltlc.agents.double_dqn.replay import ReplayBuffer, ReplaySize
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.fitted_q.numbering import Numbering
from ltlc.agents.fitted_q.table import QTable
from ltlc.agents.fitted_q.visits import VisitCounts
from ltlc.agents.transitions import TransitionBatch
from ltlc.envs import GridWorld, LTLVectorWrapper, VectorGridWorld, labelled_mdp
from ltlc.errors import FileFormatError, InvalidArgumentError, MemoryLimitExceeded, TrainingDiverged
from ltlc.mdp import Judge
from ltlc.task import Task

MAP = "S..\n.C.\nA.B"
QUICK = FittedQConfig(total_steps=20_000, epsilon_steps=5_000, log_every=2_000, checkpoint_every=6_000)


def wrapped(task: Task, map_: str = MAP, slip: float = 0.05, n: int = 8) -> LTLVectorWrapper:
    return LTLVectorWrapper(VectorGridWorld(map_, n, slip=slip, max_episode_steps=100), task, observation="none")


@pytest.mark.slow
@pytest.mark.parametrize("reward", ["two-discount", "zeta-discount", "thesis", "parity", "sadigh"])
def test_returns_of_what_is_learned_are_nearly_the_largest(reward: str) -> None:
    task = Task("F(A & F B) & G !C", reward, acceptance="transition")
    agent = train(wrapped(task), QUICK).agent
    assert isinstance(agent, FittedQ) and isinstance(agent.table, QTable)
    judge = Judge(labelled_mdp(GridWorld(MAP, slip=0.05)), task)
    assert judge.regret(greedy_policy(agent)) < 1e-3


@pytest.mark.slow
def test_values_are_those_of_the_scheme() -> None:
    task = Task("F(A & F B) & G !C", "two-discount", acceptance="transition")
    agent = train(wrapped(task, slip=0.0), QUICK).agent
    judge = Judge(labelled_mdp(GridWorld(MAP)), task)
    best = agent.q_values(np.array([0]), np.array([agent.tables.initial_state])).max()
    assert best == pytest.approx(judge.value, rel=1e-3)


@pytest.mark.slow
def test_pairs_are_chosen() -> None:
    task = Task("(F G A | F G B) & G !C", "two-discount", acceptance="transition")
    assert task.tables.n_choices == 2
    agent = train(wrapped(task, "S.A\n.C.\nB.."), QUICK).agent
    mdp = labelled_mdp(GridWorld("S.A\n.C.\nB..", slip=0.05))
    judge = Judge(mdp, task)
    assert judge.satisfaction(greedy_policy(agent)) == pytest.approx(judge.maximum.probability, abs=1e-9)


class Corridor(gym.Env[int, int]):
    """Cells 0..30; action 1 goes right, 0 goes back to cell 0; the right end pays 1 and terminates."""

    observation_space = spaces.Discrete(31)
    action_space = spaces.Discrete(2)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.cell, self.time = 0, 0
        return 0, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.cell = self.cell + 1 if action else 0
        self.time += 1
        return self.cell, float(self.cell == 30), self.cell == 30, self.time == 100, {}


@pytest.mark.slow
def test_what_is_far_away_is_found() -> None:
    """At random, thirty right steps in a row happen once in a thousand million."""
    config = dataclasses.replace(QUICK, gamma=0.99)
    agent = train(SyncVectorEnv([Corridor] * 4), config).agent
    values = agent.q_values(np.arange(30), np.zeros(30, dtype=np.int64))
    assert values.argmax(axis=1).tolist() == [1] * 30
    assert values.max(axis=1) == pytest.approx(0.99 ** np.arange(29, -1, -1), rel=1e-2)


class Killed(BaseException):
    """Stands for a kill."""


@pytest.mark.slow
def test_resumed_run_is_bit_identical(tmp_path: Path) -> None:
    task = Task("(F G A | F G B) & G !C", "two-discount", acceptance="transition")

    def kill(progress: Progress) -> None:
        if progress.row.steps >= 10_000:
            raise Killed

    whole = train(wrapped(task), QUICK, folder=tmp_path / "whole")
    with pytest.raises(Killed):
        train(wrapped(task), QUICK, folder=tmp_path / "parts", callback=kill)
    resumed = train(wrapped(task), folder=tmp_path / "parts", resume=True)
    for ours, theirs in zip(*(run.agent.table.state_dict().values() for run in (whole, resumed)), strict=True):
        assert torch.equal(ours, theirs)
    assert whole.agent.updates == resumed.agent.updates
    again = FittedQ.load(tmp_path / "whole" / "policy.ltlc")
    assert (greedy_policy(again) == greedy_policy(whole.agent)).all()


FEW, MANY = spaces.Discrete(9), spaces.MultiDiscrete([1000, 10_000])


class Shown(Corridor):
    """The corridor, seen through another space."""

    def __init__(self, space: spaces.Space[Any]) -> None:
        self.observation_space = space

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        return self.observation_space.sample(), {}


@pytest.mark.parametrize(
    ("space", "given", "agent", "why"),
    [
        (FEW, (), "fitted-q", "the 9 observations can be numbered"),
        (spaces.MultiDiscrete([3, 3]), (), "fitted-q", "the 9 observations can be numbered"),
        (FEW, ("total_steps", "epsilon_final"), "fitted-q", "can be numbered"),
        (FEW, ("hidden",), "double-dqn", "hidden was given, which fitted-q does not have"),
        (FEW, ("learning_rate", "double"), "double-dqn", "learning_rate, double was given"),
        (spaces.Discrete(4097), (), "fitted-q", "the 4097 observations can be numbered"),
        (spaces.Dict({"a": spaces.Discrete(5), "b": spaces.Discrete(5)}), (), "fitted-q", "the 25 observations"),
        (
            spaces.Dict({"at": spaces.Discrete(5), "says": spaces.Text(9)}),
            (),
            "fitted-q",
            "the 5 observations can be numbered; texts are left out: says",
        ),
        (spaces.MultiDiscrete([70, 70]), (), "fitted-q", "the 4900 observations can be numbered"),
        (spaces.MultiDiscrete([1000, 1000]), (), "fitted-q", "the 1000000 observations can be numbered"),
        (MANY, (), "double-dqn", r"MultiDiscrete\(\[ *1000 10000\]\) cannot be numbered"),
        (spaces.Box(-1.0, 1.0, (2,)), (), "double-dqn", "cannot be numbered"),
    ],
)
def test_the_agent_that_fits_is_chosen(space: spaces.Space[Any], given: tuple[str, ...], agent: str, why: str) -> None:
    chosen = choose_agent(SyncVectorEnv([lambda: Shown(space)]), given)
    assert chosen.agent == agent and re.search(why, chosen.reason)
    assert str(chosen) == f"{agent}, since {chosen.reason}"


def test_a_configuration_means_one_algorithm() -> None:
    tables = Task("F A", "two-discount").tables
    for hidden in (None, (), (8,)):
        assert not hasattr(DoubleDQN(FEW, 4, tables, DQNConfig(hidden=hidden)), "table")
    assert isinstance(train(wrapped(Task("F A")), DQNConfig(total_steps=8)).agent, DoubleDQN)
    assert isinstance(train(wrapped(Task("F A")), FittedQConfig(total_steps=8)).agent, FittedQ)


def test_a_table_that_cannot_be_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="cannot be numbered; take the agent 'double-dqn'"):
        FittedQ(spaces.Box(-1.0, 1.0, (2,)), 4, Task("F A").tables, FittedQConfig())


def test_a_table_that_is_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ltlc.agents.fitted_q.agent.LARGEST", 71)
    with pytest.raises(InvalidArgumentError, match="a table would have 72 entries, more than 71"):
        FittedQ(FEW, 4, Task("F A", "two-discount").tables, FittedQConfig())


def test_a_checkpoint_of_another_agent_is_refused(tmp_path: Path) -> None:
    train(wrapped(Task("F A")), FittedQConfig(total_steps=16), folder=tmp_path)
    with pytest.raises(InvalidArgumentError, match="is of the agent 'fitted-q', not 'double-dqn'"):
        train(wrapped(Task("F A")), DQNConfig(total_steps=16), folder=tmp_path, resume=True)
    with pytest.raises(FileFormatError, match="agent is 'fitted-q'; this is 'double-dqn'"):
        DoubleDQN.load(tmp_path / "policy.ltlc")


def test_the_network_has_two_layers_of_256_by_default() -> None:
    agent = DoubleDQN(MANY, 4, Task("F A", "two-discount").tables, DQNConfig())
    linear = [layer.out_features for layer in agent.q_network.layers if isinstance(layer, torch.nn.Linear)]
    assert linear[:2] == [256, 256] and len(linear) == 3


def steps(*rows: tuple[int, int, int, int, float, bool]) -> TransitionBatch:
    """Rows of observation, action, next observation, letter class, base reward, terminated."""
    observation, action, following, letter_class, paid, terminated = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    return TransitionBatch(
        observation=observation[:, None], state=0 * action, action=action, letter_class=letter_class,
        base_reward=paid, terminated=terminated, next_observation=following[:, None],
    )  # fmt: skip


def test_equal_steps_are_counted() -> None:
    counts = VisitCounts(Numbering(1, np.int64, 3), 2, 1)
    counts.numbering.load(torch.arange(3)[:, None])
    counts.add(steps((0, 1, 2, 0, 1.0, False), (0, 1, 2, 0, 3.0, False)))
    counts.add(steps((0, 1, 1, 0, 0.0, True), (0, 1, 2, 0, 2.0, False), (2, 0, 0, 0, 0.0, False)))
    found = counts.outcomes()
    assert len(counts) == 5
    assert found.tries.tolist() == [0, 0, 1, 4, 0, 0]  # action 0 at 0, 1, 2; action 1 at 0, 1, 2
    by_outcome = {
        (int(pair), int(target), bool(end)): (float(weight), float(paid))
        for pair, target, end, weight, paid in zip(
            found.pair, found.following, found.terminated, found.weight, found.paid, strict=True
        )
    }
    assert by_outcome.keys() == {(3, 2, False), (3, 1, True), (2, 0, False)}
    assert by_outcome[3, 2, False] == (0.75, 2.0)
    again = VisitCounts(Numbering(1, np.int64, 3), 2, 1)
    again.load_state_dict(counts.state_dict())
    assert (again.outcomes().weight == found.weight).all() and len(again) == 5


def test_experience_of_another_kind_is_refused() -> None:
    counts, wider = (VisitCounts(Numbering(width, np.int64, 9), 1, 1) for width in (1, 2))
    encoder = ObservationEncoder(spaces.Discrete(2))
    replay = ReplayBuffer(ReplaySize(4, 20, 1), encoder, Places(encoder))
    for state in (wider.state_dict(), replay.state_dict()):
        with pytest.raises(InvalidArgumentError, match="of another kind"):
            counts.load_state_dict(state)


def test_rewards_that_are_no_numbers_end_the_training() -> None:
    counts = VisitCounts(Numbering(1, np.int64, 3), 2, 1)
    with pytest.raises(TrainingDiverged, match="NaN"):
        counts.add(steps((0, 1, 2, 0, float("nan"), False)))


def test_observations_are_numbered_as_they_are_seen() -> None:
    seen = Numbering(2, np.uint8, 3)
    rows = np.array([[1, 2], [3, 4], [1, 2]], dtype=np.uint8)
    assert seen.find(rows).tolist() == [0, 0, 0]  # unknown, all of them
    assert seen.add(rows).tolist() == [0, 1, 0] and len(seen) == 2
    assert seen.find(np.array([[3, 4], [2, 1]], dtype=np.uint8)).tolist() == [1, 2]
    assert seen.rows().tolist() == [[1, 2], [3, 4]] and seen.rows(1).tolist() == [[1, 2]]
    again = Numbering(2, np.uint8, 3)
    again.load(seen.rows())
    assert again.find(rows).tolist() == [0, 1, 0]
    with pytest.raises(MemoryLimitExceeded, match="more than 3 different observations"):
        again.add(np.array([[5, 5], [6, 6]], dtype=np.uint8))


def test_steps_that_cannot_be_numbered_are_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="too many for a table"):
        VisitCounts(Numbering(1, np.int64, 2**30), 4, 4)


class Lock(Corridor):
    """A chain of 60 steps, seen through any space; a wrong step goes back to the start."""

    def __init__(self, show: Any = None, space: spaces.Space[Any] | None = None) -> None:
        self.show = show or (lambda cell: cell)
        self.observation_space = space or spaces.Discrete(61)  # type: ignore[assignment]

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        gym.Env.reset(self, seed=seed)
        self.cell = self.time = 0
        return self.show(0), {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.cell = min(self.cell + 1, 60) if action == (self.cell * 7 // 3) % 2 or self.cell == 60 else 0
        self.time += 1
        return self.show(self.cell), 0.0, False, self.time == 100, {}


HUGE = spaces.Dict({"where": spaces.MultiDiscrete([100_000, 100_000]), "on": spaces.MultiBinary(3)})
"""more observations than can be counted."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_lock_of_sixty_steps_is_opened(seed: int) -> None:
    task, envs = Task("F open"), SyncVectorEnv([Lock] * 16)
    env = LTLVectorWrapper(envs, task, labels={"open": lambda cell: cell == 60})
    agent = train(env, FittedQConfig(total_steps=100_000, seed=seed)).agent
    start = np.full(60, task.tables.initial_state)
    assert agent.policy(np.arange(60), start).tolist() == [(cell * 7 // 3) % 2 for cell in range(60)]


@pytest.mark.slow
def test_a_table_grows_with_what_was_seen(tmp_path: Path) -> None:
    def show(cell: int) -> dict[str, Any]:
        return {"where": np.array([1000 * cell, 5]), "on": np.array([cell % 2, 0, 1], dtype=np.int8)}

    task, envs = Task("F open"), SyncVectorEnv([lambda: Lock(show, HUGE)] * 4)
    env = LTLVectorWrapper(envs, task, labels={"open": lambda seen: seen["where"][0] == 10_000})
    result = train(env, FittedQConfig(total_steps=8_000, checkpoint_every=4_000), folder=tmp_path)
    agent = result.agent
    assert agent.encoder.n_observations == 0 and 10 < agent.table.n_rows <= 61
    again = FittedQ.load(tmp_path / "policy.ltlc")
    cells = [show(cell) for cell in range(61)]
    batch = {key: np.stack([cell[key] for cell in cells]) for key in ("where", "on")}
    for state in range(task.tables.n_states):
        states = np.full(61, state)
        assert np.array_equal(again.q_values(batch, states), agent.q_values(batch, states))
    unseen = {"where": np.array([[3, 3]]), "on": np.zeros((1, 3), dtype=np.int8)}
    assert agent.q_values(unseen, [0]).tolist() == [[0.0, 0.0]]
