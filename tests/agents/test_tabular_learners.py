"""Tabular learners see an environment through reset and step only; what they learn is judged exactly."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import gymnasium
import numpy as np
import pytest

from ltlc.agents import AGENTS, AgentConfig, Progress, train
from ltlc.agents.tabular.config import FuTopcuConfig, LearnerConfig, QLearningConfig, SadighConfig, WangConfig
from ltlc.agents.training.metrics import Row
from ltlc.envs import (
    GridWorld,
    LTLVectorWrapper,
    VectorGridWorld,
    grid_map,
    labelled_mdp,
    recorded_automaton,
    thesis_vector_world,
    thesis_world,
)
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import Judge, LabelledMDP
from ltlc.task import Task

SEEDS = (0, 1)
LEARNERS = [name for name in AGENTS if isinstance(AGENTS[name].defaults, LearnerConfig)]
# Sliding sideways, as on Gymnasium's frozen lake: no policy is safe, so there is something to weigh.
SLIDE = [[1 / 3, 1 / 3, 0, 1 / 3], [1 / 3, 1 / 3, 1 / 3, 0], [0, 1 / 3, 1 / 3, 1 / 3], [1 / 3, 0, 1 / 3, 1 / 3]]
LAKE = grid_map(["S...", ".h.h", "...h", "h..g"], labels={"h": "hole", "g": "goal"}, slip=SLIDE, actions=4)
PATROL = grid_map(["a...", ".#.d", "S..b"], slip=[0.1, 0.0, 0.0, 0.0, 0.0])


def thesis(size: str, name: str, n_envs: int = 64) -> LTLVectorWrapper:
    return LTLVectorWrapper(thesis_vector_world(size, n_envs), Task(recorded_automaton(name), reward="thesis"))


class Learned:
    """What a training came to: the policy, and the last row of metrics."""

    def __init__(self, env: LTLVectorWrapper, config: AgentConfig, agent: str | None = None) -> None:
        rows: list[Row] = []
        result = train(env, config, agent=agent, callback=lambda progress: rows.append(progress.row))
        self.policy = None if result.agent is None else result.agent.policy_table()
        self.result, self.row = result, rows[-1]


def regret(learned: Learned, mdp: LabelledMDP, task: Task) -> float:
    """Part of the optimal discounted return that the policy loses."""
    lost = Judge(mdp, task).regret(learned.policy)
    assert lost is not None
    return lost


def satisfaction(learned: Learned, mdp: LabelledMDP, task: Task) -> tuple[float, float]:
    """The policy's probability to satisfy the formula, and the largest one."""
    judge = Judge(mdp, task)
    return judge.satisfaction(learned.policy), judge.maximum.probability


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", LEARNERS)
def test_nearly_optimal_on_the_small_thesis_world(name: str, seed: int) -> None:
    env, config = thesis("5x5", "phi_4"), AGENTS[name].defaults
    if isinstance(config, QLearningConfig):
        config = dataclasses.replace(config, total_steps=300_000)
    if isinstance(config, SadighConfig):
        config = dataclasses.replace(config, total_steps=60_000)
    learned = Learned(env, dataclasses.replace(config, seed=seed), name)
    mdp = labelled_mdp(thesis_world("5x5"))
    assert regret(learned, mdp, env.task) <= 0.01
    assert satisfaction(learned, mdp, env.task)[0] == 1
    row = learned.row
    assert row.product_states is not None and 0 < row.product_states <= 375
    assert row.steps > 0 and row.seconds > 0
    assert row.accepting_components == (1 if name in ("fu-topcu", "wang") else None)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("config", [
    FuTopcuConfig(accuracy=0.05),
    WangConfig(accuracy=0.05, discount=0.999),
    SadighConfig(total_steps=30_000, gamma=0.999),
], ids=["fu-topcu", "wang", "sadigh"])  # fmt: skip
def test_largest_probability_where_no_policy_is_safe(config: Any, seed: int) -> None:
    env = LTLVectorWrapper(VectorGridWorld(LAKE, 32), Task("!hole U goal", reward="accept"))
    learned = Learned(env, dataclasses.replace(config, seed=seed))
    reached, largest = satisfaction(learned, labelled_mdp(GridWorld(LAKE)), env.task)
    assert largest == pytest.approx(14 / 17)
    assert reached >= largest - 0.01


@pytest.mark.parametrize("config", [FuTopcuConfig(accuracy=0.1), WangConfig(accuracy=0.1)], ids=["fu-topcu", "wang"])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
@pytest.mark.parametrize("formula", ["G F a & G F b & G !d", "F G a | G F b", "(G F a & F G !b) | (G F b & F G !a)"])
def test_goes_on_for_ever(config: Any, formula: str, acceptance: Any) -> None:
    task = Task(formula, reward="thesis", on_deadlock="terminate", acceptance=acceptance)
    learned = Learned(LTLVectorWrapper(VectorGridWorld(PATROL, 32), task), config)
    reached, largest = satisfaction(learned, labelled_mdp(GridWorld(PATROL)), task)
    assert largest == 1
    assert reached >= largest - 0.01


@pytest.mark.parametrize("name", ["fu-topcu", "wang"])
def test_no_policy_without_an_accepting_end_component(name: str) -> None:
    config: Any = AGENTS[name].defaults
    learned = Learned(thesis("5x5", "phi_1"), dataclasses.replace(config, accuracy=0.15))
    assert learned.policy is None
    assert learned.row.accepting_components == 0
    assert learned.row.value == 0
    assert "no accepting end component" in learned.result.message


