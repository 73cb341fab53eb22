"""The temperature of a policy, by trial: when another one is taken, and what counts as a success."""

import signal
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from ltlc.agents import POLICY_FILE, DoubleDQN, DQNConfig, train
from ltlc.agents.double_dqn.temperature import Trial, _successes, try_temperatures
from ltlc.agents.training.collect import Interface
from ltlc.envs import LTLVectorWrapper, VectorFlatWorld, VectorGridWorld
from ltlc.envs.success import accepted_forever
from ltlc.task import Task


class Presses(gym.Env[Any, int]):
    """Two buttons for 20 steps; shows which one was pressed last."""

    observation_space = spaces.Box(-1.0, 1.0, (1,))
    action_space = spaces.Discrete(2)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.time = 0
        return np.zeros(1, dtype=np.float32), {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.time += 1
        shown = np.array([2 * int(action) - 1], dtype=np.float32)
        return shown, 0.0, False, self.time == 20, {}


def presses(formula: str, copies: int = 50) -> LTLVectorWrapper:
    envs = SyncVectorEnv([Presses] * copies)
    return LTLVectorWrapper(envs, Task(formula), lambda shown: {"a": shown[0] < 0, "b": shown[0] > 0})


def preferring_b(env: LTLVectorWrapper, outputs: float, **changes: Any) -> DoubleDQN:
    """An agent whose output of the second action is by so much larger in every state."""
    interface = Interface.of(env)
    config, tables = DoubleDQN.fitted(DQNConfig(hidden=(4,), waves=0, total_steps=20_000, **changes), interface)
    agent = DoubleDQN(interface.space, interface.n_actions, tables, config)
    last = [layer for layer in agent.policy_network.modules() if isinstance(layer, torch.nn.Linear)][-1]
    with torch.no_grad():
        last.weight.zero_()
        last.bias.view(-1, 2)[:] = torch.tensor([0.0, outputs])
    return agent


def never() -> bool:
    return False


@pytest.mark.parametrize(
    ("formula", "outputs", "taken"),
    [
        ("G !a", 0.2, 0.0),  # drawing at .1 presses the other button in 12 % of the steps
        ("G !a", 1.0, 0.1),
        ("F a & F b", 0.1, 0.1),  # which nothing greedy does
        ("F a & F b", 0.6, 0.3),
        ("F b", 0.0, 0.1),
        ("G !b", 9.0, 0.1),  # nothing does
    ],
)
def test_another_temperature_is_taken_where_it_surely_does_better(formula: str, outputs: float, taken: float) -> None:
    env = presses(formula)
    agent = preferring_b(env, outputs)
    before = agent.chances(torch.tensor([[0.3, 0.4]]))
    message = agent.settle(Interface.of(env), 5, never)
    assert agent.config.temperature == taken
    assert (message == "") == (taken == 0.1) and (not message or f"temperature {taken} by trial" in message)
    assert before is not None and (taken == 0.1) == np.array_equal(
        before, agent.chances(torch.tensor([[0.3, 0.4]])) if taken else [[0, 1]]
    )
    again = preferring_b(env, outputs)
    assert again.settle(Interface.of(env), 5, never) == message


def test_nothing_is_tried_where_somebody_has_chosen_or_observations_are_numbered() -> None:
    env = presses("G !a")
    agent = preferring_b(env, 0.2, temperature=0.1)
    assert agent.settle(Interface.of(env), 0, never) == "" and agent.config.temperature == 0.1
    grid = Interface.of(LTLVectorWrapper(VectorGridWorld("S.A", 2), Task("F A")))
    assert DoubleDQN.fitted(DQNConfig(), grid)[0].temperature == 0.1
    assert DQNConfig.thesis().temperature == 0.0


def test_a_trial_is_given_up_on_request_and_takes_a_fifth_of_the_training() -> None:
    env = presses("G !a")
    agent = preferring_b(env, 0.2)
    asked: list[int] = []

    def third() -> bool:
        asked.append(1)
        return len(asked) == 3

    assert agent.settle(Interface.of(env), 0, third) == "" and agent.config.temperature is None
    steps = 0
    step = env.step

    def counted(actions: Any) -> Any:
        nonlocal steps
        steps += len(actions)
        return step(actions)

    env.step = counted  # type: ignore[method-assign]
    for total in (400, 4_000, 6_000, 12_345):
        steps = 0
        trials = try_temperatures(agent._at, Interface.of(env), total, 0, never)
        assert steps <= 3 * total / 5 and bool(trials) == (total > 4_000)


def test_a_difference_is_taken_for_more_than_chance_as_often_as_it_should_be() -> None:
    random, n, wrong = np.random.default_rng(0), 64, 0
    for _ in range(2_000):
        one, two = (Trial(0.0, int(random.binomial(n, 0.9)), n) for _ in range(2))
        wrong += one.surely_better(two)
    assert 0.01 < wrong / 2_000 < 0.04
    assert Trial(0.0, 64, 64).surely_better(Trial(0.1, 40, 64))
    assert not Trial(0.0, 64, 64).surely_better(Trial(0.1, 64, 64))


@pytest.mark.parametrize(
    "formula",
    [
        "F red & G !blue",
        "GF red",
        "FG !red",
        "!blue U red",
        "F G red | F blue",
        "G(red -> F blue)",
        "X" * 18 + " F red",
    ],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_successes_are_those_of_each_episode_by_itself(formula: str, seed: int) -> None:
    n, limit = 40, 30
    circles = [("red", 0.4, 0.0, 0.3), ("blue", -0.4, 0.0, 0.3)]
    task = Task(formula)
    flat = VectorFlatWorld(n, circles=circles, half_width=0.6, stride=0.1, max_episode_steps=limit)
    env = LTLVectorWrapper(flat, task, extra_labels="ignore")
    interface = Interface.of(env)
    config, tables = DoubleDQN.fitted(DQNConfig(hidden=(4,), temperature=3.0, action_repeat=1), interface)
    agent = DoubleDQN(interface.space, interface.n_actions, tables, config)
    found = _successes(agent, interface, 2 * limit, seed, never)
    assert found is not None

    holds = accepted_forever(task.automaton)
    wanted: list[bool] = []
    agent.reseed(seed)
    used = 0
    while used < 2 * limit and len(wanted) < 100:
        observations, infos = env.reset(seed=seed + len(wanted) // n)
        accepted, over, good = ([False] * n for _ in range(3))
        while used < 2 * limit and not all(over):
            chosen = agent.packed_policy(agent.encoder.pack(interface.base(observations)), infos["ltl"]["state"])
            observations, _, terminated, truncated, infos = env.step(chosen)
            used += 1
            ltl = infos["ltl"]
            for i in range(n):
                if over[i] or not ltl["valid"][i]:
                    continue
                accepted[i] |= bool(ltl["accepting"][i])
                state = int(env.automaton_state[i])
                good[i] = accepted[i]
                if state in task.automaton.deadlocks or ltl["violated"][i]:
                    good[i], over[i] = False, True
                elif state in task.automaton.accepting_sinks:
                    good[i], over[i] = True, True
                elif ltl["base_terminated"][i]:
                    good[i] = bool(holds[state, ltl["letter_class"][i]])
                elif terminated[i]:  # by the task, since the pair that was chosen cannot be satisfied
                    good[i] = False
                over[i] = over[i] or bool(terminated[i] or truncated[i])
        if all(over):
            wanted += good
    assert found.tolist() == wanted and 0 < sum(wanted) < len(wanted)


@pytest.mark.slow
def test_what_is_saved_is_the_temperature_that_was_chosen(tmp_path: Path) -> None:
    config = DQNConfig(total_steps=3_000, hidden=(8,), learning_rate=1e-9, final_learning_rate=1e-9)
    first = train(presses("G !a", 10), config, folder=tmp_path)  # which has learned nothing
    saved = DoubleDQN.load(tmp_path / POLICY_FILE)
    assert saved.config.temperature == first.agent.config.temperature is not None
    content = (tmp_path / POLICY_FILE).read_bytes()
    again = train(presses("G !a", 10), folder=tmp_path, resume=True)
    assert again.agent.config == first.agent.config and again.message == first.message
    assert (tmp_path / POLICY_FILE).read_bytes() == content


@pytest.mark.slow
def test_ctrl_c_while_trying_keeps_what_was_learned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = DQNConfig(total_steps=2_000, hidden=(8,))
    env = presses("G !a", 10)
    settle = DoubleDQN.settle

    def interrupted(*arguments: Any) -> str:
        signal.raise_signal(signal.SIGINT)
        return settle(*arguments)

    monkeypatch.setattr(DoubleDQN, "settle", interrupted)
    first = train(env, config, folder=tmp_path)
    assert first.interrupted and first.saved_steps == first.steps >= 2_000
    assert DoubleDQN.load(tmp_path / POLICY_FILE).config.temperature is None
    monkeypatch.undo()
    second = train(env, folder=tmp_path, resume=True)
    assert not second.interrupted and second.agent.config.temperature is not None
