"""Labellers: what a wrapper asks for the letters of the observations it sees."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import concatenate, create_empty_array, iterate

from ltlc.automata.possible import LetterNumbers
from ltlc.envs.batch import SubInfo, part, select
from ltlc.envs.grid_map import HOLD
from ltlc.envs.labels import BATCH_SIGNATURES, ExtraLabels, LabelSource, Source, described, shown
from ltlc.envs.letters import Letters
from ltlc.errors import InvalidArgumentError

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_NO_INFO: dict[str, Any] = {}


class Labeller:
    """Letters of the observations of one environment.

    Args:
        source: what labels observations.
        letters: over the propositions of the automaton.
        env: the environment, for functions that ask for it.
    """

    def __init__(self, source: Source, letters: Letters, env: Any = None) -> None:
        self.source = source
        self.letters = letters
        self.env = env
        self._known = letters.known

    def letter(self, observation: Any, info: Mapping[str, Any]) -> int:
        """The letter of one observation.

        Raises:
            UnknownNameError: a label is not a proposition of the formula, or not one that was declared.
            InvalidArgumentError: the label is of a wrong type, or missing.
        """
        source = self.source
        arity = source.arity
        try:
            if arity == 1:
                label: Any = source.function(observation)
            elif arity == 2:
                label = source.function(observation, info)
            else:
                label = source.function(observation, info, self.env)
        except Exception as error:
            if source.labels is not None:
                error.add_note(f"labels: {described(source.function)} was given the observation {shown(observation)}")
            raise
        kind = type(label)
        if kind is set:
            label = frozenset(label)
        if kind is frozenset or kind is set or kind is str:
            letter = self._known.get(label)
            if letter is not None:
                return letter
        return self.letters.of(label)


def labeller_for(
    labels: LabelSource,
    aps: tuple[str, ...],
    env: Any,
    extra_labels: ExtraLabels = "error",
    numbers: LetterNumbers | None = None,
) -> Labeller:
    """What turns the observations and infos of an environment into letters over `aps`.

    Args:
        labels: see `ltlc.envs.labels`; None for `info["labels"]`, whose vocabulary is the attribute `propositions` of
            the environment if it has one.
        aps: the propositions of the automaton.
        env: the environment.
        extra_labels: whether a name that the formula does not mention is an error or ignored. Where the names are
            declared, or stand all in a dict, such names are no error: they are there for other formulas too.
        numbers: how letters are numbered; None: by their bitmasks.

    Raises:
        UnknownNameError: a proposition that no label produces; suggests the nearest names.
        InvalidArgumentError: `labels` is nothing of that kind, or the automaton lacks the proposition "hold".
    """
    if labels is None:
        return Labeller(_InfoSource(), _letters_of_env(aps, env, extra_labels, numbers), env)
    source = Source(labels)
    return Labeller(source, Letters(aps, source.propositions, extra_labels, numbers), env)


class VectorLabeller:
    """Letters of the observations of a vector environment.

    Functions of one observation are called for each sub-environment in turn; what labels whole batches, and what the
    environment puts into its infos, is taken as it comes, which is faster.

    Args:
        labels: as for a single environment.
        batch_labels: a function of (observations) or (observations, infos), a dict of such predicates, or the text
            `module:name` of either.
        env: the vector environment.
        extra_labels: as for a single environment.
        autoreset_mode: of the vector environment.
        numbers: of the letters over the propositions of the automaton.

    Raises:
        UnknownNameError: see `labeller_for`.
        InvalidArgumentError: see `labeller_for`; both kinds of labels are given; or a function asks for the
            sub-environment where it cannot be had.
    """

    def __init__(
        self,
        labels: LabelSource,
        batch_labels: LabelSource,
        env: VectorEnv[Any, Any, Any],
        extra_labels: ExtraLabels,
        autoreset_mode: AutoresetMode,
        numbers: LetterNumbers,
    ) -> None:
        aps = numbers.aps
        if labels is not None and batch_labels is not None:
            raise InvalidArgumentError(
                "labels and batch_labels are both given; pass one: labels for a function of one observation, "
                "batch_labels for a function of the whole batch"
            )
        self._num_envs = env.num_envs
        self._space, self._batch_space = env.single_observation_space, env.observation_space
        self._each: list[Labeller] = []
        if labels is None and batch_labels is None:
            self._source: Source = _InfoSource()
            self._letters = _letters_of_env(aps, env, extra_labels, numbers)
            return
        self._source = Source(labels) if batch_labels is None else Source(batch_labels, BATCH_SIGNATURES)
        self._letters = Letters(aps, self._source.propositions, extra_labels, numbers)
        if batch_labels is not None:
            return
        if self._source.arity < 3:
            self._each = [Labeller(self._source, self._letters)] * env.num_envs
        else:
            inner = _sub_environments(env, self._source, autoreset_mode)
            self._each = [Labeller(self._source, self._letters, one) for one in inner]

    def of(self, observations: Any, infos: dict[str, Any], mask: BoolArray | None = None) -> IntArray:
        """The letters of a batch, shape (num_envs,), int64.

        Args:
            observations: of all sub-environments.
            infos: of all sub-environments.
            mask: which of them are labelled, shape (num_envs,); None: all. Letters of the others are 0.

        Raises:
            UnknownNameError: as `Labeller.letter`.
            InvalidArgumentError: as `Labeller.letter`, or a batch of labels has the wrong shape.
        """
        if self._each:
            return self._one_by_one(iterate(self._batch_space, observations), infos, mask)
        if mask is None or mask.all():
            return self._of_batch(observations, infos, self._num_envs)
        letters = np.zeros(self._num_envs, dtype=np.int64)
        chosen = np.flatnonzero(mask)
        if len(chosen):
            if self._source.labels is not None:
                observations = part(self._space, observations, chosen)
            letters[chosen] = self._of_batch(observations, select(infos, chosen), len(chosen))
        return letters

    def of_final(self, final_obs: Any, final_info: dict[str, Any], mask: BoolArray) -> IntArray:
        """The letters of last observations, shape (num_envs,), int64; 0 where `mask` is False.

        Args:
            final_obs: shape (num_envs,), object, as mode SAME_STEP has them.
            final_info: of all sub-environments.
            mask: which episodes have ended, shape (num_envs,).

        Raises:
            UnknownNameError: as `of`.
            InvalidArgumentError: as `of`.
        """
        if self._each:
            return self._one_by_one(final_obs, final_info, mask)
        letters = np.zeros(self._num_envs, dtype=np.int64)
        chosen = np.flatnonzero(mask)
        observations = None
        if self._source.labels is not None:
            empty: Any = create_empty_array(self._space, len(chosen))
            observations = concatenate(self._space, list(final_obs[chosen]), empty)
        letters[chosen] = self._of_batch(observations, select(final_info, chosen), len(chosen))
        return letters

    def _one_by_one(self, observations: Any, infos: dict[str, Any], mask: BoolArray | None) -> IntArray:
        letters = np.zeros(self._num_envs, dtype=np.int64)
        wants_info = self._source.arity > 1
        for i, observation in enumerate(observations):
            if mask is None or mask[i]:
                try:
                    letters[i] = self._each[i].letter(observation, SubInfo(infos, i) if wants_info else _NO_INFO)
                except Exception as error:
                    error.add_note(
                        "labels are given the observation of one sub-environment; what labels a whole batch at once "
                        "is passed as batch_labels"
                    )
                    raise
        return letters

    def _of_batch(self, observations: Any, infos: dict[str, Any], n: int) -> IntArray:
        arguments = (observations, infos)[: self._source.arity]
        if self._source.labels is None:
            _check_all_have_labels(infos)
        return self._letters.of_batch(self._source.function(*arguments), n)


class _InfoSource(Source):
    """Labels that the environment puts into its infos."""

    def __init__(self) -> None:
        super().__init__(None)

    def _find(self) -> None:
        self.given = None
        self.function, self.arity, self.propositions = _from_info, 2, None


def _from_info(observation: Any, info: dict[str, Any]) -> Any:
    try:
        return info["labels"]
    except KeyError:
        raise InvalidArgumentError(
            f"info has no entry 'labels' (it has: {', '.join(map(repr, info)) or 'nothing'}); "
            "pass labels=..., a function of the observation or a dict of predicates"
        ) from None


def _check_all_have_labels(infos: dict[str, Any]) -> None:
    present = infos.get("_labels")
    if present is not None and not present.all():
        raise InvalidArgumentError(
            f"the infos of {int((~present).sum())} of {len(present)} sub-environments have no entry 'labels', and "
            "those of the others have; put it into the info of every reset and step"
        )


def _letters_of_env(
    aps: tuple[str, ...], env: Any, extra_labels: ExtraLabels, numbers: LetterNumbers | None
) -> Letters:
    """Letters of labels that an environment gives itself."""
    vocabulary = _declared_by(env)
    if vocabulary is None:
        return Letters(aps, None, extra_labels, numbers)
    if HOLD in vocabulary and HOLD not in aps:
        raise InvalidArgumentError(
            f"this environment holds the automaton when a label is missed: make the task with hold={HOLD!r}"
        )
    return Letters(aps, vocabulary, extra_labels, numbers)


def _declared_by(env: Any) -> tuple[str, ...] | None:
    base = env.unwrapped
    names = getattr(base, "propositions", None)
    if names is not None:
        return tuple(names)
    if isinstance(base, SyncVectorEnv | AsyncVectorEnv) and all(base.call("has_wrapper_attr", "propositions")):
        return tuple(base.get_attr("propositions")[0])
    return None


def _sub_environments(env: VectorEnv[Any, Any, Any], source: Source, autoreset_mode: AutoresetMode) -> list[Any]:
    base: Any = env.unwrapped
    what = f"labels: {described(source.function)} asks for the environment"
    instead = "put LTLWrapper around each sub-environment instead"
    inner = getattr(base, "envs", None)
    if isinstance(base, AsyncVectorEnv):
        raise InvalidArgumentError(
            f"{what}, and sub-environments of AsyncVectorEnv live in processes of their own; take SyncVectorEnv, or "
            f"{instead}"
        )
    if inner is None or len(inner) != env.num_envs:
        raise InvalidArgumentError(f"{what}, and {type(base).__name__} has no sub-environments to hand out; {instead}")
    if autoreset_mode == AutoresetMode.SAME_STEP:
        raise InvalidArgumentError(
            f"{what}, which in autoreset mode SAME_STEP is in its next episode already when the last observation of an "
            f"episode is labelled; take mode NEXT_STEP or DISABLED, or {instead}"
        )
    return list(inner)
