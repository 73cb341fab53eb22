"""Determinization of transition-based generalized Buchi automata by ordered Safra trees.

Each strong component of the nondeterministic automaton that can accept has trees of its own, since a run stays in one
of them in the end; of the states in other components, only the set is remembered. A macro-state maps each state to its
path in the trees of its component: the ages of the nodes around it, oldest first. States that enter a component at the
same time are in a new root. Each node waits for one acceptance set after the other; states that have just met the
awaited set move to a new youngest child, and a node whose states have all done so forgets its children, waits for the
next set and, after the last, signals acceptance. The oldest node to die or to signal gives the priority of the move: a
parity condition (min even) for each component, hence Rabin pairs.

A state is left out where another one simulates it and is in a later component, or in older nodes of the same: then the
runs of the latter are enough, as no run can be left for another one for ever.

References:
    S. Safra: On the Complexity of omega-Automata. FOCS 1988, doi 10.1109/SFCS.1988.21948.
    N. Piterman: From Nondeterministic Buchi and Streett Automata to Deterministic Parity Automata. LMCS 3(3), 2007,
    doi 10.2168/LMCS-3(3:5)2007.
    S. Schewe, T. Varghese: Tight Bounds for the Determinisation and Complementation of Generalised Buchi Automata.
    ATVA 2012, doi 10.1007/978-3-642-33386-6_5.
    R. Redziejowski: An Improved Construction of Deterministic Omega-automaton Using Derivatives. Fundamenta
    Informaticae 119, 2012, doi 10.3233/FI-2012-744 (ages instead of names).
    C. Loeding, A. Pirogov: New Optimizations and Heuristics for Determinization of Buchi Automata. ATVA 2019, doi
    10.1007/978-3-030-31784-3_18 (states left out).
    Y. Li, A. Turrini, W. Feng, M. Vardi, L. Zhang: Divide-and-Conquer Determinization of Buchi Automata Based on SCC
    Decomposition. CAV 2022, doi 10.1007/978-3-031-13188-2_8 (trees of each component).
"""

from __future__ import annotations

from collections import Counter

from ltlc.automata.acceptance import Acceptance, Clause
from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import EmersonLei, explore
from ltlc.automata.simulation import components, inner_marks, needed_sets, simulation
from ltlc.budget import Budget, check_time
from ltlc.graph import bits

Path = tuple[int, ...]
Places = tuple[tuple[int, Path], ...]
MacroState = tuple[Places, tuple[tuple[int, ...], ...]]
"""(state, path of node ages) sorted by state, and per forest the awaited set of each node by age."""
_END = 1 << 30
"""After its end a path counts as young."""


def determinize(automaton: BuchiAutomaton, budget: Budget, *, apart: bool = True) -> EmersonLei:
    """A deterministic automaton for the language.

    Args:
        automaton: any; the smaller the better (`reduced_buchi`).
        budget: for the number of states.
        apart: whether the trees of a component have ages of their own. Then the condition is that one of the components
            accepts; otherwise there are mostly more states, with a parity condition, which is easy to negate.

    Raises:
        StateLimitExceeded, TimeLimitExceeded: the budget ran out.
    """
    trees = _Trees(automaton, apart)
    everything = (1 << automaton.n_letters) - 1

    def successors(state: MacroState) -> list[tuple[int, MacroState, int]]:
        moves = []
        for letters in _indistinguishable(trees.automaton, state[0], everything, budget):
            check_time()
            following, marks = trees.step(state, letters)
            moves.append((letters, following, marks))
        return moves

    _, edges = explore(trees.initial, successors, budget)
    n_marks = max((e.marks.bit_length() for out in edges for e in out), default=0)
    return EmersonLei(tuple(map(tuple, edges)), (trees.condition(n_marks),) * len(edges))


def parity(n_priorities: int, step: int = 1, offset: int = 0) -> Acceptance:
    """The least priority seen infinitely often is odd; mark `step` p + `offset` stands for priority p."""
    places = [1 << step * p + offset for p in range(n_priorities)]
    return tuple(sorted(Clause(sum(places[0:p:2]), places[p]) for p in range(1, n_priorities, 2)))


