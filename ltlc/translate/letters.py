"""The letters of an alphabet, grouped into the classes that a formula tells apart.

A **letter set** is a Python integer, bit c = letter class c. Intersection, union and complement are single operations,
for four propositions as for twenty.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import NamedTuple

from ltlc.arrays import Numbers
from ltlc.automata.columns import grouped, n_classes
from ltlc.automata.possible import LetterNumbers, Possible
from ltlc.budget import check_time
from ltlc.ltl import And, Constant, Formula, Not, Or, Proposition, postorder

_BOOLEAN = frozenset({Constant, Proposition, Not, And, Or})


class Letters(NamedTuple):
    """The possible letters, grouped into the classes that a formula tells apart."""

    aps: tuple[str, ...]
    letter_class: Numbers
    """the class of each letter; a list where there are few."""
    n_classes: int
    sets: Mapping[Formula, int]
    """the letter set of each Boolean subformula that no larger one contains."""
    possible: Possible | None = None
    """which letters are possible; None: all 2**len(aps)."""

    @property
    def all(self) -> int:
        """The letter set of every letter."""
        return (1 << self.n_classes) - 1


def letters_of(formula: Formula, aps: tuple[str, ...], possible: Possible | None = None) -> Letters:
    """Group the letters by the maximal Boolean subformulas that hold on them; each becomes one letter set.

    Args:
        formula: in negation normal form.
        aps: the propositions of the alphabet, at least those of the formula.
        possible: which letters are possible; None: all.

    Raises:
        AlphabetLimitExceeded: there are too many letters for tables.
    """
    numbers = LetterNumbers(aps, possible)
    truth: dict[Formula, int] = {}
    maximal: dict[Formula, None] = {}
    nodes = list(postorder(formula))
    for f in nodes:
        if type(f) in _BOOLEAN and all(arg in truth for arg in f.args):
            check_time()
            truth[f] = _truth(f, truth, numbers)
            maximal[f] = None
            for arg in f.args:
                maximal.pop(arg, None)
    for f in nodes:
        if f not in truth:
            maximal.update((arg, None) for arg in f.args if arg in truth)
    letter_class, sets = grouped([truth[f] for f in maximal], numbers.size)
    return Letters(aps, letter_class, n_classes(letter_class), dict(zip(maximal, sets, strict=True)), possible)


def _truth(f: Formula, truth: dict[Formula, int], numbers: LetterNumbers) -> int:
    """The truth table of a Boolean formula (bit k = value at letter k), from those of its operands."""
    everywhere = numbers.all
    if isinstance(f, Proposition):
        return numbers.holding(numbers.aps.index(f.name))
    if isinstance(f, Constant):
        return everywhere if f.value else 0
    tables = [truth[arg] for arg in f.args]
    if isinstance(f, Not):
        return everywhere & ~tables[0]
    return reduce(int.__and__ if isinstance(f, And) else int.__or__, tables)
