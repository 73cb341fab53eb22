"""Policies of every kind get the same verdict, exact where that can be, and intervals that hold whenever one stops."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.wrappers import TimeLimit, TransformObservation

import ltlc
from ltlc.envs import GridWorld, LTLWrapper, labelled_mdp
from ltlc.errors import InvalidArgumentError
from ltlc.judging import Sample, actor_of, judge
from ltlc.mdp import Judge
from ltlc.mdp.estimate import probability

LAKE = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}
FORMULA = "F goal & G !hole"
MAP = ("S..k", ".##.", "..x.", "...g")
GRID = {"k": "key", "g": "goal", "x": "pit"}


def grid(slip: float = 0.1) -> GridWorld:
    return GridWorld(MAP, labels=GRID, slip=slip, actions=4)


def task() -> ltlc.Task:
    return ltlc.Task("F(key & F goal) & G !pit")


def random_table(env: Any, of: ltlc.Task, seed: int) -> np.ndarray[Any, Any]:
    judge_ = Judge(labelled_mdp(env), of)
    return np.random.default_rng(seed).integers(4, size=judge_.reached.shape)


def test_the_judge_is_a_name_of_the_package() -> None:
    assert ltlc.judge is judge


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("mode", ["dict", "flat", "index"])
def test_a_function_is_judged_as_its_table(mode: str, seed: int) -> None:
    of, world = task(), grid()
    table = random_table(world, of, seed)
    expected = Judge(labelled_mdp(world), of).judge(table)
    env = TimeLimit(LTLWrapper(world, of, observation=mode), 50)  # type: ignore[arg-type]
    n = of.tables.n_states

    def act(observation: Any) -> int:
        if mode == "dict":
            return int(table[observation["observation"], observation["automaton"]])
        if mode == "index":
            return int(table[divmod(observation, n)])
        return int(table[observation[:-n].argmax(), observation[-n:].argmax()])

    found = judge(act, env)
    assert found.exact
    assert found.verdict == expected
    assert judge(table, env).verdict == expected


def test_probabilities_are_judged_as_such() -> None:
    of, world = task(), grid()
    found = judge(lambda observation: np.full(4, 0.25), world, of)
    expected = Judge(labelled_mdp(world), of).judge(np.full((16, of.tables.n_states, 4), 0.25))
    assert found.satisfaction == pytest.approx(expected.satisfaction, abs=1e-12)
    assert found.bounds[0] <= found.satisfaction <= found.bounds[1]


def test_observations_may_be_changed_outside() -> None:
    of, world = task(), grid()
    table = random_table(world, of, 5)
    wrapped = LTLWrapper(world, of, observation="index")
    shifted = TransformObservation(wrapped, lambda seen: seen + 7, wrapped.observation_space)
    found = judge(lambda seen: table[divmod(seen - 7, of.tables.n_states)], shifted)
    assert found.verdict == Judge(labelled_mdp(world), of).judge(table)


class Doubled(gym.Wrapper[Any, Any, Any, Any]):
    def step(self, action: Any) -> Any:
        self.env.step(action)
        return self.env.step(action)


def test_what_may_change_the_model_is_sampled() -> None:
    found = judge(lambda observation: 2, Doubled(gym.make("FrozenLake-v1")), FORMULA, labels=LAKE, episodes=20)
    assert not found.exact
    assert "Doubled" in found.why_sampled
    with pytest.raises(InvalidArgumentError, match="exactly: Doubled may change"):
        judge(lambda observation: 2, Doubled(gym.make("FrozenLake-v1")), FORMULA, labels=LAKE, exact=True)


class Remembering:
    def __init__(self) -> None:
        self.steps = 0

    def reset(self) -> None:
        self.steps = 0

    def __call__(self, observation: Any) -> int:
        self.steps += 1
        return self.steps % 4


def test_policies_with_memory_or_of_chance_are_sampled() -> None:
    random = np.random.default_rng(0)
    for policy in (Remembering(), lambda observation: random.integers(4)):
        found = judge(policy, "FrozenLake-v1", FORMULA, labels=LAKE, episodes=10)
        assert not found.exact
        assert found.sample is not None and found.sample.episodes == 10


@pytest.mark.parametrize("reward", ["zeta-reach", "zeta-discount", "thesis"])
def test_samples_agree_with_the_exact_answer_whatever_ends_episodes(reward: str) -> None:
    of = ltlc.Task("!pit U key", reward)
    policy = np.full((16, of.tables.n_states), 1)
    policy[:3], policy[3] = 1, 2
    env = LTLWrapper(grid(0.3), of, observation="dict")
    exact = judge(policy, env).satisfaction

    def act(observation: Any) -> int:
        return int(policy[observation["observation"], observation["automaton"]])

    found = judge(act, TimeLimit(env, 300), exact=False, episodes=400, confidence=0.999)
    low, high = found.bounds
    assert 0.05 < exact < 0.95
    assert low <= exact <= high
    assert env.stops
    assert str(found).startswith("satisfies !pit U key with a probability between")


def test_undecided_words_count_on_neither_side() -> None:
    found = judge(lambda observation: 0, "FrozenLake-v1", "G F goal", labels={"goal": lambda s: False}, exact=False,
                  episodes=30, max_steps=2)  # fmt: skip
    assert found.sample is not None
    assert found.sample.undecided == 30
    assert found.bounds == (0.0, 1.0)


def test_it_stops_where_the_interval_is_narrow() -> None:
    found = judge(lambda observation: 2, "FrozenLake-v1", FORMULA, labels=LAKE, exact=False, precision=0.5)
    assert found.sample is not None
    assert found.sample.episodes < 100
    assert found.bounds[1] - found.bounds[0] <= 0.5


@pytest.mark.parametrize("truth", [0.02, 0.5, 0.9])
def test_anytime_intervals_hold_at_all_times_at_once(truth: float) -> None:
    # An ordinary interval that is looked at after each trial misses the truth in half of such sequences.
    random, missed, ordinary = np.random.default_rng(4), 0, 0
    looks = np.unique(np.geomspace(1, 2000, 40).astype(int))
    for _ in range(100):
        successes = np.cumsum(random.random(2000) < truth)
        any_time = [probability(int(successes[n - 1]), int(n), method="anytime") for n in looks]
        once = [probability(int(successes[n - 1]), int(n), method="clopper-pearson") for n in looks]
        missed += any(not e.low <= truth <= e.high for e in any_time)
        ordinary += any(not e.low <= truth <= e.high for e in once)
    assert missed <= 5 + 4  # 5 % of 100, and two standard deviations
    assert ordinary > missed


def test_anytime_intervals_at_the_ends() -> None:
    assert probability(0, 5, method="anytime").low == 0
    assert probability(5, 5, method="anytime").high == 1
    assert probability(1, 10**6, method="anytime").low > 0
    widths = [probability(n // 2, n, method="anytime") for n in (10, 100, 1000)]
    assert np.all(np.diff([e.high - e.low for e in widths]) < 0)


def test_a_network_is_judged_by_its_best_scores() -> None:
    torch.manual_seed(0)
    of, world = task(), grid()
    n = of.tables.n_states
    network = torch.nn.Linear(16 + n, 4)
    seen = torch.eye(16).repeat_interleave(n, 0), torch.eye(n).repeat(16, 1)
    scores = network(torch.cat(seen, 1)).detach().numpy().reshape(16, n, 4)
    assert judge(network, world, of).satisfaction == Judge(labelled_mdp(world), of).satisfaction(scores.argmax(2))
    drawn = np.exp(scores.astype(np.float64))
    found = judge(network, world, of, deterministic=False)
    expected = Judge(labelled_mdp(world), of).satisfaction(drawn / drawn.sum(2, keepdims=True))
    assert found.satisfaction == pytest.approx(expected, abs=1e-6)
    with pytest.raises(InvalidArgumentError, match="scores discrete actions"):
        actor_of(network, gym.spaces.Box(0, 1, (2,)))
    with pytest.raises(InvalidArgumentError, match=r"scores of shape \(\d+, 3\)"):
        judge(torch.nn.Linear(16 + n, 3), world, of)


def test_choices_of_pairs_are_masked() -> None:
    of = ltlc.Task("(F G goal | F G key) & G !pit", "eventual")
    assert of.tables.n_choices > 0
    env = LTLWrapper(grid(), of, warn_discount=False)

    def act(observation: Any, mask: Any) -> int:
        return int(np.flatnonzero(mask)[-1])  # chooses a pair where it can

    found = judge(act, env)
    assert found.exact
    sampled = judge(act, TimeLimit(env, 30), exact=False, episodes=5)
    assert sampled.sample is not None and sampled.sample.episodes == 5


def test_the_chain_of_a_policy_is_written(tmp_path: Path) -> None:
    found = judge(lambda observation: 2, "FrozenLake-v1", FORMULA, labels=LAKE)
    exported = found.export(tmp_path)
    assert exported.model.read_text().startswith("dtmc")
    assert "goal" in exported.properties.read_text()
    sampled = judge(lambda observation: 2, "FrozenLake-v1", FORMULA, labels=LAKE, exact=False, episodes=2)
    with pytest.raises(InvalidArgumentError, match="no Markov chain to write"):
        sampled.export(tmp_path)
    assert found.to_dict()["exact"] and not sampled.to_dict()["exact"]


@pytest.mark.peer
@pytest.mark.parametrize("seed", range(3))
def test_storm_finds_the_same_in_the_chain(seed: int, tmp_path: Path) -> None:
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    of, world = ltlc.Task("!pit U (key & (!pit U goal))"), grid()
    table = np.random.default_rng(seed).dirichlet(np.ones(4), size=(16, of.tables.n_states))

    def act(seen: Any) -> Any:
        return table[seen["observation"], seen["automaton"]]

    found = judge(act, world, of)
    exported = found.export(tmp_path)
    program = stormpy.parse_prism_program(str(exported.model))
    (wanted,) = stormpy.parse_properties(exported.properties.read_text(), program)
    built = stormpy.build_model(program, [wanted])
    value = stormpy.model_checking(built, wanted)
    at = getattr(value, "at", None) or value.get_value
    assert 0 < found.satisfaction < 1
    assert at(built.initial_states[0]) == pytest.approx(found.satisfaction, abs=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: judge(lambda o: 0, grid()), "pass a task"),
        (lambda: judge("mine", grid(), "F goal"), "policy is of type str"),
        (lambda: judge(lambda o: 0, gym.make_vec("FrozenLake-v1"), "F goal"), "a single environment of Gymnasium"),
        (lambda: judge(lambda o: 0, LTLWrapper(grid(), "F goal"), "F key"), "wrapped for F goal"),
        (lambda: judge(lambda o: 0, LTLWrapper(grid(), "F goal"), labels=GRID), "leave them out"),
        (lambda: judge(lambda o: "up", grid(), "F goal"), "whole number"),
        (lambda: judge(lambda o: 0.5, grid(), "F goal"), "whole number"),
        (lambda: judge(lambda o: [0.5, 0.5], grid(), "F goal"), r"shape \(2,\)"),
        (lambda: judge(np.zeros((3, 3), dtype=int), grid(), "F goal"), "policy of shape"),
        (lambda: judge(np.zeros((16, 2), dtype=int), "CartPole-v1", "F a", labels=lambda o: set()), "exactly"),
        (lambda: judge(lambda o: 0, grid(), "F goal", episodes=0), "at least 1"),
        (lambda: judge(lambda o: 0, grid(), "F goal", confidence=1), "between 0 and 1"),
    ],
)
def test_wrong_input_is_told(call: Any, message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        call()


def test_a_sample_says_what_it_knows() -> None:
    estimate = Sample(50, 50, 0).satisfaction
    assert (estimate.value, estimate.n) == (0.5, 100)
    assert estimate.low + estimate.high == pytest.approx(1)
    assert Sample(50, 0, 50).satisfaction.high == 1


@pytest.mark.slow
def test_agents_of_worlds_that_cannot_be_counted_are_sampled() -> None:
    from ltlc.agents import DoubleDQN, DQNConfig

    world, of = gym.make("ltlc/FlatWorld-v0"), ltlc.Task("F orange & G !blue")
    actions = cast(gym.spaces.Discrete, world.action_space)
    agent = DoubleDQN(world.observation_space, int(actions.n), of.tables, DQNConfig(hidden=(8,)))
    found = judge(agent, world, of, episodes=10)
    assert not found.exact and found.sample is not None and found.sample.episodes == 10
    assert judge(agent, world, of, episodes=10) == found
    with pytest.raises(InvalidArgumentError, match="the policy was made for"):
        judge(agent, LTLWrapper(world, of, observation="flat"), episodes=2)


@pytest.mark.slow
def test_agents_with_tables_are_sampled_where_the_dynamics_are_not_known() -> None:
    from ltlc.agents import FittedQConfig, train

    class Coin(gym.Env[Any, Any]):
        observation_space, action_space = gym.spaces.Discrete(3), gym.spaces.Discrete(2)

        def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
            super().reset(seed=seed)
            return 0, {}

        def step(self, action: Any) -> tuple[int, float, bool, bool, dict[str, Any]]:
            return int(action) + 1, 0.0, True, False, {}

    heads = {"heads": lambda seen: seen == 1}
    envs = ltlc.LTLVectorWrapper(gym.vector.SyncVectorEnv([Coin] * 2), "F heads", heads)
    result = train(envs, FittedQConfig(total_steps=2000))
    found = judge(result.agent, Coin(), "F heads", labels=heads, episodes=50)
    assert found.sample is not None and found.sample.satisfied == 50
    with pytest.raises(InvalidArgumentError, match="the dynamics of Coin are not known"):
        judge(result.agent, Coin(), "F heads", labels=heads, exact=True)
    with pytest.raises(InvalidArgumentError, match="TrainingResult; take its attribute agent"):
        judge(result, Coin(), "F heads", labels=heads)
