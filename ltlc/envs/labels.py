"""Labels: from what an environment shows to the letters an automaton reads.

A label says which propositions hold. Whatever produces it, it may come as a set, list or tuple of names, as an event
string ("A B", "A,B", ""), as a dict from name to bool, or, where the producer declares its vocabulary, as a bitmask
(bit i = i-th name) or a boolean array. From a vector environment the same comes batched: an array of bitmasks or of
strings, a boolean array (num_envs, n_names), a dict from name to boolean array, or a sequence of single labels.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

from ltlc.automata.rabin import MAX_APS
from ltlc.envs.grid_map import HOLD
from ltlc.errors import AlphabetLimitExceeded, InvalidArgumentError, UnknownNameError

IntArray = npt.NDArray[np.int64]
ExtraLabels = Literal["error", "ignore"]
Predicate = Callable[[Any], Any]
LabelSource = Callable[[Any, dict[str, Any]], Any] | Mapping[str, Predicate] | None


@dataclass(frozen=True)
class LabelFunction:
    """A labelling function `(observation, info) -> label` that declares which names it can produce.

    Declaring them lets misspelt propositions be found before the first step.
    """

    function: Callable[[Any, dict[str, Any]], Any]
    propositions: tuple[str, ...]

    def __call__(self, observation: Any, info: dict[str, Any]) -> Any:
        """The label of one observation, or of a batch."""
        return self.function(observation, info)


def labeller_for(labels: LabelSource, aps: Sequence[str], env: Any, extra_labels: ExtraLabels = "error") -> Labeller:
    """What turns the observations and infos of an environment into letters over `aps`.

    Args:
        labels: a function of (observation, info); a dict of named predicates on the observation; or None for
            `info["labels"]`, whose vocabulary is the attribute `propositions` of the environment if it has one.
        aps: the propositions of the automaton.
        env: the environment.
        extra_labels: whether a label that the formula does not mention is an error or ignored. Labels that an
            environment declares itself are no error: they are there for other formulas too.

    Raises:
        UnknownNameError: a proposition that no label produces, or the reverse; suggests the nearest names.
        InvalidArgumentError: `labels` is nothing of that kind, or the automaton lacks the proposition "hold".
    """
    if extra_labels not in ("error", "ignore"):
        raise UnknownNameError("treatment of extra labels", extra_labels, ("error", "ignore"))
    source: Callable[[Any, dict[str, Any]], Any]
    if labels is None:
        source, vocabulary = _from_info, _declared_by(env)
        if vocabulary is not None:
            extra_labels = "ignore"
            if HOLD in vocabulary and HOLD not in aps:
                raise InvalidArgumentError(
                    f"this environment holds the automaton when a label is missed: make the task with hold={HOLD!r}"
                )
    elif isinstance(labels, Mapping):
        source, vocabulary = _FromPredicates(labels), tuple(labels)
    elif callable(labels):
        source, declared = labels, getattr(labels, "propositions", None)
        vocabulary = None if declared is None else tuple(declared)
    else:
        raise InvalidArgumentError(
            f"labels must be a function of (observation, info), a dict of predicates, or None, got {labels!r}"
        )
    return Labeller(source, tuple(aps), vocabulary, extra_labels)


def _declared_by(env: Any) -> tuple[str, ...] | None:
    base = env.unwrapped
    names = getattr(base, "propositions", None)
    if names is not None:
        return tuple(names)
    if isinstance(base, SyncVectorEnv | AsyncVectorEnv) and all(base.call("has_wrapper_attr", "propositions")):
        return tuple(base.get_attr("propositions")[0])
    return None


def _from_info(observation: Any, info: dict[str, Any]) -> Any:
    try:
        return info["labels"]
    except KeyError:
        raise InvalidArgumentError(
            f"info has no entry 'labels' (it has: {', '.join(map(repr, info)) or 'nothing'}); "
            "pass labels=..., a function of (observation, info) or a dict of predicates"
        ) from None


class _FromPredicates:
    """Evaluates every predicate on the observation."""

    def __init__(self, predicates: Mapping[str, Predicate]) -> None:
        for name, predicate in predicates.items():
            if not callable(predicate):
                raise InvalidArgumentError(
                    f"the predicate {name!r} is {predicate!r}, not a function of the observation"
                )
        self.predicates = dict(predicates)

    def __call__(self, observation: Any, info: dict[str, Any]) -> dict[str, Any]:
        return {name: predicate(observation) for name, predicate in self.predicates.items()}


class Labeller:
    """Letters over the propositions of an automaton, for one environment or a batch; made by `labeller_for`."""

    def __init__(
        self,
        source: Callable[[Any, dict[str, Any]], Any],
        aps: tuple[str, ...],
        vocabulary: tuple[str, ...] | None,
        extra_labels: ExtraLabels,
    ) -> None:
        self.source = source
        self.aps = aps
        self.vocabulary = vocabulary
        self.extra_labels = extra_labels
        self._bit = {name: 1 << i for i, name in enumerate(aps)}
        self._seen: dict[Any, int] = {}
        self._remap: IntArray | None = None
        if vocabulary is not None:
            for name in aps:
                if name not in vocabulary:
                    raise UnknownNameError("proposition in the formula (no label produces it):", name, vocabulary)
            for name in vocabulary:
                self._name_bit(name)

    def letter(self, observation: Any, info: dict[str, Any]) -> int:
        """The letter of one observation.

        Raises:
            UnknownNameError: a label is not a proposition of the formula, or not one that was declared.
            InvalidArgumentError: the label is of a wrong type, or missing.
        """
        label = self.source(observation, info)
        if type(label) is frozenset or type(label) is str:
            letter = self._seen.get(label)
            if letter is not None:
                return letter
        return self._encode(label)

    def letters(self, observations: Any, infos: dict[str, Any], n: int) -> IntArray:
        """The letters of a batch of n observations, shape (n,), int64.

        Raises:
            UnknownNameError: as `letter`.
            InvalidArgumentError: as `letter`, or the batch has the wrong shape.
        """
        label = self.source(observations, infos)
        if isinstance(label, Mapping):
            return self._encode_columns(label, n)
        if isinstance(label, np.ndarray) and label.dtype.kind in "iubf":
            return self._encode_array(label, n)
        if isinstance(label, Iterable) and not isinstance(label, str | set | frozenset):
            each = list(label)
            if len(each) == n:
                return np.fromiter(map(self._encode, each), dtype=np.int64, count=n)
        raise InvalidArgumentError(f"labels of {n} sub-environments are {label!r}; {_BATCHED}")

    def _encode(self, label: Any) -> int:
        try:
            known = self._seen.get(label)
        except TypeError:  # not hashable
            known = None
        if known is not None and type(label) in (frozenset, str, tuple):
            return known
        if isinstance(label, np.ndarray) and label.dtype.kind in "iubf":
            return int(self._encode_array(label[None], 1)[0])
        if isinstance(label, int | np.integer) and not isinstance(label, bool):
            return int(self._encode_array(np.array([label]), 1)[0])
        letter = 0
        for name, holds in names_of(label).items():
            bit = self._name_bit(name)  # also where it does not hold: a misspelt name never would
            letter |= bit if holds else 0
        if isinstance(label, frozenset | str | tuple) and len(self._seen) < 1 << 16:
            self._seen[label] = letter
        return letter

    def _name_bit(self, name: str) -> int:
        """Bit of a name, 0 if it is not the formula's and that is allowed."""
        if self.vocabulary is not None and name not in self.vocabulary:
            raise UnknownNameError("label (not among the declared ones)", name, self.vocabulary)
        bit = self._bit.get(name)
        if bit is not None:
            return bit
        if self.extra_labels == "error":
            kind = 'label (the formula does not mention it; extra_labels="ignore" permits it):'
            raise UnknownNameError(kind, name, self.aps)
        return 0

    def _encode_columns(self, label: Mapping[str, Any], n: int) -> IntArray:
        letters = np.zeros(n, dtype=np.int64)
        for name, column in label.items():
            if name.startswith("_") and name[1:] in label:
                continue  # Gymnasium's mask of the sub-environments that have the entry
            holds = np.asarray(column)
            if holds.dtype == object:
                holds = np.array([_truth(name, value) if value is not None else False for value in holds], dtype=bool)
            if holds.shape != (n,) or holds.dtype != np.bool_:
                raise InvalidArgumentError(
                    f"the label {name!r} of {n} sub-environments has shape {holds.shape} and type {holds.dtype}; "
                    f"it must be a boolean array of shape ({n},)"
                )
            letters |= np.where(holds, self._name_bit(name), 0)
        return letters

    def _encode_array(self, label: npt.NDArray[Any], n: int) -> IntArray:
        if label.dtype.kind == "f":
            what = "NaN" if np.isnan(label).any() else f"of type {label.dtype}"
            raise InvalidArgumentError(f"labels are {what}; {_BATCHED}")
        if self.vocabulary is None:
            raise InvalidArgumentError(
                "bitmask and boolean-array labels need a vocabulary: wrap the function in LabelFunction(..., names)"
            )
        width = len(self.vocabulary)
        if label.dtype == np.bool_:
            if label.shape != (n, width):
                raise InvalidArgumentError(f"boolean labels have shape {label.shape}, expected ({n}, {width})")
            label = label @ (1 << np.arange(width, dtype=np.int64))
        if label.shape != (n,):
            raise InvalidArgumentError(f"bitmask labels have shape {label.shape}, expected ({n},)")
        if self.vocabulary == self.aps:
            return label.astype(np.int64)
        remap = self._bitmask_remap()
        try:
            return remap.take(label)
        except IndexError:
            raise InvalidArgumentError(f"a bitmask label is outside 0..{len(remap) - 1}") from None

    def _bitmask_remap(self) -> IntArray:
        """Letter over the automaton's propositions for each bitmask over the vocabulary."""
        if self._remap is None:
            names = self.vocabulary or ()
            if len(names) > MAX_APS:
                raise AlphabetLimitExceeded(f"bitmask labels over {len(names)} names; at most {MAX_APS} are possible")
            masks = np.arange(1 << len(names), dtype=np.int64)
            self._remap = np.zeros_like(masks)
            for i, name in enumerate(names):
                self._remap |= np.where(masks >> i & 1, self._bit.get(name, 0), 0)
        return self._remap


