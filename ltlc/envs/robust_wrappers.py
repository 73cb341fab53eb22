"""Dense rewards from how far an observation is from a threshold, that change no optimal policy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import VectorEnv

from ltlc.automata import DRA
from ltlc.envs.batch import AnyVectorWrapper
from ltlc.envs.comparisons import Path, comparisons
from ltlc.envs.declared import task_in
from ltlc.envs.robustness import FloatArray, Robustness
from ltlc.envs.vector_wrapper import BoolArray, IntArray, LTLVectorWrapper
from ltlc.envs.wrapper import LTLWrapper
from ltlc.ltl import Formula
from ltlc.task import Task


class RobustLTLWrapper(LTLWrapper):
    """`LTLWrapper` with a potential that grows as the comparisons come true that the automaton waits for.

    The potential is that of `ltlc.envs.robustness.Robustness`. The reward of a step is that of the task plus discount *
    potential after - potential before, with the discount of the step, and the potential after an episode that has
    terminated is 0.

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
        A. Y. Ng, D. Harada, S. Russell, Policy invariance under reward transformations, ICML 1999,
        https://dl.acm.org/doi/10.5555/645528.657613.
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
        self.robustness = Robustness(made.tables, own, weight, scale)
        self._others = [name for name in made.aps if name not in own]
        self._seen = _Remembering(env)
        super().__init__(self._seen, made, {**own, **(labels or {})}, **options)
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
        """Of the observation and the state of the tables now."""
        names = info["ltl"]["label_names"]
        holds = {name: name in names for name in self._others}
        return float(self.robustness.potentials(self._seen.observation, holds, [self._state])[0])


class RobustLTLVectorWrapper(LTLVectorWrapper):
    """`RobustLTLWrapper` for a vector environment.

    The rewards are shaped, and `infos["ltl"]["shaping"]` is what that adds; `infos["ltl"]["reward"]` stays that of the
    task. Agents of this package, which learn from the tables of the task in all automaton states at once, take the
    potential from here and let their values begin with it, which is the same.

    Args:
        env: the vector environment.
        task: as of `LTLWrapper`.
        variables: as of `RobustLTLWrapper`.
        labels: predicates of propositions that are no comparisons, by name, as the `batch_labels` of
            `LTLVectorWrapper`.
        weight: as of `RobustLTLWrapper`.
        scale: as of `RobustLTLWrapper`.
        options: as of `LTLVectorWrapper`.

    Attributes:
        potential: shape (num_envs,), float64; of the last observations.
        scales: of the margin of each comparison.
        places: of each variable in an observation.

    Raises:
        InvalidArgumentError: see `RobustLTLWrapper`.

    Example:
        >>> cars = gym.make_vec("MountainCar-v0", num_envs=2)
        >>> env = RobustLTLVectorWrapper(cars, 'F "x >= 0.5"', {"x": 0}, scale=0.5, warn_discount=False)
        >>> _ = env.reset(seed=0)
        >>> env.potential.round(1).tolist()
        [0.5, 0.5]
    """

    def __init__(
        self,
        env: VectorEnv[Any, Any, Any],
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
        self.robustness = Robustness(made.tables, own, weight, scale)
        self.scales = {name: self.robustness.scales[name] for name in own}
        self.places = {name: path for one in own.values() for name, path in one.variables.items()}
        self._others = [(i, name) for i, name in enumerate(made.aps) if name not in own]
        self._seen = _RememberingAll(env)
        super().__init__(self._seen, made, batch_labels={**own, **(labels or {})}, **options)
        self.potential: FloatArray = np.zeros(env.num_envs)
        self._last: FloatArray | None = None

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin episodes; see `LTLVectorWrapper.reset`."""
        observations, infos = super().reset(seed=seed, options=options)
        begun = ~infos["ltl"]["valid"]
        self.potential = np.where(begun, self._potentials(self._seen.observations, infos["ltl"]), self.potential)
        return observations, infos

    def step(self, actions: Any) -> tuple[Any, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Step all sub-environments; see `LTLVectorWrapper.step`."""
        self._last = None
        observations, rewards, terminated, truncated, infos = super().step(actions)
        ltl, before = infos["ltl"], self.potential
        discount, self.potential = ltl["discount"], self._potentials(self._seen.observations, ltl)
        after = self.potential if self._last is None else self._last
        if self._last is not None:
            discount = np.where(infos["_final_info"], infos["final_info"]["ltl"]["discount"], discount)
        shaping = np.where(ltl["valid"], discount * np.where(terminated, 0.0, after) - before, 0.0)
        ltl["shaping"] = shaping
        return observations, rewards + shaping, terminated, truncated, infos

    def _final(
        self, observations: Any, infos: dict[str, Any], ltl: dict[str, Any], ended: BoolArray, done: BoolArray
    ) -> Any:
        """As ever, but first look where the episodes end (mode SAME_STEP)."""
        self._last = self._potentials(observations, ltl)
        for i in np.flatnonzero(ended):  # last observations come one by one
            own = {key: ltl[key][i : i + 1] for key in ("state", "label")}
            self._last[i] = self._potentials(infos["final_obs"][i], own)[0]
        return super()._final(observations, infos, ltl, ended, done)

    def _potentials(self, observations: Any, ltl: Mapping[str, IntArray]) -> FloatArray:
        """Of observations, or of a single one, in the states and with the letters of the infos."""
        states, row = np.unique(ltl["state"], return_inverse=True)
        masks = self.task.automaton.letter_numbers.masks(ltl["label"])
        holds = {name: (masks >> i & 1).astype(np.bool_) for i, name in self._others}
        found = np.broadcast_to(
            self.robustness.potentials(observations, holds, states.tolist()).T, (len(row), len(states))
        )
        return np.asarray(found[np.arange(len(row)), row])


class _Remembering(gym.Wrapper[Any, Any, Any, Any]):
    """Remembers the last observation."""

    observation: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self.observation, info = self.env.reset(seed=seed, options=options)
        return self.observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        self.observation, *rest = self.env.step(action)
        return self.observation, *rest


class _RememberingAll(AnyVectorWrapper):
    """Remembers the last observations."""

    observations: Any = None

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self.observations, infos = self.env.reset(seed=seed, options=options)
        return self.observations, infos

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        self.observations, *rest = self.env.step(actions)
        return self.observations, *rest
