"""Rewrite rules for X F G."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ltlc.ltl.formula import (
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
)
from ltlc.ltl.implication import Implications
from ltlc.ltl.rule import MAX_COPIED, MAX_PAIRWISE, RuleBook, factor_out
from ltlc.ltl.shape import EVENTUAL, SUSPENDABLE, UNIVERSAL

UNARY_RULES = RuleBook()


@UNARY_RULES.rule(
    Next, Eventually, Always, name="constant", laws="X true = true; F false = false; G true = true", having=(Constant,)
)
def _constant(node: Formula, _: Implications) -> Formula | None:
    return node.args[0] if isinstance(node.args[0], Constant) else None


@UNARY_RULES.rule(Next, Eventually, Always, name="pure", laws="X s = s; F e = e; G u = u")
def _pure(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    enough = _ABSORBED[type(node)]
    return operand if operand.flags & enough == enough else None


_ABSORBED: Mapping[type[Formula], int] = MappingProxyType({Next: SUSPENDABLE, Eventually: EVENTUAL, Always: UNIVERSAL})


@UNARY_RULES.rule(Eventually, Always, name="next-out", laws="F X a = X F a; G X a = X G a", having=(Next,))
def _next_out(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    return Next(type(node)(operand.args[0])) if isinstance(operand, Next) else None


@UNARY_RULES.rule(
    Eventually,
    name="eventually-binary",
    laws="F(a U b) = F b; F(a M b) = F(a & b)",
    having=(Until, StrongRelease),
)
def _eventually_binary(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, Until):
        return Eventually(operand.args[1])
    if isinstance(operand, StrongRelease):
        return Eventually(And(*operand.args))
    return None


@UNARY_RULES.rule(Always, name="always-binary", laws="G(a R b) = G b; G(a W b) = G(a | b)", having=(Release, WeakUntil))
def _always_binary(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, Release):
        return Always(operand.args[1])
    if isinstance(operand, WeakUntil):
        return Always(Or(*operand.args))
    return None


@UNARY_RULES.rule(
    Eventually,
    name="eventually-weak",
    laws="F(a W b) = F b | F G a; F(a R b) = F(a & b) | F G b",
    having=(WeakUntil, Release),
    grows=True,
)
def _eventually_weak(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, WeakUntil):
        a, b = operand.args
        return Or(Eventually(b), Eventually(Always(a)))
    if isinstance(operand, Release) and operand.args[1].size <= MAX_COPIED:
        a, b = operand.args
        return Or(Eventually(And(a, b)), Eventually(Always(b)))
    return None


@UNARY_RULES.rule(
    Always,
    name="always-strong",
    laws="G(a M b) = G b & G F a; G(a U b) = G(a | b) & G F b",
    having=(StrongRelease, Until),
    grows=True,
)
def _always_strong(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, StrongRelease):
        a, b = operand.args
        return And(Always(b), Always(Eventually(a)))
    if isinstance(operand, Until) and operand.args[1].size <= MAX_COPIED:
        a, b = operand.args
        return And(Always(Or(a, b)), Always(Eventually(b)))
    return None


@UNARY_RULES.rule(
    Next,
    Eventually,
    Always,
    name="pure-part-out",
    laws="F(a | e) = F a | e; G(a & u) = G a & u; X(a & s) = X a & s; X(a | s) = X a | s; F(a & s) = F a & s; "
    "G(a | s) = G a | s",
    having=(And, Or),
)
def _pure_part_out(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if not isinstance(operand, (And, Or)):
        return None
    distributes = type(operand) is _DISTRIBUTED.get(type(node))
    movable = _ABSORBED[type(node)] if distributes else SUSPENDABLE
    return factor_out(operand, movable, lambda rest: node.with_args((rest,)))


_DISTRIBUTED: Mapping[type[Formula], type[Formula]] = MappingProxyType({Eventually: Or, Always: And})


@UNARY_RULES.rule(
    Eventually,
    Always,
    name="implied-in-time",
    laws="F(a | b) = F a if b -> F a; G(a & b) = G a if G a -> b",
    having=(And, Or),
)
def _implied_in_time(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    if type(operand) is not _DISTRIBUTED[type(node)] or len(operand.args) > MAX_PAIRWISE:
        return None
    connective = type(operand)
    for part in operand.args:
        if not any(part.literal_mask & other.literal_mask for other in operand.args if other is not part):
            continue  # nothing that the rest could imply
        rest = node.with_args((connective(*[other for other in operand.args if other is not part]),))
        if known.implies(part, rest) if connective is Or else known.implies(rest, part):
            return rest
    return None


@UNARY_RULES.rule(
    Eventually,
    Always,
    name="nested-in-time",
    laws="F(a & F b) = F b if b -> a; G(a | G b) = G b if a -> b",
    having=(And, Or),
)
def _nested_in_time(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    eventually = type(node) is Eventually
    if type(operand) is not (And if eventually else Or) or len(operand.args) > MAX_PAIRWISE:
        return None
    for part in operand.args:
        if type(part) is type(node):
            inner, others = part.args[0], [other for other in operand.args if other is not part]
            if all(known.implies(inner, other) if eventually else known.implies(other, inner) for other in others):
                return part
    return None


@UNARY_RULES.rule(
    Eventually,
    Always,
    name="split",
    laws="F(a | u) = F a | F u; G(a & e) = G a & G e",
    having=(And, Or),
    grows=True,
)
def _split(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if type(operand) is not _DISTRIBUTED[type(node)]:
        return None
    movable = UNIVERSAL if type(node) is Eventually else EVENTUAL
    return factor_out(operand, movable, lambda rest: node.with_args((rest,)), node)


@UNARY_RULES.rule(
    Eventually,
    Always,
    name="split-in-the-limit",
    laws="G F(a & e) = G F a & G e; F G(a | u) = F G a | F u",
    having=(Eventually, Always),
    grows=True,
)
def _split_in_the_limit(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    always = type(node) is Always
    if type(operand) is not (Eventually if always else Always):
        return None
    (inner,) = operand.args
    if type(inner) is not (And if always else Or):
        return None
    movable = EVENTUAL if always else UNIVERSAL
    return factor_out(inner, movable, lambda rest: node.with_args((operand.with_args((rest,)),)), node)
