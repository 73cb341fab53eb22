"""Formulas with bounds as texts, and what they mean, distance by distance."""

from __future__ import annotations

import random
from dataclasses import dataclass

Letters = list[frozenset[str]]


@dataclass(frozen=True)
class Bounded:
    """A formula: a name, or an operator with its bound (last None: without end) and its operands."""

    symbol: str
    args: tuple[Bounded, ...] = ()
    first: int = 0
    last: int | None = None
    spelling: str = ""

    def __str__(self) -> str:
        if not self.args:
            return self.symbol
        if len(self.args) == 1:
            return f"{self.symbol}{self.spelling} ({self.args[0]})"
        return f"({self.args[0]}) {self.symbol}{self.spelling} ({self.args[1]})"


def random_bounded(rng: random.Random, depth: int, names: str) -> Bounded:
    """A formula of at most so many nested operators."""
    if depth == 0 or rng.random() < 0.15:
        return Bounded(rng.choice(names))
    symbol = rng.choice(["!", "&", "|", "F", "G", "X", "U", "R", "W", "M", "U", "R"])
    args = tuple(random_bounded(rng, depth - 1, names) for _ in range(1 if symbol in "!FGX" else 2))
    if symbol in "!&|":
        return Bounded(symbol, args)
    first = rng.randint(0, 3)
    last = first if symbol == "X" else first + rng.randint(0, 3)
    spellings: list[tuple[int, int | None, str]] = [
        (first, last, f"[{first}:{last}]"),
        (first, last, f"[{first},{last}]"),
    ]
    if symbol == "X":
        spellings = [(first, first, f"[{first}]")]
    else:
        spellings += [(0, last, f"<={last}"), (first, None, f">={first}"), (first, None, f"[{first}:]")]
    return Bounded(symbol, args, *rng.choice(spellings))


def bounded_holds(formula: Bounded, letters: Letters, loop: int | None) -> bool:
    """Whether a word satisfies a formula at its first position; arguments as of `textbook.holds`."""
    known: dict[tuple[Bounded, int], bool] = {}
    size = len(letters)

    def place(i: int) -> int | None:
        """Where position i is among the letters, or None behind the end of a trace."""
        if i < size:
            return i
        return None if loop is None else loop + (i - loop) % (size - loop)

    def at(f: Bounded, i: int) -> bool:
        here = place(i)
        assert here is not None
        if (f, here) not in known:
            known[f, here] = value(f, here)
        return known[f, here]

    def distances(f: Bounded, i: int) -> list[int]:
        # Without end, all places have been seen after the letters twice over.
        last = f.first + 2 * size if f.last is None else f.last
        return [d for d in range(f.first, last + 1) if place(i + d) is not None]

    def value(f: Bounded, i: int) -> bool:
        if not f.args:
            return f.symbol in letters[i]
        a, b = f.args[0], f.args[-1]
        within = distances(f, i)
        match f.symbol:
            case "!":
                return not at(a, i)
            case "&":
                return at(a, i) and at(b, i)
            case "|":
                return at(a, i) or at(b, i)
            case "F" | "X":
                return any(at(a, i + d) for d in within)
            case "G":
                return all(at(a, i + d) for d in within)
            case "U":
                return any(at(b, i + d) and all(at(a, i + e) for e in range(d)) for d in within)
            case "R":
                return all(at(b, i + d) or any(at(a, i + e) for e in range(d)) for d in within)
            case "W":
                return all(at(a, i + d) or at(b, i + d) or any(at(b, i + e) for e in range(d)) for d in within)
            case "M":
                return any(at(a, i + d) and all(at(b, i + e) for e in range(d + 1)) for d in within)
        raise AssertionError(f.symbol)

    return at(formula, 0)
