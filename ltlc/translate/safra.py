"""Determinization of transition-based generalized Buchi automata by ordered Safra trees.

A macro-state maps each state of the nondeterministic automaton to its path in the tree: the ages of the nodes around
it, oldest first. Each node waits for one acceptance set after the other; states that have just met the awaited set
move to a new youngest child, and a node whose states have all done so forgets its children, waits for the next set
and, after the last, signals acceptance. The oldest node to die or to signal gives the priority of the move: a parity
condition (min even), hence Rabin pairs.

References:
    S. Safra: On the Complexity of omega-Automata. FOCS 1988, doi 10.1109/SFCS.1988.21948.
    N. Piterman: From Nondeterministic Buchi and Streett Automata to Deterministic Parity Automata. LMCS 3(3), 2007,
    doi 10.2168/LMCS-3(3:5)2007.
    S. Schewe, T. Varghese: Tight Bounds for the Determinisation and Complementation of Generalised Buchi Automata.
    ATVA 2012, doi 10.1007/978-3-642-33386-6_5.
    R. Redziejowski: An Improved Construction of Deterministic Omega-automaton Using Derivatives. Fundamenta
    Informaticae 119, 2012, doi 10.3233/FI-2012-744 (ages instead of names).
"""

from __future__ import annotations

from ltlc.automata.acceptance import Acceptance, Clause
from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import EmersonLei, explore
from ltlc.budget import Budget, check_time

Path = tuple[int, ...]
Places = tuple[tuple[int, Path], ...]
MacroState = tuple[Places, tuple[int, ...]]
"""(state, path of node ages) sorted by state, and the awaited set of each node by age."""


def determinize(automaton: BuchiAutomaton, budget: Budget) -> EmersonLei:
    """A deterministic parity automaton for the language; marks are priorities, the least one decides (odd: accept).

    Raises:
        StateLimitExceeded, TimeLimitExceeded: the budget ran out.
    """
    everything = (1 << automaton.n_letters) - 1
    initial: MacroState = (tuple((q, (0,)) for q in automaton.initial), (0,))

    def successors(state: MacroState) -> list[tuple[int, MacroState, int]]:
        moves = []
        for letters in _indistinguishable(automaton, state[0], everything, budget):
            check_time()
            following, priority = _step(automaton, state, letters)
            moves.append((letters, following, 0 if priority is None else 1 << priority))
        return moves

    _, edges = explore(initial, successors, budget)
    n_priorities = max((e.marks.bit_length() for out in edges for e in out), default=0)
    return EmersonLei(tuple(map(tuple, edges)), (parity(n_priorities),) * len(edges))


def parity(n_priorities: int) -> Acceptance:
    """The least priority seen infinitely often is odd; mark p stands for priority p, no mark for none."""
    even = sum(1 << p for p in range(0, n_priorities, 2))
    return tuple(sorted(Clause((1 << p) - 1 & even, 1 << p) for p in range(1, n_priorities, 2)))


def _indistinguishable(automaton: BuchiAutomaton, places: Places, letters: int, budget: Budget) -> list[int]:
    """The coarsest partition of the letters that the edges of these states respect."""
    blocks = [letters]
    for letter_set in dict.fromkeys(edge.letters for q, _ in places for edge in automaton.edges[q]):
        check_time()
        budget.check_moves(len(blocks), automaton.n_letters)
        blocks = [part for b in blocks for part in (b & letter_set, b & ~letter_set) if part]
    return blocks


def _step(automaton: BuchiAutomaton, state: MacroState, letters: int) -> tuple[MacroState, int | None]:
    """The next macro-state and the priority of the move."""
    places, waits = state
    n_old, n_sets, edges = len(waits), automaton.n_sets, automaton.edges
    best: dict[int, Path] = {}
    for q, path in places:
        node = path[-1]
        awaited = 1 << waits[node]
        # All new nodes are younger than the old ones; the child of an older node counts as older.
        below = (*path, n_old + node)
        for edge_letters, target, marks in edges[q]:
            if edge_letters & letters:
                moved = below if marks & awaited or not n_sets else path
                rival = best.get(target)
                # Older nodes win; inside the same nodes, the deeper place wins: after its end, a path counts as young.
                if rival is None or (moved != rival and (*moved, 2 * n_old) < (*rival, 2 * n_old)):
                    best[target] = moved
    waits_after = list(waits)
    present = {node for path in best.values() for node in path}
    # Only a node in which no state stays can be complete.
    empty = present.difference([path[-1] for path in best.values()])
    signals = [i for i in sorted(empty) if i < n_old and _complete(i, best, waits_after, n_sets)]
    alive = sorted({node for path in best.values() for node in path} if empty else present)
    # A node that signals infinitely often counts only if it and all older ones die finitely often.
    priority = min([2 * i + 1 for i in signals], default=None)
    death = next((i for i, node in enumerate(alive) if i != node), len(alive))  # the first number that is missing
    if death < n_old and (priority is None or 2 * death < priority):
        priority = 2 * death
    age = {node: i for i, node in enumerate(alive)}
    following = tuple([(q, tuple([age[node] for node in path])) for q, path in sorted(best.items())])
    return (following, tuple([waits_after[node] if node < n_old else 0 for node in alive])), priority


def _complete(node: int, places: dict[int, Path], waits: list[int], n_sets: int) -> bool:
    """If all states of the node are in its children, take them back and go on waiting; True after the last set."""
    inside = [q for q, path in places.items() if node in path]
    if not inside or any(places[q][-1] == node for q in inside):
        return False
    for q in inside:
        path = places[q]
        places[q] = path[: path.index(node) + 1]
    waits[node] = (waits[node] + 1) % max(n_sets, 1)
    return waits[node] == 0
