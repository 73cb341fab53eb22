"""Syntactic implication: a quick, sound and incomplete test for `f -> g` in every word."""

from __future__ import annotations

from ltlc.ltl.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    fold,
)
from ltlc.ltl.normal import is_literal, negation
from ltlc.ltl.purity import Purity, purity

_UNTILS = (Until, WeakUntil)
_RELEASES = (Release, StrongRelease)


class Implications:
    """Answers about formulas in negation normal form, remembered for as long as this object lives.

    Args:
        depth: how many operators deep an answer is looked for.
        budget: how many pairs of formulas are looked at in all; afterwards every new answer is no.

    References:
        Fabio Somenzi and Roderick Bloem, Efficient Buchi automata from LTL formulae, CAV 2000,
        doi:10.1007/10722167_21.
    """

    def __init__(self, depth: int = 12, budget: int = 20_000) -> None:
        self._depth = depth
        self._budget = budget
        self._known: dict[tuple[Formula, Formula], bool] = {}
        self._negations: dict[Formula, Formula] = {}
        self._purities: dict[Formula, Purity] = {}
        self._sizes: dict[Formula, int] = {}

    def negation(self, formula: Formula) -> Formula:
        """The negation, in negation normal form."""
        known = self._negations.get(formula)
        return negation(formula, self._negations) if known is None else known

    def purity(self, formula: Formula) -> Purity:
        """Whether it is a pure eventuality or universality."""
        known = self._purities.get(formula)  # asked again and again
        return purity(formula, self._purities) if known is None else known

    def size(self, formula: Formula) -> int:
        """Its number of nodes, written out as a tree."""
        return fold(formula, self._sizes, lambda _, sizes: 1 + sum(sizes))

    def implies(self, f: Formula, g: Formula) -> bool:
        """Whether f -> g is seen to be valid."""
        return self._implies(f, g, self._depth)

    def contradict(self, f: Formula, g: Formula) -> bool:
        """Whether f & g is seen to be unsatisfiable."""
        return self.implies(f, self.negation(g))

    def exhaust(self, f: Formula, g: Formula) -> bool:
        """Whether f | g is seen to be valid."""
        return self.implies(self.negation(f), g)

    def _implies(self, f: Formula, g: Formula, depth: int) -> bool:
        if f is g or f is FALSE or g is TRUE:
            return True
        if is_literal(f) and is_literal(g):
            return False
        known = self._known.get((f, g))
        if known is not None:
            return known
        if depth == 0 or self._budget == 0:
            return False
        self._budget -= 1
        # No answer depends on itself: each step takes an operator off f or g.
        result = self._by_connectives(f, g, depth - 1) or self._by_operators(f, g, depth - 1)
        self._known[f, g] = result
        return result

    def _by_connectives(self, f: Formula, g: Formula, depth: int) -> bool:
        test = self._implies
        if isinstance(f, Or):
            return all(test(part, g, depth) for part in f.args)
        if isinstance(g, And):
            return all(test(f, part, depth) for part in g.args)
        if isinstance(f, And) and any(test(part, g, depth) for part in f.args):
            return True
        return isinstance(g, Or) and any(test(f, part, depth) for part in g.args)

    def _by_operators(self, f: Formula, g: Formula, depth: int) -> bool:
        return self._weaker_now(f, g, depth) or self._stronger_now(f, g, depth) or self._step_by_step(f, g, depth)

    def _weaker_now(self, f: Formula, g: Formula, depth: int) -> bool:
        """By what f demands of the first position, or, if g is a pure eventuality, of any position."""
        test = self._implies
        if isinstance(f, Always | Release | StrongRelease) and test(f.args[-1], g, depth):
            return True
        if isinstance(f, _UNTILS) and test(f.args[0], g, depth) and test(f.args[1], g, depth):
            return True
        if self.purity(g).eventual:
            if isinstance(f, Eventually | Next | Until):
                return test(f.args[-1], g, depth)
            if isinstance(f, StrongRelease):
                return test(f.args[0], g, depth)
        return False

    def _stronger_now(self, f: Formula, g: Formula, depth: int) -> bool:
        """By what makes g true at the first position, or, if f is a pure universality, at any position."""
        test = self._implies
        if isinstance(g, Eventually | Until | WeakUntil) and test(f, g.args[-1], depth):
            return True
        if isinstance(g, _RELEASES) and test(f, g.args[0], depth) and test(f, g.args[1], depth):
            return True
        if self.purity(f).universal:
            if isinstance(g, Always | Next | Release):
                return test(f, g.args[-1], depth)
            if isinstance(g, WeakUntil):
                return test(f, g.args[0], depth)
        return False

    def _step_by_step(self, f: Formula, g: Formula, depth: int) -> bool:
        """By comparing operands of two temporal operators."""
        test = self._implies
        if isinstance(f, Next) and isinstance(g, Next):
            return test(f.args[0], g.args[0], depth)
        if len(f.args) != 2 or len(g.args) != 2:
            return False
        (a, b), (c, d) = f.args, g.args
        strong = isinstance(f, Until | StrongRelease)
        if isinstance(f, _UNTILS) and isinstance(g, (*_UNTILS, *_RELEASES)):
            # a holds until b: then a keeps g going, and b, when it comes, implies g.
            keeps = c if isinstance(g, _UNTILS) else d
            return (strong or isinstance(g, WeakUntil | Release)) and test(a, keeps, depth) and test(b, g, depth)
        if isinstance(f, _RELEASES) and isinstance(g, _UNTILS):
            # b holds up to and including the first a.
            return (strong or isinstance(g, WeakUntil)) and test(b, c, depth) and test(a, d, depth)
        if isinstance(f, _RELEASES) and isinstance(g, _RELEASES):
            return (strong or isinstance(g, Release)) and test(b, d, depth) and test(a, c, depth)
        return False