_SINGLE = "expected a set of names, an event string, a dict from name to bool, or a bitmask"
_BATCHED = (
    "expected an array of bitmasks or of event strings, a boolean array with a column per name, a dict from name to "
    "boolean array, or a sequence of single labels"
)


def names_of(label: Any) -> dict[str, bool]:
    """The names that a single label speaks of, and whether each holds.

    Raises:
        InvalidArgumentError: the label is no set of names, event string or dict from name to bool.
    """
    if isinstance(label, Mapping):
        return {name: _truth(name, holds) for name, holds in label.items()}
    if isinstance(label, str):
        return {name: True for name in re.split(r"[\s,;&]+", label) if name}
    if not isinstance(label, Iterable):
        raise InvalidArgumentError(f"a label is {label!r} ({type(label).__name__}); {_SINGLE}")
    names = list(label)
    for name in names:
        if not isinstance(name, str):
            raise InvalidArgumentError(f"a label contains {name!r} ({type(name).__name__}); {_SINGLE}")
    return dict.fromkeys(names, True)


def _truth(name: str, value: Any) -> bool:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, np.ndarray) and value.dtype == np.bool_ and value.size == 1:
        return bool(value.item())
    raise InvalidArgumentError(
        f"the label {name!r} is {value!r} ({type(value).__name__}); a predicate must say True or False"
    )
