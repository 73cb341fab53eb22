"""The letters of an alphabet, grouped into the classes that a formula tells apart.

A **letter set** is a Python integer, bit c = letter class c. Intersection, union and complement are single operations,
for four propositions as for twenty.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ltlc.automata.rabin import MAX_APS
from ltlc.errors import AlphabetLimitExceeded
from ltlc.ltl import And, Constant, Formula, Not, Or, Proposition, postorder

_COLUMNS_AT_ONCE = 40
"""truth values that fit, with the up to 2**20 classes before them, into 64 bits."""
_BOOLEAN = (Constant, Proposition, Not, And, Or)


class Letters(NamedTuple):
    """The letters of 2^aps, grouped into the classes that a formula tells apart."""

    aps: tuple[str, ...]
    letter_class: npt.NDArray[np.int32]
    n_classes: int
    sets: Mapping[Formula, int]
    """the letter set of each Boolean subformula that no larger one contains."""

    @property
    def all(self) -> int:
        """The letter set of every letter."""
        return (1 << self.n_classes) - 1


def letters_of(formula: Formula, aps: tuple[str, ...]) -> Letters:
    """Group the letters by the maximal Boolean subformulas that hold on them; each becomes one letter set.

    Args:
        formula: in negation normal form.
        aps: the propositions of the alphabet, at least those of the formula.

    Raises:
        AlphabetLimitExceeded: there are more than `MAX_APS` propositions.
    """
    if len(aps) > MAX_APS:
        raise AlphabetLimitExceeded(
            f"the formula has {len(aps)} atomic propositions; tables over letters hold at most {MAX_APS}"
        )
    letter = np.arange(2 ** len(aps), dtype=np.int64)
    truth: dict[Formula, npt.NDArray[np.bool_]] = {}
    maximal: dict[Formula, None] = {}
    for f in postorder(formula):
        if isinstance(f, _BOOLEAN) and all(arg in truth for arg in f.args):
            truth[f] = _truth(f, truth, aps, letter)
            maximal[f] = None
        if isinstance(f, _BOOLEAN) and f in truth:
            for arg in f.args:
                maximal.pop(arg, None)
    for f in postorder(formula):
        if f not in truth:
            maximal.update((arg, None) for arg in f.args if arg in truth)
    columns = list(maximal)
    classes = np.zeros(len(letter), dtype=np.int64)
    for start in range(0, len(columns), _COLUMNS_AT_ONCE):
        for f in columns[start : start + _COLUMNS_AT_ONCE]:
            classes = classes << 1 | truth[f]
        _, first, classes = np.unique(classes, return_index=True, return_inverse=True)
    if columns:
        order = np.argsort(first)
        first, classes = first[order], np.argsort(order)[classes]
    else:
        first = np.zeros(1, dtype=np.int64)
    sets = {f: _as_letter_set(truth[f][first]) for f in columns}
    return Letters(aps, classes.astype(np.int32), len(first), sets)


def _truth(
    f: Formula,
    truth: dict[Formula, npt.NDArray[np.bool_]],
    aps: tuple[str, ...],
    letter: npt.NDArray[np.int64],
) -> npt.NDArray[np.bool_]:
    if isinstance(f, Proposition):
        return (letter >> aps.index(f.name) & 1).astype(np.bool_)
    if isinstance(f, Constant):
        return np.full(len(letter), f.value)
    columns = [truth[arg] for arg in f.args]
    if isinstance(f, Not):
        return ~columns[0]
    return reduce(np.logical_and if isinstance(f, And) else np.logical_or, columns)


def _as_letter_set(column: npt.NDArray[np.bool_]) -> int:
    return int.from_bytes(np.packbits(column, bitorder="little").tobytes(), "little")
