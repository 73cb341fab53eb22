"""How small a component of a recurrence language can be at best, whatever its pairs.

A deterministic Rabin automaton for such a language accepts the runs that take infinitely often an edge on no rejected
cycle. The other edges are *safe* (for the complement), the words along which a run can stay on them are the safe
language of a state. An automaton needs, for each state of this one, a state of the same residual whose safe language
contains it; and from there on, by staying safe, one of the same residual and safe language for each state of some of
the strong components of the safe edges: those in which no state has a rival elsewhere.

References:
    B. Abu Radi, O. Kupferman: Minimizing GFG Transition-Based Automata. ICALP 2019, doi 10.4230/LIPIcs.ICALP.2019.100
    (the smallest co-Buchi automata whose choices depend on the past; deterministic ones are not smaller).
    S. Krishnan, A. Puri, R. Brayton: Deterministic omega automata vis-a-vis deterministic Buchi automata. ISAAC 1994,
    doi 10.1007/3-540-58325-4_202 (which edges decide).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ltlc import graph
from ltlc.automata.acceptance import rabin, streett
from ltlc.automata.emptiness import accepting_parts
from ltlc.budget import check_time
from ltlc.minimize.residuals import Part

_MAX_WORK = 500_000
"""Pairs of states of one residual, times columns, up to which it is worth comparing their safe languages."""
SafeMoves = list[tuple[int, ...]]
"""Per state and column: the next state along a safe edge, else -1."""


def least_for_recurrence(part: Part) -> int:
    """A number of states that no component for the same words goes below; 0 if they are no recurrence language."""
    if sum(n**2 for n in Counter(part.residual_of).values()) * part.n_columns > _MAX_WORK:
        return 0
    moves = _safe_moves(part)
    if moves is None:
        return 0
    residual_of, moves = _merged(part.residual_of, moves)
    above = _rivals(residual_of, moves)
    component = graph.strong_components([[t for t in row if t >= 0] for row in moves])
    members = graph.component_members(component)
    left = (1 << len(moves)) - 1
    for states in members:
        here = sum(1 << q for q in states)
        if any(above[q] & left & ~here for q in states):
            left &= ~here
    return left.bit_count()


def _safe_moves(part: Part) -> SafeMoves | None:
    """The edges on rejected cycles, or None if these alone can make an accepted one."""
    edges = [
        sorted({(t, marks) for t, marks in zip(*row, strict=True) if t >= 0})
        for row in zip(part.delta, part.marks, strict=True)
    ]
    place = [(-1, 0)] * len(edges)  # per state: which part it is in, and what its edges there do not carry
    for i, (nodes, avoided, _) in enumerate(accepting_parts(edges, (streett(part.n_pairs),))):
        for q in nodes:
            place[q] = i, avoided

    def is_safe(source: int, target: int, marks: int) -> bool:
        i, avoided = place[source]
        return target >= 0 and i >= 0 and place[target][0] == i and not marks & avoided

    safe = [[(t, marks) for t, marks in row if is_safe(q, t, marks)] for q, row in enumerate(edges)]
    if next(accepting_parts(safe, rabin(part.n_pairs)), None) is not None:
        return None
    return [
        tuple(t if is_safe(q, t, marks) else -1 for t, marks in zip(*row, strict=True))
        for q, row in enumerate(zip(part.delta, part.marks, strict=True))
    ]


def _merged(residual_of: Sequence[int], moves: SafeMoves) -> tuple[list[int], SafeMoves]:
    """One state for those of one residual and safe language."""
    block, n_blocks = list(residual_of), 0
    while len(set(block)) > n_blocks:
        n_blocks = len(set(block))
        number: dict[tuple[int, ...], int] = {}
        rows = ((b, *[block[t] if t >= 0 else -1 for t in row]) for b, row in zip(block, moves, strict=True))
        block = [number.setdefault(row, len(number)) for row in rows]
    first = [block.index(b) for b in range(n_blocks)]
    return [residual_of[q] for q in first], [tuple(block[t] if t >= 0 else -1 for t in moves[q]) for q in first]


def _rivals(residual_of: Sequence[int], moves: SafeMoves) -> list[int]:
    """For each state the set of those of its residual whose safe language contains its own, itself among them."""
    able = [sum(1 << q for q, row in enumerate(moves) if row[c] >= 0) for c in range(len(moves[0]))]
    above = []
    for residual, row in zip(residual_of, moves, strict=True):
        rivals = sum(1 << q for q, other in enumerate(residual_of) if other == residual)
        for c, target in enumerate(row):
            rivals &= able[c] if target >= 0 else -1
        above.append(rivals)
    changed = True
    while changed:
        check_time()
        changed = False
        for q, row in enumerate(moves):
            for rival in graph.bits(above[q] & ~(1 << q)):
                if any(t >= 0 and not above[t] >> moves[rival][c] & 1 for c, t in enumerate(row)):
                    above[q] ^= 1 << rival
                    changed = True
    return above
