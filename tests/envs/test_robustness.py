"""Shaping by robustness: margins, the potential, and that returns change by that of the first observation alone."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import ltlc
from ltlc.envs import Comparison, RobustLTLVectorWrapper, RobustLTLWrapper
from ltlc.errors import InvalidArgumentError

VARIABLES = {"x": 0, "v": 1}


class Line(gymnasium.Env[Any, int]):
    """A point that is pushed left and right on a line, at random a little farther; it ends beyond 3."""

    observation_space = gymnasium.spaces.Box(-10, 10, (2,))
    action_space = gymnasium.spaces.Discrete(2)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.state = self.np_random.uniform(-1, 1, 2)
        return self.state.copy(), {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.state = self.state + (0.5 if action else -0.5) + self.np_random.uniform(-0.2, 0.2, 2)
        return self.state.copy(), 0.0, bool(abs(self.state[0]) > 3), False, {}


@pytest.mark.parametrize(
    ("text", "margin"),
    [
        ("x > 0.5", -0.25),
        ("x <= 0.5", 0.25),
        ("0 < x < 2 * v", 0.25),
        ("abs(v) >= x", 0.75),
        ("x == 0.5", -0.25),
        ("x != 0.5", 0.25),
    ],
)
def test_margins(text: str, margin: float) -> None:
    comparison = Comparison(text, VARIABLES)
    assert comparison.margin([0.25, -1.0 if "abs" in text else 1.0]) == pytest.approx(margin)
    batch = np.random.default_rng(0).normal(size=(200, 2))
    margins = comparison.margin(batch)
    assert ((margins > 0) <= comparison(batch)).all()
    assert ((margins < 0) <= ~comparison(batch)).all()


def discounts(env: Any, actions: list[int], seed: int) -> tuple[float, float, float, bool]:
    """The discounted return, the first potential, the discounted last one, and whether the episode has terminated."""
    env.reset(seed=seed)
    first = getattr(env, "potential", 0.0)
    total, weight, terminated = 0.0, 1.0, False
    for action in actions:
        _, reward, terminated, _, info = env.step(action)
        total += weight * reward
        weight *= info["ltl"]["discount"]
        if terminated:
            break
    return total, first, weight * getattr(env, "potential", 0.0), terminated


@pytest.mark.parametrize("reward", ["two-discount", "zeta-discount", "thesis"])
@pytest.mark.parametrize(
    "text", ['F "x > 2"', 'GF "x > 1" & G "v < 4"', 'F("x > 1" & F "x < -1")', 'G("v > 0" -> F "v <= 0") & F "x==0"']
)
def test_every_return_changes_by_the_first_potential_alone(text: str, reward: str) -> None:
    task = ltlc.Task(text, reward=reward)
    rng = np.random.default_rng(1)
    ended = 0
    for seed in range(30):
        actions = rng.integers(0, 2, int(rng.integers(1, 30))).tolist()
        plain = ltlc.LTLWrapper(Line(), task, ltlc.envs.comparisons(task.automaton, VARIABLES), warn_discount=False)
        shaped = RobustLTLWrapper(Line(), task, VARIABLES, weight=3.0, scale=0.7, warn_discount=False)
        unshaped, *_ = discounts(plain, actions, seed)
        total, first, last, terminated = discounts(shaped, actions, seed)
        assert total == pytest.approx(unshaped + last - first)
        assert last == 0 or not terminated
        ended += terminated
    assert ended or reward != "two-discount"


def test_the_potential_grows_towards_the_threshold() -> None:
    env = RobustLTLWrapper(Line(), 'F "x > 2"', VARIABLES, warn_discount=False)
    env.reset(seed=0)
    seen = []
    for x in (-2.0, 0.0, 1.5, 1.99):
        env.unwrapped.state = np.array([x - 0.5, 0.0])  # type: ignore[attr-defined]
        env.step(1)
        seen.append((float(env.unwrapped.state[0]), env.potential))  # type: ignore[attr-defined]
    below = [potential for x, potential in sorted(seen) if x <= 2]
    assert below == sorted(below)
    assert 0.5 <= below[0] < below[-1] <= 1


def test_other_labels_and_scales() -> None:
    env = RobustLTLWrapper(
        Line(),
        'F("x > 2" & lamp)',
        VARIABLES,
        {"lamp": lambda observation: observation[1] > 0},
        scale={"x > 2": 0.1},
        warn_discount=False,
    )
    env.reset(seed=0)
    _, _, _, _, info = env.step(1)
    assert isinstance(info["ltl"]["shaping"], float)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scale": 0.0}, "scale is 0.0; it must be positive"),
        ({"scale": {"x > 2": -1.0}}, "it must be positive"),
        ({"weight": float("nan")}, "weight and scale must be finite numbers"),
        ({"scale": "wide"}, "weight and scale must be finite numbers"),
    ],
)
def test_errors(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        RobustLTLWrapper(Line(), 'F "x > 2"', VARIABLES, **options)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("text", ['F("x > 1" & F "x < -1")', 'G("v > 0" -> F "v <= 0") & F "x==0" | G lamp'])
def test_many_environments_are_paid_as_each_alone(mode: AutoresetMode, text: str) -> None:
    options: dict[str, Any] = {"weight": 2.0, "scale": {"x > 1": 0.5}, "warn_discount": False}
    labels = {"lamp": lambda observation: observation[..., 1] > 0}
    if "lamp" not in text:
        labels.clear()
    made = [lambda: gymnasium.wrappers.TimeLimit(Line(), 9)] * 3
    vector = RobustLTLVectorWrapper(SyncVectorEnv(made, autoreset_mode=mode), text, VARIABLES, labels, **options)
    alone = [RobustLTLWrapper(make(), text, VARIABLES, labels, **options) for make in made]
    vector.reset(seed=5)
    for i, env in enumerate(alone):
        env.reset(seed=5 + i)
    actions = np.random.default_rng(0).integers(0, 2, (60, 3))
    done = np.zeros(3, dtype=bool)
    ended = 0
    for row in actions:
        if mode == AutoresetMode.DISABLED and done.any():
            vector.reset(options={"reset_mask": done.copy()})
            for i in np.flatnonzero(done):
                alone[i].reset()
            done[:] = False
        _, rewards, terminated, truncated, _ = vector.step(row)
        for i, env in enumerate(alone):
            if mode == AutoresetMode.NEXT_STEP and done[i]:
                env.reset()
                assert rewards[i] == 0
                continue
            _, reward, *ends, _ = env.step(row[i])
            assert rewards[i] == pytest.approx(reward, abs=1e-5)
            assert [terminated[i], truncated[i]] == ends
            if mode == AutoresetMode.SAME_STEP and any(ends):
                env.reset()
            assert vector.potential[i] == pytest.approx(env.potential, abs=1e-5) or any(ends)
        done = terminated | truncated
        ended += int(done.sum())
    assert ended > 10
