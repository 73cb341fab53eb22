"""LTL to transition-based generalized Buchi automata.

States are sets of subformulas that still have to hold (clauses of an obligation). On each letter every subformula is
unfolded; a least fixpoint (F, U, M) may be met now or put off, and putting it off withholds its mark. So a run is
accepted iff no fixpoint is put off for ever. Moves that demand more and give less than another are dropped.

References:
    J.-M. Couvreur: On-the-Fly Verification of Linear Temporal Logic. FM 1999, doi 10.1007/3-540-48119-2_16.
    P. Gastin, D. Oddoux: Fast LTL to Buchi Automata Translation. CAV 2001, doi 10.1007/3-540-44585-4_6.
    A. Duret-Lutz: LTL translation improvements in Spot 1.0. IJCCBS 5(1/2), 2014, doi 10.1504/IJCCBS.2014.059594.
"""

from __future__ import annotations

from typing import NamedTuple

from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import LetterEdge, explore
from ltlc.budget import Budget, check_time
from ltlc.graph import bits
from ltlc.translate.closure import Closure

_MANY = 64
"""A comparison with more than so many moves asks for the time."""


class Move(NamedTuple):
    """On `letters`, go on with `clause`, having put off the least fixpoints in `delayed` (a set of nodes)."""

    letters: int
    clause: int
    delayed: int


def tableau(closure: Closure, node: int, budget: Budget) -> BuchiAutomaton:
    """The generalized Buchi automaton of a subformula, one acceptance set per least fixpoint that can be put off.

    Raises:
        StateLimitExceeded, TimeLimitExceeded: the budget ran out.
    """
    return _Tableau(closure, budget).build(node)


class _Tableau:
    def __init__(self, closure: Closure, budget: Budget) -> None:
        self._closure = closure
        self._budget = budget
        self._unfolded: dict[int, list[Move]] = {}

    def build(self, node: int) -> BuchiAutomaton:
        # A state that nothing enters stands for the disjunction of the initial clauses; explore numbers it 0.
        start = -1
        initial = self._closure.obligation(node)

        def successors(clause: int) -> list[tuple[int, int, int]]:
            clauses = initial if clause == start else (clause,)
            moves = _undominated([m for c in clauses for m in self._moves(c)])
            return [(m.letters, m.clause, m.delayed) for m in moves]

        _, edges = explore(start, successors, self._budget)
        delayed = 0
        for out in edges:
            for edge in out:
                delayed |= edge.marks
        sets = bits(delayed)
        automaton = [
            tuple(
                LetterEdge(letters, target, sum(1 << i for i, u in enumerate(sets) if not put_off >> u & 1))
                for letters, target, put_off in out
            )
            for out in edges
        ]
        return BuchiAutomaton(self._closure.letters.n_classes, (0,), tuple(automaton), len(sets))

    def _moves(self, clause: int) -> list[Move]:
        moves = [Move(self._closure.letters.all, 0, 0)]
        for atom in bits(clause):
            moves = self._both(moves, self.unfold(atom))
        return moves

    def unfold(self, node: int) -> list[Move]:
        """The ways to satisfy a node."""
        known = self._unfolded.get(node)
        if known is None:
            known = self._unfolded[node] = _undominated(self._unfold(node))
        return known

    def _unfold(self, node: int) -> list[Move]:
        closure = self._closure
        kind, args, letters = closure.nodes[node]
        if kind == "letters":
            return [Move(letters, 0, 0)] if letters else []
        if kind == "X":
            return [Move(closure.letters.all, clause, 0) for clause in closure.obligation(args[0])]
        if kind == "|":
            return [move for arg in args for move in self.unfold(arg)]
        if kind == "&":
            moves = [Move(closure.letters.all, 0, 0)]
            for arg in args:
                moves = self._both(moves, self.unfold(arg))
            return moves
        put_off = 1 << node if kind in "FUM" else 0
        delay = [Move(closure.letters.all, clause, put_off) for clause in closure.obligation(node)]
        if kind == "F":
            return [*self.unfold(args[0]), *delay]
        if kind == "G":
            return self._both(self.unfold(args[0]), delay)
        left, right = self.unfold(args[0]), self.unfold(args[1])
        if kind in "UW":
            return [*right, *self._both(left, delay)]
        return self._both(right, [*left, *delay])

    def _both(self, left: list[Move], right: list[Move]) -> list[Move]:
        """Every way to do both.

        Clauses are joined as sets: to drop what another subformula implies would let two fixpoints be put off in turns.
        """
        moves: dict[tuple[int, int], int] = {}
        for a in left:
            self._budget.check_size(len(moves))
            self._budget.check_sets(len(moves), self._closure.letters.n_classes)
            for b in right:
                letters = a.letters & b.letters
                if letters:
                    key = (a.clause | b.clause, a.delayed | b.delayed)
                    moves[key] = moves.get(key, 0) | letters
        self._budget.check_size(len(moves))
        return [Move(letters, clause, delayed) for (clause, delayed), letters in moves.items()]


def _undominated(moves: list[Move]) -> list[Move]:
    """Without the letters on which another move demands no more and puts off no more."""
    kept: list[Move] = []
    for move in sorted(moves, key=lambda m: (m.clause.bit_count() + m.delayed.bit_count(), m.clause, m.delayed)):
        letters, clause, delayed = move
        if len(kept) > _MANY:
            check_time()
        for other in kept:
            if not other.clause & ~clause and not other.delayed & ~delayed:
                letters &= ~other.letters
        if letters:
            kept.append(Move(letters, clause, delayed))
    return kept
