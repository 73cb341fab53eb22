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

from ltlc.automata.alphabet import letter_classes, proposition_column
from ltlc.automata.rabin import MAX_APS, BoolArray
from ltlc.errors import AlphabetLimitExceeded
from ltlc.ltl import And, Constant, Formula, Not, Or, Proposition, postorder

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
    truth: dict[Formula, BoolArray] = {}
    maximal: dict[Formula, None] = {}
    for f in postorder(formula):
        if isinstance(f, _BOOLEAN) and all(arg in truth for arg in f.args):
            truth[f] = _truth(f, truth, aps)
            maximal[f] = None
        if isinstance(f, _BOOLEAN) and f in truth:
            for arg in f.args:
                maximal.pop(arg, None)
    for f in postorder(formula):
        if f not in truth:
            maximal.update((arg, None) for arg in f.args if arg in truth)
    letter_class, first = letter_classes([truth[f] for f in maximal], len(aps))
    sets = {f: _as_letter_set(truth[f][first]) for f in maximal}
    return Letters(aps, letter_class, len(first), sets)


def _truth(f: Formula, truth: dict[Formula, BoolArray], aps: tuple[str, ...]) -> BoolArray:
    """The letters on which a Boolean formula holds, from those of its operands."""
    if isinstance(f, Proposition):
        return proposition_column(aps.index(f.name), len(aps))
    if isinstance(f, Constant):
        return np.full(2 ** len(aps), f.value)
    columns = [truth[arg] for arg in f.args]
    if isinstance(f, Not):
        return ~columns[0]
    return reduce(np.logical_and if isinstance(f, And) else np.logical_or, columns)


def _as_letter_set(column: BoolArray) -> int:
    return int.from_bytes(np.packbits(column, bitorder="little").tobytes(), "little")
