"""What formulas mean, word for word as textbooks define it: positions, quantifiers, and nothing clever.

Formulas are taken by their symbols, so that nothing is shared with the library but the shape of its nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def holds(formula: Any, letters: Sequence[frozenset[str]], loop: int | None) -> bool:
    """Whether a word satisfies a formula at its first position.

    Args:
        formula: a node with `symbol` and `args`.
        letters: all letters of a finite trace; or of an infinite word the prefix and one round of the cycle.
        loop: where the cycle starts, or None for a finite trace.
    """
    if loop is None:
        return _Evaluator(list(letters), None, 0).at(formula, 0)
    cycle = len(letters) - loop
    # So many rounds are unrolled that what the past says about the last one is what it says about all later ones.
    rounds = _past_operators(formula) + 2
    unrolled = [*letters, *list(letters[loop:]) * rounds]
    return _Evaluator(unrolled, len(unrolled) - cycle, cycle).at(formula, 0)


def _past_operators(formula: Any) -> int:
    deepest = max((_past_operators(part) for part in formula.args), default=0)
    return deepest + (formula.symbol in ("Y", "Z", "O", "H", "S", "T"))


class _Evaluator:
    def __init__(self, letters: list[frozenset[str]], start: int | None, cycle: int) -> None:
        self.letters, self.start, self.cycle = letters, start, cycle
        self.known: dict[tuple[Any, int], bool] = {}

    def at(self, formula: Any, i: int) -> bool:
        if self.start is not None and i >= self.start + self.cycle:
            i = self.start + (i - self.start) % self.cycle
        if (formula, i) not in self.known:
            self.known[formula, i] = self.value(formula, i)
        return self.known[formula, i]

    def future(self, i: int) -> range:
        """The positions from i on: all of a finite trace, and of an infinite one enough to see each once."""
        if self.start is None:
            return range(i, len(self.letters))
        return range(i, max(i, self.start) + self.cycle)

    def has_next(self, i: int) -> bool:
        return self.start is not None or i + 1 < len(self.letters)

    def value(self, formula: Any, i: int) -> bool:
        symbol, args, at = formula.symbol, formula.args, self.at
        if symbol == "constant":
            return bool(formula.value)
        if symbol == "proposition":
            return formula.name in self.letters[i]
        a, b = args[0], args[-1]
        later, earlier = self.future(i), range(i + 1)
        match symbol:
            case "!":
                return not at(a, i)
            case "&":
                return all(at(part, i) for part in args)
            case "|":
                return any(at(part, i) for part in args)
            case "->":
                return not at(a, i) or at(b, i)
            case "<->":
                return at(a, i) == at(b, i)
            case "xor":
                return at(a, i) != at(b, i)
            case "X":
                return self.has_next(i) and at(a, i + 1)
            case "WX":
                return not self.has_next(i) or at(a, i + 1)
            case "F":
                return any(at(a, j) for j in later)
            case "G":
                return all(at(a, j) for j in later)
            case "U":
                return any(at(b, j) and all(at(a, k) for k in range(i, j)) for j in later)
            case "W":
                return all(at(a, j) for j in later) or any(
                    at(b, j) and all(at(a, k) for k in range(i, j)) for j in later
                )
            case "R":
                return all(at(b, j) or any(at(a, k) for k in range(i, j)) for j in later)
            case "M":
                return any(at(a, j) and all(at(b, k) for k in range(i, j + 1)) for j in later)
            case "Y":
                return i > 0 and at(a, i - 1)
            case "Z":
                return i == 0 or at(a, i - 1)
            case "O":
                return any(at(a, j) for j in earlier)
            case "H":
                return all(at(a, j) for j in earlier)
            case "S":
                return any(at(b, j) and all(at(a, k) for k in range(j + 1, i + 1)) for j in earlier)
            case "T":
                return all(at(b, j) or any(at(a, k) for k in range(j + 1, i + 1)) for j in earlier)
        raise AssertionError(symbol)
