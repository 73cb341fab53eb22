"""Where the environment terminates, its last letter goes on: in the judge and the rewards."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from mdp_cases import GOAL_OR_DOCK, goal_or_dock
from random_ltl import random_formula
from random_worlds import random_task, random_world, united
from scipy import sparse

import ltlc
from ltlc.automata import DRA
from ltlc.envs import LTLVectorWrapper, LTLWrapper, labelled_mdp
from ltlc.faithful import Candidate, faithfulness
from ltlc.mdp import (
    Judge,
    LabelledMDP,
    Product,
    RewardProduct,
    expected_return,
    max_satisfaction_probability,
    optimal_return,
    satisfaction_probability,
)
from ltlc.prism import with_sure_labels
from ltlc.rewards import SCHEMES, Shaped, get_scheme
from ltlc.task import Task

NEAR_THE_LIMIT = (
    Candidate.from_name("zeta-reach", zeta=1 - 1e-5),
    Candidate.from_name("zeta-discount", zeta=1 - 1e-5),
    Candidate.from_name("two-discount", gamma_accept=1 - 1e-5, gamma=1 - 1e-10),
    Candidate.from_name("eventual", gamma=1 - 1e-5),
    Candidate.from_name("frontier", eta=1 - 1e-5),
    Candidate.from_name("parity", epsilon=1e-3),
    Candidate.from_name("parity", epsilon=1e-3, mode="terminate"),
)
SHAPED = tuple(
    Candidate(f"shaped {c.name}", Shaped(c.scheme, 1.0))
    for c in NEAR_THE_LIMIT
    if c.scheme.name in ("two-discount", "parity")
)


@pytest.mark.parametrize("formula", GOAL_OR_DOCK)
@pytest.mark.parametrize("terminal", [(), (1,), (2,), (3,), (1, 3), (1, 2, 3)])
def test_ending_at_the_goal_is_as_good_as_staying_there(formula: str, terminal: tuple[int, ...]) -> None:
    report = faithfulness(goal_or_dock(*terminal), formula, (*NEAR_THE_LIMIT, *SHAPED))
    assert report.maximum == pytest.approx(0.9)
    assert [row.satisfaction for row in report.rows] == pytest.approx([0.9] * len(report.rows))


def test_cut_is_what_it_was() -> None:
    cut = [replace(candidate, on_termination="cut") for candidate in NEAR_THE_LIMIT]
    report = faithfulness(goal_or_dock(1), GOAL_OR_DOCK[0], cut)
    assert [row.satisfaction for row in report.rows] == pytest.approx([0.5] * len(cut))


@pytest.mark.parametrize("size", ["4x4", "8x8"])
def test_the_default_reward_on_the_frozen_lake_as_gymnasium_makes_it(size: str) -> None:
    env = gym.make("FrozenLake-v1", map_name=size)
    tiles = env.unwrapped.desc.ravel()  # type: ignore[attr-defined]
    labels = {"goal": lambda s: tiles[s] == b"G", "hole": lambda s: tiles[s] == b"H"}
    mdp = labelled_mdp(env, labels)
    for formula in ("G F goal", "F G goal", "!hole U goal", "F goal & G !hole", "F G hole | F G goal"):
        task = Task(formula)
        judge = Judge(mdp, task)
        assert judge.satisfaction(judge.optimal_policy) >= judge.maximum.probability - 1e-3, formula


def check_faithful(seeds: Sequence[int], candidates: tuple[Candidate, ...]) -> None:
    """Optimal policies of all candidates in random worlds that end, one for each seed, attain Pmax.

    Worlds of the same automaton are solved side by side. In none can a policy exceed Pmax, so its mean over k worlds is
    short by at most 1e-3 / k only where it is short by at most 1e-3 in each.
    """
    groups: dict[str, tuple[DRA, list[LabelledMDP]]] = {}
    for seed in seeds:
        automaton = replace(ltlc.compile(random_task(random.Random(seed))), formula=None, translator=None)
        worlds = groups.setdefault(automaton.to_json(), (automaton, []))[1]
        worlds.append(random_world(np.random.default_rng(seed)))
    for automaton, worlds in groups.values():
        report = faithfulness(united(worlds), automaton, candidates)
        for row in report.rows:
            if row.satisfaction is None:
                assert "colours with epsilon" in (row.problem or ""), (seeds, row)
            else:
                assert row.satisfaction >= report.maximum - 1e-3 / len(worlds), (seeds, automaton.to_json(), row)


def test_worlds_side_by_side_come_to_the_mean_of_each() -> None:
    worlds = [random_world(np.random.default_rng(seed)) for seed in range(20)]
    automaton = ltlc.compile(GOAL_OR_DOCK[2].replace("goal", "a").replace("dock", "b"))
    products = [Product(world, automaton) for world in (united(worlds), *worlds)]
    mean, *each = (max_satisfaction_probability(product).probability for product in products)
    assert mean == pytest.approx(np.mean(each)) and len({*each}) > 2


@pytest.mark.slow
@pytest.mark.parametrize("block", range(2))
def test_optimal_policies_in_worlds_that_end_attain_the_maximum(block: int) -> None:
    check_faithful(range(100 * block, 100 * block + 100), NEAR_THE_LIMIT)


@pytest.mark.slow
def test_so_do_those_of_shaped_rewards() -> None:
    check_faithful(range(500, 600), SHAPED)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(10))
def test_so_it_is_in_two_thousand_worlds(block: int) -> None:
    formulas = {seed: str(random_task(random.Random(seed))) for seed in range(1000, 3000)}
    alike = sorted(formulas, key=lambda seed: (len(formulas[seed]), formulas[seed]))
    check_faithful(alike[200 * block : 200 * block + 200], (*NEAR_THE_LIMIT, *SHAPED))


def test_ties_do_not_keep_policy_iteration_going() -> None:
    """Rounding once made two equally good policies take turns here for ever."""
    check_faithful([1267], NEAR_THE_LIMIT[:2])


def by_hand(mdp: LabelledMDP) -> LabelledMDP:
    """The process without terminal states: instead, states for each letter that stay as they are."""
    n, letters = mdp.n_states, len(mdp.letters)
    over = np.flatnonzero(mdp.terminal)
    size, shown = n + letters * len(over), mdp.label_probability.toarray()
    p = np.zeros((mdp.n_actions, size, size))
    labels, start = np.zeros((size, letters)), np.zeros(size)
    start[:n], labels[:n] = mdp.start, shown
    for action in range(mdp.n_actions):
        p[action, :n, :n] = mdp.transitions[action].toarray()
    for i, state in enumerate(over):
        new = n + letters * i + np.arange(letters)
        p[:, :, new] = p[:, :, [state]] * shown[state]
        start[new] = start[state] * shown[state]
        p[:, :, state], start[state] = 0, 0
        p[:, state, :] = p[:, new, :] = 0
        p[:, state, state] = 1
        p[:, new, new] = 1
        labels[new] = np.eye(letters)
    return LabelledMDP(
        mdp.aps, tuple(sparse.csr_array(one) for one in p), mdp.letters, sparse.csr_array(labels),
        initial_distribution=start,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("initial_label", ["read", "skip"])
def test_the_last_letter_is_drawn_once(initial_label: Any) -> None:
    """Pmax and optimal returns are those of a process in which each final letter has a state of its own."""
    rng = random.Random(4)
    for seed in range(60):
        mdp = random_world(np.random.default_rng([seed, 1]), ends=0.5, chance=0.5)
        other, sure = by_hand(mdp), with_sure_labels(mdp)[0]
        automaton = ltlc.compile(random_formula(rng, rng.randint(3, 9)))
        maxima = [
            max_satisfaction_probability(Product(one, automaton, initial_label=initial_label)).probability
            for one in (mdp, sure, other)
        ]
        assert maxima == pytest.approx([maxima[0]] * 3, abs=1e-6)
        for scheme in (get_scheme("two-discount", gamma_accept=0.9, gamma=0.99), get_scheme("parity", epsilon=0.2),
                       get_scheme("thesis"), get_scheme("zeta-reach", zeta=0.9)):  # fmt: skip
            tables = scheme.compile(automaton)
            values = []
            for one in (mdp, sure, other):
                product = RewardProduct(one, tables, initial_label=initial_label)
                used = product.initial > 0
                values.append(float(product.initial[used] @ optimal_return(product).value[used]))
            assert values == pytest.approx([values[0]] * 3, abs=1e-6, rel=1e-6), (seed, scheme.name)


def test_a_world_that_begins_at_its_end() -> None:
    """The letter of a terminal first state is drawn once, too: P(G a) is the chance of a."""
    mdp = LabelledMDP.from_arrays(np.ones((1, 1, 1)), aps=("a",), labels=[{"a": 0.3}], terminal=[True])
    for formula, probability in (("G a", 0.3), ("G F a", 0.3), ("F a", 0.3), ("G a | G !a", 1.0), ("a & F !a", 0.0)):
        task = Task(formula, get_scheme("zeta-reach"))
        product = Product(mdp, task.automaton)
        assert max_satisfaction_probability(product).probability == pytest.approx(probability)
        assert satisfaction_probability(product, product.lift(np.zeros(1, dtype=int))).probability == pytest.approx(
            probability
        )
        rewards = RewardProduct(mdp, task.tables)
        assert expected_return(rewards, rewards.lift(np.zeros(1, dtype=int))) <= probability + 1e-9


def test_held_labels_at_the_end_of_the_world() -> None:
    """With miss="hold" the automaton stays where it is for ever, paid as entering its state."""
    p = np.zeros((1, 2, 2))
    p[0, :, 1] = 1
    mdp = LabelledMDP.from_arrays(p, aps=("a",), labels=[{}, {"a": 0.25}], terminal=[False, True])
    tables = get_scheme("thesis", gamma=0.9, terminate_on_accept=False, accepting=5.0).compile(ltlc.compile("G F a"))
    seen, missed = (RewardProduct(mdp, tables, miss=miss) for miss in ("empty", "hold"))
    values = [expected_return(product, product.lift(np.zeros(2, dtype=int))) for product in (seen, missed)]
    assert values == pytest.approx([0.25 * 5 / 0.1 - 0.75 * 1 / 0.1] * 2)  # the automaton held q, where a is missing


class Walk(gym.Env[Any, Any]):
    """A deterministic MDP as an environment that labels itself; it may say that it is truncated where it ends, too."""

    def __init__(
        self, following: np.ndarray, terminal: np.ndarray, labels: list[set[str]], also_truncates: bool = False
    ) -> None:
        self.following, self.terminal, self.labels, self.also_truncates = following, terminal, labels, also_truncates
        self.observation_space = gym.spaces.Discrete(following.shape[1])
        self.action_space = gym.spaces.Discrete(len(following))
        self.state = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.state = 0
        return 0, {"labels": self.labels[0]}

    def step(self, action: Any) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.state = int(self.following[action, self.state])
        over = bool(self.terminal[self.state])
        return self.state, 0.0, over, over and self.also_truncates, {"labels": self.labels[self.state]}


def deterministic_world(rng: np.random.Generator) -> tuple[LabelledMDP, np.ndarray]:
    """Every path ends within 8 steps: states lead to later ones, and the last is terminal."""
    n = 8
    terminal = rng.random(n) < 0.25
    terminal[0], terminal[-1] = False, True
    following = np.array([[s if terminal[s] else rng.integers(s + 1, n) for s in range(n)] for _ in range(2)])
    p = np.zeros((2, n, n))
    for action in range(2):
        p[action, np.arange(n), following[action]] = 1
    labels = [[name for name in "abc" if rng.random() < 0.5] for _ in range(n)]
    return LabelledMDP.from_arrays(p, aps="abc", labels=labels, terminal=terminal), following


def episode(env: Any, policy: np.ndarray, task: Task, vector: bool) -> float:
    """The return of an episode, discounted as the task says; of the first sub-environment of a vector."""
    observation, info = env.reset(seed=0)
    total, weight, over = 0.0, 1.0, False
    at = (lambda x: x[0]) if vector else (lambda x: x)
    while not over:
        action = int(policy[int(at(observation)), int(at(info["ltl"]["state"]))])
        observation, reward, terminated, _, info = env.step(np.array([action, action]) if vector else action)
        over = bool(at(terminated))
        last = info["final_info"] if vector and over and "final_info" in info else info
        assert at(reward) == at(last["ltl"]["reward"])
        total += weight * float(at(reward))
        weight *= float(at(last["ltl"]["discount"]))
    return total


@pytest.mark.parametrize("name", sorted({*SCHEMES} - {"zeta-reach"}))
@pytest.mark.parametrize("on_termination", ["repeat", "cut"])
def test_both_wrappers_pay_what_the_reward_product_says(name: str, on_termination: Any) -> None:
    rng, formulas = np.random.default_rng(11), random.Random(11)
    paid = 0
    for case in range(12):
        mdp, following = deterministic_world(rng)
        formula = ("FG a | GF b", "(FG a & GF b) | FG c")[case % 2] if case < 4 else random_formula(formulas, 6)
        automaton = ltlc.compile(formula)
        automaton = automaton if automaton.aps else ltlc.compile("F a")
        mode = ("stay", "initial", "terminate")[case % 3]
        task = Task(automaton, name, shaping=0.5 * (case % 2), on_deadlock=mode, on_termination=on_termination)
        names = [{n for i, n in enumerate(mdp.aps) if letter >> i & 1} & set(automaton.aps)
                 for letter in mdp.letters[mdp.label_probability.indices].tolist()]  # fmt: skip
        product = RewardProduct(mdp, task.tables)
        solution = optimal_return(product)
        policy = np.zeros((mdp.n_states, task.tables.n_states), dtype=int)
        policy[product.mdp_state, product.machine_state] = solution.policy
        exact = expected_return(product, product.lift(policy))
        make = partial(Walk, following, mdp.terminal, names, bool(case % 4 == 3))
        single = LTLWrapper(make(), task, observation="none")
        assert episode(single, policy, task, vector=False) == pytest.approx(exact, rel=1e-12, abs=1e-12)
        for reset in AutoresetMode:
            vector = LTLVectorWrapper(SyncVectorEnv([make] * 2, autoreset_mode=reset), task, observation="none")
            assert episode(vector, policy, task, vector=True) == pytest.approx(exact, rel=1e-12, abs=1e-12)
        paid += task.tables.closing.any()
    assert paid or on_termination == "cut"


def test_truncation_is_not_the_end_of_the_world() -> None:
    class Cut(Walk):
        def step(self, action: Any) -> tuple[int, float, bool, bool, dict[str, Any]]:
            observation, reward, over, _, info = super().step(action)
            return observation, reward, False, over, info

    following, terminal = np.array([[1, 1]]), np.array([False, True])
    task = Task("G F a", "eventual")
    paid = []
    for kind in (Walk, Cut):
        env = LTLWrapper(kind(following, terminal, [set(), {"a"}]), task, observation="none")
        env.reset(seed=0)
        paid.append(env.step(0)[1])
    assert paid == pytest.approx([100.0, 1.0])


def test_a_pair_can_still_be_chosen_at_the_end() -> None:
    """No pair was chosen before the world ended: the last letter decides, and the judge makes the best choice."""
    p = np.zeros((1, 3, 3))
    p[0, 0, [1, 2]] = 0.5
    p[0, [1, 2], [1, 2]] = 1
    mdp = LabelledMDP.from_arrays(p, aps=("a", "b"), labels={1: "a", 2: "b"}, terminal=[False, True, True])
    task = Task("(F G a | F G b) & X(F G a | F G b)", get_scheme("zeta-reach"), acceptance="transition")
    assert task.tables.n_choices
    judge = Judge(mdp, task)
    policy = np.zeros((3, task.tables.n_states), dtype=int)
    assert judge.satisfaction(policy) == pytest.approx(1)
    assert judge.satisfaction(np.eye(judge.words.n_actions)[policy]) == pytest.approx(1)
    assert judge.value == pytest.approx(1)
