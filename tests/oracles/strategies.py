"""Random formulas and words shared by the tests; every test seeds its own `random.Random`, so that failures repeat."""

from __future__ import annotations

import random
from collections.abc import Sequence

from ltlc.ltl.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Iff,
    Implies,
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
from ltlc.ltl.semantics import LassoWord

# A kind is listed as often as it is to be drawn: the modalities people write most appear most.
UNARY = (Not, Next, Eventually, Eventually, Always, Always)
BINARY = (And, And, Or, Or, Until, Until, Implies, Release, WeakUntil, StrongRelease, Iff, Xor)


def random_formula(rng: random.Random, aps: Sequence[str], size: int) -> Formula:
    """A formula over `aps` with `size` operators and operands (at least 1), constants included now and then."""
    if size <= 1:
        return rng.choice((TRUE, FALSE)) if not aps or rng.random() < 0.03 else Proposition(rng.choice(aps))
    if size == 2 or rng.random() < 0.4:
        return rng.choice(UNARY)(random_formula(rng, aps, size - 1))
    left = rng.randint(1, size - 2)
    operator: type[Formula] = rng.choice(BINARY)
    return operator(random_formula(rng, aps, left), random_formula(rng, aps, size - 1 - left))


def random_letter(rng: random.Random, aps: Sequence[str]) -> frozenset[str]:
    """A set of propositions, each in it with probability one half."""
    return frozenset(name for name in aps if rng.random() < 0.5)


def random_word(rng: random.Random, aps: Sequence[str], max_prefix: int = 4, max_cycle: int = 4) -> LassoWord:
    """An ultimately periodic word over `aps`: up to `max_prefix` letters, then 1 to `max_cycle` letters for ever."""
    prefix = tuple(random_letter(rng, aps) for _ in range(rng.randint(0, max_prefix)))
    cycle = tuple(random_letter(rng, aps) for _ in range(rng.randint(1, max_cycle)))
    return LassoWord(prefix, cycle)
