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
    Historically,
    Iff,
    Implies,
    LassoWord,
    Next,
    Not,
    Once,
    Or,
    Proposition,
    Release,
    Since,
    StrongRelease,
    Triggered,
    Until,
    WeakUntil,
    WeakYesterday,
    Xor,
    Yesterday,
    fold,
)

UNARY = (Not, Next, Eventually, Always)
BINARY = (And, Or, Until, Release, WeakUntil, StrongRelease)
SUGAR = (Implies, Iff, Xor)
PAST_UNARY = (Yesterday, WeakYesterday, Once, Historically)


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


def random_past(rng: random.Random, size: int, names: Sequence[str] = ("a", "b", "c")) -> Formula:
    """A formula about the past and the present, of about `size` nodes."""
    if size <= 1:
        return rng.choice((TRUE, FALSE)) if rng.random() < 0.05 else Proposition(rng.choice(names))
    if size == 2 or rng.random() < 0.5:
        return rng.choice((Not, *PAST_UNARY))(random_past(rng, size - 1, names))
    left = rng.randrange(1, size - 1)
    operator = rng.choice((And, Or, Implies, Iff, Xor, Since, Triggered))
    return operator(random_past(rng, left, names), random_past(rng, size - 1 - left, names))


def random_with_past(rng: random.Random, size: int, names: Sequence[str] = ("a", "b", "c")) -> Formula:
    """A formula of about `size` nodes, some of whose leaves speak about the past."""
    leaves = {name: random_past(rng, rng.randint(1, 4), names) for name in ("p", "q", "r")}
    formula = random_formula(rng, size, (*names, *leaves))

    def replaced(node: Formula, args: list[Formula]) -> Formula:
        known = leaves.get(node.name) if isinstance(node, Proposition) else None
        return known or node.with_args(tuple(args))

    return fold(formula, {}, replaced)


def random_word(rng: random.Random, names: Sequence[str] = ("a", "b", "c"), longest: int = 4) -> LassoWord:
    """A word with prefix and cycle of at most `longest` letters each."""

    def letters(least: int) -> list[list[str]]:
        return [[name for name in names if rng.random() < 0.5] for _ in range(rng.randint(least, longest))]

    return LassoWord(letters(0), letters(1))


def random_next_chain(rng: random.Random, names: Sequence[str]) -> Formula:
    """Operands behind chains of X, joined by any two operators."""

    def part() -> Formula:
        formula = random_formula(rng, rng.randint(1, 3), names)
        for _ in range(rng.randint(0, 3)):
            formula = Next(formula)
        return formula

    first, second = rng.choice(BINARY), rng.choice(BINARY + SUGAR)
    return rng.choice((Eventually, Always, Next))(second(first(part(), part()), part()))


def random_nesting(rng: random.Random, names: Sequence[str]) -> Formula:
    """G and F in turns, three or four deep, with an operator between them."""
    formula = random_formula(rng, rng.randint(1, 3), names)
    for _ in range(rng.randint(2, 4)):
        formula = rng.choice((Always, Eventually))(formula)
        if rng.random() < 0.5:
            other = random_formula(rng, rng.randint(1, 3), names)
            formula = rng.choice(BINARY)(*rng.sample([formula, other], 2))
    return formula


def random_task(rng: random.Random, names: Sequence[str]) -> Formula:
    """What an agent is asked to do: reach and avoid, in sequence, patrol, respond, settle; or two of these."""

    def place() -> Formula:
        name = Proposition(rng.choice(names))
        return name if rng.random() < 0.8 else Not(name)

    def sequence(length: int) -> Formula:
        return Eventually(And(place(), sequence(length - 1)) if length > 1 else place())

    kind = rng.randrange(7)
    if kind == 0:
        return And(sequence(rng.randint(1, 3)), Always(Not(place())))
    if kind == 1:
        return Until(Not(place()), And(place(), Until(Not(place()), place())))
    if kind == 2:
        return And(*(Always(Eventually(place())) for _ in range(rng.randint(1, 3))), Always(Not(place())))
    if kind == 3:
        return Always(Implies(place(), rng.choice((Eventually, Next))(And(place(), Eventually(place())))))
    if kind == 4:
        return Or(And(Eventually(Always(place())), sequence(2)), Always(Eventually(place())))
    return rng.choice((And, Or, Implies, Iff))(random_task(rng, names), random_task(rng, names))
