"""Where a policy acts: the wrapper that knows the task, what is around it, and the model where there is one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
from gymnasium.wrappers import (
    OrderEnforcing,
    PassiveEnvChecker,
    RecordEpisodeStatistics,
    TimeLimit,
    TransformObservation,
)

from ltlc.automata import DFA, DRA
from ltlc.envs import LTLWrapper, labelled_mdp
from ltlc.envs.declared import task_in
from ltlc.envs.labels import LabelSource
from ltlc.envs.observation import MODES, observer
from ltlc.envs.tabular import model_of, shows_states
from ltlc.errors import InvalidArgumentError, check_type
from ltlc.judging.policies import Actor
from ltlc.ltl import Formula
from ltlc.mdp import LabelledMDP
from ltlc.task import Task

_PLAIN = (TimeLimit, OrderEnforcing, PassiveEnvChecker, RecordEpisodeStatistics)
"""wrappers that change neither observations nor actions nor what follows, but for the length of episodes."""


@dataclass(frozen=True)
class Place:
    """An environment with a task in it.

    Attributes:
        env: what the policy sees.
        wrapper: what knows the task, inside `env` or the same.
        task: of the wrapper.
        mdp: the model; None: it is not known, or the policy does not see its states.
        why_not: why there is no model.
    """

    env: gym.Env[Any, Any]
    wrapper: LTLWrapper
    task: Task
    mdp: LabelledMDP | None
    why_not: str

    def observation(self, state: int, table_state: int) -> Any:
        """What the policy sees in a state of the model and of the reward tables."""
        seen = self.wrapper.observer.single(state, table_state)
        for change in self._changes():
            seen = change(seen)
        return seen

    def _changes(self) -> list[Callable[[Any], Any]]:
        outside = [layer for layer in _layers(self.env, self.wrapper) if isinstance(layer, TransformObservation)]
        return [layer.observation for layer in reversed(outside)]


def place_of(
    env: gym.Env[Any, Any] | str,
    task: Task | Formula | str | DRA | DFA | None,
    labels: LabelSource,
    actor: Callable[[gym.Env[Any, Any]], Actor],
) -> tuple[Place, Actor]:
    """The place where a policy acts, and the policy.

    Args:
        env: wrapped in an `LTLWrapper` already, which says what the task is, or not, or a name in Gymnasium's registry.
        task: of an environment that is not wrapped.
        labels: of an environment that is not wrapped.
        actor: makes the policy of an environment with its actions.

    Raises:
        InvalidArgumentError: there is no task, or there are two; or the policy is for other observations.
    """
    made = gym.make(env) if isinstance(env, str) else env
    single = "a single environment of Gymnasium, or the name of one; make one like those of a vector environment"
    check_type(made, gym.Env, "env", single)
    wrapper = _wrapper_in(made)
    if wrapper is None:
        if task is None:
            raise InvalidArgumentError("task is None, and the environment is not wrapped in an LTLWrapper; pass a task")
        of = task_in(made, task)
        made = wrapper = LTLWrapper(made, of, labels, observation="none", warn_discount=False)
        acts = actor(made)
        made = wrapper = LTLWrapper(made.env, of, labels, observation=_mode(acts, made, of), warn_discount=False)  # type: ignore[arg-type]
    else:
        _check_same(wrapper.task, task, labels)
        acts = actor(made)
    if acts.observation_space is not None and acts.observation_space != made.observation_space:
        raise InvalidArgumentError(
            f"the policy was made for {acts.observation_space}, and the environment shows {made.observation_space}"
        )
    mdp, why_not = _model(made, wrapper)
    return Place(made, wrapper, wrapper.task, mdp, why_not), acts


def _check_same(inside: Task, task: Any, labels: LabelSource) -> None:
    if labels is not None:
        raise InvalidArgumentError(
            "labels are given, and the environment has its own, in its LTLWrapper; leave them out"
        )
    if task is None or task is inside:
        return
    formula = task if isinstance(task, str) else getattr(task, "formula", None) or str(task)
    if str(formula) != inside.formula:
        raise InvalidArgumentError(
            f"the task is {formula}, and the environment is wrapped for {inside.formula or 'an automaton'}; leave the "
            "task out, or pass the environment without its LTLWrapper"
        )


def _mode(actor: Actor, env: gym.Env[Any, Any], task: Task) -> str:
    """How a policy wants to see the state of the automaton in an environment without a wrapper."""
    if actor.observation_space is None:
        return actor.mode
    for mode in MODES:
        try:
            if observer(mode, env.observation_space, task.tables.n_states).space == actor.observation_space:
                return mode
        except InvalidArgumentError:
            continue
    raise InvalidArgumentError(
        f"the policy was made for {actor.observation_space}; what this environment shows, {env.observation_space}, "
        f"alone or with one of {task.tables.n_states} states of the task, is something else in every observation mode "
        f"({', '.join(MODES)}). Pass the environment wrapped as it was for the training"
    )


def _wrapper_in(env: gym.Env[Any, Any]) -> LTLWrapper | None:
    while isinstance(env, gym.Wrapper):
        if isinstance(env, LTLWrapper):
            return env
        env = env.env
    return None


def _layers(env: gym.Env[Any, Any], end: gym.Env[Any, Any]) -> list[Any]:
    """The wrappers from the outermost to `end`, without it."""
    found: list[Any] = []
    while env is not end:
        found.append(env)
        env = env.env  # type: ignore[attr-defined]
    return found


def _model(env: gym.Env[Any, Any], wrapper: LTLWrapper) -> tuple[LabelledMDP | None, str]:
    """The model whose states the policy sees; or None, and why."""
    kind = type(env.unwrapped).__name__
    for layer in _layers(env, wrapper):
        if not isinstance(layer, TransformObservation) and not _is_plain(layer):
            return None, f"{type(layer).__name__} may change what the model of {kind} says"
    for layer in _layers(wrapper.env, env.unwrapped):
        if not _is_plain(layer):
            return None, f"{type(layer).__name__} may change what the model of {kind} says"
    own = model_of(env)
    if own is None:
        return None, f"the dynamics of {kind} are not known"
    if not shows_states(env, own):
        return None, f"observations of {kind} are not the states of its model"
    try:
        return labelled_mdp(wrapper), ""
    except InvalidArgumentError as error:
        return None, str(error)


def _is_plain(layer: Any) -> bool:
    if isinstance(layer, (*_PLAIN, gym.RewardWrapper)):
        return True
    return type(layer).__module__.startswith("stable_baselines3.") and type(layer).__name__ == "Monitor"
