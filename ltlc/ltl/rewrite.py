"""Negation normal form and simplification by named rules."""

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
)

_DUAL: dict[type[Formula], type[Formula]] = {
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


def nnf(formula: Formula) -> Formula:
    """Negation normal form: `!` stands before propositions only, and -> <-> xor are gone.

    >>> from ltlc.ltl import parse
    >>> nnf(parse("!(a U (b -> X c))"))
    parse('!a R (b & X !c)')
    """
    # (f, True) stands for f and (f, False) for !f; a pair is done when what it needs is.
    done: dict[tuple[Formula, bool], Formula] = {}
    stack = [(formula, True)]
    while stack:
        pair = stack[-1]
        if pair in done:
            stack.pop()
            continue
        needed = _needed(*pair)
        missing = [other for other in needed if other not in done]
        if missing:
            stack.extend(reversed(missing))
        else:
            done[pair] = _normal(*pair, [done[other] for other in needed])
            stack.pop()
    return done[formula, True]


def _needed(node: Formula, positive: bool) -> list[tuple[Formula, bool]]:
    if isinstance(node, Not):
        return [(node.args[0], not positive)]
    if isinstance(node, Implies):
        return [(node.args[0], not positive), (node.args[1], positive)]
    if isinstance(node, Iff | Xor):
        return [(child, sign) for child in node.args for sign in (True, False)]
    return [(child, positive) for child in node.args]


def _normal(node: Formula, positive: bool, parts: list[Formula]) -> Formula:
    if isinstance(node, Constant):
        return TRUE if node.value == positive else FALSE
    if isinstance(node, Proposition):
        return node if positive else Not(node)
    if isinstance(node, Not):
        return parts[0]
    result: Formula
    if isinstance(node, Implies):
        result = Or(*parts) if positive else And(*parts)
    elif isinstance(node, Iff | Xor):
        a, not_a, b, not_b = parts
        same = isinstance(node, Iff) == positive
        result = Or(And(a, b), And(not_a, not_b)) if same else Or(And(a, not_b), And(not_a, b))
    else:
        result = (type(node) if positive else _DUAL[type(node)])(*parts)
    return result


def simplify(formula: Formula) -> Formula:
    """An equivalent formula in negation normal form (rules to come)."""
    return nnf(formula)
