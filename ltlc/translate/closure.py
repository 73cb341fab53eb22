"""What a formula becomes after one letter: obligations and their derivatives.

Two representations carry every construction of this package:

* an **obligation** is a positive Boolean combination of *atoms* (letter sets and temporal subformulas) in disjunctive
  normal form: a sorted tuple of clauses, each an integer with one bit per atom. Clauses are reduced by syntactic
  implication, so that equal tuples mean propositionally equivalent formulas, and many more are recognised as equal.
* a **derivative** is the deterministic successor relation: a dictionary obligation -> letter set that partitions the
  letters ("after" function, Brzozowski-style).

References:
    J. Esparza, J. Kretinsky, S. Sickert: One Theorem to Rule Them All: A Unified Translation of LTL into
    omega-Automata. LICS 2018, doi 10.1145/3209108.3209161 (the "after" function).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce

from ltlc.budget import Budget, check_time
from ltlc.graph import bits
from ltlc.ltl import Formula
from ltlc.translate.letters import Letters
from ltlc.translate.nodes import Nodes

Obligation = tuple[int, ...]
Derivative = dict[Obligation, int]

TRUE: Obligation = (0,)
FALSE: Obligation = ()
_MANY = 16
"""A loop over more than so many things asks for the time itself."""


class Closure(Nodes):
    """The nodes of a formula, and the derivative of each.

    Args:
        formula: in negation normal form, over `&`, `|` and the temporal operators.
        letters: `letters_of` the formula.
        budget: checked while obligations grow.
    """

    def __init__(self, formula: Formula, letters: Letters, budget: Budget) -> None:
        super().__init__(formula, letters)
        self.budget = budget
        self._derivative: dict[int, Derivative] = {}
        self._after: dict[Obligation, Derivative] = {}
        self._combined: dict[tuple[bool, Obligation, Obligation], Obligation] = {}
        self._obligation: dict[int, Obligation] = {}
        self._up: list[int] = []
        self._against: list[int] = []
        self._atoms = 0
        self._registered: set[int] = set()
        self._registered_finite: set[int] = set()

    # -- atoms --------------------------------------------------------------------------------------------------------

    def register(self, node: int) -> None:
        """Make known every atom that an obligation to satisfy the node can lead to.

        Clauses are reduced by what is implied among known atoms, so all of them have to be known before the first
        obligation is built: then equal obligations stay equal.
        """
        if node not in self._registered:
            self._registered.add(node)
            kind, args, _ = self.nodes[node]
            if kind not in "&|":
                self._register_atom(node)
            for arg in args:
                self.register(arg)

    def register_finite_parts(self, node: int) -> None:
        """`register` the finite part of every subformula."""
        if node not in self._registered_finite:
            self._registered_finite.add(node)
            self.register(self.finite_part(node))
            for arg in self.nodes[node].args:
                self.register_finite_parts(arg)

    def _register_atom(self, node: int) -> None:
        if not len(self._registered) & 15:
            check_time()
        while len(self._up) < len(self.nodes):
            self._up.append(0)
            self._against.append(0)
        others = bits(self._atoms)
        self._atoms |= 1 << node
        up = above = 1 << node
        kind, _, letters = self.nodes[node]
        for other in others:
            other_kind, _, other_letters = self.nodes[other]
            if kind == other_kind == "letters":
                common = letters & other_letters
                implies, implied = common == letters, common == other_letters
                if not common:
                    self._against[node] |= 1 << other
                    self._against[other] |= 1 << node
            else:
                implies, implied = self.implies(node, other), self.implies(other, node)
            if implies:
                up |= self._up[other]
            if implied:
                above |= 1 << other
        self._up[node] = up
        for other in others:  # kept transitively closed
            if self._up[other] & above:
                self._up[other] |= up

    # -- obligations --------------------------------------------------------------------------------------------------

    def obligation(self, node: int) -> Obligation:
        """The obligation to satisfy a node."""
        known = self._obligation.get(node)
        if known is None:
            kind, args, letters = self.nodes[node]
            if kind == "letters" and letters in (0, self.letters.all):
                known = TRUE if letters else FALSE
            elif kind == "&":
                known = reduce(self.both, map(self.obligation, args))
            elif kind == "|":
                known = reduce(self.either, map(self.obligation, args))
            else:
                self.register(node)
                known = (1 << node,)
            self._obligation[node] = known
        return known

    def both(self, f: Obligation, g: Obligation) -> Obligation:
        """Conjunction."""
        if f in (g, FALSE) or g == TRUE:
            return f
        if f == TRUE or g == FALSE:
            return g
        key = (True, f, g) if f < g else (True, g, f)
        known = self._combined.get(key)
        if known is None:
            known = self._combined[key] = self._antichain(self._joined(f, g))
        return known

    def either(self, f: Obligation, g: Obligation) -> Obligation:
        """Disjunction."""
        if f in (g, TRUE) or g == FALSE:
            return f
        if f == FALSE or g == TRUE:
            return g
        key = (False, f, g) if f < g else (False, g, f)
        known = self._combined.get(key)
        if known is None:
            known = self._combined[key] = self._antichain({*f, *g})
        return known

    def _joined(self, f: Obligation, g: Obligation) -> set[int]:
        """Every clause of f together with every clause of g."""
        clauses: set[int] = set()
        for a in f:
            if len(f) > _MANY or len(g) > _MANY:
                check_time()
            clauses.update([c for b in g if (c := self._clause(a | b)) is not None])
        return clauses

    def _clause(self, clause: int) -> int | None:
        """The clause without atoms that others of it imply, or None if it contradicts itself."""
        kept = clause
        for atom in bits(clause):
            if self._against[atom] & clause:
                return None
            if kept >> atom & 1:
                kept &= ~(self._up[atom] & ~(1 << atom))
        return kept

    def _antichain(self, clauses: set[int]) -> Obligation:
        self.budget.check_size(len(clauses))
        if len(clauses) == 1:
            return tuple(clauses)
        up = {c: self.closed(c) for c in clauses}
        kept: list[int] = []
        for c in sorted(clauses, key=lambda c: (c.bit_count(), c)):
            closed = up[c]
            if len(kept) > _MANY:
                check_time()
            if not any(d & ~closed == 0 for d in kept):
                kept = [d for d in kept if c & ~up[d]]
                kept.append(c)
        return tuple(sorted(kept))

    def closed(self, clause: int) -> int:
        """The clause with every atom that its atoms imply."""
        closed = 0
        for atom in bits(clause):
            closed |= self._up[atom]
        return closed

    # -- derivatives --------------------------------------------------------------------------------------------------

    def after(self, f: Obligation) -> Derivative:
        """What remains to be satisfied after one letter: a partition of the letters."""
        known = self._after.get(f)
        if known is None:
            if len(f) > _MANY:
                check_time()
            if f in (TRUE, FALSE):
                known = {f: self.letters.all}
            else:
                clauses = (reduce(self._both_after, map(self.derivative, bits(clause))) for clause in f)
                known = reduce(self._either_after, clauses)
            self._after[f] = known
        return known

    def derivative(self, node: int) -> Derivative:
        """`after` for a node."""
        known = self._derivative.get(node)
        if known is None:
            known = self._derivative[node] = self._derive(node)
        return known

    def _derive(self, node: int) -> Derivative:
        kind, args, letters = self.nodes[node]
        everything = self.letters.all
        if kind == "letters":
            parts = {TRUE: letters, FALSE: everything & ~letters}
            return {f: part for f, part in parts.items() if part}
        if kind == "X":
            return {self.obligation(args[0]): everything}
        if kind in "&|":
            return reduce(self._both_after if kind == "&" else self._either_after, map(self.derivative, args))
        again: Derivative = {self.obligation(node): everything}
        if kind == "F":
            return self._either_after(self.derivative(args[0]), again)
        if kind == "G":
            return self._both_after(self.derivative(args[0]), again)
        left, right = self.derivative(args[0]), self.derivative(args[1])
        if kind in "UW":  # f U g = g | (f & X(f U g))
            return self._either_after(right, self._both_after(left, again))
        return self._both_after(right, self._either_after(left, again))  # f R g = g & (f | X(f R g))

    def _both_after(self, f: Derivative, g: Derivative) -> Derivative:
        return self._merge(self.both, f, g)

    def _either_after(self, f: Derivative, g: Derivative) -> Derivative:
        return self._merge(self.either, f, g)

    def _merge(
        self, combine: Callable[[Obligation, Obligation], Obligation], f: Derivative, g: Derivative
    ) -> Derivative:
        merged: Derivative = {}
        for a, letters_a in f.items():
            if len(g) > _MANY or len(merged) > _MANY:
                check_time()
            for b, letters_b in g.items():
                common = letters_a & letters_b
                if common:
                    c = combine(a, b)
                    merged[c] = merged.get(c, 0) | common
        self.budget.check_moves(len(merged), self.letters.n_classes)
        return merged
