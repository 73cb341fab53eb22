"""The agent with a table of values: it learns exactly, explores what it has not tried, and resumes bit by bit."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.agents import DoubleDQN, DQNConfig, ExactJudge, Progress, greedy_policy, train
from ltlc.agents.double_dqn.networks import QNetwork
from ltlc.agents.double_dqn.replay import ReplayBuffer, Steps
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.fitted_q.table import QTable, Tally
from ltlc.envs import GridWorld, LTLVectorWrapper, VectorGridWorld, labelled_mdp
from ltlc.errors import InvalidArgumentError, TrainingDiverged
from ltlc.mdp import Judge
from ltlc.task import Task

MAP = "S..\n.C.\nA.B"
QUICK = DQNConfig(total_steps=20_000, epsilon_steps=5_000, log_every=2_000, checkpoint_every=6_000)


def wrapped(task: Task, map_: str = MAP, slip: float = 0.05, n: int = 8) -> LTLVectorWrapper:
    return LTLVectorWrapper(VectorGridWorld(map_, n, slip=slip, max_episode_steps=100), task, observation="none")


@pytest.mark.parametrize("reward", ["two-discount", "zeta-discount", "thesis", "parity", "sadigh"])
def test_returns_of_what_is_learned_are_nearly_the_largest(reward: str) -> None:
    task = Task("F(A & F B) & G !C", reward, acceptance="transition")
    agent = train(wrapped(task), QUICK).agent
    assert agent.tabular and isinstance(agent.q_network, QTable)
    judge = ExactJudge(labelled_mdp(GridWorld(MAP, slip=0.05)), agent.tables)
    assert judge.regret(greedy_policy(agent)).relative < 1e-3


def test_values_are_those_of_the_scheme() -> None:
    task = Task("F(A & F B) & G !C", "two-discount", acceptance="transition")
    agent = train(wrapped(task, slip=0.0), QUICK).agent
    judge = ExactJudge(labelled_mdp(GridWorld(MAP)), agent.tables)
    best = agent.q_values(np.array([0]), np.array([agent.tables.initial_state])).max()
    assert best == pytest.approx(judge.optimum, rel=1e-3)


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


def test_what_is_far_away_is_found() -> None:
    """At random, thirty right steps in a row happen once in a thousand million."""
    config = dataclasses.replace(QUICK, gamma=0.99)
    agent = train(SyncVectorEnv([Corridor] * 4), config).agent
    values = agent.q_values(np.arange(30), np.zeros(30, dtype=np.int64))
    assert values.argmax(axis=1).tolist() == [1] * 30
    assert values.max(axis=1) == pytest.approx(0.99 ** np.arange(29, -1, -1), rel=1e-2)


class Killed(BaseException):
    """Stands for a kill."""


def test_resumed_run_is_bit_identical(tmp_path: Path) -> None:
    task = Task("(F G A | F G B) & G !C", "two-discount", acceptance="transition")

    def kill(progress: Progress) -> None:
        if progress.row.steps >= 10_000:
            raise Killed

    whole = train(wrapped(task), QUICK, folder=tmp_path / "whole")
    with pytest.raises(Killed):
        train(wrapped(task), QUICK, folder=tmp_path / "parts", callback=kill)
    resumed = train(wrapped(task), folder=tmp_path / "parts", resume=True)
    for ours, theirs in zip(*(run.agent.q_network.state_dict().values() for run in (whole, resumed)), strict=True):
        assert torch.equal(ours, theirs)
    assert whole.agent.updates == resumed.agent.updates
    again = DoubleDQN.load(tmp_path / "whole" / "policy.ltlc")
    assert again.tabular and (greedy_policy(again) == greedy_policy(whole.agent)).all()


FEW, MANY = spaces.Discrete(9), spaces.MultiDiscrete([100, 100])


@pytest.mark.parametrize(
    ("space", "changes", "tabular"),
    [
        (FEW, {}, True),
        (spaces.MultiDiscrete([3, 3]), {}, True),
        (FEW, {"hidden": (8,)}, False),
        (FEW, {"hidden": ()}, False),
        (FEW, {"observation_input": "raw"}, False),
        (FEW, {"counterfactual": False}, False),
        (MANY, {}, False),
        (spaces.Box(-1.0, 1.0, (2,)), {}, False),
    ],
)
def test_numbered_observations_have_a_table_unless_the_configuration_asks_for_a_network(
    space: spaces.Space[Any], changes: dict[str, Any], tabular: bool
) -> None:
    agent = DoubleDQN(space, 4, Task("F A", "two-discount").tables, DQNConfig(**changes))
    assert agent.tabular == tabular
    assert isinstance(agent.q_network, QTable if tabular else QNetwork)


def test_the_network_has_one_layer_of_256_by_default() -> None:
    agent = DoubleDQN(MANY, 4, Task("F A", "two-discount").tables, DQNConfig())
    assert [tuple(weights.shape)[:1] for weights in agent.q_network.parameters()][:1] == [(256,)]


def steps(*rows: tuple[int, int, int, int, float, bool]) -> Steps:
    """Rows of observation, action, next observation, letter class, base reward, terminated."""
    observation, action, following, letter_class, paid, terminated = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    return Steps(
        observation=observation[:, None], state=0 * action, action=action, letter_class=letter_class,
        base_reward=paid, terminated=terminated, next_observation=following[:, None],
    )  # fmt: skip


def test_equal_steps_are_counted() -> None:
    encoder = ObservationEncoder(spaces.Discrete(3))
    tally = Tally(encoder, 2, 1)
    tally.add(steps((0, 1, 2, 0, 1.0, False), (0, 1, 2, 0, 3.0, False)))
    tally.add(steps((0, 1, 1, 0, 0.0, True), (0, 1, 2, 0, 2.0, False), (2, 0, 0, 0, 0.0, False)))
    found = tally.outcomes()
    assert len(tally) == 5
    assert found.tries.tolist() == [0, 0, 1, 4, 0, 0]  # action 0 at 0, 1, 2; action 1 at 0, 1, 2
    by_outcome = {
        (int(pair), int(target), bool(end)): (float(weight), float(paid))
        for pair, target, end, weight, paid in zip(
            found.pair, found.following, found.terminated, found.weight, found.paid, strict=True
        )
    }
    assert by_outcome.keys() == {(3, 2, False), (3, 1, True), (2, 0, False)}
    assert by_outcome[3, 2, False] == (0.75, 2.0)
    again = Tally(encoder, 2, 1)
    again.load_state_dict(tally.state_dict())
    assert (again.outcomes().weight == found.weight).all() and len(again) == 5


def test_experience_of_another_kind_is_refused() -> None:
    tally = Tally(ObservationEncoder(spaces.Discrete(2)), 1, 1)
    larger = Tally(ObservationEncoder(spaces.Discrete(9)), 1, 1)
    larger.add(steps((8, 0, 8, 0, 0.0, False)))
    for state in (larger.state_dict(), ReplayBuffer(4, 1, np.int64).state_dict()):
        with pytest.raises(InvalidArgumentError, match="of another kind"):
            tally.load_state_dict(state)


def test_rewards_that_are_no_numbers_end_the_training() -> None:
    tally = Tally(ObservationEncoder(spaces.Discrete(3)), 2, 1)
    with pytest.raises(TrainingDiverged, match="NaN"):
        tally.add(steps((0, 1, 2, 0, float("nan"), False)))
