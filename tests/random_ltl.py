"""Random formulas and random words for tests, reproducible by the generator that is passed in."""

from __future__ import annotations

import random
from collections.abc import Sequence

from ltlc.ltl import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Iff,
    Implies,
    LassoWord,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
)

UNARY = (Not, Next, Eventually, Always)
BINARY = (And, Or, Until, Release, WeakUntil, StrongRelease)
SUGAR = (Implies, Iff, Xor)


def random_formula(
    rng: random.Random,
    size: int,
    names: Sequence[str] = ("a", "b", "c"),
    *,
    sugar: bool = True,
    constants: float = 0.05,
) -> Formula:
    """A formula of about `size` nodes; `sugar` allows -> <-> xor, `constants` is how many leaves are true or false."""
    if size <= 1:
        return rng.choice((TRUE, FALSE)) if rng.random() < constants else Proposition(rng.choice(names))
    if size == 2 or rng.random() < 0.4:
        return rng.choice(UNARY)(random_formula(rng, size - 1, names, sugar=sugar, constants=constants))
    left = rng.randrange(1, size - 1)
    operator = rng.choice(BINARY + SUGAR if sugar else BINARY)
    return operator(
        random_formula(rng, left, names, sugar=sugar, constants=constants),
        random_formula(rng, size - 1 - left, names, sugar=sugar, constants=constants),
    )


def random_word(rng: random.Random, names: Sequence[str] = ("a", "b", "c"), longest: int = 4) -> LassoWord:
    """A word with prefix and cycle of at most `longest` letters each."""

    def letters(least: int) -> list[list[str]]:
        return [[name for name in names if rng.random() < 0.5] for _ in range(rng.randint(least, longest))]

    return LassoWord(letters(0), letters(1))
