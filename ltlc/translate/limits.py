"""What holds again and again, or from some time on: G F f and F G f for any f, by simpler formulas of these kinds.

In the long run, G g holds always or never, and so does F g. So where G g is a part of f, G F f holds iff F G g does and
G F f with true in place of G g, or G F f with false in its place. Where g W h is a part of f, either F G g, and it
holds in the long run, or it is g U h. What remains is G F f for a co-safety formula f, which is a recurrence formula;
F G f is its dual.

References:
    S. Sickert, J. Esparza: An Efficient Normalisation Procedure for Linear Temporal Logic and Very Weak Alternating
    Automata. LICS 2020, doi 10.1145/3373718.3394743 (these laws).
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from ltlc.budget import check_time
from ltlc.ltl import (
    FALSE,
    TRUE,
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    fold,
    postorder,
    simplify,
)

_MAX_CASES = 64
"""A formula for which more cases have to be distinguished stays as it is."""
_GREATEST = (Always, WeakUntil, Release)
_LEAST = (Eventually, Until, StrongRelease)


class _TooManyCasesError(Exception):
    pass


def in_the_limit(formula: Formula) -> Formula:
    """The formula with every G F f and F G f beyond recurrence and persistence formulas written by some of these.

    Args:
        formula: simplified, in negation normal form.

    Returns:
        An equivalent simplified formula; the formula itself where there is nothing to do.

    Example:
        >>> from ltlc.ltl import parse
        >>> in_the_limit(parse("G F(a & (b R c) & F d)"))
        parse('G F d & (F G c & G F a | G F(a & b M c))')
    """
    if not any(_is_beyond(node) for node in postorder(formula)):
        return formula
    limits = _Limits()
    found: dict[Formula, Formula] = {}

    def rewritten(node: Formula, args: list[Formula]) -> Formula:
        with suppress(_TooManyCasesError):
            if _is_beyond(node):
                often_or_almost = limits.often if isinstance(node, Always) else limits.almost
                return often_or_almost(node.args[0].args[0])
        return node.with_args(tuple(args)) if args else node

    changed = fold(formula, found, rewritten)
    return formula if changed is formula else simplify(changed)


def _is_beyond(node: Formula) -> bool:
    """Whether it is G F f or F G f, beyond recurrence and persistence formulas."""
    if isinstance(node, Always):
        return isinstance(node.args[0], Eventually) and _has(node.args[0], _GREATEST)
    return isinstance(node, Eventually) and isinstance(node.args[0], Always) and _has(node.args[0], _LEAST)


def _has(formula: Formula, operators: tuple[type[Formula], ...]) -> bool:
    return any(isinstance(node, operators) for node in postorder(formula))


class _Limits:
    """The laws."""

    def __init__(self) -> None:
        self._often: dict[Formula, Formula] = {}
        self._almost: dict[Formula, Formula] = {}
        self._n_cases = 0

    def often(self, f: Formula) -> Formula:
        """A formula for G F f."""
        known = self._often.get(f)
        if known is None:
            known = self._often[f] = self._infinitely_often(f)
        return known

    def almost(self, f: Formula) -> Formula:
        """A formula for F G f."""
        known = self._almost.get(f)
        if known is None:
            known = self._almost[f] = self._almost_always(f)
        return known

    def _infinitely_often(self, f: Formula) -> Formula:
        match f:
            case Constant():
                return f
            case Or():
                return Or(*map(self.often, f.args))
            case Next() | Eventually():
                return self.often(f.args[0])
            case Always():
                return self.almost(f.args[0])
            case Until():
                return self.often(f.args[1])
            case StrongRelease():
                return self.often(And(*f.args))
            case WeakUntil():
                return self.often(f.args[1]) | self.almost(f.args[0])
            case Release():
                return self.often(And(*f.args)) | self.almost(f.args[1])
        part = next((node for node in postorder(f) if isinstance(node, (*_GREATEST, Eventually))), None)
        return Always(Eventually(f)) if part is None else self._by_cases(f, part, self.often)

    def _almost_always(self, f: Formula) -> Formula:
        match f:
            case Constant():
                return f
            case And():
                return And(*map(self.almost, f.args))
            case Next() | Always():
                return self.almost(f.args[0])
            case Eventually():
                return self.often(f.args[0])
            case Release():
                return self.almost(f.args[1])
            case WeakUntil():
                return self.almost(Or(*f.args))
            case Until():
                return self.almost(Or(*f.args)) & self.often(f.args[1])
            case StrongRelease():
                return self.almost(f.args[1]) & self.often(f.args[0])
        part = next((node for node in postorder(f) if isinstance(node, (*_LEAST, Always))), None)
        return Eventually(Always(f)) if part is None else self._by_cases(f, part, self.almost)

    def _by_cases(self, f: Formula, part: Formula, limit: Callable[[Formula], Formula]) -> Formula:
        """G F f or F G f by what becomes of a part of f in the long run: something stronger, or something weaker."""
        check_time()
        self._n_cases += 1
        if self._n_cases > _MAX_CASES:
            raise _TooManyCasesError
        stronger: Formula = FALSE
        weaker: Formula = TRUE
        match part:
            case Eventually():
                condition = self.often(part.args[0])
            case Always():
                condition = self.almost(part.args[0])
            case WeakUntil():
                condition, stronger = self.almost(part.args[0]), Until(*part.args)
            case Release():
                condition, stronger = self.almost(part.args[1]), StrongRelease(*part.args)
            case Until():
                condition, weaker = self.often(part.args[1]), WeakUntil(*part.args)
            case _:
                condition, weaker = self.often(part.args[0]), Release(*part.args)
        return condition & limit(_replaced(f, part, weaker)) | limit(_replaced(f, part, stronger))


def _replaced(formula: Formula, part: Formula, value: Formula) -> Formula:
    """The formula, simplified, with a part replaced."""
    return simplify(fold(formula, {part: value}, lambda node, args: node.with_args(tuple(args)) if args else node))
