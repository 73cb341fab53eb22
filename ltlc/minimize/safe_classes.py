"""How small a component of a recurrence or a persistence language can be at best, whatever its pairs.

Let L be a persistence language: a deterministic automaton accepts the runs that stay, from some time on, on edges of
accepted cycles, if these make no rejected one. Call these edges *safe*, and the words along which a run can stay on
them for ever the safe language of a state. A strong component of safe edges is *needed* where no state elsewhere has
the same residual and a safe language that contains that of a state in it.

A Rabin automaton for L has a state for each residual and safe language of a needed component T. Let it read words
that keep this automaton in T for so long that a set of edges remains, taken again and again, which is accepted. Say
that it is in one state beside p and beside q, and w is safe for q, not for p. Read on from a state of T whose safe
language no other contains, so that no other run of this automaton stays safe; lead the one that is left to p; and read
w as if it were q. Then none is safe, but the other automaton takes the same edges for ever, and accepts.

The complement of a recurrence language is a persistence language, and Rabin automata for the former are co-Buchi
automata for the latter: these need such states for all needed components together.

References:
    B. Abu Radi, O. Kupferman: Minimizing GFG Transition-Based Automata. ICALP 2019, doi 10.4230/LIPIcs.ICALP.2019.100
    (the smallest co-Buchi automata whose choices may depend on the past).
    S. Krishnan, A. Puri, R. Brayton: Deterministic omega automata vis-a-vis deterministic Buchi automata. ISAAC 1994,
    doi 10.1007/3-540-58325-4_202 (which edges decide).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ltlc import graph
from ltlc.automata.acceptance import Acceptance, rabin, streett
from ltlc.automata.emptiness import accepting_parts
from ltlc.budget import check_time
from ltlc.minimize.residuals import Part

_MAX_WORK = 500_000
"""Pairs of states of one residual, times columns, up to which it is worth comparing their safe languages."""
SafeMoves = list[tuple[int, ...]]
"""Per state and column: the next state along a safe edge, else -1."""


def least_by_safe_edges(part: Part) -> int:
    """A number of states that no component for the same words goes below; 0 for other languages, or large parts."""
    if sum(n**2 for n in Counter(part.residual_of).values()) * part.n_columns > _MAX_WORK:
        return 0
    accepted, rejected = rabin(part.n_pairs), (streett(part.n_pairs),)
    moves = _safe_moves(part, rejected, accepted)
    if moves is not None:
        return sum(map(len, _needed(part.residual_of, moves)))
    moves = _safe_moves(part, accepted, rejected)
    if moves is None:
        return 0
    needed = _needed(part.residual_of, moves)
    return max((len(residuals) + len(part.residuals) - len(set(residuals)) for residuals in needed), default=0)


def _safe_moves(part: Part, good: Acceptance, bad: Acceptance) -> SafeMoves | None:
    """The edges on good cycles, or None if these alone can make a bad one."""
    edges = [
        sorted({(t, marks) for t, marks in zip(*row, strict=True) if t >= 0})
        for row in zip(part.delta, part.marks, strict=True)
    ]
    safe: list[set[tuple[int, int]]] = [set() for _ in edges]
    for nodes, avoided, _ in accepting_parts(edges, good):
        inside = set(nodes)
        for q in nodes:
            safe[q].update([(t, marks) for t, marks in edges[q] if t in inside and not marks & avoided])
    if next(accepting_parts([sorted(row) for row in safe], bad), None) is not None:
        return None
    return [
        tuple([t if (t, marks) in here else -1 for t, marks in zip(*row, strict=True)])
        for here, row in zip(safe, zip(part.delta, part.marks, strict=True), strict=True)
    ]


def _needed(residual_of: Sequence[int], moves: SafeMoves) -> list[list[int]]:
    """The needed components: of each state with a safe language of its own, the residual."""
    residuals, moves = _merged(residual_of, moves)
    above = _rivals(residuals, moves)
    component = graph.strong_components([[t for t in row if t >= 0] for row in moves])
    needed = []
    left = (1 << len(moves)) - 1
    for states in graph.component_members(component):
        here = sum(1 << q for q in states)
        if any(above[q] & left & ~here for q in states):
            left &= ~here
        else:
            needed.append([residuals[q] for q in states])
    return needed


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
