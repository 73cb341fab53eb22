"""How small a component can be at best, whatever its pairs, by what can be read without leaving some of its edges.

Call the edges on accepted cycles *safe*, or those on rejected cycles, and the words along which a run can stay on them
the safe language of a state. A strong component T of safe edges all of which together are accepted, or rejected, is
*needed* if no state elsewhere has the residual of a state of T and a safe language that contains its own.

Another automaton for the same words has, for a needed T, a state for each residual and safe language in T. Let it read
words that keep this automaton in T, for so long that only edges remain that are taken again and again. Say that it is
in one state beside p and beside q, and w is safe for q, not for p. Read on from a state of T whose safe language no
other contains, so that no other run of this automaton stays safe; lead the one that is left to p; and read w as if it
were q. Then this automaton leaves the safe edges again and again, but the other one takes all of its edges for ever,
and no more, as it does along T: their verdicts differ.

What two needed components of rejected cycles ask for are different states, since Rabin automata reject the union of
rejected cycles. All this holds again inside of T, with safe languages in place of residuals.

References:
    B. Abu Radi, O. Kupferman: Minimizing GFG Transition-Based Automata. ICALP 2019, doi 10.4230/LIPIcs.ICALP.2019.100
    (the smallest co-Buchi automata whose choices may depend on the past).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ltlc import graph
from ltlc.automata.acceptance import Acceptance, holds, rabin, streett
from ltlc.automata.emptiness import accepting_parts
from ltlc.automata.partition import first_places, refine_by
from ltlc.budget import check_time
from ltlc.minimize.residuals import Part

_MAX_WORK = 4_000_000
"""Pairs of states of one residual, times columns, up to which it is worth comparing their safe languages."""
Moves = list[list[tuple[int, int]]]
"""Per state and column: the next state and the marks on the way, or `_NONE`."""
_NONE = -1, 0


class Component(NamedTuple):
    """A strong component of safe edges: states, and for each one a number of its residual and safe language."""

    states: list[int]
    languages: list[int]


def least_by_safe_edges(part: Part) -> int:
    """A number of states that no component for the same words goes below; 0 for large parts."""
    if sum(n**2 for n in Counter(part.residual_of).values()) * part.n_columns > _MAX_WORK:
        return 0
    moves = [
        [move if move[0] >= 0 else _NONE for move in zip(*row, strict=True)]
        for row in zip(part.delta, part.marks, strict=True)
    ]
    return _least(part.n_pairs, part.residual_of, moves)


def _least(n_pairs: int, residual_of: Sequence[int], moves: Moves) -> int:
    least = n_residuals = len(set(residual_of))
    for verdict, cycles in ((False, (streett(n_pairs),)), (True, rabin(n_pairs))):
        if least == len(moves):
            return least
        safe = _safe_moves(moves, cycles)
        found = [0]
        for alternatives in _needed(residual_of, safe):
            chosen = [c for c in alternatives if not verdict or holds(cycles, _marks(safe, c.states))]
            bound = max([_inside(n_pairs, residual_of, moves, safe, c) for c in chosen], default=0)
            others = n_residuals - len({residual_of[q] for q in alternatives[0].states}) if verdict else 0
            found.append(bound + others)
        least = max(least, max(found) if verdict else sum(found))
    return least


def _inside(n_pairs: int, residual_of: Sequence[int], moves: Moves, safe: Moves, component: Component) -> int:
    """The bound for a component of safe edges, which is not looked into again where it shows nothing new."""
    states, languages = component
    if len(states) == len(moves) and safe == moves and len(set(languages)) == len(set(residual_of)):
        return len(set(languages))
    number = {q: i for i, q in enumerate(states)}
    return _least(
        n_pairs, languages, [[(number[t], marks) if t in number else _NONE for t, marks in safe[q]] for q in states]
    )


def _marks(moves: Moves, states: list[int]) -> int:
    seen = 0
    for q in states:
        for t, marks in moves[q]:
            seen |= marks if t >= 0 else 0
    return seen


def _safe_moves(moves: Moves, cycles: Acceptance) -> Moves:
    """The moves on some cycles."""
    edges = [sorted({move for move in row if move[0] >= 0}) for row in moves]
    safe: list[set[tuple[int, int]]] = [set() for _ in edges]
    for nodes, avoided, _ in accepting_parts(edges, cycles):
        inside = set(nodes)
        for q in nodes:
            safe[q].update([(t, marks) for t, marks in edges[q] if t in inside and not marks & avoided])
    return [[move if move in here else _NONE for move in row] for here, row in zip(safe, moves, strict=True)]


def _needed(residual_of: Sequence[int], safe: Moves) -> Iterator[list[Component]]:
    """For each needed set of safe languages, the components that have them: states, and the language of each."""
    targets = [[t for t, _ in row] for row in safe]
    language = _languages(residual_of, targets)
    first = first_places(language)
    residuals = [residual_of[q] for q in first]
    above = _rivals(residuals, [[language[t] if t >= 0 else -1 for t in targets[q]] for q in first])
    having: dict[frozenset[int], list[Component]] = {}
    for states in graph.component_members(graph.strong_components([[t for t in row if t >= 0] for row in targets])):
        found = Component(states, [language[q] for q in states])
        having.setdefault(frozenset(found.languages), []).append(found)
    dropped: set[int] = set()
    for here, components in having.items():
        if any(above[b] - here - dropped for b in here):
            dropped |= here
        else:
            yield components


def _languages(residual_of: Sequence[int], targets: Sequence[Sequence[int]]) -> list[int]:
    """A number for each state, the same for those of one residual and safe language."""
    return refine_by(residual_of, lambda block: (tuple([block[t] if t >= 0 else -1 for t in row]) for row in targets))


def _rivals(residual_of: Sequence[int], targets: Sequence[Sequence[int]]) -> list[set[int]]:
    """For each state those of its residual whose safe language contains its own, itself among them."""
    alike: dict[int, list[int]] = {}
    able = [sum(1 << c for c, t in enumerate(row) if t >= 0) for row in targets]
    sources: list[dict[int, list[int]]] = [{} for _ in targets[0]]
    for q, (residual, row) in enumerate(zip(residual_of, targets, strict=True)):
        alike.setdefault(residual, []).append(q)
        for before, t in zip(sources, row, strict=True):
            before.setdefault(t, []).append(q)
    above = [
        {r for r in alike[residual] if not own & ~able[r]} for residual, own in zip(residual_of, able, strict=True)
    ]
    todo = [(q, r) for q, residual in enumerate(residual_of) for r in alike[residual] if r not in above[q]]
    n_left = sum(map(len, above)) - len(above)
    for n, (p, r) in enumerate(todo):  # grows while it is read
        if not n & 255:
            check_time()
        if not n_left:
            break
        for before in sources:
            for q in before.get(p, ()):
                lost = above[q].intersection(before.get(r, ()))
                above[q] -= lost
                n_left -= len(lost)
                todo += [(q, other) for other in lost]
    return above
