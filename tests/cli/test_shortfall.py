"""Rewards whose optimum falls short of what is possible are named, with rewards whose optimum does not."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ltlc.faithful
from ltlc.agents.training.run_folder import RunFolder
from ltlc.cli.app import run
from ltlc.envs import labelled_mdp
from ltlc.faithful import Shortfall, shortfall
from ltlc.mdp import LabelledMDP, Product, max_satisfaction_probability, satisfaction_probability
from ltlc.mdp.verdict import TOLERANCE, Judge
from ltlc.rewards import RECOMMENDED, SCHEMES, RewardScheme, get_scheme
from ltlc.task import Task

LABELS = """
MAPS = {
    16: "SFFFFHFHFFFHHFFG",
    64: "SFFFFFFFFFFFFFFFFFFHFFFFFFFFFHFFFFFHFFFFFHHFFFHFFHFFHFHFFFFHFFFG",
}

def small(observation, info):
    return {"H": {"hole"}, "G": {"goal"}}.get(MAPS[16][observation], set())

def large(observation, info):
    return {"H": {"hole"}, "G": {"goal"}}.get(MAPS[64][observation], set())
"""


def gamble(n: int, p: float) -> LabelledMDP:
    """A sure loop of n steps through a goal, or, at its beginning, a gamble for a state that is a goal for ever."""
    matrices = np.zeros((2, n + 2, n + 2))
    for i in range(n):
        matrices[:, i, (i + 1) % n] = 1
    matrices[1, 0] = 0
    matrices[1, 0, [n, n + 1]] = p, 1 - p
    matrices[:, [n, n + 1], [n, n + 1]] = 1
    return LabelledMDP.from_arrays(matrices, aps=("g",), labels={n - 1: "g", n: "g"})


def found(mdp: LabelledMDP, reward: str | RewardScheme, formula: str = "G F g", **options: str) -> Shortfall | None:
    task = Task(formula, reward, **options)  # type: ignore[arg-type]
    return shortfall(Judge(mdp, task), task)


def check(mdp: LabelledMDP, formula: str, answer: Shortfall) -> None:
    """The rewards of the answer are solved anew, and judged on the product with the automaton alone."""
    assert answer.better is not None
    task = Task(formula, answer.better.scheme, on_deadlock=answer.better.on_deadlock)
    judge = Judge(mdp, task)
    assert judge.optimal_policy is not None
    product = Product(mdp, task.automaton)
    best = max_satisfaction_probability(product).probability
    assert answer.maximum == pytest.approx(best, abs=1e-6)
    if len(task.tables.automaton_state) == task.automaton.n_states:
        policy = product.lift(judge.optimal_policy)
        assert satisfaction_probability(product, policy).probability >= best - TOLERANCE
    assert answer.better_satisfaction == judge.satisfaction(judge.optimal_policy) >= best - TOLERANCE


def test_a_long_sure_loop_beside_a_short_gamble() -> None:
    answer = found(gamble(150, 0.95), "two-discount")
    assert answer is not None
    assert (answer.maximum, answer.satisfaction) == (1.0, pytest.approx(0.95))
    assert answer.better is not None
    assert answer.better.scheme == get_scheme("two-discount", gamma=0.999999)
    assert "0.95 where 1 is possible" in answer.text
    check(gamble(150, 0.95), "G F g", answer)
    assert found(gamble(20, 0.95), "two-discount") is None
    assert found(gamble(150, 0.95), answer.better.scheme) is None


@pytest.mark.slow
def test_the_search_goes_further_where_it_must() -> None:
    answer = found(gamble(2000, 0.99), "two-discount")
    assert answer is not None
    check(gamble(2000, 0.99), "G F g", answer)
    shaped = found(gamble(150, 0.95), get_scheme("two-discount", shaping=0.5))
    assert shaped is not None
    assert shaped.to_dict()["reached_by"]["parameters"] == {"gamma": 0.999999, "shaping": 0.5}


@pytest.mark.parametrize("name", ["thesis", "accept", "sadigh"])
def test_without_a_limit_of_its_own_the_recommended_scheme_comes_first(name: str) -> None:
    answer = found(gamble(20, 0.95), name)
    assert answer is not None
    assert answer.better is not None
    assert answer.better.scheme == get_scheme(RECOMMENDED)


def test_rewards_without_an_optimum_fall_short() -> None:
    answer = found(gamble(20, 0.95), get_scheme("accept", gamma=1.0))
    assert answer is not None
    assert answer.satisfaction is None
    assert "no optimal policy" in answer.text
    check(gamble(20, 0.95), "G F g", answer)


@pytest.mark.slow
def test_where_violations_are_forgiven_rewards_that_mind_them_are_found() -> None:
    p = np.zeros((2, 4, 4))  # surely through the trap to a goal, or, half of the time, around it
    p[0, 0, 1] = 1
    p[1, 0, [2, 3]] = 0.5
    p[:, 1, 2] = p[:, 2, 2] = p[:, 3, 3] = 1
    mdp = LabelledMDP.from_arrays(p, aps=("g", "x"), labels={1: "x", 2: "g"})
    answer = found(mdp, "two-discount", "G F g & G !x", on_deadlock="stay")
    assert answer is not None
    assert (answer.maximum, answer.satisfaction) == (0.5, 0)
    assert answer.better is not None
    assert answer.better.scheme.name == "parity"  # in which a violation costs
    check(mdp, "G F g & G !x", answer)


def test_large_models_are_compared_but_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ltlc.faithful, "SEARCHED_UP_TO", 100)
    answer = found(gamble(150, 0.95), "two-discount")
    assert answer is not None
    assert answer.better is None
    assert not answer.searched
    assert "too large" in answer.text
    assert answer.to_dict()["reached_by"] is None


def test_a_small_maximum_may_not_be_missed_altogether() -> None:
    mdp = gamble(20, 0.95)
    worthless = np.zeros((1, 22, 22))
    worthless[0, 0, [1, 21]] = 5e-4, 1 - 5e-4
    worthless[0, range(1, 22), range(1, 22)] = 1
    either = np.concatenate((worthless, np.roll(np.eye(22), -1, axis=0)[None]))
    either[1] = np.eye(22)
    mdp = LabelledMDP.from_arrays(either, aps=("g",), labels={1: "g"})
    task = Task("G F g", get_scheme("thesis", other=0.0, rejecting=0.0, terminal=-1.0))
    judge = Judge(mdp, task)
    assert judge.maximum.probability == pytest.approx(5e-4)
    assert judge.optimum is not None
    assert judge.optimum.satisfaction == 0
    assert judge.falls_short


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_random_models(seed: int) -> None:
    rng = np.random.default_rng([seed, 7])
    n, actions = int(rng.integers(2, 8)), 3
    matrices = rng.dirichlet(np.full(n, 0.3), size=(actions, n))
    matrices[rng.random((actions, n)) < 0.4] = np.eye(n)[int(rng.integers(n))]
    labels = {s: {name for name in "ab" if rng.random() < 0.4} for s in range(n)}
    mdp = LabelledMDP.from_arrays(matrices, aps=("a", "b"), labels=labels)
    formula = ["G F a & F G !b", "F G a | G F b", "!b U a", "G(a -> F b)", "F(a & X(!a U b))"][seed % 5]
    for name in SCHEMES:
        task = Task(formula, name)
        judge = Judge(mdp, task)
        answer = shortfall(judge, task)
        if judge.optimum is not None:
            missed = judge.maximum.probability - judge.optimum.satisfaction
            assert (answer is not None) == (missed > min(TOLERANCE, judge.maximum.probability / 2))
        if answer is not None:
            check(mdp, formula, answer)


@pytest.mark.parametrize(("env", "labels"), [("FrozenLake-v1", "small"), ("FrozenLake8x8-v1", "large")])
@pytest.mark.parametrize("formula", ["G F goal", "F goal & G !hole", "!hole U goal", "F G goal", "F goal & G F !hole"])
def test_the_default_rewards_attain_the_maximum_on_frozen_lake(env: str, labels: str, formula: str) -> None:
    """As Gymnasium makes it, with its terminal states."""
    names: dict[str, Any] = {}
    exec(LABELS, names)  # the text that the commands below read from a file
    mdp = labelled_mdp(gym.make(env), names[labels])
    assert mdp.terminal is not None
    assert mdp.terminal.any()
    task = Task(formula)
    judge = Judge(mdp, task)
    assert judge.optimum is not None
    assert judge.optimum.satisfaction >= judge.maximum.probability - TOLERANCE
    assert judge.maximum.probability > 0.5
    assert not judge.falls_short


class TestCommands:
    @pytest.fixture(autouse=True)
    def _here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        (tmp_path / "lake.py").write_text(LABELS)
        monkeypatch.chdir(tmp_path)
        monkeypatch.delitem(sys.modules, "lake", raising=False)

    TASK = ("G F goal", "-e", "FrozenLake-v1", "-l", "lake:small", "-r", "thesis", "--on-termination", "cut", "--json")

    def told(self, captured: pytest.CaptureFixture[str]) -> dict[str, object]:
        """What was printed as JSON; that stderr has the warning, once."""
        printed = captured.readouterr()
        lines = [line for line in printed.err.splitlines() if "0.028125 where 0.823529 is possible" in line]
        assert len(lines) == 1
        assert lines[0].startswith("ltlc: warning: ")
        assert lines[0].endswith("(--reward two-discount --on-termination cut)")
        values = json.loads(printed.out)
        assert values["shortfall"]["reached_by"]["reward"] == "two-discount"
        assert values["shortfall"]["satisfaction"] == pytest.approx(0.028125)
        return dict(values)

    @pytest.mark.slow
    def test_solve_train_and_evaluate_say_so(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", *self.TASK]) == 0
        self.told(capsys)
        assert run(["train", *self.TASK, "--steps", "500", "--num-envs", "4", "--out", "run"]) == 0
        values = self.told(capsys)
        assert json.loads(Path("run/result.json").read_text())["shortfall"] == values["shortfall"]
        assert run(["evaluate", "run", "--json"]) == 0
        self.told(capsys)

    @pytest.mark.slow
    def test_what_takes_long_is_compared_after_training(
        self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("ltlc.cli.train.COMPARED_UP_TO", 10)
        assert run(["train", *self.TASK, "--steps", "500", "--num-envs", "4", "--out", "run"]) == 0
        error = capsys.readouterr().err
        assert (
            0 < error.index("judged last what the rewards teach") < error.index("0.028125 where 0.823529 is possible")
        )

    def test_nothing_is_said_where_nothing_falls_short(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["solve", "G F goal", "-e", "FrozenLake-v1", "-l", "lake:small", "--json"]) == 0
        printed = capsys.readouterr()
        assert printed.err == ""
        assert json.loads(printed.out)["shortfall"] is None

    @pytest.mark.slow
    def test_learners_that_do_not_see_the_rewards_are_not_warned(self) -> None:
        where = [*self.TASK[:-1], "-q"]
        run(["train", *where, "--agent", "wang", "--steps", "200", "--out", "run"])
        assert RunFolder.open("run").shortfall is None
