"""Words, rewards and ends of agents of PettingZoo are those of the reward tables, followed by hand."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

import ltlc
from ltlc.errors import InvalidArgumentError, MissingProgramError, UnknownNameError

pettingzoo = pytest.importorskip("pettingzoo", reason="pettingzoo is not installed")

bridge = importlib.import_module("ltlc.bridges.pettingzoo")
LTLAECWrapper, LTLParallelWrapper = bridge.LTLAECWrapper, bridge.LTLParallelWrapper

pytestmark = pytest.mark.peer

NAMES = ("player_0", "player_1")
SEEN, MOVES = Box(0, 4, (2,), dtype=np.float32), Discrete(3)


class Line(pettingzoo.ParallelEnv):  # type: ignore[misc]
    """Two players walk on five cells; where `end` is reached, a player has terminated."""

    metadata = {"name": "line_v0", "render_modes": []}  # noqa: RUF012
    render_mode = None
    possible_agents = list(NAMES)  # noqa: RUF012

    def __init__(self, end: int = -1, steps: int = 12) -> None:
        self.end, self.most = end, steps

    def observation_space(self, agent: str) -> Any:
        return SEEN

    def action_space(self, agent: str) -> Any:
        return MOVES

    def reset(self, seed: int | None = None, options: Any = None) -> Any:
        self.agents, self.steps, self.places = list(NAMES), 0, {"player_0": 1, "player_1": 3}
        return self.seen(), {agent: {} for agent in self.agents}

    def seen(self) -> Any:
        return {a: np.array([self.places[a], self.places[NAMES[a == NAMES[0]]]], np.float32) for a in self.agents}

    def step(self, actions: Any) -> Any:
        self.steps += 1
        now = list(self.agents)
        for agent, action in actions.items():
            self.places[agent] = min(max(self.places[agent] + int(action) - 1, 0), 4)
        seen = self.seen()
        over = {agent: self.places[agent] == self.end for agent in now}
        cut = dict.fromkeys(now, self.steps == self.most)
        self.agents = [agent for agent in now if not (over[agent] or cut[agent])]
        return seen, dict.fromkeys(now, 7.0), over, cut, {agent: {} for agent in now}


class Turns(pettingzoo.AECEnv):  # type: ignore[misc]
    """The same by turns."""

    metadata = {"name": "turns_v0", "render_modes": [], "is_parallelizable": False}  # noqa: RUF012
    render_mode = None
    possible_agents = list(NAMES)  # noqa: RUF012

    def __init__(self, steps: int = 12) -> None:
        super().__init__()
        self.most = steps

    def observation_space(self, agent: str) -> Any:
        return SEEN

    def action_space(self, agent: str) -> Any:
        return MOVES

    def reset(self, seed: int | None = None, options: Any = None) -> None:
        self.agents, self.steps, self.places = list(NAMES), 0, {"player_0": 1, "player_1": 3}
        self.agent_selection = NAMES[0]
        self.rewards = dict.fromkeys(NAMES, 0.0)
        self._cumulative_rewards = dict.fromkeys(NAMES, 0.0)
        self.terminations, self.truncations = dict.fromkeys(NAMES, False), dict.fromkeys(NAMES, False)
        self.infos: Any = {agent: {} for agent in NAMES}

    def observe(self, agent: str) -> Any:
        return np.array([self.places[agent], self.places[NAMES[agent == NAMES[0]]]], np.float32)

    def step(self, action: Any) -> None:
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            self._was_dead_step(action)
            return
        self._cumulative_rewards[agent] = 0.0
        self.steps += 1
        self.places[agent] = min(max(self.places[agent] + int(action) - 1, 0), 4)
        if self.steps >= self.most:
            self.truncations = dict.fromkeys(NAMES, True)
        self.agent_selection = NAMES[agent == NAMES[0]]
        self._deads_step_first()


def joint_labels(observations: Any) -> set[str]:
    one, other = (float(observations[agent][0]) if agent in observations else -1 for agent in NAMES)
    return {name for name, holds in (("key", 0 in (one, other)), ("met", one == other)) if holds}


def own_labels(seen: Any) -> set[str]:
    return {"low"} if seen[0] <= 1 else {"high"} if seen[0] >= 3 else set()


class Followed:
    """The tables of a task, followed by hand."""

    def __init__(self, task: ltlc.Task, first: set[str]) -> None:
        self.tables, self.aps = task.tables, task.tables.aps
        self.state = self.tables.initial_state
        self.read(first)

    def read(self, names: set[str]) -> tuple[float, float, float]:
        letter = sum(1 << i for i, name in enumerate(self.aps) if name in names)
        at = self.state, int(self.tables.letter_class[letter])
        self.state = int(self.tables.next_state[at])
        return float(self.tables.reward[at]), float(self.tables.discount[at]), float(self.tables.stop[at])


@pytest.mark.parametrize("seed", range(5))
def test_one_task_for_all_reads_all_observations(seed: int) -> None:
    task = ltlc.Task("F(key & F met)", "two-discount")
    env, random = LTLParallelWrapper(Line(), task, joint_labels, warn_discount=False), np.random.default_rng(seed)
    plain = Line()
    seen, _ = env.reset(seed=seed)
    hand = Followed(task, joint_labels(plain.reset()[0]))
    while env.agents:
        assert {seen[agent]["automaton"] for agent in env.agents} == {hand.state}
        actions = {agent: int(random.integers(3)) for agent in env.agents}
        seen, rewards, ended, cut, infos = env.step(actions)
        expected = plain.step(actions)
        reward, discount, stop = hand.read(joint_labels(expected[0]))
        assert rewards == dict.fromkeys(NAMES, reward)
        assert [infos[agent]["ltl"]["discount"] for agent in NAMES] == [discount] * 2
        assert ended == dict.fromkeys(NAMES, stop == 1)
        assert stop == 1 or cut == expected[3]
        assert seen["player_0"]["observation"].tolist() == expected[0]["player_0"].tolist()


@pytest.mark.parametrize("seed", range(5))
def test_a_task_for_each_agent_reads_what_it_observes(seed: int) -> None:
    tasks = {"player_0": ltlc.Task("F high", "zeta-discount"), "player_1": ltlc.Task("G !low", "two-discount")}
    env = LTLParallelWrapper(Line(), tasks, own_labels, extra_labels="ignore", warn_discount=False)
    plain, random = Line(), np.random.default_rng(seed)
    env.reset(seed=seed)
    first, _ = plain.reset()
    hands = {agent: Followed(tasks[agent], own_labels(first[agent])) for agent in NAMES}
    while env.agents:
        actions = {agent: int(random.integers(3)) for agent in env.agents}
        seen, rewards, ended, cut, _ = env.step(actions)
        expected = plain.step(actions)
        found = {agent: hands[agent].read(own_labels(expected[0][agent])) for agent in NAMES}
        assert {agent: seen[agent]["automaton"] for agent in NAMES} == {a: hand.state for a, hand in hands.items()}
        stopped = any(stop == 1 for _, _, stop in found.values())
        assert ended == {agent: found[agent][2] == 1 for agent in NAMES}
        assert all(ended[agent] or cut[agent] for agent in NAMES) == (stopped or expected[3]["player_0"])
        assert bool(env.agents) == (not stopped and bool(plain.agents))
        if not any(ended.values()):
            assert rewards == {agent: reward for agent, (reward, _, _) in found.items()}


def test_agents_without_a_task_are_left_as_they_are() -> None:
    env = LTLParallelWrapper(Line(), {"player_1": "F high"}, own_labels, extra_labels="ignore", warn_discount=False)
    seen, infos = env.reset(seed=0)
    assert env.observation_space("player_0") == SEEN
    assert seen["player_0"].shape == (2,) and "ltl" not in infos["player_0"]
    _, rewards, *_ = env.step(dict.fromkeys(NAMES, 1))
    assert rewards["player_0"] == 7


def test_where_the_environment_ends_an_agent_its_last_letter_is_for_ever() -> None:
    task = ltlc.Task("G F low", "zeta-discount")
    env = LTLParallelWrapper(Line(end=0), {"player_0": task}, own_labels, extra_labels="ignore", warn_discount=False)
    env.reset(seed=0)
    _, rewards, ended, _, infos = env.step({"player_0": 0, "player_1": 1})
    assert ended == {"player_0": True, "player_1": False}
    ltl = infos["player_0"]["ltl"]
    assert rewards["player_0"] > task.tables.reward[0].max()
    assert rewards["player_0"] == pytest.approx(ltl["reward"])
    assert env.agents == ["player_1"]


def played(env: Any, seed: int, steps: int = 100) -> list[tuple[str, Any, float, bool, bool, Any]]:
    random, log = np.random.default_rng(seed), []
    env.reset(seed=seed)
    for agent in env.agent_iter(steps):
        seen, reward, ended, cut, info = env.last()
        log.append((agent, seen, reward, ended, cut, info))
        env.step(None if ended or cut else int(random.integers(3)))
    return log


@pytest.mark.parametrize("seed", range(4))
def test_turns_with_a_task_for_each_agent(seed: int) -> None:
    tasks = {agent: ltlc.Task("G F high", "two-discount") for agent in NAMES}
    log = played(LTLAECWrapper(Turns(), tasks, own_labels, extra_labels="ignore", warn_discount=False), seed)
    for agent in NAMES:
        rows = [row for row in log if row[0] == agent]
        hand = Followed(tasks[agent], own_labels(rows[0][1]["observation"]))
        assert rows[0][2] == 0
        for _, seen, reward, _, _, info in rows[1:]:
            expected = hand.read(own_labels(seen["observation"]))
            assert seen["automaton"] == hand.state
            assert (reward, info["ltl"]["discount"]) == pytest.approx(expected[:2])
        assert rows[-1][4]  # cut


@pytest.mark.parametrize("seed", range(4))
def test_turns_with_one_task_for_all(seed: int) -> None:
    task = ltlc.Task("G F met", "two-discount")
    log = played(LTLAECWrapper(Turns(), task, joint_labels, extra_labels="ignore", warn_discount=False), seed)
    moves, places = np.random.default_rng(seed), {"player_0": 1, "player_1": 3}
    hand = Followed(task, set())
    since: dict[str, list[tuple[float, float]]] = {agent: [] for agent in NAMES}
    for agent, seen, reward, _, cut, info in log:
        total, weight = 0.0, 1.0
        for paid, discount in since[agent]:
            total, weight = total + weight * paid, weight * discount
        assert seen["automaton"] == hand.state
        assert (reward, info["ltl"]["discount"]) == pytest.approx((total, weight))
        if not cut:
            since[agent] = []
            places[agent] = min(max(places[agent] + int(moves.integers(3)) - 1, 0), 4)
            row = hand.read({"met"} if places["player_0"] == places["player_1"] else set())
            for rows in since.values():
                rows.append(row[:2])
    assert log[-1][4]


@pytest.mark.filterwarnings("ignore::UserWarning", "ignore::DeprecationWarning")
@pytest.mark.parametrize("task", ["F(key & F met)", {"player_0": "F high"}])
def test_pettingzoo_finds_no_fault(task: Any) -> None:
    test = pytest.importorskip("pettingzoo.test", reason="its tests need pygame", exc_type=ImportError)
    labels = joint_labels if isinstance(task, str) else own_labels
    more = {"extra_labels": "ignore", "warn_discount": False, "observation": "flat"}
    test.parallel_api_test(LTLParallelWrapper(Line(), task, labels, **more), num_cycles=50)
    test.api_test(LTLAECWrapper(Turns(), task, labels, **more), num_cycles=50)


def test_the_task_of_an_agent_ends_the_episode_of_all_in_turns() -> None:
    env = LTLAECWrapper(Turns(), {"player_0": "F high"}, own_labels, extra_labels="ignore", warn_discount=False)
    env.reset(seed=0)
    over: dict[str, tuple[bool, bool]] = {}
    for agent in env.agent_iter(100):
        _, _, ended, cut, _ = env.last()
        if ended or cut:
            over[agent] = ended, cut
        env.step(None if ended or cut else 2)
    stops = ltlc.Task("F high").tables.stop.max() == 1
    assert not stops or over == {"player_0": (True, False), "player_1": (False, True)}


def test_wrong_input_is_told() -> None:
    with pytest.raises(UnknownNameError, match="unknown agent 'player_2'"):
        LTLParallelWrapper(Line(), {"player_2": "F high"}, own_labels)
    with pytest.raises(InvalidArgumentError, match="agents may choose differently"):
        LTLParallelWrapper(Line(), ltlc.Task("F G met | F G key", "eventual"), joint_labels)


def test_a_missing_library_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("pettingzoo")]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.delitem(sys.modules, "ltlc.bridges.pettingzoo")
    with pytest.raises(MissingProgramError, match="pip install pettingzoo"):
        import ltlc.bridges.pettingzoo  # noqa: F401
