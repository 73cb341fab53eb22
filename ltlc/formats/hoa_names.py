"""The acceptance conditions that have names in HOA, and whether a condition is what its name says."""

from __future__ import annotations

from collections.abc import Sequence

from ltlc.arrays import BoolArray, np
from ltlc.formats.hoa_acceptance import AcceptanceSet, Atom, sets_of
from ltlc.ltl.formula import FALSE, TRUE, And, Formula, Or, Proposition
from ltlc.ltl.traversal import postorder

_EXACT = 12
"""sets up to which two conditions are compared in all cases."""
_SAMPLES = 2_000
"""cases in which they are compared where there are more."""


def rabin(n_pairs: int) -> Formula:
    """`Fin(2i) & Inf(2i+1)` for some pair i."""
    return Or(*(And(_fin(2 * i), _inf(2 * i + 1)) for i in range(n_pairs)))


def is_misnamed(condition: Formula, name: Sequence[str]) -> bool:
    """Whether a condition is not what its name says; a name that HOA does not define says nothing.

    Args:
        condition: its atoms are named like `Fin(!3)`.
        name: the words of the header acc-name.
    """
    kind, *words = name
    most = max(2 * len(sets_of(condition)) + 2, len(words))  # a billion sets differ as these do
    numbers = [min(int(word[:9]), most) for word in words if word.isdecimal()]
    patterns = _patterns(kind, words, numbers)
    return bool(patterns) and all(_differ(condition, pattern) for pattern in patterns)


def _patterns(kind: str, words: Sequence[str], numbers: Sequence[int]) -> list[Formula]:
    """The conditions with this name: none if HOA does not define it, two where versions of HOA disagree."""
    match kind, words:
        case "all", []:
            return [TRUE]
        case "none", []:
            return [FALSE]
        case "Buchi", []:
            return [_inf(0)]
        case "co-Buchi", []:
            return [_fin(0)]
        case "parity", [("min" | "max") as first, ("even" | "odd") as wanted, _] if numbers:
            # of a run that takes no set infinitely often, one version says yes where another one says no
            return [_parity(first, wanted, numbers[0], default) for default in (FALSE, TRUE)]
    if not numbers or len(numbers) != len(words):
        return []
    n, *sizes = numbers
    if kind == "generalized-Rabin" and len(sizes) == n:
        starts = [sum(sizes[:i]) + i for i in range(n)]
        pairs = [range(start + 1, start + 1 + size) for start, size in zip(starts, sizes, strict=True)]
        return [Or(*(And(_fin(start), *map(_inf, infs)) for start, infs in zip(starts, pairs, strict=True)))]
    if sizes:
        return []
    match kind:
        case "generalized-Buchi":
            return [And(*map(_inf, range(n)))]
        case "generalized-co-Buchi":
            return [Or(*map(_fin, range(n)))]
        case "Streett":
            return [And(*(Or(_fin(2 * i), _inf(2 * i + 1)) for i in range(n)))]
        case "Rabin":
            return [rabin(n)]
    return []


def _parity(first: str, wanted: str, n: int, default: Formula) -> Formula:
    """The least or greatest set that is taken infinitely often is even or odd."""
    condition = default
    for number in reversed(range(n)) if first == "min" else range(n):
        accepts = number % 2 == (wanted == "odd")
        condition = Or(_inf(number), condition) if accepts else And(_fin(number), condition)
    return condition


def _fin(number: int) -> Formula:
    return Proposition(f"Fin({number})")


def _inf(number: int) -> Formula:
    return Proposition(f"Inf({number})")


def _differ(one: Formula, other: Formula) -> bool:
    """Whether two conditions are seen to differ; those of more than `_EXACT` sets are compared by samples."""
    if one is other:
        return False
    sets = sorted({*sets_of(one), *sets_of(other)})
    n = len(sets)
    if n <= _EXACT:
        taken = (np.arange(1 << n)[:, None] >> np.arange(n) & 1).astype(np.bool_)
    else:
        density = np.random.default_rng(0).random((_SAMPLES, 1))
        taken = np.random.default_rng(1).random((_SAMPLES, n)) < density**4  # few sets matter most, as in parity
        taken = np.concatenate([taken, ~taken, np.eye(n, dtype=np.bool_), np.zeros((1, n), dtype=np.bool_)])
    column = {key: taken[:, i] for i, key in enumerate(sets)}
    return not np.array_equal(_truth(one, column, len(taken)), _truth(other, column, len(taken)))


def _truth(condition: Formula, taken: dict[AcceptanceSet, BoolArray], size: int) -> BoolArray:
    """Where a condition holds, by whether each set, and each complement of one, is taken infinitely often."""
    value: dict[Formula, BoolArray] = {}
    for node in postorder(condition):
        parts = [value[arg] for arg in node.args]
        if isinstance(node, Proposition):
            atom = Atom.parse(node.name)
            value[node] = taken[atom.of] ^ (not atom.is_inf)
        elif isinstance(node, And):
            value[node] = np.logical_and.reduce(parts)
        else:
            value[node] = np.logical_or.reduce(parts) if isinstance(node, Or) else np.full(size, node is TRUE)
    return value[condition]
