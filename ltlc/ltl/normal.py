"""Negation normal form."""

from __future__ import annotations

from ltlc.budget import check_time
from ltlc.ltl.finite import WeakNext
from ltlc.ltl.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
)
from ltlc.ltl.past import Historically, Once, Since, Triggered, WeakYesterday, Yesterday
from ltlc.ltl.shape import NORMAL
from ltlc.ltl.traversal import fold

DUAL: dict[type[Formula], type[Formula]] = {
    Next: Next,
    Eventually: Always,
    Always: Eventually,
    And: Or,
    Or: And,
    Until: Release,
    Release: Until,
    WeakUntil: StrongRelease,
    StrongRelease: WeakUntil,
    Yesterday: WeakYesterday,
    WeakYesterday: Yesterday,
    Once: Historically,
    Historically: Once,
    Since: Triggered,
    Triggered: Since,
}
"""Operator -> the one that negates it on negated operands: !(a U b) = !a R !b."""
DUAL_ON_TRACES: dict[type[Formula], type[Formula]] = {**DUAL, Next: WeakNext, WeakNext: Next}
"""The same on finite traces, where !X a = WX !a."""

_Signed = tuple[Formula, bool]  # (f, True) stands for f and (f, False) for !f


def nnf(formula: Formula, *, finite: bool = False) -> Formula:
    """Negation normal form: `!` stands before propositions only, and -> <-> xor are gone.

    >>> from ltlc.ltl import parse
    >>> nnf(parse("!(a U (b -> X c))"))
    parse('!a R (b & X !c)')

    Args:
        formula: any formula.
        finite: whether it is about finite traces, where !X a is WX !a; on infinite words WX is X.
    """
    dual = DUAL_ON_TRACES if finite else DUAL
    done: dict[_Signed, Formula] = {}
    stack: list[_Signed | None] = [(formula, True)]
    waiting: list[tuple[_Signed, type[Formula], list[_Signed]]] = []  # for operands, one for each None on the stack
    while stack:
        signed = stack.pop()
        if signed is None:
            ready, operator, operands = waiting.pop()
            if not len(done) & 255:
                check_time()
            done[ready] = _rebuild(operator, [done[operand] for operand in operands])
        elif signed not in done:
            result, operands = _resolve(*signed, dual)
            if isinstance(result, Formula):
                done[signed] = result
            else:
                waiting.append((signed, result, operands))
                stack.append(None)
                stack.extend(operands)
    return done[formula, True]


def negation(formula: Formula, done: dict[Formula, Formula]) -> Formula:
    """The negation normal form of !f for an f in negation normal form; `done` as in `fold`."""
    return fold(formula, done, _negate)


def _negate(node: Formula, negated: list[Formula]) -> Formula:
    if isinstance(node, Constant):
        return FALSE if node.value else TRUE
    if isinstance(node, Proposition):
        return Not(node)
    if isinstance(node, Not):
        return node.args[0]
    return DUAL[type(node)](*negated)


def _resolve(
    node: Formula, positive: bool, dual: dict[type[Formula], type[Formula]]
) -> tuple[type[Formula] | Formula, list[_Signed]]:
    """What a signed formula is after one step: an operator and its signed operands, or a literal or constant.

    A chain of & and | and -> is taken apart at once, because one operand at a time would copy a long chain over and
    over; likewise a chain of negations.
    """
    while type(node) is Not:
        node, positive = node.args[0], not positive
    if positive and node.flags & NORMAL:
        return node, []
    operator = type(node)
    if operator is WeakNext and operator not in dual:
        operator = Next  # the same on infinite words
    if isinstance(node, Constant):
        return (FALSE if node.value else TRUE), []
    if operator is Proposition:
        return Not(node), []
    if operator is Iff or operator is Xor:
        return (Iff if (operator is Iff) == positive else Xor), [
            (arg, sign) for arg in node.args for sign in (True, False)
        ]
    if operator in _CHAINED:
        connective = And if (operator is And) == positive else Or
        return connective, _chain(node, positive, connective)
    return (operator if positive else dual[operator]), [(arg, positive) for arg in node.args]


_CHAINED = (And, Or, Implies)


def _chain(node: Formula, positive: bool, connective: type[Formula]) -> list[_Signed]:
    operands: list[_Signed] = []
    pending = [(node, positive)]
    while pending:
        part, sign = pending.pop()
        operator = type(part)
        if operands and not len(operands) & 255:
            check_time()
        if operator is Not:
            pending.append((part.args[0], not sign))
        elif operator in _CHAINED and ((operator is And) == sign) == (connective is And):
            if operator is Implies:
                pending += (part.args[1], sign), (part.args[0], not sign)
            else:
                pending.extend([(arg, sign) for arg in part.args[::-1]])
        else:
            operands.append((part, sign))
    return operands


def _rebuild(operator: type[Formula], parts: list[Formula]) -> Formula:
    if operator is Iff:
        a, not_a, b, not_b = parts
        return Or(And(a, b), And(not_a, not_b))
    if operator is Xor:
        a, not_a, b, not_b = parts
        return Or(And(a, not_b), And(not_a, b))
    return operator(*parts)
