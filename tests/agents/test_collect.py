"""What reaches the replay buffer: executed actions, true last observations, no bogus transitions."""

import itertools
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from ltlc.agents.double_dqn.places import Places
from ltlc.agents.double_dqn.replay import ReplayBuffer, ReplaySize
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.training.collect import Collector, Interface
from ltlc.agents.transitions import TransitionBatch
from ltlc.envs import HeldActions, LTLVectorWrapper, LTLWrapper, VectorGridWorld
from ltlc.envs.spec import EnvSpec
from ltlc.errors import InvalidArgumentError
from ltlc.task import Task

MAP = "S..\n.C.\n..A"
MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]


class Line(gym.Env[int, int]):
    """Cells 0..4 in a row, start at 1; action 1 goes right, 0 left; the ends terminate, 3 steps truncate."""

    observation_space = spaces.Discrete(5)
    action_space = spaces.Discrete(2)
    propositions = ("edge",)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.cell, self.time = 1, 0
        return self.cell, {"labels": set()}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.cell += 2 * int(action) - 1
        self.time += 1
        end = self.cell in (0, 4)
        return self.cell, float(self.cell), end, self.time == 3, {"labels": {"edge"} if end else set()}


def lines(mode: AutoresetMode, n: int = 3) -> SyncVectorEnv:
    return SyncVectorEnv([Line] * n, autoreset_mode=mode)


def collector(env: Any) -> Collector:
    interface = Interface.of(env)
    made = Collector(interface, ObservationEncoder(interface.space))
    made.reset(0)
    return made


def rows(steps: TransitionBatch) -> list[tuple[Any, ...]]:
    of_a_step = tuple(TransitionBatch.__dataclass_fields__)[:-2]  # whatever was before and after
    columns = [np.ravel(getattr(steps, name)).tolist() for name in of_a_step]
    return list(zip(*columns, strict=True))


def collect(env: Any, n: int, seed: int = 0) -> tuple[list[tuple[Any, ...]], list[Any]]:
    source, random = collector(env), np.random.default_rng(seed)
    found = []
    for _ in range(n):
        found += rows(source.step(random.integers(0, source.interface.n_actions, env.num_envs)))
    return found, source.take_episodes()


@pytest.mark.parametrize("mode", MODES)
def test_plain_environment_gives_true_transitions_only(mode: AutoresetMode) -> None:
    found, episodes = collect(lines(mode), 60)
    assert len(found) > 100
    for observation, state, action, letter_class, reward, terminated, arrived in found:
        assert arrived == observation + 2 * action - 1  # never the first observation of the next episode
        assert reward == arrived and (state, letter_class) == (0, 0)
        assert terminated == (arrived in (0, 4))  # and not where the time was up
    assert {episode.length for _, episode in episodes} == {1, 3}
    assert all(episode.reward == (0 if episode.length == 1 else episode.reward) for _, episode in episodes)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("observation", ["none", "dict", "index", "flat"])
def test_wrapped_grid_gives_true_transitions_in_every_mode(mode: AutoresetMode, observation: Any) -> None:
    task = Task("F A & G !C", on_deadlock="terminate")
    env = VectorGridWorld(MAP, 4, max_episode_steps=7, autoreset_mode=mode)
    wrapped = LTLVectorWrapper(env, task, observation=observation)
    tables = task.tables
    source, random = collector(wrapped), np.random.default_rng(1)
    seen = set()
    for _ in range(80):
        before = source.states.copy()
        actions = random.integers(0, 5, 4)
        steps = source.step(actions)
        cells = source.encoder.features(torch.from_numpy(steps.observation))
        after = source.encoder.features(torch.from_numpy(steps.next_observation))
        if observation == "flat":  # indicator vectors arrive as a box scaled to [-1, 1]
            cells, after = cells > 0, after > 0
        for i, (cell, arrived) in enumerate(
            zip(cells.int().argmax(1).tolist(), after.int().argmax(1).tolist(), strict=True)
        ):
            row, column = divmod(cell, 3)
            move = [(-1, 0), (0, 1), (1, 0), (0, -1), (0, 0)][int(steps.action[i])]
            row, column = min(max(row + move[0], 0), 2), min(max(column + move[1], 0), 2)
            assert arrived == 3 * row + column
            letter = {8: 1 << tables.aps.index("A"), 4: 1 << tables.aps.index("C")}.get(arrived, 0)
            assert steps.letter_class[i] == tables.letter_class[letter]
            assert steps.base_reward[i] == 0 and not steps.terminated[i]
            seen.add(arrived)
        assert set(steps.state.tolist()) <= set(before.tolist())
    assert seen == set(range(9))
    lengths = {episode.length for _, episode in source.take_episodes()}
    assert max(lengths) == 7 and min(lengths) < 7  # some run out of time, some end by the task


