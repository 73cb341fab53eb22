"""The exact line of a learning curve: what the policy that is optimal for the rewards returns in cut episodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ltlc.agents.training import artifacts
from ltlc.agents.training.run_folder import RunFolder
from ltlc.cli.app import run
from ltlc.envs import GridWorld, labelled_mdp
from ltlc.mdp import RewardProduct, expected_return, expected_return_within, expected_steps, optimal_return
from ltlc.pictures.curves import Curve, draw_curves
from ltlc.rewards import SCHEMES
from ltlc.task import Task

MAP = ("S.a", ".x.", "..b")


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("formula", ["F(a & F b) & G !x", "G F a & G F b"])
def test_returns_of_episodes_that_are_cut(name: str, formula: str) -> None:
    product = RewardProduct(labelled_mdp(GridWorld(MAP, slip=0.2)), Task(formula, name).tables)
    policy = product.choice_action[product.choice_start[:-1]]
    weights = product.policy_matrix(policy)
    distribution, total = product.initial.copy(), 0.0
    for steps in range(40):  # forwards, a distribution over states; the function goes backwards
        assert expected_return_within(product, policy, steps) == pytest.approx(total, abs=1e-9)
        total += float(distribution @ (weights @ product.reward))
        distribution = distribution @ (weights @ product.matrix).toarray()
    if expected_steps(product, policy) < 1000:
        whole = expected_return(product, policy, discount=1.0)
        assert expected_return_within(product, policy, 100_000) == pytest.approx(whole, rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_the_line_is_drawn_where_an_endless_episode_has_no_finite_return(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, drawn = str(tmp_path / "run"), []
    monkeypatch.setattr(artifacts, "draw_curves", lambda path, curves, **_: drawn.extend(curves) or path)
    task = ["G F A & G F B", "-e", "ltlc/Thesis5x5-v0", "--env-set", "slip=0.1", "--episode-steps", "50"]
    assert run(["train", *task, "--steps", "1000", "--num-envs", "4", "-q", "--out", folder]) == 0
    judge = RunFolder.open(folder).judge
    assert judge is not None
    assert judge.optimum is not None
    assert judge.optimum.total_return == np.inf
    best = expected_return_within(judge.rewards, optimal_return(judge.rewards).policy, 50)
    assert [curve.optimum for curve in drawn] == [pytest.approx(best)]
    assert 0 < best < 1
    assert [0 <= curve.outcome <= best + 1e-9 for curve in drawn] == [True]  # what was learned is no better


@pytest.mark.slow
def test_a_curve_with_an_infinite_optimum_has_no_line(tmp_path: Path) -> None:
    x = np.arange(20.0)
    for optimum in (np.inf, -np.inf, np.nan, None):
        curve = Curve("run", x, x, optimum, outcome=optimum)
        assert curve.marks == []
        path = draw_curves(tmp_path / "c.png", [curve], title="t", x_label="steps")
        assert path.stat().st_size > 1000
