"""What all worlds promise that exist alone and as arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from ltlc.envs import (
    DrawnEnv,
    FlatWorld,
    LetterWorld,
    LTLVectorWrapper,
    VectorFlatWorld,
    VectorLetterWorld,
    VectorZoneWorld,
    ZoneWorld,
    register_envs,
)
from ltlc.errors import InvalidArgumentError, UnknownNameError


class World(NamedTuple):
    """A world in all its forms."""

    single: Any
    vector: Any
    arguments: dict[str, Any]
    name: str
    steps: int
    formula: str


WORLDS = {
    "flat": World(FlatWorld, VectorFlatWorld, {}, "ltlc/FlatWorld-v0", 500, "F(red & F green) & G !outside"),
    "flat-continuous": World(
        FlatWorld, VectorFlatWorld, {"continuous": True}, "ltlc/FlatWorld-v0", 500, "GF(blue & green)"
    ),
    "letters": World(LetterWorld, VectorLetterWorld, {}, "ltlc/LetterWorld-v0", 75, "!a U (b & F c)"),
    "zones": World(ZoneWorld, VectorZoneWorld, {}, "ltlc/Zone8-v0", 1000, "!blue U (green & F red)"),
    "zones-continuous": World(
        ZoneWorld, VectorZoneWorld, {"continuous": True}, "ltlc/Zone8-v0", 1000, "GF blue & GF green & G !outside"
    ),
}
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS)


def drawn_actions(world: Any, n: int, draw: np.random.Generator) -> Any:
    space = world.single_action_space
    if isinstance(space, gym.spaces.Discrete):
        return draw.integers(0, space.n, n)
    return draw.uniform(-1, 1, (n, *space.shape))


def names(world: Any, letter: int) -> set[str]:
    return {name for i, name in enumerate(world.propositions) if letter >> i & 1}


@every_world
def test_many_copies_go_the_way_of_single_worlds(world: World) -> None:
    n = 5
    vector = world.vector(n, max_episode_steps=20, **world.arguments)
    singles = [gym.wrappers.TimeLimit(world.single(**world.arguments), 20) for _ in range(n)]
    seen, infos = vector.reset(seed=3)
    for i, single in enumerate(singles):
        assert (single.reset(seed=3 + i)[0] == seen[i]).all()
    over = np.zeros(n, dtype=bool)
    draw = np.random.default_rng(0)
    ends = 0
    for _ in range(100):
        actions = drawn_actions(vector, n, draw)
        seen, rewards, terminated, truncated, infos = vector.step(actions)
        assert seen in vector.observation_space
        assert not rewards.any()
        for i, single in enumerate(singles):
            if over[i]:
                (alone, info), ended = single.reset(), [False, False]
            else:
                alone, _, *ended, info = single.step(actions[i])
            assert (alone == seen[i]).all()
            assert ended == [terminated[i], truncated[i]]
            assert info["labels"] == names(vector, infos["labels"][i])
        over = terminated | truncated
        ends += over.sum()
    assert ends >= 4 * n


@every_world
def test_the_same_seed_gives_the_same_episodes(world: World) -> None:
    runs = []
    for _ in range(2):
        vector = world.vector(4, max_episode_steps=9, **world.arguments)
        draw = np.random.default_rng(1)
        runs.append([vector.reset(seed=7)[0].tolist()])
        runs[-1] += [vector.step(drawn_actions(vector, 4, draw))[0].tolist() for _ in range(40)]
    assert runs[0] == runs[1]
    assert runs[0][0] != vector.reset(seed=8)[0].tolist()


@every_world
@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_episodes_begin_again_in_every_mode(world: World, mode: AutoresetMode) -> None:
    vector = world.vector(3, max_episode_steps=2, autoreset_mode=mode, **world.arguments)
    first = vector.reset(seed=0)[0]
    draw = np.random.default_rng(2)
    vector.step(drawn_actions(vector, 3, draw))
    seen, _, terminated, truncated, infos = vector.step(drawn_actions(vector, 3, draw))
    assert truncated.all()
    assert first.tolist() != seen.tolist()
    if mode == AutoresetMode.SAME_STEP:
        assert infos["_final_obs"].all()
        assert all(one in vector.single_observation_space for one in infos["final_obs"])
        return
    if mode == AutoresetMode.DISABLED:
        with pytest.raises(InvalidArgumentError, match="must be reset before it is stepped"):
            vector.step(drawn_actions(vector, 3, draw))
        vector.reset(options={"reset_mask": np.ones(3, dtype=bool)})
        return
    *_, terminated, truncated, _ = vector.step(drawn_actions(vector, 3, draw))
    assert not (terminated | truncated).any()


@every_world
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasium_makes_and_checks_it(world: World) -> None:
    register_envs()
    single = gym.make(world.name, **world.arguments)
    check_env(single.unwrapped)
    assert single.spec is not None
    assert single.spec.max_episode_steps == world.steps
    envs = gym.make_vec(world.name, num_envs=3, **world.arguments)
    assert isinstance(envs.unwrapped, world.vector)
    assert envs.unwrapped.max_episode_steps == world.steps
    tasks = LTLVectorWrapper(envs, world.formula)
    assert tasks.reset(seed=0)[1]["ltl"]["label"].tolist() == [0, 0, 0]
    tasks.step(np.asarray(tasks.action_space.sample()))


@every_world
def test_wrong_actions_and_modes_are_explained(world: World) -> None:
    with pytest.raises(InvalidArgumentError, match=r"actions must be 2 (numbers in 0\.\.|finite vectors of shape)"):
        world.vector(2, **world.arguments).step(np.array([0, 99]))
    for make in (world.single, world.vector):
        with pytest.raises(UnknownNameError, match="unknown render mode 'human'"):
            make(render_mode="human", **world.arguments)


@pytest.mark.slow
@every_world
def test_worlds_can_be_drawn(world: World) -> None:
    vector, single = world.vector(2, render_mode="rgb_array", **world.arguments), world.single(**world.arguments)
    vector.reset(seed=5)
    single.reset(seed=6)
    assert isinstance(vector, DrawnEnv)
    assert isinstance(single, DrawnEnv)
    assert vector.scene(1) == single.scene()
    left, bottom, right, top = single.scene().bounds
    x, y = single.scene().position
    assert left <= x <= right
    assert bottom <= y <= top
    pixels = vector.render()
    assert [one.shape for one in pixels] == [(384, 384, 3)] * 2
    assert pixels[0].dtype == np.uint8
    assert (pixels[0] != pixels[1]).any()
    with pytest.warns(UserWarning, match="needs a render mode"):
        assert single.render() is None
