"""A vector wrapper and as many single wrappers, stepped alike and compared."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from envs_reference import no_sink_automaton
from gymnasium.vector import AutoresetMode

from ltlc.rewards import get_scheme
from ltlc.task import Task

N = 5
RESETS = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]
TASKS: list[Callable[[], Task]] = [
    lambda: Task("!b U a", "zeta-discount"),
    lambda: Task("G F a & G !(a & b)", "thesis"),
    lambda: Task("G F a", get_scheme("zeta-reach", zeta=0.7)),
    lambda: Task("G F a & G F b", "frontier", shaping=1.0),
    lambda: Task(no_sink_automaton(3), "thesis-code"),
    lambda: Task("G(a -> X b)", get_scheme("parity", mode="terminate", epsilon=0.3)),
]


def assert_same(left: Any, right: Any, mask: np.ndarray | None = None) -> None:
    """Equal trees of arrays, where the mask says so."""
    if isinstance(left, dict):
        names = {name for name in left if not name.startswith("_")}
        assert names <= set(right), (names, set(right))
        for name in names:
            known = left.get(f"_{name}")
            inner = mask if known is None else known if mask is None else known & mask
            assert_same(left[name], right[name], inner)
        return
    left, right = np.atleast_1d(left), np.atleast_1d(right)
    if mask is not None:
        left, right = left[mask], right[mask]
    assert left.shape == right.shape
    for a, b in zip(left, right, strict=True):
        if isinstance(a, dict):
            assert_same(a, b)
        else:
            assert np.array_equal(a, b), (left, right)


def run(one_by_one: Any, together: Any, steps: int, mode: AutoresetMode, seed: Any = 11) -> dict[str, int]:
    rng = np.random.default_rng(0)
    assert_same(*(env.reset(seed=seed)[0] for env in (one_by_one, together)))
    seen = {"terminated": 0, "truncated": 0, "begun": 0}
    finished = np.zeros(N, dtype=bool)
    for _ in range(steps):
        actions = rng.integers(0, 2, N)
        left, right = one_by_one.step(actions), together.step(actions)
        for part in range(5):
            assert_same(left[part], right[part])
        assert together.observation_space.contains(right[0])
        begun = ~right[4]["ltl"]["valid"]
        assert np.array_equal(begun, finished if mode == AutoresetMode.NEXT_STEP else np.zeros(N, dtype=bool))
        finished = left[2] | left[3]
        seen["terminated"] += int(left[2].sum())
        seen["truncated"] += int(left[3].sum())
        seen["begun"] += int(begun.sum())
        if mode == AutoresetMode.DISABLED and finished.any():
            (left_observations, left_info), (right_observations, right_info) = (
                env.reset(options={"reset_mask": finished.copy()}) for env in (one_by_one, together)
            )
            assert_same(left_observations, right_observations)
            assert_same(left_info, right_info)
    return seen
