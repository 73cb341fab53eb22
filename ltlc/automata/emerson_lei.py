"""Deterministic automata with Emerson-Lei acceptance: what the constructions build before Rabin pairs are formed.

The acceptance condition (without promises, see `acceptance`) may differ from one strong component to the next, which is
sound since a run settles in one of them, and lets a component forget the marks that no longer matter in it.

References:
    C. Loeding: Efficient minimization of deterministic weak omega-automata. Information Processing Letters 79, 2001,
    doi 10.1016/S0020-0190(00)00183-6.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from typing import Final, NamedTuple, TypeVar

from ltlc import graph
from ltlc.automata.acceptance import ALWAYS, NEVER, Acceptance, negation, restrict, without_implied
from ltlc.automata.partition import refine_by
from ltlc.budget import NO_LIMIT, Budget, check_time
from ltlc.graph import bits

State = TypeVar("State", bound=Hashable)


class LetterEdge(NamedTuple):
    """An edge for every letter of a set.

    Attributes:
        letters: bit k = letter (or letter class) k is read.
        marks: bit i = the edge has mark i, or is in acceptance set i.
    """

    letters: int
    target: int
    marks: int


class EmersonLei:
    """A complete deterministic automaton; state 0 is initial.

    Args:
        edges: per state; the letter sets of a state's edges partition the letters.
        acceptance: per state; the same for all states of a strong component.
        component: what the property `component` is, if that is known already.
        alike: per state; states with equal entries accept the same words, others may do so, too. By default nothing is
            known.
    """

    def __init__(
        self,
        edges: tuple[tuple[LetterEdge, ...], ...],
        acceptance: tuple[Acceptance, ...],
        component: list[int] | None = None,
        alike: Sequence[int] | None = None,
    ) -> None:
        self.alike: Final = range(len(edges)) if alike is None else alike
        self.edges: Final = edges
        self.acceptance: Final = acceptance
        self._component = component

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.edges)

    @property
    def is_weak(self) -> bool:
        """Whether each strong component accepts all of its runs or none."""
        return all(condition in (ALWAYS, NEVER) for condition in self.acceptance)

    @property
    def component(self) -> list[int]:
        """Strong component of each state, numbered in topological order."""
        if self._component is None:
            self._component = graph.strong_components([[edge.target for edge in edges] for edges in self.edges])
        return self._component

    def relabelled(self, edges: tuple[tuple[LetterEdge, ...], ...], acceptance: tuple[Acceptance, ...]) -> EmersonLei:
        """Other marks and conditions on the same graph, whose strong components are not looked for again."""
        return EmersonLei(edges, acceptance, self.component, self.alike)


def explore(
    initial: State,
    successors: Callable[[State], Iterable[tuple[int, State, int]]],
    budget: Budget,
) -> tuple[list[State], list[list[LetterEdge]]]:
    """Number the states reachable from `initial` breadth-first, by least letter; merge edges with target and marks."""
    number = {initial: 0}
    states = [initial]
    edges: list[list[LetterEdge]] = []
    n_edges = everything = 0
    for state in states:  # grows while it is read
        check_time()
        moves = []
        for letters, target, marks in sorted(successors(state), key=_least_letter):
            index = number.get(target)
            if index is None:
                index = number[target] = len(states)
                states.append(target)
                budget.check_states(len(states))
            moves.append((letters, index, marks))
            everything |= letters
        edges.append(merged(moves))
        n_edges += len(edges[-1])
        budget.check_sets(n_edges, everything.bit_length())
    return states, edges


def merged(moves: Iterable[tuple[int, int, int]]) -> list[LetterEdge]:
    """One edge per target and marks, in the order in which they first appear; moves are (letters, target, marks)."""
    return [LetterEdge(letters, *move) for move, letters in _letters_by_move(moves).items()]


def _letters_by_move(moves: Iterable[tuple[int, int, int]]) -> dict[tuple[int, int], int]:
    letters_of: dict[tuple[int, int], int] = {}
    for letters, target, marks in moves:
        key = (target, marks)
        letters_of[key] = letters_of.get(key, 0) | letters
    return letters_of


def _least_letter(move: tuple[int, object, int]) -> int:
    return move[0] & -move[0]


def complement(automaton: EmersonLei, limit: int | None = None) -> EmersonLei:
    """The automaton of the words that are not accepted; `limit` of clauses as in `simplify`."""
    negated = {condition: negation(condition, limit) for condition in dict.fromkeys(automaton.acceptance)}
    return EmersonLei(automaton.edges, tuple([negated[c] for c in automaton.acceptance]), alike=automaton.alike)


def localized(automaton: EmersonLei) -> EmersonLei:
    """Each strong component with its own simplest condition; marks that do not matter are removed."""
    component = automaton.component
    n_components = max(component) + 1
    possible, certain, leaving = [0] * n_components, [-1] * n_components, [0] * n_components
    seen: list[set[int]] = [set() for _ in range(n_components)]
    for q, edges in enumerate(automaton.edges):
        here = component[q]
        if not q & 15:
            check_time()
        for edge in edges:
            if component[edge.target] == here:
                possible[here] |= edge.marks
                certain[here] &= edge.marks
                seen[here].add(edge.marks)
            else:
                leaving[here] |= edge.marks
    conditions = [NEVER] * n_components
    useful = [0] * n_components
    for q, condition in enumerate(automaton.acceptance):
        here = component[q]
        if certain[here] != -1 and not useful[here] and conditions[here] == NEVER:
            simpler = restrict(condition, possible[here], certain[here])
            conditions[here] = without_implied(simpler, _implied(seen[here]))
            for clause in conditions[here]:
                useful[here] |= clause.fin | clause.inf
    kept = []
    for q, edges in enumerate(automaton.edges):
        if not q & 15:
            check_time()
        here = component[q]
        if not leaving[here] | possible[here] & ~useful[here]:
            kept.append(edges)
            continue
        moves = ((e.letters, e.target, e.marks & useful[here] if component[e.target] == here else 0) for e in edges)
        kept.append(tuple(merged(moves)))
    return automaton.relabelled(tuple(kept), tuple(conditions[c] for c in component))


def _implied(seen: Iterable[int]) -> dict[int, int]:
    """The marks that are on every edge with a mark, for each mark, from the sets of marks on edges."""
    implied: dict[int, int] = {}
    for marks in seen:
        for m in bits(marks):
            implied[m] = implied.get(m, marks) & marks
    return implied


def refine(edges: Sequence[Sequence[LetterEdge]], initial: Iterable[Hashable]) -> list[int]:
    """The coarsest partition finer than `initial` that the successors respect (bisimulation), as class numbers.

    Edges are compared with their marks; classes are numbered by their first state.
    """

    def signatures(block: list[int]) -> Iterator[Hashable]:
        for q, out in enumerate(edges):
            if not q & 255:
                check_time()
            yield frozenset(_letters_by_move((e.letters, block[e.target], e.marks) for e in out).items())

    return refine_by(initial, signatures)


def quotient(automaton: EmersonLei, block: Sequence[int]) -> EmersonLei:
    """One state per block (blocks numbered by first state), with the edges of its first state."""
    if max(block) + 1 == automaton.n_states:
        return automaton
    first: dict[int, int] = {}
    for q, b in enumerate(block):
        first.setdefault(b, q)

    def successors(b: int) -> Iterable[tuple[int, int, int]]:
        return ((e.letters, block[e.target], e.marks) for e in automaton.edges[first[b]])

    blocks, edges = explore(block[0], successors, NO_LIMIT)
    acceptance = tuple(automaton.acceptance[first[b]] for b in blocks)
    return EmersonLei(tuple(map(tuple, edges)), acceptance, alike=[automaton.alike[first[b]] for b in blocks])


def reduced(automaton: EmersonLei) -> EmersonLei:
    """Quotient by bisimulation with marks, components localized; weak automata are minimized exactly."""
    has_marks = any(edge.marks for out in automaton.edges for edge in out)
    if has_marks or not automaton.is_weak:
        automaton = localized(automaton)
    if automaton.is_weak:
        return minimized_weak(automaton)
    return quotient(automaton, refine(automaton.edges, automaton.acceptance))


def minimized_weak(automaton: EmersonLei) -> EmersonLei:
    """The smallest weak automaton for the language of a weak automaton (Loeding 2001).

    Every strong component gets the largest even (accepting) or odd (rejecting) color that its successors allow;
    then the states are merged as those of a finite automaton that accepts in even colors.
    """
    component = automaton.component
    members = graph.component_members(component)
    color = [0] * len(members)
    for c in reversed(range(len(members))):
        if not c & 255:
            check_time()
        limit, cyclic = 2 * len(members), False
        for edge in (edge for q in members[c] for edge in automaton.edges[q]):
            if component[edge.target] == c:
                cyclic = True
            else:
                limit = min(limit, color[component[edge.target]])
        odd = automaton.acceptance[members[c][0]] == NEVER
        color[c] = limit - 1 if cyclic and limit % 2 != odd else limit
    acceptance = tuple(NEVER if color[c] % 2 else ALWAYS for c in component)
    weak = automaton.relabelled(automaton.edges, acceptance)
    return quotient(weak, refine(weak.edges, acceptance))
