"""Temporal operators pulled out of each other, so that what remains are recurrence and persistence formulas.

What depends on no prefix, G F g or F G g, holds everywhere or nowhere: it is decided outside. Once G g holds it stays
true, so that (f | G g) W h is f W (h | G g), and G(f | G g) is f W G g; the other laws are like these, or dual. Where
they do not suffice, U is taken out of W by what it becomes in the long run.

References:
    J. Esparza, R. Rubio, S. Sickert: Efficient Normalization of Linear Temporal Logic. Journal of the ACM 71(2), 2024,
    doi 10.1145/3651152 (normalization by rewriting).
"""

from __future__ import annotations

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
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    fold,
    nnf,
    postorder,
    simplify,
)
from ltlc.translate.limits import in_the_limit

_MAX_STEPS: tuple[int, ...] = (8, 20, 60)
"""Both signs are tried with so many steps, then with more; a formula that takes more steps stays as it is,"""
_MAX_GROWTH = 5
"""and so does one that would get more times as many subformulas."""
_NEVER: Formula = FALSE
_BOOLEAN = (And, Or)
_LEAST = (Eventually, Until, StrongRelease)
_SIGMA_1, _PI_1, _SIGMA_2, _PI_2 = 1, 2, 4, 8


class _TooManyStepsError(Exception):
    pass


def is_low(formula: Formula) -> bool:
    """Whether it is a Boolean combination of recurrence and persistence formulas, in shape."""
    return _Rewriting(0, {}).is_low(formula)


def without_mixtures(formula: Formula) -> Formula:
    """An equivalent Boolean combination of recurrence and persistence formulas, or the formula itself if none is found.

    The laws take U out of W; for the negation they take W out of U. The way with fewer steps, or subformulas, is taken.

    Args:
        formula: simplified, in negation normal form.

    Example:
        >>> from ltlc.ltl import parse
        >>> without_mixtures(parse("(a | G b) U (c & G F d)"))
        parse('G F d & (a | G b) U c')
    """
    if is_low(formula):
        return formula
    negation = nnf(Not(formula))
    simpler: dict[Formula, Formula] = {}
    for max_steps in _MAX_STEPS:
        found = []
        for start in (formula, negation):
            rewriting = _Rewriting(max_steps, simpler)
            with suppress(_TooManyStepsError):
                result = rewriting.low(start)
                if rewriting.is_low(result):
                    found.append(result if start is formula else nnf(Not(result)))
        if found:
            best = min(found, key=n_nodes)
            return best if n_nodes(best) <= _MAX_GROWTH * n_nodes(formula) else formula
    return formula


def n_nodes(formula: Formula) -> int:
    """How many different subformulas it has."""
    return sum(1 for _ in postorder(formula))


class _Rewriting:
    def __init__(self, max_steps: int, simpler: dict[Formula, Formula]) -> None:
        self._max_steps = max_steps
        self._simpler = simpler
        self._levels: dict[Formula, int] = {}
        self._low: dict[tuple[Formula, bool], Formula] = {}
        self._n_steps = 0

    def level(self, formula: Formula) -> int:
        """The classes that the shape of the formula shows, as bits."""
        return fold(formula, self._levels, _level)

    def is_low(self, formula: Formula, *, inside: bool = False) -> bool:
        """Whether it is a Boolean combination of recurrence and persistence formulas.

        Args:
            formula: the formula.
            inside: whether it is an operand of F, U or M: then the former must be G F f, which can be taken out.
        """
        if isinstance(formula, _BOOLEAN):
            return all(self.is_low(arg, inside=inside) for arg in formula.args)
        level = self.level(formula)
        return bool(level & _SIGMA_2 or (level and (not inside or _is_limit(formula))))

    def low(self, formula: Formula, *, inside: bool = False) -> Formula:
        """The formula, rewritten as far as the laws go; arguments as for `is_low`."""
        known = self._low.get((formula, inside))
        if known is None:
            check_time()
            if self.is_low(formula, inside=inside):
                simple = simplify(formula, self._simpler)  # which may join what was taken apart
                known = simple if self.is_low(simple, inside=inside) else formula
            elif isinstance(formula, _BOOLEAN):
                known = formula.with_args(tuple([self.low(arg, inside=inside) for arg in formula.args]))
            else:
                known = self._rewritten(formula, inside)
            self._low[formula, inside] = known
        return known

    def _rewritten(self, formula: Formula, inside: bool) -> Formula:
        self._n_steps += 1
        if self._n_steps > self._max_steps:
            raise _TooManyStepsError
        limit = next((part for part in postorder(formula) if _is_limit(part) and part is not formula), None)
        if limit is not None:
            both = self.low(limit & _replaced(formula, limit, TRUE, self._simpler), inside=inside)
            without = _replaced(formula, limit, FALSE, self._simpler)
            return both if without is FALSE else both | self.low(without, inside=inside)
        better = _pulled_out(formula, self._simpler)
        if better is None:
            is_least = isinstance(formula, _LEAST)
            better = formula.with_args(tuple([self.low(arg, inside=inside or is_least) for arg in formula.args]))
        if better is formula:
            better = self._without_least(formula)
        return formula if better is None else self.low(better, inside=inside)

    def _without_least(self, f: Formula) -> Formula | None:
        """G, W or R with one operator fewer of F, U and M below it, or None where there is none.

        If g2 holds again and again, g1 U g2 is the same as g1 W g2; else it is false from some time on.
        """
        match f:
            case Always():
                (body,), exit_ = f.args, _NEVER
            case WeakUntil():
                body, exit_ = f.args
            case Release():
                body, exit_ = f.args[1], And(*f.args)
            case _:
                return None
        part = next((node for node in postorder(body) if isinstance(node, _LEAST)), None)
        if part is None:
            return Until(body, exit_) | Always(body) if _has(exit_, _LEAST) else None
        weak: Formula = TRUE
        if isinstance(part, Until):
            goal, weak = part.args[1], WeakUntil(*part.args)
        elif isinstance(part, StrongRelease):
            goal, weak = And(*part.args), Release(*part.args)
        else:
            goal = part.args[0]
        again = in_the_limit(simplify(Always(Eventually(goal)), self._simpler))
        weaker = _replaced(body, part, weak, self._simpler)
        if isinstance(f, Always):
            forever: Formula = Always(weaker)
        elif isinstance(f, WeakUntil):
            forever = WeakUntil(weaker, exit_)
        else:
            forever = Release(f.args[0], weaker)
        return again & forever | Until(body, exit_ | Always(_replaced(body, part, FALSE, self._simpler)))


