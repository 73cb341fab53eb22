"""Zone worlds: mechanics, lidar, labels and placement against slow definitions."""

from __future__ import annotations

from math import atan2, cos, exp, hypot, pi, sin
from typing import Any

import numpy as np
import pytest

from ltlc.envs import VectorZoneWorld, ZoneWorld
from ltlc.envs.zone_world import BINS, COLOURS
from ltlc.errors import InvalidArgumentError

CONTROLS = {0: (1, 0), 1: (-1, 0), 2: (0, 1), 3: (0, -1), 4: (0, 0)}


def test_the_mass_moves_as_the_formulas_say() -> None:
    world = VectorZoneWorld(6)
    world.reset(seed=0)
    draw = np.random.default_rng(1)
    x, y, heading = world._at[0].tolist(), world._at[1].tolist(), world._heading.tolist()
    vx, vy = [0.0] * 6, [0.0] * 6
    for _ in range(60):
        actions = draw.choice([0, 0, 1, 2, 3, 4], 6)
        seen = world.step(actions)[0]
        for i, action in enumerate(actions.tolist()):
            force, turning = CONTROLS[action]
            before = vx[i], vy[i]
            vx[i] = (vx[i] + 2 * force * cos(heading[i]) * 0.05) * (1 - 0.08)
            vy[i] = (vy[i] + 2 * force * sin(heading[i]) * 0.05) * (1 - 0.08)
            x[i] += vx[i] * 0.05
            y[i] += vy[i] * 0.05
            heading[i] += 3 * turning * 0.05
            ahead, left = (cos(heading[i]), sin(heading[i])), (-sin(heading[i]), cos(heading[i]))
            ax, ay = (vx[i] - before[0]) / 0.05, (vy[i] - before[1]) / 0.05
            body = [ax * ahead[0] + ay * ahead[1], ax * left[0] + ay * left[1]]
            body += [vx[i] * ahead[0] + vy[i] * ahead[1], vx[i] * left[0] + vy[i] * left[1], 3 * turning]
            assert seen[i, :5] == pytest.approx(body, abs=1e-5)
        assert world._at[0] == pytest.approx(x)
        assert world._at[1] == pytest.approx(y)


def test_the_speed_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ltlc.envs.zone_world.FORCE", 400.0)
    world = VectorZoneWorld(3)
    world.reset(seed=0)
    world.step(np.array([0, 1, 4]))
    assert np.hypot(*world._velocity) == pytest.approx([3, 3, 0])


def lidar(world: VectorZoneWorld, i: int) -> np.ndarray[Any, Any]:
    """What a copy sees, zone by zone."""
    seen = np.zeros((len(world.colours), BINS))
    for k in range(len(world.colours)):
        dx, dy = (world._zones[:, k, i] - world._at[:, i]).tolist()
        direction = (atan2(dy, dx) - float(world._heading[i])) % (2 * pi) / (2 * pi) * BINS
        bin_, strength = int(direction), exp(-0.5 * hypot(dx, dy))
        seen[k, bin_ % BINS] = strength
        seen[k, (bin_ + 1) % BINS] = strength * (direction - bin_)
        seen[k, (bin_ - 1) % BINS] = strength * (1 - (direction - bin_))
    return seen.ravel()


@pytest.mark.slow
def test_lidar_and_labels_follow_their_definitions() -> None:
    world = VectorZoneWorld(200, max_episode_steps=400)
    seen, _ = world.reset(seed=1)
    draw = np.random.default_rng(0)
    letters = set()
    for step in range(300):
        seen, *_, infos = world.step(draw.choice([0, 0, 0, 2, 3], 200))
        for i, letter in enumerate(infos["labels"].tolist()):
            x, y = world._at[:, i].tolist()
            expected = {c for c, (a, b) in zip(COLOURS, world._zones[:, :, i].T.tolist(), strict=True)
                        if hypot(x - a, y - b) < 0.4}  # fmt: skip
            if max(abs(x), abs(y)) > 3.3:
                expected = {"outside"}
            assert {name for k, name in enumerate(world.propositions) if letter >> k & 1} == expected
            letters.add(letter)
        if step % 50 == 0:
            for i in range(20):
                assert seen[i, 5:] == pytest.approx(lidar(world, i), abs=1e-5)
    assert len(letters) > 9


def test_zones_and_starts_are_where_they_may_be() -> None:
    world = VectorZoneWorld(500)
    world.reset(seed=2)
    for i in range(500):
        zones, at = world._zones[:, :, i].T, world._at[:, i]
        apart = [hypot(*(zones[k] - zones[j])) for k in range(8) for j in range(k)]
        assert min(apart) >= 0.55
        assert min(hypot(*(zone - at)) for zone in zones) >= 0.4
    assert np.abs(world._zones).max() <= 2.5
    assert np.abs(world._zones).max() > 2.4
    assert np.histogram(world._heading, 4, (0, 2 * pi))[0].min() > 80


def test_leaving_ends_the_episode() -> None:
    world = VectorZoneWorld(2)
    world.reset(seed=0)
    world._at[:, 0], world._velocity[:, 0] = (3.29, 0), (1, 0)
    *_, terminated, _, infos = world.step(np.array([4, 4]))
    assert terminated.tolist() == [True, False]
    assert infos["labels"].tolist() == [1 << 8, 0]


@pytest.mark.parametrize(("arguments", "message"), [
    ({"colours": ("red", "red")}, "each is there once"),
    ({"colours": ()}, "each is there once"),
    ({"colours": ("outside",)}, "none is 'outside'"),
    ({"radius": 0}, "lengths are positive"),
    ({"spawn": 4}, "the spawn area lies in the world"),
])  # fmt: skip
def test_wrong_worlds_are_explained(arguments: dict[str, Any], message: str) -> None:
    for make in (ZoneWorld, VectorZoneWorld):
        with pytest.raises(InvalidArgumentError, match=message):
            make(**arguments)


def test_a_crowded_world_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ltlc.envs.vector_world._ROUNDS", 20)
    with pytest.raises(InvalidArgumentError, match="no room for zones that far apart"):
        ZoneWorld(apart=5.0).reset(seed=0)
