"""Environments by name, as the command line gives them: made, labelled, vectorised, and as exact models."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial, wraps
from typing import Any

import gymnasium as gym
from gymnasium.vector import VectorEnv

from ltlc.automata.finite import spoken
from ltlc.automata.possible import DeclaredLetters, mask_type, names_in
from ltlc.board import Board
from ltlc.envs.comparisons import VARIABLES, Variables
from ltlc.envs.declared import declared_letters
from ltlc.envs.discretised import DiscretisedVectorActions
from ltlc.envs.labeller import labeller_for
from ltlc.envs.labels import LabelFunction, LabelSource, Source, described, shown
from ltlc.envs.registration import register_envs
from ltlc.envs.tabular import (
    NO_MODEL,
    NO_STATES,
    MoreThanState,
    board_of,
    labelled_mdp,
    model_of,
    shows_states,
    with_labels_of,
)
from ltlc.envs.vector_wrapper import LTLVectorWrapper
from ltlc.envs.workers import WorkerVectorEnv
from ltlc.envs.wrapper import InitialLabel
from ltlc.errors import InvalidArgumentError, LtlcError, MissingProgramError, UnknownNameError
from ltlc.mdp import LabelledMDP
from ltlc.registry import import_module, import_object
from ltlc.task import Task

EPISODE_STEPS = 500
"""limit on the length of training episodes in environments that have none of their own."""


@dataclass(frozen=True, kw_only=True)
class EnvSpec:
    """Where a task is learned: an environment by name, its labels, and where its episodes are cut.

    Nothing is made until it is asked for.

    Attributes:
        env: a name in Gymnasium's registry; `module:Name-v0` imports the module first.
        arguments: for the constructor of the environment.
        labels: `module:name` of what labels one observation, see `ltlc.envs.labels`; or `variables:` and places of
            numbers, such as `variables:x=0`, where propositions are comparisons; None for an environment that labels
            itself.
        max_episode_steps: limit on the length of episodes; None: that of the environment, or `EPISODE_STEPS` where it
            has none.
        initial_label: whether the label of the first observation is read.
        discretise: points of each coordinate of a grid of actions, where those of the environment are continuous; None:
            no grid.
    """

    env: str
    arguments: Mapping[str, Any] = field(default_factory=dict)
    labels: str | None = None
    max_episode_steps: int | None = None
    initial_label: InitialLabel = "read"
    discretise: int | None = None

    def __post_init__(self) -> None:
        steps = self.max_episode_steps
        if steps is not None and (not isinstance(steps, int) or isinstance(steps, bool) or steps < 1):
            raise InvalidArgumentError(f"max_episode_steps is {steps!r}; it must be a whole number, at least 1")

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values; without `discretise` where there is no grid, as ever."""
        values = asdict(self) | {"arguments": dict(self.arguments)}
        return {name: value for name, value in values.items() if name != "discretise" or value is not None}

    @cached_property
    def single(self) -> gym.Env[Any, Any]:
        """One environment, without a task.

        Raises:
            UnknownNameError: there is no such environment.
            InvalidArgumentError: it does not take these arguments.
            MissingProgramError: it needs a package that is not installed.
        """
        env: gym.Env[Any, Any] = _made(self._spec, dict(self.arguments))
        return env

    @cached_property
    def label_source(self) -> LabelSource | Variables:
        """What labels a single environment, with its vocabulary declared where that can be known; or None.

        Raises:
            InvalidArgumentError: the environment has no labels and none are given, or they cannot be loaded.
        """
        if self.labels is None:
            _check_labels_itself(self.single, self.env)
            return None
        if self.labels.startswith(VARIABLES):
            return Variables(self.labels.removeprefix(VARIABLES))
        source: Any = _reported(Source(self.labels).given, self.labels)
        if not isinstance(source, Mapping) and not hasattr(source, "propositions"):
            model = self._model_of(source)
            if model is not None:
                source = LabelFunction(source, model.aps)
        labels: LabelSource = source
        return labels

    @cached_property
    def model(self) -> LabelledMDP | None:
        """The exact model of the environment, or None where its dynamics are not known."""
        return self._model_of(self.label_source)

    @property
    def declared_letters(self) -> DeclaredLetters:
        """What the environment declares about the letters that occur in it."""
        return declared_letters(self.single)

    @property
    def board(self) -> Board | None:
        """The map of the environment, or None where it has none."""
        return board_of(self.single)

    @property
    def why_no_model(self) -> str:
        """Why there is no exact model, as a message begins."""
        own = self._own_model
        if own is not None and isinstance(self.label_source, Variables):
            return f"what holds in the states of {self.env} is not known, because comparisons are about observations"
        if own is None:
            return f"the dynamics of {self.env} are not known: {NO_MODEL}"
        why = "the labels look at more than the state" if shows_states(self.single, own) else NO_STATES
        return f"what holds in the states of {self.env} is not known, because {why}"

    @property
    def episode_steps(self) -> int:
        """Where episodes are cut."""
        return self.max_episode_steps or self._spec.max_episode_steps or EPISODE_STEPS

    @property
    def continuous(self) -> bool:
        """Whether the actions of the environment itself are continuous."""
        return isinstance(self.single.action_space, gym.spaces.Box)

    def vector(self, task: Task, num_envs: int, workers: int = 0) -> LTLVectorWrapper:
        """Many environments with the task around them.

        Args:
            task: the task.
            num_envs: how many.
            workers: processes that step them, each its share; 0: they are stepped here.

        Raises:
            UnknownNameError: the formula speaks of something that no label produces.
            InvalidArgumentError: the environment, its arguments and labels do not go together.
        """
        if num_envs < 1:
            raise InvalidArgumentError(f"{num_envs} environments; at least 1 is needed")
        if workers < 0:
            raise InvalidArgumentError(f"workers is {workers}; it must be at least 0")
        envs: VectorEnv[Any, Any, Any]
        if workers:
            envs = WorkerVectorEnv(partial(replace(self)._one_by_one, spoken(task.aps)), num_envs, workers)
        elif self.label_source is None and self._spec.vector_entry_point is not None:
            envs = _made(self._spec, self._all_arguments, num_envs)
        else:
            envs = self._one_by_one(spoken(task.aps), num_envs)
        if self.discretise is not None:
            envs = DiscretisedVectorActions(envs, self.discretise)
        return LTLVectorWrapper(envs, task, initial_label=self.initial_label)

    def _one_by_one(self, aps: tuple[str, ...], num_envs: int) -> Any:
        """So many environments that are stepped one by one, with labels over these propositions."""
        source = self.label_source
        wrappers = [] if source is None else [_Labelled.around(source, aps)]
        return _made(self._spec, self._all_arguments, num_envs, vectorization_mode="sync", wrappers=wrappers)

    @property
    def _all_arguments(self) -> dict[str, Any]:
        return dict(self.arguments) | {"max_episode_steps": self.episode_steps}

    @property
    def default_arguments(self) -> dict[str, Any]:
        """What the constructor of the environment takes where an argument is not given; empty where it cannot tell."""
        spec = self._spec
        try:
            make = spec.entry_point
            made = gym.envs.registration.load_env_creator(make) if isinstance(make, str) else make
            parameters = inspect.signature(made).parameters.values() if made is not None else ()
        except Exception:  # the module is the user's, so anything may happen; making the environment tells
            return {}
        defaults = {one.name: one.default for one in parameters if one.default is not one.empty}
        return defaults | dict(spec.kwargs)

    @cached_property
    def _spec(self) -> gym.envs.registration.EnvSpec:
        register_envs()
        module, _, name = self.env.rpartition(":")
        if module:
            import_module(module, f"the environment {self.env!r}")
        if name not in gym.registry:
            raise UnknownNameError("environment", name, gym.registry)
        return gym.registry[name]

    def _model_of(self, source: LabelSource | Variables) -> LabelledMDP | None:
        if isinstance(source, Variables):
            return None
        own = self._own_model
        if own is None or source is None:
            return None if own is None else labelled_mdp(self.single)
        if not shows_states(self.single, own):
            return None
        try:
            return with_labels_of(own, source)
        except MoreThanState:
            return None

    @cached_property
    def _own_model(self) -> LabelledMDP | None:
        return model_of(self.single)


