"""Letters: labels as the numbers of letters that an automaton reads, one at a time or for a batch.

The number of a letter is its bitmask over the propositions of the automaton, unless letters are impossible there
(`ltlc.automata.possible`).

From a vector environment labels come batched: as an array of bitmasks or of event strings, a boolean array
(num_envs, n_names), a dict from name to boolean array, or a sequence of single labels.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from ltlc.automata.possible import LetterNumbers, Possible, mask_type, names_in
from ltlc.envs.labels import ExtraLabels, names_of, truth
from ltlc.errors import InvalidArgumentError, UnknownNameError

IntArray = npt.NDArray[np.int64]

_REMEMBERED = 1 << 16
"""labels whose letters are kept."""
_TABULATED = 21
"""Bitmasks over at most so many names have a table of letters."""
_BATCHED = (
    "expected an array of bitmasks or of event strings, a boolean array with a column per name, a dict from name to "
    "boolean array, or a sequence of single labels"
)


class Letters:
    """The letters of labels over the propositions of an automaton.

    Args:
        aps: the propositions.
        vocabulary: the names that labels are made of, if they are declared; then some may go unused.
        extra_labels: whether a name that the formula does not mention is an error or ignored, in a label whose
            vocabulary nobody knows. A dict states its own: further names in it are fine if all propositions are there.
        numbers: how letters are numbered; None: by their bitmasks, which are Python's integers if there are more than
            62 propositions.

    Attributes:
        known: letters of hashable labels seen before.

    Raises:
        UnknownNameError: a proposition that no label produces; suggests the nearest names.
    """

    def __init__(
        self,
        aps: tuple[str, ...],
        vocabulary: tuple[str, ...] | None,
        extra_labels: ExtraLabels,
        numbers: LetterNumbers | None = None,
    ) -> None:
        self.aps = aps
        self.vocabulary = vocabulary
        self.extra_labels = extra_labels
        self.known: dict[Any, int] = {}
        self._bit = {name: 1 << i for i, name in enumerate(aps)}
        self._remap: npt.NDArray[Any] | None = None
        self._numbers = None if numbers is None or numbers.possible is None else numbers
        self._mask_type = mask_type(len(aps))
        if vocabulary is not None:
            self._check_all_produced(vocabulary)

    def of(self, label: Any) -> int:
        """The letter of a single label.

        Raises:
            UnknownNameError: the label is not a proposition of the formula, or not one that was declared.
            ImpossibleLetterError: the letter was declared impossible.
            InvalidArgumentError: the label is of a wrong type.
        """
        if type(label) is dict or isinstance(label, Mapping):  # the former is faster
            return self._of_dict(label)
        if type(label) is set:
            label = frozenset(label)
        try:
            known = self.known.get(label)
        except TypeError:  # not hashable
            known = None
        if known is not None and type(label) in (frozenset, str, tuple):
            return known
        if isinstance(label, np.ndarray) and label.dtype.kind in "iubf":
            return int(self._numbered(self._of_array(label[None], 1))[0])
        if isinstance(label, int | np.integer) and not isinstance(label, bool):
            return int(self._numbered(self._of_array(np.array([label]), 1))[0])
        letter = 0
        for name in names_of(label):
            letter |= self._name_bit(name)
        letter = letter if self._numbers is None else self._numbers.number(letter)
        if isinstance(label, frozenset | str | tuple) and len(self.known) < _REMEMBERED:
            self.known[label] = letter
        return letter

    def _of_dict(self, label: Mapping[str, Any]) -> int:
        letter, further = 0, False
        for name, holds in label.items():
            bit = self._bit.get(name, 0)
            further |= not bit
            if holds is True or (holds is not False and truth(name, holds)):
                letter |= bit
        if further:
            self._check_further(label)
        return letter if self._numbers is None else self._numbers.number(letter)

    def _numbered(self, masks: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return masks if self._numbers is None else self._numbers.numbers(masks)

    def of_batch(self, label: Any, n: int) -> IntArray:
        """The letters of the labels of n sub-environments, shape (n,), int64.

        Raises:
            UnknownNameError: as `of`.
            InvalidArgumentError: as `of`, or the batch has the wrong shape.
        """
        if isinstance(label, Mapping):
            return self._numbered(self._of_columns(label, n))
        if isinstance(label, np.ndarray) and label.dtype.kind in "iubf":
            return self._numbered(self._of_array(label, n))
        if isinstance(label, Iterable) and not isinstance(label, str | set | frozenset):
            each = list(label)
            if len(each) == n:
                return np.fromiter(map(self.of, each), dtype=np.int64, count=n)
        raise InvalidArgumentError(f"labels of {n} sub-environments are {label!r}; {_BATCHED}")

    def _check_all_produced(self, names: Collection[str]) -> None:
        for name in self.aps:
            if name not in names:
                raise UnknownNameError("proposition in the formula (no label produces it):", name, names)

    def _check_further(self, names: Collection[str]) -> None:
        """Check the names of a dict of which some are not the formula's."""
        if self.vocabulary is not None:
            for name in names:
                self._name_bit(name)
        elif self.extra_labels == "error":  # a misspelt name never would hold
            self._check_all_produced(names)

    def _name_bit(self, name: str) -> int:
        """Bit of a name that holds, 0 if it is not the formula's and that is allowed."""
        if self.vocabulary is not None and name not in self.vocabulary:
            raise UnknownNameError("label (not among the declared ones)", name, self.vocabulary)
        bit = self._bit.get(name)
        if bit is None and self.vocabulary is None and self.extra_labels == "error":
            kind = (
                "label (the formula does not mention it; permitted where the function declares all its names, "
                'f.propositions = (...), or returns a dict of all, or by extra_labels="ignore"):'
            )
            raise UnknownNameError(kind, name, self.aps)
        return bit or 0

    def _of_columns(self, label: Mapping[str, Any], n: int) -> npt.NDArray[Any]:
        # Gymnasium's masks of the sub-environments that have an entry are no names.
        names = [name for name in label if not (name.startswith("_") and name[1:] in label)]
        if any(name not in self._bit for name in names):
            self._check_further(names)
        letters = np.zeros(n, dtype=self._mask_type)
        for name in names:
            holds = np.asarray(label[name])
            if holds.dtype == object:
                holds = np.array([truth(name, value) if value is not None else False for value in holds], dtype=bool)
            if holds.shape != (n,) or holds.dtype != np.bool_:
                raise InvalidArgumentError(
                    f"the label {name!r} of {n} sub-environments has shape {holds.shape} and type {holds.dtype}; "
                    f"it must be a boolean array of shape ({n},)"
                )
            letters |= np.where(holds, self._bit.get(name, 0), 0)
        return letters

    def _of_array(self, label: npt.NDArray[Any], n: int) -> npt.NDArray[Any]:
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
            weights = np.array([1 << i for i in range(width)], dtype=mask_type(width))
            label = label.astype(weights.dtype) @ weights
        if label.shape != (n,):
            raise InvalidArgumentError(f"bitmask labels have shape {label.shape}, expected ({n},)")
        if label.dtype != np.dtype(object):
            label = label.astype(np.int64)
            if n and int(label.view(np.uint64).max()) >> width:  # negative numbers are large ones here
                raise InvalidArgumentError(f"a bitmask label is outside 0..{(1 << width) - 1}")
        if self.vocabulary == self.aps:
            return label
        return self._bitmask_remap().take(label) if width <= _TABULATED else self._remapped(label)

    def _bitmask_remap(self) -> npt.NDArray[Any]:
        """Bitmask over the automaton's propositions for each bitmask over the vocabulary."""
        if self._remap is None:
            self._remap = self._remapped(np.arange(1 << len(self.vocabulary or ()), dtype=np.int64))
        return self._remap

    def _remapped(self, masks: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Bitmasks over the vocabulary as bitmasks over the automaton's propositions."""
        result = np.zeros(masks.shape, dtype=self._mask_type)
        for i, name in enumerate(self.vocabulary or ()):
            if name in self._bit:
                result |= np.where(masks >> i & 1, self._bit[name], 0)
        return result


def letter_names(aps: tuple[str, ...], letter: int, possible: Possible | None = None) -> frozenset[str]:
    """The propositions that hold in a letter, given as its number."""
    return names_in(aps, letter if possible is None else LetterNumbers(aps, possible).mask(letter))


class NamesOfLetters(dict[int, frozenset[str]]):
    """The propositions that hold in each letter, found when a letter is first asked for."""

    def __init__(self, aps: tuple[str, ...], possible: Possible | None = None) -> None:
        self.aps, self.possible = aps, possible

    def __missing__(self, letter: int) -> frozenset[str]:
        names = self[letter] = letter_names(self.aps, letter, self.possible)
        return names


class LabelNames(np.ndarray[Any, np.dtype[np.int64]]):
    """An array of letters whose entries show themselves as sets of names, made when they are looked at.

    Args:
        aps: the propositions.
        letters: shape (n,), int64; shared, not copied.
        possible: which letters are possible.

    Example:
        >>> LabelNames(("goal", "wall"), np.array([0, 1]))
        LabelNames([frozenset(), frozenset({'goal'})])
    """

    aps: tuple[str, ...]
    possible: Possible | None

    def __new__(cls, aps: tuple[str, ...], letters: IntArray, possible: Possible | None = None) -> LabelNames:
        """A view of the letters."""
        names = letters.view(cls)
        names.aps, names.possible = aps, possible
        return names

    def __array_finalize__(self, source: Any) -> None:
        self.aps = getattr(source, "aps", ())
        self.possible = getattr(source, "possible", None)

    def __getitem__(self, key: Any) -> Any:
        part = super().__getitem__(key)
        return part if isinstance(part, LabelNames) else letter_names(self.aps, int(part), self.possible)

    def tolist(self) -> Any:
        """The sets as a list."""
        return [self[i] for i in range(len(self))]

    def item(self, *key: Any) -> Any:
        """One of the sets."""
        return letter_names(self.aps, super().item(*key), self.possible)

    def __reduce__(self) -> Any:
        return LabelNames, (self.aps, np.asarray(self), self.possible)

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        return self.__reduce__()

    def __repr__(self) -> str:
        return f"LabelNames({list(self)})"