def _level(node: Formula, levels: list[int]) -> int:
    if isinstance(node, Constant | Proposition | Not) or not levels:
        return 15
    level = levels[0]
    for other in levels[1:]:
        level &= other
    if isinstance(node, Eventually | Until | StrongRelease):
        return _SIGMA_1 | _SIGMA_2 | _PI_2 if level & _SIGMA_1 else level & _SIGMA_2
    if isinstance(node, Always | WeakUntil | Release):
        return _PI_1 | _SIGMA_2 | _PI_2 if level & _PI_1 else level & _PI_2
    return level


def _has(formula: Formula, operators: tuple[type[Formula], ...]) -> bool:
    return any(isinstance(node, operators) for node in postorder(formula))


def _is_limit(node: Formula) -> bool:
    return (isinstance(node, Always) and isinstance(node.args[0], Eventually)) or (
        isinstance(node, Eventually) and isinstance(node.args[0], Always)
    )


def _pulled_out(f: Formula, simpler: dict[Formula, Formula]) -> Formula | None:
    """The formula with a part pulled out of its operator, or None where no law applies."""
    if isinstance(f, Next):
        return None if not isinstance(f.args[0], _BOOLEAN) else f.args[0].with_args(tuple(map(Next, f.args[0].args)))
    if isinstance(f, Always | Eventually):
        (inner,) = f.args
        part = _part(inner, type(f))
        if part is None:
            return None
        with_part, without = [_replaced_here(inner, part, value, simpler) for value in (TRUE, FALSE)]
        if isinstance(f, Always):
            return WeakUntil(without, part) & Always(with_part)
        return StrongRelease(with_part, part) | Eventually(without)
    left, right = f.args
    operator = Always if isinstance(f, Until | WeakUntil) else Eventually
    part = _part(left, operator)
    if part is None:
        return None
    with_part, without = [_replaced_here(left, part, value, simpler) for value in (TRUE, FALSE)]
    match f:
        case WeakUntil():
            return WeakUntil(without, right | part) & WeakUntil(with_part, right)
        case Until():
            return Until(without, right | part & Eventually(right)) & Until(with_part, right)
        case StrongRelease():
            return StrongRelease(with_part, right & part) | StrongRelease(without, right)
        case _:
            return Release(with_part, right & (part | Always(right))) | Release(without, right)


def _part(formula: Formula, operator: type[Formula]) -> Formula | None:
    """A part that begins with the operator, not inside of another temporal operator."""
    if isinstance(formula, operator):
        return formula
    if isinstance(formula, _BOOLEAN):
        return next((part for arg in formula.args if (part := _part(arg, operator)) is not None), None)
    return None


def _replaced(
    formula: Formula,
    part: Formula,
    value: Formula,
    simpler: dict[Formula, Formula],
    within: tuple[type[Formula], ...] | None = None,
) -> Formula:
    """The formula, simplified, with a part replaced; `simpler` as in `simplify`, `within` as in `fold`."""
    values = {part: value}
    changed = fold(formula, values, lambda node, args: node.with_args(tuple(args)) if args else node, within)
    return simplify(changed, simpler)


def _replaced_here(formula: Formula, part: Formula, value: Formula, simpler: dict[Formula, Formula]) -> Formula:
    """The same, but not inside of temporal operators, where the part speaks of positions at which it may differ."""
    return _replaced(formula, part, value, simpler, _BOOLEAN)