@pytest.mark.parametrize("mode", MODES)
def test_environment_that_terminates_is_told_from_the_task(mode: AutoresetMode) -> None:
    wrapped = LTLVectorWrapper(lines(mode), Task("F edge"), observation="none")
    found, episodes = collect(wrapped, 60)
    assert all(terminated == (arrived in (0, 4)) for *_, terminated, arrived in found)
    assert {episode.acceptances for _, episode in episodes} == {0, 1}


@pytest.mark.parametrize("mode", MODES)
def test_base_reward_is_what_comes_on_top_of_the_tables(mode: AutoresetMode) -> None:
    wrapped = LTLVectorWrapper(lines(mode), Task("F edge"), observation="none", reward="add")
    found, _ = collect(wrapped, 30)
    assert all(reward == pytest.approx(arrived) for *_, reward, _, arrived in found)


def test_the_executed_action_is_stored_and_not_the_greedy_one() -> None:
    source = collector(lines(AutoresetMode.NEXT_STEP))
    executed = np.array([1, 0, 1])
    steps = source.step(executed)
    assert steps.action.tolist() == executed.tolist()
    buffer = buffer_of(ReplaySize(30, 20, 3))
    buffer.add(steps)
    assert buffer.columns["action"][:, 0].tolist() == executed.tolist()


def buffer_of(size: ReplaySize, space: spaces.Space[Any] | None = None) -> ReplayBuffer:
    encoder = ObservationEncoder(space or spaces.Discrete(5))
    return ReplayBuffer(size, encoder, Places(encoder))


def filled(mode: AutoresetMode, rounds: int, size: ReplaySize) -> tuple[ReplayBuffer, list[list[tuple[Any, ...]]]]:
    """A buffer, and the steps that were put into it, of each sub-environment in order."""
    source, random, buffer = collector(lines(mode)), np.random.default_rng(1), buffer_of(size)
    made: list[list[tuple[Any, ...]]] = [[], [], []]
    for i in range(rounds):
        if i == rounds - 3:  # new episodes everywhere
            source.reset(5)
            buffer.cut()
        steps = source.step(random.integers(0, 2, 3))
        buffer.add(steps)
        for copy, row in zip(steps.copy.tolist(), rows(steps), strict=True):
            made[copy].append(row)
    return buffer, made


@pytest.mark.parametrize("mode", MODES)
def test_the_buffer_gives_back_the_newest_steps_whole(mode: AutoresetMode) -> None:
    buffer, made = filled(mode, 40, ReplaySize(36, 20, 3))
    newest = {row for steps in made for row in steps[-8:]}
    everything = {row for steps in made for row in steps}
    assert len(buffer) == 36 and buffer.steps == sum(map(len, made))
    sample = set(rows(buffer.sample(2_000, torch.Generator().manual_seed(0))))
    assert newest <= sample <= everything


@pytest.mark.parametrize("mode", MODES)
def test_segments_are_steps_that_followed_one_another(mode: AutoresetMode) -> None:
    buffer, made = filled(mode, 40, ReplaySize(36, 20, 3))
    found = buffer.sample_segments(400, 4, torch.Generator().manual_seed(0))
    assert found.observation.shape == (400, 5, 1) and found.letter_class.shape == (400, 4, 1)
    following = [pair for steps in made for pair in itertools.pairwise(steps)]
    seen = 0
    for i in range(400):
        for t in range(3):
            if found.real[i, t] and found.real[i, t + 1]:
                one, two = (
                    (int(found.observation[i, k, 0]), int(found.action[i, k]), bool(found.terminated[i, k, 0]))
                    for k in (t, t + 1)
                )
                assert any((a[0], a[2], a[5], b[0], b[2], b[5]) == (*one, *two) for a, b in following)
                assert not one[2] and int(found.observation[i, t + 1, 0]) == one[0] + 2 * one[1] - 1
                seen += 1
    assert seen > 100