@pytest.mark.slow
@pytest.mark.parametrize("name", LEARNERS)
def test_the_same_from_the_same_seed(name: str) -> None:
    changes: dict[str, Any] = {"total_steps": 20_000, "seed": 3}
    if hasattr(AGENTS[name].defaults, "accuracy"):
        changes["accuracy"] = 0.2
    config = dataclasses.replace(AGENTS[name].defaults, **changes)
    first, second = (Learned(thesis("5x5", "phi_3"), config, name) for _ in range(2))
    assert first.policy is not None and second.policy is not None
    np.testing.assert_array_equal(first.policy, second.policy)
    assert (first.row.value, first.row.steps) == (second.row.value, second.row.steps)


@pytest.mark.slow
@pytest.mark.parametrize("name", LEARNERS)
def test_a_callback_sees_progress_and_can_stop(name: str) -> None:
    seen: list[Progress] = []

    def callback(progress: Progress) -> bool:
        seen.append(progress)
        return progress.agent is not None

    env = thesis("5x5", "phi_3")
    result = train(env, AGENTS[name].defaults, agent=name, callback=callback)
    assert result.agent is seen[-1].agent and result.agent is not None
    assert result.steps == seen[-1].row.steps
    assert all(before.row.steps <= after.row.steps for before, after in itertools.pairwise(seen))
    judge = Judge(labelled_mdp(thesis_world("5x5")), env.task)
    assert judge.satisfaction(result.agent.policy_table()) <= 1


@pytest.mark.slow
def test_environment_that_ends_its_episodes() -> None:
    holes = {5, 7, 11, 12}
    labels = {"goal": lambda s: s == 15, "hole": lambda s: np.isin(s, list(holes))}
    lake = gymnasium.make_vec("FrozenLake-v1", num_envs=16, vectorization_mode="sync")
    task = Task("F goal & G !hole", reward="accept")
    learned = Learned(LTLVectorWrapper(lake, task, labels), FuTopcuConfig(accuracy=0.15))
    reached, largest = satisfaction(learned, labelled_mdp(gymnasium.make("FrozenLake-v1"), labels), task)
    assert largest == pytest.approx(14 / 17)
    assert reached >= largest - 0.01
    lake.close()


@pytest.mark.slow
def test_q_learning_finds_the_exact_values_where_nothing_is_random() -> None:
    layout = grid_map(["S..a", "....", "b..."])
    env = LTLVectorWrapper(VectorGridWorld(layout, 16), Task("F a & F b", reward="thesis"))
    optimum = Judge(labelled_mdp(GridWorld(layout)), env.task).value
    for config in (
        QLearningConfig(averaging_steps=1),
        QLearningConfig(averaging_steps=1, double=True, counterfactual=False),
    ):
        learned = Learned(env, dataclasses.replace(config, total_steps=40_000))
        assert learned.row.value == pytest.approx(optimum, rel=1e-3)
        assert regret(learned, labelled_mdp(GridWorld(layout)), env.task) == pytest.approx(0, abs=1e-9)


@pytest.mark.slow
def test_counterfactual_updates_learn_from_fewer_steps() -> None:
    mdp, losses = labelled_mdp(thesis_world("5x5")), []
    for counterfactual in (True, False):
        config = QLearningConfig(counterfactual=counterfactual, total_steps=60_000)
        env = thesis("5x5", "phi_4")
        losses.append(regret(Learned(env, config), mdp, env.task))
    assert losses[0] < losses[1]


@pytest.mark.parametrize("make, changes", [
    (QLearningConfig, {"horizon": 0}), (QLearningConfig, {"averaging_steps": 0}),
    (QLearningConfig, {"epsilon_final": 1.5}),
    (FuTopcuConfig, {"delta": 1.0}), (FuTopcuConfig, {"total_steps": 0}),
    (SadighConfig, {"gamma": 1.0}), (SadighConfig, {"weight_fin": 0}), (SadighConfig, {"sweeps": 0}),
    (SadighConfig, {"epsilon_start": -1}),
    (WangConfig, {"accuracy": 0}), (WangConfig, {"step_size": 0}), (WangConfig, {"iterations": 0}),
])  # fmt: skip
def test_impossible_hyperparameters(make: Any, changes: dict[str, Any]) -> None:
    with pytest.raises(InvalidArgumentError, match=next(iter(changes))):
        make(**changes)


def test_environments_without_task_or_numbers() -> None:
    with pytest.raises(InvalidArgumentError, match="LTLVectorWrapper"):
        train(thesis_vector_world("5x5", 2), QLearningConfig())
    cars = gymnasium.make_vec("MountainCar-v0", num_envs=2, vectorization_mode="sync")
    labelled = LTLVectorWrapper(cars, Task("F up"), {"up": lambda obs: obs[:, 0] > 0.5})
    with pytest.raises(InvalidArgumentError, match="observations that are discrete"):
        train(labelled, FuTopcuConfig())
    cars.close()


def test_no_pair_to_reward() -> None:
    task = Task("a & !a", reward="thesis", on_deadlock="terminate")
    if task.automaton.n_pairs == 0:
        with pytest.raises(InvalidArgumentError, match="no Rabin pair"):
            train(LTLVectorWrapper(VectorGridWorld(PATROL, 2), task), SadighConfig())


@pytest.mark.parametrize("name", LEARNERS)
def test_tables_leave_the_choice_of_pairs_to_others(name: str) -> None:
    task = Task("(G F a & F G !b) | (G F b & F G !a)", reward="zeta-discount")
    assert task.tables.n_choices
    with pytest.raises(InvalidArgumentError, match="parity"):
        train(LTLVectorWrapper(VectorGridWorld(PATROL, 16), task), agent=name)
