"""FlatWorld: geometry, labels and where episodes begin and end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ltlc.envs import FlatWorld, LTLWrapper, VectorFlatWorld
from ltlc.envs.flat_world import CIRCLES
from ltlc.errors import InvalidArgumentError


def colours(x: float, y: float) -> set[str]:
    """What holds at a place, by definition."""
    if abs(x) > 2 or abs(y) > 2:
        return {"outside"}
    return {c.colour for c in CIRCLES if (x - c.x) ** 2 + (y - c.y) ** 2 < c.radius**2}


def names(world: Any, letter: int) -> set[str]:
    return {name for i, name in enumerate(world.propositions) if letter >> i & 1}


@pytest.mark.slow
def test_what_holds_follows_the_definition() -> None:
    world = VectorFlatWorld(64, max_episode_steps=100)
    world.reset(seed=0)
    draw = np.random.default_rng(0)
    seen = set()
    for _ in range(300):
        infos = world.step(draw.integers(0, 9, 64) * draw.integers(0, 2, 64))[4]
        for i, letter in enumerate(infos["labels"].tolist()):
            assert names(world, letter) == colours(*world._at[:, i])
            seen.add(letter)
    assert len(seen) > 8


@pytest.mark.slow
def test_the_circles_can_be_seen_in_thirteen_ways() -> None:
    world = VectorFlatWorld(1)
    grid = np.stack(np.meshgrid(*[np.linspace(-2, 2, 801)] * 2)).reshape(2, -1)
    letters = {int(letter) for letter in world._colours(grid)}
    assert len(letters) == 13
    assert {frozenset(names(world, letter)) for letter in letters} == {
        frozenset(colours(x, y)) for x, y in grid[:, ::3].T.tolist()
    }


def test_a_rim_does_not_belong_to_its_circle_and_the_border_to_the_square() -> None:
    world = VectorFlatWorld(2, circles=[("a", 0.5, 0, 0.5), ("a", 0.75, 0, 0.5)], half_width=1, stride=0.25)
    world.reset(seed=0)
    world._at[:] = [[0.0, 1.0], [0.0, 0.0]]
    *_, terminated, _, infos = world.step(np.array([8, 8]))
    assert (terminated.tolist(), infos["labels"].tolist()) == ([False, False], [0, 1])
    *_, terminated, _, infos = world.step(np.array([0, 8]))
    assert (terminated.tolist(), infos["labels"].tolist()) == ([False, False], [1, 1])
    *_, terminated, _, infos = world.step(np.array([0, 0]))
    assert (terminated.tolist(), infos["labels"].tolist()) == ([False, True], [1, 2])


def test_steps_have_one_length() -> None:
    world, vectors = VectorFlatWorld(9), VectorFlatWorld(3, continuous=True)
    for one in (world, vectors):
        one.reset(seed=0)
        one._at[:] = 0
    world.step(np.arange(9))
    assert np.hypot(*world._at) == pytest.approx([0.08] * 8 + [0])
    assert np.arctan2(*world._at[::-1, :8]) == pytest.approx([0, *np.arange(1, 4) * np.pi / 4, np.pi,
                                                             *np.arange(-3, 0) * np.pi / 4])  # fmt: skip
    vectors.step(np.array([[1, 1], [0.3, 0.4], [-9, 0]]))
    assert np.hypot(*vectors._at) == pytest.approx([0.08, 0.04, 0.08])


def test_starts_are_uniform_outside_the_circles() -> None:
    world = VectorFlatWorld(20_000)
    seen, infos = world.reset(seed=1)
    assert not infos["labels"].any()
    uniform = np.random.default_rng(2).uniform(-2, 2, (400_000, 2))
    free = uniform[world._colours(uniform.T) == 0]
    for low, high in (((-2, -2), (0, 0)), ((0, -2), (2, 0)), ((1, 1), (2, 2))):
        expected = ((free >= low) & (free < high)).all(axis=1).mean()
        drawn = ((seen >= low) & (seen < high)).all(axis=1).mean()
        assert abs(drawn - expected) < 5 * np.sqrt(expected / 20_000)


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_leaving_ends_an_episode_in_every_mode(mode: AutoresetMode) -> None:
    world = VectorFlatWorld(2, autoreset_mode=mode)
    world.reset(seed=0)
    world._at[:, 0] = (1.95, 0)
    seen, _, terminated, _, infos = world.step(np.array([0, 8]))
    assert terminated.tolist() == [True, False]
    if mode == AutoresetMode.SAME_STEP:
        assert infos["final_obs"][0] == pytest.approx([2.03, 0])
        assert names(world, infos["final_info"]["labels"][0]) == {"outside"}
        assert (np.abs(seen) <= 2).all()
        assert infos["labels"][0] == 0
        return
    assert names(world, infos["labels"][0]) == {"outside"}
    assert seen in world.observation_space
    if mode == AutoresetMode.DISABLED:
        world.reset(options={"reset_mask": np.array([True, False])})
    seen, _, terminated, _, infos = world.step(np.array([8, 8]))
    assert not terminated.any()
    assert (np.abs(seen) <= 2).all()


def test_a_task_sees_that_the_square_was_left() -> None:
    wrapped = LTLWrapper(FlatWorld(), "G !outside", warn_discount=False)
    wrapped.reset(seed=0)
    ended = False
    while not ended:
        *_, ended, _, info = wrapped.step(0)
    assert info["ltl"]["violated"]


@pytest.mark.parametrize(("arguments", "message"), [
    ({"stride": 0}, "stride 0; lengths and radii are positive"),
    ({"half_width": float("nan")}, "half_width is nan"),
    ({"circles": [("a", 0, 0, -1)]}, "lengths and radii are positive"),
    ({"circles": [("outside", 0, 0, 1)]}, "no circle is called 'outside'"),
])  # fmt: skip
def test_wrong_worlds_are_explained(arguments: dict[str, Any], message: str) -> None:
    for make in (FlatWorld, VectorFlatWorld):
        with pytest.raises(InvalidArgumentError, match=message):
            make(**arguments)


@pytest.mark.slow
def test_a_full_world_is_explained() -> None:
    with pytest.raises(InvalidArgumentError, match="no room for a start outside the circles"):
        FlatWorld(circles=[("a", 0, 0, 9)]).reset()
