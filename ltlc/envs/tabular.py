"""Exact models and maps of environments that offer them, with the labels of the task."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from ltlc.board import Board
from ltlc.envs.labels import LabelSource, Source, described, names_of
from ltlc.envs.protocol import MappedEnv, ModelledEnv
from ltlc.envs.toy_text import adapted
from ltlc.errors import InvalidArgumentError, check_type
from ltlc.mdp import LabelledMDP


class MoreThanState(InvalidArgumentError):
    """Labels look at more than the state, so what holds in it is not known."""


class _NoInfo(Mapping[str, Any]):
    """Stands for the info where there is none."""

    def __init__(self, labels: str) -> None:
        self._labels = labels

    def _refuse(self, *_: object) -> Any:
        raise MoreThanState(f"labels: {self._labels} looks at the info, so what holds in a state is not known")

    __getitem__ = __iter__ = __len__ = _refuse


def labelled_mdp(env: Any, labels: LabelSource = None) -> LabelledMDP:
    """The exact model of an environment that has one.

    That is an environment with the method of `ltlc.envs.protocol.ModelledEnv`, as grid worlds have, or with a
    transition table `P`, as Gymnasium's FrozenLake, Taxi and CliffWalking have. Terminal states are absorbing: the word
    of an episode goes on with the last label for ever. Limits on the length of episodes are left out.

    Args:
        env: the environment, wrapped or not; of an `LTLWrapper` the labels are taken.
        labels: a function of the state as it is observed, whose labels are names, or a dict of predicates; see
            `ltlc.envs.labels`. None: those of the model itself, as grid worlds have.

    Raises:
        MoreThanState: the labels look at the info or the environment.
        InvalidArgumentError: the dynamics are not known, there are no labels, or one is of a wrong type.

    Example:
        >>> import gymnasium
        >>> lake = gymnasium.make("FrozenLake-v1")
        >>> labelled_mdp(lake, {"goal": lambda state: state == 15}).n_states
        16
    """
    kind = type(env.unwrapped).__name__
    model = model_of(env)
    if model is None:
        raise InvalidArgumentError(f"the dynamics of {kind} are not known: {NO_MODEL}")
    if labels is None:
        labels = _labels_of_wrapper(env)
    if labels is None and (model.aps or isinstance(env.unwrapped, ModelledEnv)):
        return model
    if labels is None:
        raise InvalidArgumentError(f"pass labels=...: the states of {kind} carry none")
    if not shows_states(env, model):
        raise MoreThanState(f"what holds in the states of {kind} is not known, because {NO_STATES}")
    return with_labels_of(model, labels)


def with_labels_of(model: LabelledMDP, labels: LabelSource) -> LabelledMDP:
    """A model with the labels that each state, taken as an observation, has; see `labelled_mdp`.

    Raises:
        MoreThanState: the labels look at the info or the environment.
        InvalidArgumentError: a label is of a wrong type.
    """
    source = Source(labels)
    if source.arity > 2:
        what = described(source.function)
        raise MoreThanState(f"labels: {what} asks for the environment, so what holds in a state is not known")
    named = [_names(source, state) for state in range(model.n_states)]
    aps = sorted({name for label in named for name in label})
    return model.with_labels(aps, [[name for name, here in label.items() if here] for label in named])


NO_STATES = "the labels are functions of the observation, and observations are not the states"
"""why a model cannot be labelled, as the end of a message."""
NO_MODEL = "it has neither a method labelled_mdp (as grid worlds have) nor a transition table P"
"""why an environment has no exact model, as the end of a message."""


def model_of(env: Any) -> LabelledMDP | None:
    """The exact model that an environment itself offers, or None.

    Raises:
        InvalidArgumentError: its `labelled_mdp()` returns something else.
    """
    base = adapted(env.unwrapped)
    if not isinstance(base, ModelledEnv):
        return None
    model = base.labelled_mdp()
    check_type(model, LabelledMDP, f"{type(base).__name__}.labelled_mdp()", "an ltlc.mdp.LabelledMDP")
    return model


def shows_states(env: Any, model: LabelledMDP) -> bool:
    """Whether the observations of an environment are the states of its model."""
    space = getattr(env.unwrapped, "single_observation_space", env.unwrapped.observation_space)
    return isinstance(space, Discrete) and space.start == 0 and space.n == model.n_states


def board_of(env: Any) -> Board | None:
    """The map of an environment, or None where it has none.

    Raises:
        InvalidArgumentError: its `board()` returns something else.
    """
    base = adapted(env.unwrapped)
    if not isinstance(base, MappedEnv):
        return None
    board = base.board()
    check_type(board, Board, f"{type(base).__name__}.board()", "an ltlc.board.Board")
    return board


def _labels_of_wrapper(env: Any) -> LabelSource:
    while env is not getattr(env, "env", env):
        if hasattr(env, "labeller"):
            if getattr(env, "batch_labels", None) is not None:
                raise InvalidArgumentError("the environment is labelled by batch_labels; pass labels=... of one state")
            found: LabelSource = getattr(env, "labels", None)
            if found is not None:
                return found
        env = env.env
    return None


def _names(source: Source, state: int) -> dict[str, bool]:
    arguments = (state, _NoInfo(described(source.function)))[: source.arity]
    label, names = source.function(*arguments), source.propositions or ()
    if isinstance(label, int | np.integer) and not isinstance(label, bool) and 0 <= label < 2 ** len(names):
        return {name: bool(label >> i & 1) for i, name in enumerate(names)}  # a bitmask
    return {**dict.fromkeys(names, False), **names_of(label)}
