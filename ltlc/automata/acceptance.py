"""Acceptance conditions on the marks that a run takes infinitely often, as disjunctions of clauses.

A clause (fin, inf, promises) holds iff no mark of `fin` and every mark of `inf` is taken infinitely often and, for each
promise (mark, partners), a partner is if the mark is. Every Boolean combination of Fin and Inf can be written
without promises; with them, Streett conditions stay small. Rabin pair i has Fin mark 2i and Inf mark 2i + 1, as in HOA.

References:
    E. A. Emerson, C.-L. Lei: Modalities for Model Checking: Branching Time Logic Strikes Back. Science of Computer
    Programming 8, 1987, doi 10.1016/0167-6423(87)90036-0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from ltlc.budget import check_time
from ltlc.graph import bits

_MANY = 16
"""A loop over more clauses than this asks for the time itself."""


class Clause(NamedTuple):
    """A conjunction; sets of marks are bit masks."""

    fin: int
    inf: int
    promises: tuple[tuple[int, int], ...] = ()
    """Streett pairs (mark, partners)."""


Acceptance = tuple[Clause, ...]
ALWAYS: Acceptance = (Clause(0, 0),)
NEVER: Acceptance = ()


class TooManyClausesError(Exception):
    """A condition has more clauses than were allowed."""


def rabin_pair(i: int, offset: int = 0) -> Clause:
    """Fin mark 2i finitely and Inf mark 2i + 1 infinitely often, both after `offset` other marks."""
    return Clause(1 << 2 * i + offset, 2 << 2 * i + offset)


def rabin(n_pairs: int) -> Acceptance:
    """Some Rabin pair holds."""
    return tuple(rabin_pair(i) for i in range(n_pairs))


def rabin_accepts(n_pairs: int, seen: int) -> bool:
    """Whether some Rabin pair accepts a run that sees exactly these marks infinitely often."""
    return any(seen >> 2 * i & 3 == 2 for i in range(n_pairs))


def recurring_marks(state: int, run: Callable[[int], tuple[int, int]]) -> int:
    """The marks seen infinitely often by a deterministic run that reads one word for ever.

    Args:
        state: where it starts.
        run: the state after the word, and the marks seen on the way, from a state.
    """
    trail: dict[int, int] = {}
    while state not in trail:
        source = state
        state, trail[source] = run(source)
    rounds = list(trail)
    seen = 0
    for source in rounds[rounds.index(state) :]:
        seen |= trail[source]
    return seen


def streett(n_pairs: int, offset: int = 0) -> Clause:
    """No Rabin pair holds; their marks come after `offset` other marks."""
    return Clause(0, 0, tuple((pair.inf, pair.fin) for pair in (rabin_pair(i, offset) for i in range(n_pairs))))


def only_first(n_first: int, n_second: int) -> Acceptance:
    """The first of two Rabin automata accepts and the second does not; its marks come after those of the first.

    Written with one Rabin pair at a time, which keeps the search for such cycles polynomial.
    """
    rejected = streett(n_second, 2 * n_first)
    return tuple(rejected._replace(fin=pair.fin, inf=pair.inf) for pair in rabin(n_first))


def exactly_one(n_first: int, n_second: int, required: int = 0) -> Acceptance:
    """One of two Rabin automata accepts, the other does not, `required` marks are taken; marks as in `only_first`."""
    rejected = streett(n_first)
    second = [rabin_pair(i, 2 * n_first) for i in range(n_second)]
    found = (*only_first(n_first, n_second), *(rejected._replace(fin=pair.fin, inf=pair.inf) for pair in second))
    return tuple(clause._replace(inf=clause.inf | required) for clause in found)


def simplify(clauses: Iterable[Clause], limit: int | None = None) -> Acceptance:
    """Drop contradictory and subsumed clauses, and sort.

    Raises:
        TooManyClausesError: more than `limit` remain.
    """
    distinct = set(clauses)
    if len(distinct) == 1 and limit is None:
        (alone,) = distinct
        return NEVER if alone.fin & alone.inf else (alone,)
    kept: list[Clause] = []
    for n, clause in enumerate(sorted(distinct, key=_length), 1):
        if not n & 63:
            check_time()
        fin, inf, promises = clause
        if not fin & inf and not any(
            f & ~fin == 0 and i & ~inf == 0 and (not p or set(p) <= set(promises)) for f, i, p in kept
        ):
            kept.append(clause)
            if limit is not None and len(kept) > limit:
                raise TooManyClausesError
    return tuple(sorted(kept))


def _length(clause: Clause) -> tuple[int, Clause]:
    return clause.fin.bit_count() + clause.inf.bit_count() + len(clause.promises), clause


def conjunction(a: Acceptance, b: Acceptance, limit: int | None = None) -> Acceptance:
    """Both conditions hold; `limit` as in `simplify`."""
    clauses: set[Clause] = set()
    for f, i, p in a:
        if len(b) > _MANY:
            check_time()
        clauses.update([Clause(f | g, i | j, (*p, *q)) for g, j, q in b])
    return simplify(clauses, limit)


def disjunction(a: Acceptance, b: Acceptance, limit: int | None = None) -> Acceptance:
    """At least one of the conditions holds; `limit` as in `simplify`."""
    return simplify((*a, *b), limit)


def negation(a: Acceptance, limit: int | None = None, *, with_promises: bool = False) -> Acceptance:
    """The condition fails.

    Args:
        a: the condition.
        limit: as in `simplify`.
        with_promises: make promises of the clauses with one Inf mark, so that the negation of Rabin is one clause.
    """
    kept = [c for c in a if with_promises and c.inf.bit_count() == 1 and not c.promises]
    result: Acceptance = (Clause(0, 0, tuple((c.inf, c.fin) for c in kept)),)
    for fin, inf, promises in a:
        if kept and inf.bit_count() == 1 and not promises:
            continue
        ways = [Clause(0, 1 << m) for m in bits(fin)] + [Clause(1 << m, 0) for m in bits(inf)]
        ways += [Clause(partner, mark) for mark, partner in promises]
        result = conjunction(result, simplify(ways), limit)
    return result


def holds(a: Acceptance, seen: int) -> bool:
    """Whether a run that takes exactly the marks `seen` infinitely often is accepted."""
    return any(
        not fin & seen and not inf & ~seen and all(partner & seen or not mark & seen for mark, partner in promises)
        for fin, inf, promises in a
    )


def restrict(a: Acceptance, possible: int, certain: int) -> Acceptance:
    """Simplify for where only `possible` marks exist and the `certain` ones are on every edge."""
    clauses = (c for c in a if not c.inf & ~possible and not c.fin & certain)
    return simplify([Clause(c.fin & possible, c.inf & ~certain, c.promises) for c in clauses])


def without_implied(a: Acceptance, implied: Mapping[int, int]) -> Acceptance:
    """Simplify for where each mark (by its number) is only on edges with the marks that it implies, itself included."""
    clauses = []
    for fin, inf, promises in a:
        if any(implied[m] & fin for m in bits(inf)):
            continue
        for m in bits(inf):
            if any(implied[other] >> m & 1 for other in bits(inf & ~(1 << m))):
                inf &= ~(1 << m)
        for m in bits(fin):
            if implied[m] & fin & ~(1 << m):
                fin &= ~(1 << m)
        clauses.append(Clause(fin, inf, promises))
    return simplify(clauses)
