"""Dense rewards from how far an observation is from a threshold, that change no optimal policy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np

from ltlc.automata import DRA
from ltlc.automata.guards import Guard
from ltlc.envs.comparisons import Path, comparisons
from ltlc.envs.declared import task_in
from ltlc.envs.wrapper import LTLWrapper
from ltlc.errors import InvalidArgumentError
from ltlc.ltl import Formula
from ltlc.task import Task


class RobustLTLWrapper(LTLWrapper):
    """`LTLWrapper` with a potential that grows as the comparisons come true that the automaton waits for.

    The potential of an observation in an automaton state is the progress of that state, and above it up to the progress
    of the next one, by how far the guard that leads there is from holding: the margin of a comparison is the difference
    of its sides, that of a conjunction the least and that of a disjunction the largest (robustness), squashed to 0..1.
    The reward of a step is that of the task plus discount * potential after - potential before, with the discount of
    the step, and the potential after an episode that has terminated is 0.

    So the return of every policy changes by the potential of the first observation alone, and optimal policies stay
    what they are, unless an episode can go on for ever undiscounted. Where an episode is truncated, bootstrapping
    stays right.

    Args:
        env: the environment.
        task: as of `LTLWrapper`.
        variables: where the names in comparisons stand in an observation; see `ltlc.envs.comparisons`.
        labels: predicates of propositions that are no comparisons, by name.
        weight: potential of a state on an accepting cycle.
        scale: the margin at which a comparison counts as three quarters true and more; of all, or by proposition.
        options: as of `LTLWrapper`.

    Raises:
        InvalidArgumentError: weight or scale are no finite numbers, or a scale is not positive.

    Example:
        >>> car = gym.make("MountainCar-v0")
        >>> env = RobustLTLWrapper(car, 'F "x >= 0.5"', {"x": 0}, weight=1.0, scale=0.5, warn_discount=False)
        >>> _ = env.reset(seed=0)
        >>> round(env.potential, 1)
        0.5

    References:
        A. Donze, O. Maler, Robust satisfaction of temporal logic over real-valued signals, FORMATS 2010, doi
        10.1007/978-3-642-15297-9_9. A. Y. Ng, D. Harada, S. Russell, Policy invariance under reward transformations,
        ICML 1999, https://dl.acm.org/doi/10.5555/645528.657613.
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        task: Task | Formula | str | DRA,
        variables: Mapping[str, Path],
        labels: Mapping[str, Any] | None = None,
        *,
        weight: float = 1.0,
        scale: float | Mapping[str, float] = 1.0,
        **options: Any,
    ) -> None:
        made = task_in(env, task)
        own = comparisons(made.automaton, variables)
        scales = dict(scale) if isinstance(scale, Mapping) else dict.fromkeys(own, scale)
        numbers = [weight, *scales.values()]
        if not all(isinstance(number, int | float) and np.isfinite(number) for number in numbers):
            raise InvalidArgumentError(f"weight and scale must be finite numbers, and are {weight!r} and {scale!r}")
        if any(number <= 0 for number in scales.values()):
            raise InvalidArgumentError(f"scale is {scale!r}; it must be positive")
        self._seen = _Remembering(env)
        super().__init__(self._seen, made, {**own, **(labels or {})}, **options)
        self.weight = weight
        self._margins = {name: (comparison, scales.get(name, 1.0)) for name, comparison in own.items()}
        self._guards, self._gains = _onward(made.automaton)
        self.potential = 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see `LTLWrapper.reset`."""
        observation, info = super().reset(seed=seed, options=options)
        self.potential = self._potential(info)
        return observation, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Step the environment; the reward is shaped, and `info["ltl"]["shaping"]` is what that adds."""
        observation, reward, terminated, truncated, info = super().step(action)
        before, self.potential = self.potential, 0.0 if terminated else self._potential(info)
        shaping = info["ltl"]["discount"] * self.potential - before
        info["ltl"]["shaping"] = shaping
        return observation, reward + shaping, terminated, truncated, info

    def _potential(self, info: dict[str, Any]) -> float:
        """Of the observation and the state of the automaton now."""
        state = self.automaton_state
        progress, guard = float(self.task.tables.progress[self._state]), self._guards[state]
        if guard is None:
            return self.weight * progress
        names = info["ltl"]["label_names"]

        def value(literal: tuple[int, bool]) -> float:
            name, sign = self.task.aps[literal[0]], 1.0 if literal[1] else -1.0
            if name not in self._margins:
                return 1.0 if (name in names) == literal[1] else 0.0
            comparison, scale = self._margins[name]
            margin = comparison.margin(self._seen.observation)
            return 0.5 if np.isnan(margin) else 0.5 + 0.5 * float(np.tanh(sign * margin / scale))

        inner, outer = (min, max) if guard.disjunctive else (max, min)
        parts = [inner(map(value, term)) for term in guard.terms if term]
        return self.weight * (progress + self._gains[state] * (outer(parts) if parts else 0.0))


class _Remembering(gym.Wrapper[Any, Any, Any, Any]):
    """Remembers the last observation."""

    observation: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self.observation, info = self.env.reset(seed=seed, options=options)
        return self.observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        self.observation, *rest = self.env.step(action)
        return self.observation, *rest


def _onward(automaton: DRA) -> tuple[list[Guard | None], list[float]]:
    """For each state the guard that leads on towards acceptance, if there is any to wait for, and what it is worth."""
    distance = automaton.annotations.distance.astype(np.int64)
    far = int(distance.max()) + 1
    marked = np.asarray((automaton.edge_inf & ~automaton.edge_fin).any(axis=0))
    guards: list[Guard | None] = []
    for state, steps in enumerate(distance.tolist()):
        after = distance[automaton.delta[state]]
        onward = marked[state] & (after >= 0) if steps == 0 else (after >= 0) & (after < steps)
        waits = steps >= 0 and bool(onward.any()) and not onward.all()
        guards.append(automaton.alphabet.guard(np.flatnonzero(onward).tolist()) if waits else None)
    return guards, [1 / far if guard is not None else 0.0 for guard in guards]