def _indistinguishable(automaton: BuchiAutomaton, places: Places, letters: int, budget: Budget) -> list[int]:
    """The coarsest partition of the letters that the edges of these states respect."""
    blocks = [letters]
    for letter_set in dict.fromkeys(edge.letters for q, _ in places for edge in automaton.edges[q]):
        check_time()
        budget.check_moves(len(blocks), automaton.n_letters)
        blocks = [part for b in blocks for part in (b & letter_set, b & ~letter_set) if part]
    return blocks


class _Trees:
    """The forests of an automaton, and how they change.

    Attributes:
        automaton: of which macro-states are made.
        n_forests: how many there are.
        initial: the first macro-state.
    """

    def __init__(self, automaton: BuchiAutomaton, apart: bool) -> None:
        self.automaton = automaton
        self._above = simulation(automaton)
        self._component = components(automaton)
        needed = [needed_sets(marks, automaton.n_sets) for marks in inner_marks(automaton, self._component)]
        self._sets = {c: sets for c, sets in enumerate(needed) if sets is not None}
        """per component that can accept"""
        self.n_forests = max(len(self._sets), 1) if apart else 1
        self._forest = {c: i if apart else 0 for i, c in enumerate(self._sets)}
        members = Counter(self._component)
        self._alone = {c for c, sets in self._sets.items() if apart and sets and members[c] == 1}
        """components of one state: whether it is there is enough, and its acceptance sets are those of a move"""
        self.initial: MacroState = self._settled(
            {q: self._fresh(q, 0) for q in automaton.initial}, ((),) * self.n_forests
        )[0]

    def condition(self, n_marks: int) -> Acceptance:
        """That one of the forests accepts; their marks take turns."""
        n_priorities = -(-n_marks // self.n_forests)
        clauses: list[Clause] = []
        for c, forest in self._forest.items():
            if c in self._alone:
                clauses.append(Clause(1 << forest, self._seen(c, -1)))
            elif c == min(other for other, its in self._forest.items() if its == forest):
                clauses += parity(n_priorities, self.n_forests, forest)
        return tuple(sorted(clauses))

    def _seen(self, c: int, marks: int) -> int:
        """The marks for the acceptance sets of a component of one state; the first mark of a forest is for its end."""
        n, forest = self.n_forests, self._forest[c]
        return sum(1 << (i + 1) * n + forest for i, s in enumerate(self._sets[c]) if marks >> s & 1)

    def _fresh(self, state: int, n_old: int) -> Path:
        """The path of a state whose component has just been entered; new roots are younger than all other nodes."""
        c = self._component[state]
        return (2 * n_old + c,) if c in self._forest else ()

    def step(self, state: MacroState, letters: int) -> tuple[MacroState, int]:
        """The next macro-state and the marks of the move."""
        places, waits = state
        component, edges = self._component, self.automaton.edges
        best: dict[int, Path] = {}
        seen = 0
        for q, path in places:
            c = component[q]
            forest = self._forest.get(c, -1)
            below, awaited = path, 0
            if forest >= 0 and self._sets[c]:
                # All new nodes are younger than the old ones; the child of an older node counts as older.
                below = (*path, len(waits[forest]) + path[-1])
                awaited = 1 << self._sets[c][waits[forest][path[-1]]]
            for edge_letters, target, marks in edges[q]:
                if edge_letters & letters:
                    if component[target] == c:
                        moved = below if marks & awaited else path
                        if c in self._alone:
                            moved, seen = path, seen | self._seen(c, marks)
                    else:
                        other = self._forest.get(component[target], 0)
                        moved = self._fresh(target, len(waits[other]))
                    rival = best.get(target)
                    # Older nodes win; inside the same nodes, the deeper place wins.
                    if rival is None or (*moved, _END) < (*rival, _END):
                        best[target] = moved
        following, signals = self._settled(best, waits)
        return following, signals | seen

    def _settled(self, best: dict[int, Path], waits: tuple[tuple[int, ...], ...]) -> tuple[MacroState, int]:
        """The macro-state with these paths, in which nodes that are complete have no children."""
        self._leave_out(best)
        marks = 0
        ages: list[dict[int, int]] = []
        waits_after: list[tuple[int, ...]] = []
        members: dict[int, dict[int, Path]] = {}
        for q, path in best.items():
            if path:
                members.setdefault(self._forest[self._component[q]], {})[q] = path
        for forest, old in enumerate(waits):
            inside = members.get(forest)
            if inside is None:  # mostly
                marks |= 1 << forest if old else 0
                ages.append({})
                waits_after.append(())
                continue
            self._join_roots(inside)
            alive, awaited, priority = self._cleared(inside, list(old))
            best.update(inside)
            if priority is not None:
                marks |= 1 << priority * self.n_forests + forest
            ages.append({node: i for i, node in enumerate(alive)})
            waits_after.append(tuple([awaited[node] if node < len(old) else 0 for node in alive]))
        following = []
        for q, path in sorted(best.items()):
            if path:
                age = ages[self._forest[self._component[q]]]
                path = tuple([age[node] for node in path])
            following.append((q, path))
        return (tuple(following), tuple(waits_after)), marks

    def _leave_out(self, best: dict[int, Path]) -> None:
        """Leave out the states whose runs those of others make up for."""
        present = sum(1 << q for q in best)
        if present.bit_count() < 2:
            return
        component, above = self._component, self._above
        for q, path in list(best.items()):
            for other in bits(above[q] & present & ~(1 << q)):
                if component[other] < component[q]:
                    continue
                if component[other] == component[q]:
                    mine, its = (*path, _END), (*best[other], _END)
                    if its > mine or (its == mine and above[other] >> q & 1 and other > q):
                        continue
                del best[q]
                present ^= 1 << q
                break

    def _join_roots(self, inside: dict[int, Path]) -> None:
        """In a component all of whose cycles accept, those that wait for the oldest root to die wait together."""
        roots: dict[int, set[int]] = {}
        for q, path in inside.items():
            if not self._sets[self._component[q]]:
                roots.setdefault(self._component[q], set()).add(path[0])
        for q, path in inside.items():
            waiting = sorted(roots.get(self._component[q], ()))[1:]
            if path[0] in waiting:
                inside[q] = (waiting[0],)

    def _cleared(self, inside: dict[int, Path], waits: list[int]) -> tuple[list[int], list[int], int | None]:
        """The nodes by age, what each awaits, and the priority."""
        n_old = len(waits)
        present = {node for path in inside.values() for node in path}
        signals = []
        # Only a node in which no state stays can be complete.
        for node in sorted(present.difference([path[-1] for path in inside.values()])):
            if node < n_old and self._complete(node, inside, waits):
                signals.append(node)
        alive = sorted({node for path in inside.values() for node in path})
        oldest: dict[int, int] = {}
        for q, path in inside.items():
            c = self._component[q]
            if not self._sets[c]:
                oldest[c] = min(oldest.get(c, _END), path[0])
        signals += [node for node in oldest.values() if node < n_old]
        # A node that signals infinitely often counts only if it and all older ones die finitely often.
        priority = min([2 * i + 1 for i in signals], default=None)
        death = next((i for i, node in enumerate(alive) if i != node), len(alive))  # the first number that is missing
        if death < n_old and (priority is None or 2 * death < priority):
            priority = 2 * death
        return alive, waits, priority

    def _complete(self, node: int, places: dict[int, Path], waits: list[int]) -> bool:
        """If all states of the node are in its children, take them back and go on waiting; True after the last set."""
        inside = [q for q, path in places.items() if node in path]
        if not inside or any(places[q][-1] == node for q in inside):
            return False
        for q in inside:
            path = places[q]
            places[q] = path[: path.index(node) + 1]
        waits[node] = (waits[node] + 1) % len(self._sets[self._component[inside[0]]])
        return waits[node] == 0