def test_segments_of_held_actions_are_whole_actions_of_one_episode() -> None:
    repeat, copies, rng = 3, 2, np.random.default_rng(0)
    holds, buffer = HeldActions(repeat, 4), buffer_of(ReplaySize(80, 20, copies, repeat), spaces.Discrete(10_000))
    steps: dict[int, tuple[int, int, int, bool, bool]] = {}  # by observation: action, class, age, terminated, ended
    ends, at, age, everywhere = 0, np.array([0, 5_000]), np.zeros(copies, dtype=np.int64), np.arange(copies)
    for i in range(200):
        deciding = holds.deciding(copies)
        assert (deciding == (age % repeat == 0)).all()
        action = holds.keep(rng.integers(4, size=copies), deciding)
        letter, terminated = rng.integers(9, size=copies), rng.random(copies) < 0.06
        ended = terminated | (rng.random(copies) < 0.04)
        steps |= {int(at[c]): (int(action[c]), int(letter[c]), int(age[c]), bool(terminated[c]), bool(ended[c]))
                  for c in everywhere}  # fmt: skip
        buffer.add(TransitionBatch(
            observation=at[:, None], state=0 * at, action=action, letter_class=letter, base_reward=1.0 * letter,
            terminated=terminated, next_observation=at[:, None] + 1, copy=everywhere, ended=ended,
        ))  # fmt: skip
        holds.advance(everywhere, ended)
        at, age = at + 1 + ended, np.where(ended, 0, age + 1)
        if i == 150:
            buffer.cut()
            steps |= {key: (*step[:4], True) for key, step in steps.items() if key in (at - 1).tolist()}
            holds.clear()
            at, age = at + 2, 0 * age
        found = buffer.sample_segments(50, 4, torch.Generator().manual_seed(i))
        whole = np.argwhere(found.real[:, :-1].numpy())
        for n, t in whole:
            start, last = int(found.observation[n, t, 0]), False
            for k in range(repeat):
                assert found.made[n, t, k] == (not last)
                if not last:
                    action_, letter_, age_, terminated_, last = steps[start + k]
                    assert (action_, age_ % repeat) == (int(found.action[n, t]), k)
                    assert found.letter_class[n, t, k] == found.base_reward[n, t, k] == letter_
                    assert found.terminated[n, t, k] == terminated_
                    assert found.observation[n, t + 1, 0] >= start + k + 1
            assert found.observation[n, t + 1, 0] == start + int(found.made[n, t].sum())
            assert not last or not found.real[n, t + 1]
            ends += last
    assert ends > 1000 and len(whole) > 80 and found.letter_class.shape == (50, 4, repeat)


def test_the_buffer_comes_back_from_its_state() -> None:
    size = ReplaySize(36, 20, 3)
    one, _ = filled(AutoresetMode.NEXT_STEP, 9, size)
    other = buffer_of(size)
    other.load_state_dict(one.state_dict())
    drawn = [rows(buffer.sample(50, torch.Generator().manual_seed(0))) for buffer in (one, other)]
    assert drawn[0] == drawn[1] and other.steps == one.steps
    with pytest.raises(InvalidArgumentError, match="does not fit this buffer"):
        buffer_of(size, spaces.MultiDiscrete([5, 5])).load_state_dict(one.state_dict())


def test_environments_the_agent_cannot_take_are_refused() -> None:
    with pytest.raises(InvalidArgumentError, match=r"no vector environment; make one with gymnasium\.make_vec"):
        Interface.of(Line())  # type: ignore[arg-type]
    pendulum = SyncVectorEnv([lambda: gym.make("Pendulum-v1")])
    with pytest.raises(InvalidArgumentError, match="needs discrete actions"):
        Interface.of(pendulum)
    inside = SyncVectorEnv([lambda: LTLWrapper(Line(), Task("F edge"))])
    with pytest.raises(InvalidArgumentError, match="put LTLVectorWrapper around them"):
        collector(inside)


def test_the_limit_of_episodes_is_the_one_that_was_asked_for() -> None:
    def limit(envs: Any) -> int | None:
        return Interface.of(LTLVectorWrapper(envs, Task("F a"), lambda seen: {"a": bool(seen[0] > 0)})).episode_steps

    for mode in ("sync", "async"):
        own = gym.make_vec("MountainCar-v0", num_envs=2, vectorization_mode=mode)
        other = gym.make_vec("MountainCar-v0", num_envs=2, vectorization_mode=mode, max_episode_steps=400)
        assert (limit(own), limit(other)) == (200, 400)
        own.close()
        other.close()
    assert limit(SyncVectorEnv([lambda: gym.make("MountainCar-v0", max_episode_steps=50)] * 2)) == 50
    assert limit(SyncVectorEnv([lambda: gym.make("MountainCar-v0").unwrapped] * 2)) is None
    spec = EnvSpec(env="MountainCar-v0", labels="variables:x=0", max_episode_steps=70)
    for workers in (0, 2):
        made = spec.vector(Task('F "x > 0"'), 2, workers)
        assert Interface.of(made).episode_steps == 70
        made.close()
