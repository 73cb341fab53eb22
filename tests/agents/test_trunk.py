"""What a network makes of images, grids of codes, and numbers with and without bounds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.agents import DoubleDQN, DQNConfig, Progress, train
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.trunk import EMBEDDED, Image, RunningStatistics, Trunk, cell_shape, image_order, is_image
from ltlc.envs import LTLVectorWrapper
from ltlc.task import Task


def trunk_of(space: spaces.Space[Any], mode: Any = "one-hot") -> tuple[ObservationEncoder, Trunk]:
    encoder = ObservationEncoder(space, mode)
    return encoder, Trunk(encoder, torch.Generator().manual_seed(0))


def features(encoder: ObservationEncoder, batch: Any) -> torch.Tensor:
    return encoder.features(torch.from_numpy(encoder.pack(batch)))


@pytest.mark.parametrize(
    ("shape", "order", "cells"),
    [
        ((84, 84, 4), (2, 0, 1), (84, 84, 4)),
        ((4, 84, 84), (0, 1, 2), (84, 84, 4)),
        ((7, 7, 12), (2, 0, 1), (7, 7, 12)),
        ((12, 7, 7), (0, 1, 2), (7, 7, 12)),
        ((210, 160, 3), (2, 0, 1), (210, 160, 3)),
        ((3, 210, 160), (0, 1, 2), (210, 160, 3)),
        ((3, 3, 3), (2, 0, 1), (3, 3, 3)),
        ((4, 84, 84, 3), (0, 3, 1, 2), (84, 84, 12)),
        ((4, 3, 84, 84), (0, 1, 2, 3), (84, 84, 12)),
        ((9, 8), (0, 1), (9, 8, 1)),
    ],
)
def test_channels_are_found(shape: tuple[int, ...], order: tuple[int, ...], cells: tuple[int, ...]) -> None:
    assert image_order(shape) == order and cell_shape(shape) == cells


def test_cells_of_an_image_are_where_they_were() -> None:
    for shape in ((5, 6, 2), (2, 5, 6), (3, 5, 6, 2), (5, 6)):
        encoder, trunk = trunk_of(spaces.Box(0, 200, shape, dtype=np.uint8), "one-hot")
        (image,) = trunk.parts
        assert isinstance(image, Image)
        batch = np.random.default_rng(0).integers(0, 201, (3, *shape)).astype(np.uint8)
        cells = image.cells(features(encoder, batch))
        expected = {2: batch[:, None], 3: np.moveaxis(batch, -1, 1) if shape[-1] == 2 else batch}.get(len(shape))
        if expected is None:
            expected = np.moveaxis(batch, -1, 2).reshape(3, 6, 5, 6)
        assert torch.allclose((cells + 1) * 100, torch.from_numpy(expected).float(), atol=1e-4)


def test_what_is_an_image() -> None:
    for shape in ((7, 7, 3), (3, 7, 7), (4, 84, 84, 1)):
        assert is_image(spaces.Box(0, 1, shape))
    assert is_image(spaces.Box(0, 9, (8, 8), dtype=np.int8))
    for space in (spaces.Box(0, 1, (8, 8)), spaces.Box(0, 9, (4, 8), dtype=np.int8), spaces.Box(0, 1, (2, 2, 3)),
                  spaces.Box(0, 1, (64,)), spaces.MultiBinary((7, 7, 3))):  # fmt: skip
        assert not is_image(space)


def test_codes_are_told_apart_and_intensities_are_scaled() -> None:
    encoder, trunk = trunk_of(spaces.Box(0, 255, (7, 7, 3), dtype=np.uint8))
    one, other = np.full((1, 7, 7, 3), 4, np.uint8), np.full((1, 7, 7, 3), 5, np.uint8)
    trunk.observe(encoder, encoder.pack(np.concatenate([one, other])))
    near = trunk(features(encoder, one)) - trunk(features(encoder, other))
    assert trunk.n_outputs == 49 * 3 * (1 + EMBEDDED) == near.shape[1]
    assert near.square().mean().sqrt() > 0.3  # scaled by its bounds, it would be .008
    encoder, trunk = trunk_of(spaces.Box(0, 255, (84, 84, 4), dtype=np.uint8))
    assert trunk.n_outputs == 32 * 9 * 9 and not any(isinstance(part, RunningStatistics) for part in trunk.modules())
    encoder, trunk = trunk_of(spaces.Box(0, 1, (7, 7, 5), dtype=np.uint8))
    assert (trunk(features(encoder, np.ones((2, 7, 7, 5), np.uint8))) == 1).all() and trunk.n_outputs == 49 * 5
    _, trunk = trunk_of(spaces.Box(0, 1, (12, 12, 5), dtype=np.uint8))
    assert trunk.n_outputs > 144 * 5  # and convolutions


def test_statistics_are_those_of_all_rows() -> None:
    rows = np.random.default_rng(0).normal(100, 7, (50, 3)).astype(np.float32)
    statistics = RunningStatistics(np.zeros(3, dtype=np.bool_))
    assert torch.equal(statistics(torch.from_numpy(rows[:2])), torch.full((2, 3), 5.0))  # nothing is known: only cut
    for part in np.split(rows, [1, 17, 30]):
        statistics.add(torch.from_numpy(part))
    assert np.allclose(statistics.mean, rows.mean(axis=0)) and int(statistics.count) == 50
    assert np.allclose(statistics.squares / 50, rows.var(axis=0))
    assert np.allclose(statistics(torch.from_numpy(rows)), (rows - rows.mean(axis=0)) / rows.std(axis=0) / 2, atol=1e-4)


def test_bounds_that_are_far_too_wide_do_not_hide_a_number() -> None:
    space = spaces.Box(np.array([-1.0, -1000.0, -np.inf]), np.array([1.0, 1000.0, np.inf]), dtype=np.float64)
    encoder, trunk = trunk_of(space)
    rows = np.random.default_rng(0).uniform(-1, 1, (500, 3)) * [1, 20, 5000]
    trunk.observe(encoder, encoder.pack(rows))
    seen = trunk(features(encoder, rows)).numpy()
    assert np.allclose(seen[:, 0], rows[:, 0])  # sane bounds: scaled by them alone
    assert seen.std(axis=0) == pytest.approx([0.577, 0.25, 0.5], rel=0.1)


def test_many_numbers_are_all_normalised() -> None:
    encoder, trunk = trunk_of(spaces.Box(0, 1, (40,)))
    rows = np.random.default_rng(0).uniform(0, 1, (500, 40)).astype(np.float32)
    rows[:, 3:] *= rows[:, 3:] > 0.9  # seldom something
    trunk.observe(encoder, encoder.pack(rows))
    seen = trunk(features(encoder, rows)).numpy()
    assert np.allclose(seen.mean(axis=0), 0, atol=0.05) and np.allclose(seen.std(axis=0), 0.5, atol=0.1)


class Room(gym.Env[Any, int]):
    """A square room; the agent is shown as any space wants it, and walks to the corner."""

    action_space = spaces.Discrete(4)

    def __init__(self, kind: str, side: int = 7) -> None:
        self.kind, self.side = kind, side
        self.observation_space = SPACES[kind]  # type: ignore[assignment]

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.place, self.time = np.zeros(2, dtype=np.int64), 0
        return self._seen()

    def _seen(self) -> tuple[Any, dict[str, Any]]:
        x, y = (int(number) for number in self.place)
        info = {"labels": {"goal"} if x == y == self.side - 1 else set()}
        grid = np.zeros((self.side, self.side), np.uint8)
        grid[x, y] = 1
        views: dict[str, Any] = {
            "indicators": np.stack([grid, 1 - grid], axis=-1),
            "codes": np.stack([2 + 8 * grid, 5 * grid, 1 + 0 * grid], axis=-1).astype(np.uint8),
            "first": np.stack([grid, 1 - grid]).astype(np.float32),
            "image": np.kron(grid, np.full((6, 6), 200, np.uint8))[..., None].repeat(2, axis=-1),
            "free": np.array([1000.0 + x, 0.01 * y]),
            "mixed": {"at": (x, np.array([y, 1])), "on": np.array([x > 3, y > 3], np.int8), "says": "go"},
            "many": x * 1000 + y,
        }
        return views[self.kind], info

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        move = ((1, 0), (0, 1), (-1, 0), (0, -1))[action]
        self.place = np.clip(self.place + move, 0, self.side - 1)
        self.time += 1
        observation, info = self._seen()
        return observation, 0.0, False, self.time == 40, info


SPACES: dict[str, spaces.Space[Any]] = {
    "indicators": spaces.Box(0, 1, (7, 7, 2), dtype=np.uint8),
    "codes": spaces.Box(0, 255, (7, 7, 3), dtype=np.uint8),
    "first": spaces.Box(0.0, 1.0, (2, 7, 7), dtype=np.float32),
    "image": spaces.Box(0, 255, (42, 42, 2), dtype=np.uint8),
    "free": spaces.Box(-np.inf, np.inf, (2,), dtype=np.float64),
    "mixed": spaces.Dict(
        at=spaces.Tuple([spaces.Discrete(7), spaces.MultiDiscrete([7, 5])]),
        on=spaces.MultiBinary(2),
        says=spaces.Text(5),
    ),
    "many": spaces.Discrete(2_000_000),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", SPACES)
def test_every_kind_is_trained_saved_and_acts_the_same(kind: str, tmp_path: Path) -> None:
    def env() -> LTLVectorWrapper:
        return LTLVectorWrapper(SyncVectorEnv([lambda: Room(kind)] * 2), Task("F goal"))

    config = DQNConfig(
        total_steps=120, learning_starts=40, batch_size=32, hidden=(16,), log_every=30, checkpoint_every=60
    )
    agent = train(env(), config, folder=tmp_path / "whole").agent
    assert isinstance(agent, DoubleDQN) and agent.updates > 0
    again = DoubleDQN.load(tmp_path / "whole" / "policy.ltlc")
    room = Room(kind)
    seen = [room.reset()[0]] + [room.step(i % 2)[0] for i in range(11)]
    packed = np.concatenate([agent.encoder.pack(batched(one)) for one in seen])
    for state in range(agent.tables.n_states):
        states = np.full(len(seen), state)
        ours, theirs = (one.evaluate(one.policy_network, packed, states) for one in (agent, again))
        assert torch.equal(ours, theirs)
    before = {name: value.clone() for name, value in agent.policy_network.state_dict().items()}
    agent.packed_policy(packed, np.zeros(len(seen), dtype=np.int64))
    assert all(torch.equal(value, before[name]) for name, value in agent.policy_network.state_dict().items())
    with pytest.raises(Killed):
        train(env(), config, folder=tmp_path / "parts", callback=kill)
    resumed = train(env(), folder=tmp_path / "parts", resume=True).agent.policy_network.state_dict()
    assert all(torch.equal(value, before[name]) for name, value in resumed.items())


class Killed(BaseException):
    """Stands for a kill."""


def kill(progress: Progress) -> None:
    if progress.row.steps >= 90:
        raise Killed


def batched(observation: Any) -> Any:
    if isinstance(observation, dict):
        return {key: batched(part) for key, part in observation.items()}
    if isinstance(observation, tuple):
        return tuple(batched(part) for part in observation)
    return np.asarray(observation)[None]


def test_statistics_are_shared_and_frozen_where_nothing_is_explored() -> None:
    agent = DoubleDQN(SPACES["free"], 4, Task("F goal").tables, DQNConfig(hidden=(8,)))
    packed = agent.encoder.pack(np.array([[1000.0, 0.0], [1006.0, 0.06]]))
    states, generator = np.zeros(2, dtype=np.int64), torch.Generator().manual_seed(0)
    for _ in range(3):
        agent.explore(packed, states, 0.5, generator)
    counts = [network.trunk.parts[0].statistics.count for network in (agent.q_network, agent.policy_network)]
    assert [int(count) for count in counts] == [6, 6] and counts[0] is counts[1]
    assert agent.q_network.trunk.parts[0].statistics.mean.tolist() == pytest.approx([1003.0, 0.03])
    agent.policy(np.array([[5.0, 5.0]]), [0])
    assert int(counts[0]) == 6