class _Labelled(gym.Wrapper[Any, Any, Any, Any]):
    """Puts the letter of each observation into `info["labels"]`."""

    def __init__(self, env: gym.Env[Any, Any], source: LabelSource, aps: tuple[str, ...]) -> None:
        super().__init__(env)
        self.labeller = labeller_for(source, aps, env)
        self.propositions = aps

    @classmethod
    def around(
        cls, source: LabelSource | Variables, aps: tuple[str, ...]
    ) -> Callable[[gym.Env[Any, Any]], gym.Env[Any, Any]]:
        labels = source.labels(aps) if isinstance(source, Variables) else source
        return lambda env: cls(env, labels, aps)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, {**info, "labels": self._label(observation, info)}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, {**info, "labels": self._label(observation, info)}

    def _label(self, observation: Any, info: dict[str, Any]) -> int | frozenset[str]:
        """The letter as a bitmask if the arrays of vector environments can hold it."""
        mask = self.labeller.letter(observation, info)
        return mask if not mask_type(len(self.propositions)).hasobject else names_in(self.propositions, mask)


def _reported(labels: Any, name: str) -> Any:
    """Labels whose exceptions become one of our errors, `sys.exit` included: the user is told what fails and where."""
    if isinstance(labels, Mapping):
        return {key: _reported(predicate, name) for key, predicate in labels.items()}
    if isinstance(labels, str):  # a predicate that is text itself
        return _reported(import_object(labels, f"labels {name!r}"), name)

    @wraps(labels)
    def reported(observation: Any, *more: Any) -> Any:
        try:
            return labels(observation, *more)
        except (LtlcError, KeyboardInterrupt):
            raise
        except BaseException as error:
            frame = error.__traceback__.tb_next if error.__traceback__ is not None else None
            where = f" in {frame.tb_frame.f_code.co_filename}:{frame.tb_lineno}" if frame is not None else ""
            raise InvalidArgumentError(
                f"labels {name!r}: {described(labels, place=False)} fails{where} on the observation "
                f"{shown(observation)} with {type(error).__name__}: {error}"
            ) from error

    declared = getattr(labels, "propositions", None)
    return reported if declared is None else LabelFunction(reported, tuple(declared))


def _made(spec: Any, arguments: dict[str, Any], num_envs: int | None = None, **options: Any) -> Any:
    """The environment of a spec, or a vector of them; what goes wrong in it becomes one of our errors."""
    try:
        if num_envs is None:
            return gym.make(spec, **arguments)
        envs: VectorEnv[Any, Any, Any] = gym.make_vec(spec, num_envs=num_envs, **options, **arguments)
        return envs
    except LtlcError:
        raise
    except gym.error.DependencyNotInstalled as error:
        raise MissingProgramError(f"{spec.id}: {error}") from error
    except (Exception, SystemExit) as error:  # the environment is the user's, so anything may happen
        raise InvalidArgumentError(f"{spec.id} cannot be made ({type(error).__name__}: {error})") from error


def _check_labels_itself(env: gym.Env[Any, Any], name: str) -> None:
    if not env.has_wrapper_attr("propositions") and "labels" not in env.reset(seed=0)[1]:
        raise InvalidArgumentError(
            f"{name} says nothing about propositions; give labels, the text module:function of a function that "
            "takes the observation of one environment and returns the set of names that hold"
        )
