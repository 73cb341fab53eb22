"""Smaller nondeterministic Buchi automata: without useless states, edges and marks, and with similar states merged.

A state *simulates* another if it can answer each of its moves by one on the same letter that has all of its marks, and
leads to a state that simulates the one reached. So it accepts each word that the other accepts.

References:
    K. Etessami, G. Holzmann: Optimizing Buchi Automata. CONCUR 2000, doi 10.1007/3-540-44618-4_13.
    F. Somenzi, R. Bloem: Efficient Buchi Automata from LTL Formulae. CAV 2000, doi 10.1007/10722167_21 (simulation in
    both directions).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from ltlc import graph
from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import LetterEdge, merged
from ltlc.budget import check_time
from ltlc.graph import bits

_MAX_WORK = 1 << 20
"""Steps of a search for simulations, some tenths of a second; where more would be needed, it is given up."""
_MANY = 64
"""A move that is compared with more others than this asks for the time."""


def reduced_buchi(automaton: BuchiAutomaton) -> BuchiAutomaton:
    """An automaton of the same language, with no more states."""
    result = trimmed(automaton)
    while True:
        before = result
        result = _merged_alike(result, simulation(result), forwards=True)
        result = _merged_alike(result, reverse_simulation(result), forwards=False)
        if result.n_states == before.n_states:
            return result
        result = trimmed(result)


def trimmed(automaton: BuchiAutomaton) -> BuchiAutomaton:
    """Without states from which nothing is accepted, and in each strong component with the acceptance sets it needs.

    A set that contains another one, and one that contains all edges, is not needed. Edges from component to component
    have no marks.
    """
    component = components(automaton)
    inner = inner_marks(automaton, component)
    needed = [needed_sets(marks, automaton.n_sets) for marks in inner]
    n_sets = max((len(sets) for sets in needed if sets is not None), default=0)
    if any(sets is None and marks for sets, marks in zip(needed, inner, strict=True)):
        n_sets = max(n_sets, 1)
    live = [sets is not None for sets in needed]
    for q in sorted(range(automaton.n_states), key=component.__getitem__, reverse=True):
        live[component[q]] |= any(live[component[edge.target]] for edge in automaton.edges[q])
    edges: list[tuple[LetterEdge, ...]] = []
    for q, out in enumerate(automaton.edges):
        check_time()
        here, moves = component[q], []
        for letters, target, marks in out:
            if live[component[target]]:
                sets = needed[here] if component[target] == here else None
                moves.append((letters, target, 0 if sets is None else _renamed(marks, sets, n_sets)))
        edges.append(_undominated(moves, {}))
    return _reachable(replace(automaton, edges=tuple(edges), n_sets=n_sets))


def components(automaton: BuchiAutomaton) -> list[int]:
    """The strong component of each state, numbered in topological order."""
    return graph.strong_components([[edge.target for edge in out] for out in automaton.edges])


def inner_marks(automaton: BuchiAutomaton, component: Sequence[int]) -> list[list[int]]:
    """The marks of the edges inside each strong component."""
    inner: list[list[int]] = [[] for _ in range(max(component) + 1)]
    for q, out in enumerate(automaton.edges):
        for edge in out:
            if component[edge.target] == component[q]:
                inner[component[q]].append(edge.marks)
    return inner


def needed_sets(marks: list[int], n_sets: int) -> list[int] | None:
    """The acceptance sets that decide in a strong component with these marks on its edges; None if it never accepts."""
    kinds = sorted(set(marks))
    if not kinds:
        return None
    holders = [sum(1 << i for i, kind in enumerate(kinds) if kind >> s & 1) for s in range(n_sets)]
    if 0 in holders:
        return None
    full = (1 << len(kinds)) - 1
    kept: list[int] = []
    for s in sorted(range(n_sets), key=lambda s: (holders[s].bit_count(), s)):
        if holders[s] != full and not any(holders[t] & ~holders[s] == 0 for t in kept):
            kept.append(s)
    return sorted(kept)


def _renamed(marks: int, sets: Sequence[int], n_sets: int) -> int:
    """The marks of the acceptance sets that are needed, numbered anew, and all of the numbers that are left."""
    kept = sum(1 << i for i, s in enumerate(sets) if marks >> s & 1)
    return kept | (1 << n_sets) - (1 << len(sets))


def _reachable(automaton: BuchiAutomaton) -> BuchiAutomaton:
    """Numbered breadth-first, without what cannot be reached."""
    number = {q: i for i, q in enumerate(automaton.initial)}
    order = list(number)
    for q in order:  # grows while it is read
        for edge in automaton.edges[q]:
            if edge.target not in number:
                number[edge.target] = len(order)
                order.append(edge.target)
    edges = (tuple([e._replace(target=number[e.target]) for e in automaton.edges[q]]) for q in order)
    return replace(automaton, initial=tuple(range(len(automaton.initial))), edges=tuple(edges))


def simulation(automaton: BuchiAutomaton) -> list[int]:
    """For each state the set of states that simulate it, itself among them."""
    everything = (1 << automaton.n_states) - 1
    return _simulation(automaton.edges, [everything] * automaton.n_states)


def reverse_simulation(automaton: BuchiAutomaton) -> list[int]:
    """For each state the set of states that simulate it on the way back to the initial states."""
    incoming: list[list[LetterEdge]] = [[] for _ in automaton.edges]
    for q, out in enumerate(automaton.edges):
        for letters, target, marks in out:
            incoming[target].append(LetterEdge(letters, q, marks))
    everything, initial = (1 << automaton.n_states) - 1, sum(1 << q for q in automaton.initial)
    return _simulation(incoming, [initial if initial >> q & 1 else everything for q in range(automaton.n_states)])


def _simulation(edges: Sequence[Sequence[LetterEdge]], above: list[int]) -> list[int]:
    """The largest simulation within a relation that is reflexive and transitive; equality, if that is too much work."""
    kinds = {edge.marks for out in edges for edge in out}
    if len(kinds) ** 2 > _MAX_WORK:
        return _equality(len(edges))
    # Per letter and marks: for each state, those with a move to it that has all of these marks.
    sources: dict[tuple[int, int], dict[int, int]] = {}
    covered = {marks: [kind for kind in kinds if not kind & ~marks] for marks in kinds}
    work = sum(e.letters.bit_count() * len(covered[e.marks]) for out in edges for e in out)
    if work > _MAX_WORK:
        return _equality(len(edges))
    letters_of = {letters: bits(letters) for letters in {edge.letters for out in edges for edge in out}}
    for q, out in enumerate(edges):
        check_time()
        for letters, target, marks in out:
            for kind in covered[marks]:
                for letter in letters_of[letters]:
                    of_target = sources.setdefault((letter, kind), {})
                    of_target[target] = of_target.get(target, 0) | 1 << q
    answers: dict[tuple[int, int, int], int] = {}

    def answering(edge: LetterEdge) -> int:
        """The states that can answer a move on each of its letters."""
        nonlocal work
        able, targets = -1, above[edge.target]
        for letter in letters_of[edge.letters]:
            key = (letter, edge.marks, targets)
            known = answers.get(key)
            if known is None:
                known, of_target = 0, sources[letter, edge.marks]
                work += len(of_target)
                for target, states in of_target.items():
                    if targets >> target & 1:
                        known |= states
                answers[key] = known
            able &= known
        work += len(letters_of[edge.letters])
        return able

    todo = list(range(len(edges)))
    while todo:
        answers.clear()
        changed = 0
        for q in todo:
            check_time()
            left = above[q]
            for edge in edges[q]:
                left &= answering(edge)
                if work > _MAX_WORK:
                    return _equality(len(edges))
            if left != above[q]:
                above[q] = left
                changed |= 1 << q
        todo = [q for q, out in enumerate(edges) if any(changed >> edge.target & 1 for edge in out)]
    return above


def _equality(n_states: int) -> list[int]:
    return [1 << q for q in range(n_states)]


def _merged_alike(automaton: BuchiAutomaton, above: list[int], *, forwards: bool) -> BuchiAutomaton:
    """States that simulate each other merged, and moves left out where another one is as good."""
    first = [next(p for p in bits(others) if above[p] >> q & 1) for q, others in enumerate(above)]
    moves: list[list[tuple[int, int, int]]] = [[] for _ in automaton.edges]
    for q, out in enumerate(automaton.edges):
        check_time()
        if first[q] == q or not forwards:
            moves[first[q]] += [(letters, first[target], marks) for letters, target, marks in out]
    better = {q: others & ~(1 << q) for q, others in enumerate(above) if first[q] == q} if forwards else {}
    edges = tuple([_undominated(out, better) for out in moves])
    initial = tuple(dict.fromkeys(first[q] for q in automaton.initial))
    return _reachable(replace(automaton, initial=initial, edges=edges))


def _undominated(moves: Iterable[tuple[int, int, int]], better: dict[int, int]) -> tuple[LetterEdge, ...]:
    """Without the letters on which another move has the same marks or more, and the same target or a better one."""
    edges = merged(moves)
    to: dict[int, list[LetterEdge]] = {}
    for edge in edges:
        to.setdefault(edge.target, []).append(edge)
    kept = []
    for edge in edges:
        letters, above = edge.letters, better.get(edge.target, 0)
        rivals = [other for other in to[edge.target] if other.marks != edge.marks]
        for target in to if above else ():
            rivals += to[target] if above >> target & 1 else ()
        if len(rivals) > _MANY:
            check_time()
        for other in rivals:
            if not edge.marks & ~other.marks:
                letters &= ~other.letters
        if letters:
            kept.append(edge._replace(letters=letters))
    return tuple(kept)
