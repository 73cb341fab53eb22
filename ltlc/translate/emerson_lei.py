"""Deterministic automata with Emerson-Lei acceptance: what the constructions build before Rabin pairs are formed.

An acceptance condition is a disjunction of clauses (fin, inf) of two mark sets: a clause holds iff no mark of `fin` and
every mark of `inf` is seen infinitely often. It may differ from one strong component to the next, which is sound since
a run settles in one of them, and lets a component forget the marks that no longer matter in it.

References:
    E. A. Emerson, C.-L. Lei: Modalities for Model Checking: Branching Time Logic Strikes Back. Science of Computer
    Programming 8, 1987, doi 10.1016/0167-6423(87)90036-0.
    C. Loeding: Efficient minimization of deterministic weak omega-automata. Information Processing Letters 79, 2001,
    doi 10.1016/S0020-0190(00)00183-6.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from ltlc import graph
from ltlc.translate.bitset import bits
from ltlc.translate.budget import Budget

Acceptance = tuple[tuple[int, int], ...]
State = TypeVar("State", bound=Hashable)
ALWAYS: Acceptance = ((0, 0),)
NEVER: Acceptance = ()


class Edge(NamedTuple):
    """The letters on which the automaton moves to `target`, and the marks seen on the way."""

    letters: int
    target: int
    marks: int


@dataclass(frozen=True)
class EmersonLei:
    """A complete deterministic automaton; state 0 is initial."""

    edges: tuple[tuple[Edge, ...], ...]
    """per state; the letter sets of a state's edges partition the letters."""
    acceptance: tuple[Acceptance, ...]
    """per state; the same for all states of a strong component."""

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.edges)

    @property
    def is_weak(self) -> bool:
        """Whether each strong component accepts all of its runs or none."""
        return all(condition in (ALWAYS, NEVER) for condition in self.acceptance)

    def successors(self) -> list[list[int]]:
        """Target states of each state."""
        return [[edge.target for edge in edges] for edges in self.edges]


# -- acceptance conditions --------------------------------------------------------------------------------------------


def simplify(clauses: Iterable[tuple[int, int]]) -> Acceptance:
    """Without contradictory and subsumed clauses, sorted."""
    kept: list[tuple[int, int]] = []
    for fin, inf in sorted(set(clauses), key=lambda c: (c[0].bit_count() + c[1].bit_count(), c)):
        if not fin & inf and not any(f & ~fin == 0 and i & ~inf == 0 for f, i in kept):
            kept.append((fin, inf))
    return tuple(sorted(kept))


def conjunction(a: Acceptance, b: Acceptance) -> Acceptance:
    """Both conditions hold."""
    return simplify((f | g, i | j) for f, i in a for g, j in b)


def disjunction(a: Acceptance, b: Acceptance) -> Acceptance:
    """At least one of the conditions holds."""
    return simplify((*a, *b))


def negation(a: Acceptance) -> Acceptance:
    """The condition fails."""
    result = ALWAYS
    for fin, inf in a:
        result = conjunction(result, simplify([(0, 1 << m) for m in bits(fin)] + [(1 << m, 0) for m in bits(inf)]))
    return result


def holds(a: Acceptance, seen: int) -> bool:
    """Whether a run that sees exactly the marks `seen` infinitely often is accepted."""
    return any(not fin & seen and not inf & ~seen for fin, inf in a)


def restrict(a: Acceptance, possible: int, certain: int) -> Acceptance:
    """The condition where only `possible` marks exist and the `certain` ones are on every edge."""
    clauses = ((fin & possible, inf & ~certain) for fin, inf in a if not inf & ~possible and not fin & certain)
    return simplify(clauses)


# -- automata ---------------------------------------------------------------------------------------------------------


def explore(
    initial: State,
    successors: Callable[[State], Iterable[tuple[int, State, int]]],
    budget: Budget,
) -> tuple[list[State], list[list[Edge]]]:
    """Number the states reachable from `initial` breadth-first, by least letter; merge edges with target and marks."""
    number = {initial: 0}
    states = [initial]
    edges: list[list[Edge]] = []
    for state in states:  # grows while it is read
        merged: dict[tuple[int, int], int] = {}
        for letters, target, marks in sorted(successors(state), key=_least_letter):
            index = number.get(target)
            if index is None:
                index = number[target] = len(states)
                states.append(target)
                budget.check_size(len(states))
            merged[index, marks] = merged.get((index, marks), 0) | letters
        edges.append([Edge(letters, target, marks) for (target, marks), letters in merged.items()])
    return states, edges


def _least_letter(move: tuple[int, object, int]) -> int:
    return move[0] & -move[0]


def complement(automaton: EmersonLei) -> EmersonLei:
    """The automaton of the words that are not accepted."""
    return EmersonLei(automaton.edges, tuple(map(negation, automaton.acceptance)))


