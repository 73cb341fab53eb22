"""Negation normal form."""

from __future__ import annotations

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
    fold,
)

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
}
"""Operator -> the one that negates it on negated operands: !(a U b) = !a R !b."""

_Signed = tuple[Formula, bool]  # (f, True) stands for f and (f, False) for !f


def nnf(formula: Formula) -> Formula:
    """Negation normal form: `!` stands before propositions only, and -> <-> xor are gone.

    >>> from ltlc.ltl import parse
    >>> nnf(parse("!(a U (b -> X c))"))
    parse('!a R (b & X !c)')
    """
    done: dict[_Signed, Formula] = {}
    stack: list[_Signed] = [(formula, True)]
    while stack:
        signed = stack[-1]
        operator, needed = _resolve(*signed)
        missing = () if signed in done else [other for other in needed if other not in done]
        if missing:
            stack.extend(missing)
            continue
        if signed not in done:
            parts = [done[other] for other in needed]
            done[signed] = _rebuild(operator, parts) if isinstance(operator, type) else operator
        stack.pop()
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


def _resolve(node: Formula, positive: bool) -> tuple[type[Formula] | Formula, list[_Signed]]:
    """What a signed formula is after one step: an operator and its signed operands, or a literal or constant.

    A chain of & and | and -> is taken apart at once, because one operand at a time would copy a long chain over and
    over; likewise a chain of negations.
    """
    while isinstance(node, Not):
        node, positive = node.args[0], not positive
    if isinstance(node, Constant):
        return (TRUE if node.value == positive else FALSE), []
    if isinstance(node, Proposition):
        return (node if positive else Not(node)), []
    if isinstance(node, Iff | Xor):
        return (Iff if isinstance(node, Iff) == positive else Xor), [
            (arg, sign) for arg in node.args for sign in (True, False)
        ]
    if isinstance(node, And | Or | Implies):
        connective = And if isinstance(node, And) == positive else Or
        return connective, _chain(node, positive, connective)
    return (type(node) if positive else DUAL[type(node)]), [(arg, positive) for arg in node.args]


def _chain(node: Formula, positive: bool, connective: type[Formula]) -> list[_Signed]:
    operands: list[_Signed] = []
    pending = [(node, positive)]
    while pending:
        part, sign = pending.pop()
        if isinstance(part, Not):
            pending.append((part.args[0], not sign))
        elif isinstance(part, And | Or | Implies) and (isinstance(part, And) == sign) == (connective is And):
            signs = (not sign, sign) if isinstance(part, Implies) else (sign,) * len(part.args)
            pending.extend(reversed(list(zip(part.args, signs, strict=True))))
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


def is_literal(formula: Formula) -> bool:
    """Whether it is a proposition or the negation of one."""
    return isinstance(formula, Proposition) or (isinstance(formula, Not) and isinstance(formula.args[0], Proposition))
