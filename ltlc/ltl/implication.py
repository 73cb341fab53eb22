"""Syntactic implication: a quick, sound and incomplete test for `f -> g` in every word."""

from __future__ import annotations

from ltlc.budget import check_time
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
)
from ltlc.ltl.normal import negation
from ltlc.ltl.shape import EVENTUAL, LITERAL, UNIVERSAL

_UNTILS = (Until, WeakUntil)
_RELEASES = (Release, StrongRelease)
_NOW_RIGHT = (Always, Release, StrongRelease)
"""Operators that imply their last operand,"""
_BY_RIGHT = (Eventually, Until, WeakUntil)
"""and operators that their last operand implies."""


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

    def negation(self, formula: Formula) -> Formula:
        """The negation, in negation normal form."""
        known = self._negations.get(formula)
        return negation(formula, self._negations) if known is None else known

    def implies(self, f: Formula, g: Formula) -> bool:
        """Whether f -> g is seen to be valid."""
        return self._implies(f, g, self._depth)

    def contradict(self, f: Formula, g: Formula) -> bool:
        """Whether f & g is seen to be unsatisfiable."""
        if not f.literal_mask & g.negated_literal_mask:
            return False
        if f.flags & LITERAL:  # the same question, without the negation of a larger formula
            return self.implies(g, self.negation(f))
        return self.implies(f, self.negation(g))

    def exhaust(self, f: Formula, g: Formula) -> bool:
        """Whether f | g is seen to be valid."""
        if not f.negated_literal_mask & g.literal_mask:
            return False
        if g.flags & LITERAL:
            return self.implies(self.negation(g), f)
        return self.implies(self.negation(f), g)

    def _implies(self, f: Formula, g: Formula, depth: int) -> bool:
        if f is g:
            return True
        # Every chain of reasons ends in a common subformula, or in a constant.
        if not f.literal_mask & g.literal_mask:
            return False
        if f is FALSE or g is TRUE:
            return True
        if f.flags & g.flags & LITERAL:
            return False
        known = self._known.get((f, g))
        if known is not None:
            return known
        if depth == 0 or self._budget == 0:
            return False
        self._budget -= 1
        if not self._budget & 63:
            check_time()
        # No answer depends on itself: each step takes an operator off f or g.
        result = self._by_connectives(f, g, depth - 1) or self._by_operators(f, g, depth - 1)
        self._known[f, g] = result
        return result

    def _by_connectives(self, f: Formula, g: Formula, depth: int) -> bool:
        test = self._implies
        if type(f) is Or:
            return all(test(part, g, depth) for part in f.args)
        if type(g) is And:
            return all(test(f, part, depth) for part in g.args)
        if type(f) is And:
            for part in f.args:
                if test(part, g, depth):
                    return True
        if type(g) is Or:
            for part in g.args:
                if test(f, part, depth):
                    return True
        return False

    def _by_operators(self, f: Formula, g: Formula, depth: int) -> bool:
        return self._weaker_now(f, g, depth) or self._stronger_now(f, g, depth) or self._step_by_step(f, g, depth)

    def _weaker_now(self, f: Formula, g: Formula, depth: int) -> bool:
        """By what f demands of the first position, or, if g is a pure eventuality, of any position."""
        test = self._implies
        operator = type(f)
        if operator in _NOW_RIGHT and test(f.args[-1], g, depth):
            return True
        if operator in _UNTILS and test(f.args[0], g, depth) and test(f.args[1], g, depth):
            return True
        if g.flags & EVENTUAL:
            if operator is Eventually or operator is Next or operator is Until:
                return test(f.args[-1], g, depth)
            if operator is StrongRelease:
                return test(f.args[0], g, depth)
        return False

    def _stronger_now(self, f: Formula, g: Formula, depth: int) -> bool:
        """By what makes g true at the first position, or, if f is a pure universality, at any position."""
        test = self._implies
        operator = type(g)
        if operator in _BY_RIGHT and test(f, g.args[-1], depth):
            return True
        if operator in _RELEASES and test(f, g.args[0], depth) and test(f, g.args[1], depth):
            return True
        if f.flags & UNIVERSAL:
            if operator is Always or operator is Next or operator is Release:
                return test(f, g.args[-1], depth)
            if operator is WeakUntil:
                return test(f, g.args[0], depth)
        return False

    def _step_by_step(self, f: Formula, g: Formula, depth: int) -> bool:
        """By comparing operands of two temporal operators."""
        test = self._implies
        left, right = type(f), type(g)
        if left is Next and right is Next:
            return test(f.args[0], g.args[0], depth)
        if len(f.args) != 2 or len(g.args) != 2:
            return False
        (a, b), (c, d) = f.args, g.args
        strong = left is Until or left is StrongRelease
        if left in _UNTILS and (right in _UNTILS or right in _RELEASES):
            # a holds until b: then a keeps g going, and b, when it comes, implies g.
            keeps = c if right in _UNTILS else d
            return (strong or right is WeakUntil or right is Release) and test(a, keeps, depth) and test(b, g, depth)
        if left in _RELEASES and right in _UNTILS:
            # b holds up to and including the first a.
            return (strong or right is WeakUntil) and test(b, c, depth) and test(a, d, depth)
        if left in _RELEASES and right in _RELEASES:
            return (strong or right is Release) and test(b, d, depth) and test(a, c, depth)
        return False