def localized(automaton: EmersonLei) -> EmersonLei:
    """Each strong component with its own simplest condition; marks that do not matter are removed."""
    component = graph.strong_components(automaton.successors())
    n_components = max(component) + 1
    possible, certain = [0] * n_components, [-1] * n_components
    for q, edges in enumerate(automaton.edges):
        here = component[q]
        for edge in edges:
            if component[edge.target] == here:
                possible[here] |= edge.marks
                certain[here] &= edge.marks
    conditions = [NEVER] * n_components
    useful = [0] * n_components
    for q, condition in enumerate(automaton.acceptance):
        here = component[q]
        if certain[here] != -1 and not useful[here] and conditions[here] == NEVER:
            conditions[here] = restrict(condition, possible[here], certain[here])
            for fin, inf in conditions[here]:
                useful[here] |= fin | inf
    kept = []
    for q, edges in enumerate(automaton.edges):
        here = component[q]
        merged: dict[tuple[int, int], int] = {}
        for letters, target, marks in edges:
            key = (target, marks & useful[here] if component[target] == here else 0)
            merged[key] = merged.get(key, 0) | letters
        kept.append(tuple(Edge(letters, target, marks) for (target, marks), letters in merged.items()))
    return EmersonLei(tuple(kept), tuple(conditions[c] for c in component))


def refine(edges: Sequence[Sequence[Edge]], initial: Sequence[object]) -> list[int]:
    """The coarsest partition finer than `initial` that the successors respect (bisimulation), as class numbers.

    Edges are compared with their marks; classes are numbered by their first state.
    """
    block = _number(initial)
    n_blocks = max(block) + 1
    while True:
        signatures = []
        for q, out in enumerate(edges):
            merged: dict[tuple[int, int], int] = {}
            for letters, target, marks in out:
                key = (block[target], marks)
                merged[key] = merged.get(key, 0) | letters
            signatures.append((block[q], frozenset(merged.items())))
        block = _number(signatures)
        if max(block) + 1 == n_blocks:
            return block
        n_blocks = max(block) + 1


def quotient(automaton: EmersonLei, block: Sequence[int]) -> EmersonLei:
    """One state per block (blocks numbered by first state), with the edges of its first state."""
    first: dict[int, int] = {}
    for q, b in enumerate(block):
        first.setdefault(b, q)

    def successors(b: int) -> Iterable[tuple[int, int, int]]:
        return ((e.letters, block[e.target], e.marks) for e in automaton.edges[first[b]])

    blocks, edges = explore(block[0], successors, _NO_LIMIT)
    return EmersonLei(tuple(map(tuple, edges)), tuple(automaton.acceptance[first[b]] for b in blocks))


def reduced(automaton: EmersonLei) -> EmersonLei:
    """Quotient by bisimulation with marks, components localized; weak automata are minimized exactly."""
    automaton = localized(automaton)
    if automaton.is_weak:
        return minimized_weak(automaton)
    trivial = _trivial(automaton)
    kind = [() if trivial[q] else condition for q, condition in enumerate(automaton.acceptance)]
    return quotient(automaton, refine(automaton.edges, kind))


def minimized_weak(automaton: EmersonLei) -> EmersonLei:
    """The smallest weak automaton for the language of a weak automaton (Loeding 2001).

    Every strong component gets the largest even (accepting) or odd (rejecting) color that its successors allow;
    then the states are merged as those of a finite automaton that accepts in even colors.
    """
    successors = automaton.successors()
    component = graph.strong_components(successors)
    members = graph.component_members(component)
    trivial = _trivial(automaton)
    top = 2 * len(members)
    color = [0] * len(members)
    for c in range(len(members) - 1, -1, -1):
        q = members[c][0]
        limit = min((color[component[t]] for p in members[c] for t in successors[p] if component[t] != c), default=top)
        if trivial[q]:
            color[c] = limit
        else:
            odd = automaton.acceptance[q] == NEVER
            color[c] = limit if limit % 2 == odd else limit - 1
    accepting = [color[component[q]] % 2 == 0 for q in range(automaton.n_states)]
    plain = [tuple(Edge(e.letters, e.target, 0) for e in edges) for edges in automaton.edges]
    weak = EmersonLei(tuple(plain), tuple(ALWAYS if a else NEVER for a in accepting))
    return quotient(weak, refine(weak.edges, accepting))


def _trivial(automaton: EmersonLei) -> list[bool]:
    """Which states lie on no cycle."""
    component = graph.strong_components(automaton.successors())
    cyclic = {component[q] for q, out in enumerate(automaton.edges) for e in out if component[e.target] == component[q]}
    return [c not in cyclic for c in component]


def _number(values: Sequence[object]) -> list[int]:
    numbers: dict[object, int] = {}
    return [numbers.setdefault(value, len(numbers)) for value in values]


_NO_LIMIT = Budget("", 1 << 62, None)
