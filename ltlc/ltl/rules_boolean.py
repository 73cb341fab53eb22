"""Rewrite rules for conjunctions and disjunctions; each law has a dual, and the code holds for both."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

from ltlc.ltl.formula import (
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
    Release,
    StrongRelease,
    Until,
    WeakUntil,
)
from ltlc.ltl.implication import Implications
from ltlc.ltl.rule import MAX_PAIRWISE, RuleBook
from ltlc.ltl.shape import SUSPENDABLE

BOOLEAN_RULES = RuleBook()
Key = TypeVar("Key")


class _Side(NamedTuple):
    """What differs between & and |."""

    dual: type[Formula]
    unit: Constant
    zero: Constant
    lasting: type[Formula]
    """G or F: the operator that distributes over this connective."""
    other: type[Formula]


SIDES: dict[type[Formula], _Side] = {
    And: _Side(Or, TRUE, FALSE, Always, Eventually),
    Or: _Side(And, FALSE, TRUE, Eventually, Always),
}


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="constants-and-repetitions",
    laws="a & true = a; a & false = false; a | false = a; a | true = true; a & a = a; a | a = a; "
    "p & !p = false; p | !p = true",
    shared=True,
)
def _constants_and_repetitions(node: Formula, _: Implications) -> Formula | None:
    connective = type(node)
    side = SIDES[connective]
    parts = dict.fromkeys(node.args)
    parts.pop(side.unit, None)
    if side.zero in parts or any(type(part) is Not and part.args[0] in parts for part in parts):
        return side.zero
    return connective(*parts) if len(parts) < len(node.args) else None


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="gather",
    laws="X a & X b = X(a & b); X a | X b = X(a | b); G a & G b = G(a & b); F a | F b = F(a | b); "
    "F G a & F G b = F G(a & b); G F a | G F b = G F(a | b)",
    having=(Next, Eventually, Always),
)
def _gather(node: Formula, _: Implications) -> Formula | None:
    """One X, one G or F, and one FG or GF for all operands of that form."""
    connective = type(node)
    side = SIDES[connective]

    def form(part: Formula) -> tuple[type[Formula], ...] | None:
        operator = type(part)
        if operator is Next:
            return (Next,)
        if operator is side.other and type(part.args[0]) is side.lasting:
            return (side.other, side.lasting)
        if operator is side.lasting and part.flags & SUSPENDABLE != SUSPENDABLE:
            return (side.lasting,)
        return None

    def merge(operators: tuple[type[Formula], ...], group: list[Formula]) -> Formula:
        inner: list[Formula] = group
        for _ in operators:
            inner = [part.args[0] for part in inner]
        merged = connective(*inner)
        for operator in reversed(operators):
            merged = operator(merged)
        return merged

    return _merge_groups(node, form, merge)


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="common-operand",
    laws="(a U c) & (b U c) = (a & b) U c; (a W c) & (b W c) = (a & b) W c; (a U c) & (b W c) = (a & b) U c; "
    "(a R b) & (a R c) = a R (b & c); (a M b) & (a M c) = a M (b & c); (a R b) & (a M c) = a M (b & c); "
    "(a U b) | (a U c) = a U (b | c); (a W b) | (a W c) = a W (b | c); (a U b) | (a W c) = a W (b | c); "
    "(a R c) | (b R c) = (a | b) R c; (a M c) | (b M c) = (a | b) M c; (a R c) | (b M c) = (a | b) R c",
    having=(Until, WeakUntil, Release, StrongRelease),
    shared=True,
)
def _common_operand(node: Formula, _: Implications) -> Formula | None:
    connective = type(node)
    conjunction = connective is And

    def form(part: Formula) -> tuple[bool, Formula] | None:
        operator = type(part)
        if operator is Until or operator is WeakUntil:
            return True, part.args[1 if conjunction else 0]
        if operator is Release or operator is StrongRelease:
            return False, part.args[0 if conjunction else 1]
        return None

    def merge(key: tuple[bool, Formula], group: list[Formula]) -> Formula:
        until, common = key
        strengths = [isinstance(part, (Until, StrongRelease)) for part in group]
        strong = any(strengths) if conjunction else all(strengths)
        operator = (Until if strong else WeakUntil) if until else (StrongRelease if strong else Release)
        if until == conjunction:
            return operator(connective(*(part.args[0] for part in group)), common)
        return operator(common, connective(*(part.args[1] for part in group)))

    return _merge_groups(node, form, merge)


def _merge_groups(
    node: Formula, form: Callable[[Formula], Key | None], merge: Callable[[Key, list[Formula]], Formula]
) -> Formula | None:
    """Replaces all operands of one form by a single one, where the first of them stood."""
    keys = [form(part) for part in node.args]
    found = [key for key in keys if key is not None]
    if len(set(found)) == len(found):
        return None
    groups: dict[Key, list[Formula]] = {}
    for key, part in zip(keys, node.args, strict=True):
        if key is not None:
            groups.setdefault(key, []).append(part)
    parts = []
    for key, part in zip(keys, node.args, strict=True):
        if key is None:
            parts.append(part)
        elif key in groups:
            group = groups.pop(key)
            parts.append(part if len(group) == 1 else merge(key, group))
    return type(node)(*parts)


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="weak-and-strong",
    laws="(a W b) & F b = a U b; (a R b) & F a = a M b; (a U b) | G a = a W b; (a M b) | G b = a R b",
    having=(Eventually, Always),
    shared=True,
)
def _weak_and_strong(node: Formula, _: Implications) -> Formula | None:
    connective = type(node)
    side = SIDES[connective]
    extras = {part.args[0]: part for part in node.args if type(part) is side.other}
    if not extras:
        return None
    for part in node.args:
        for operator, needed, result in _COMPLETED[connective]:
            if type(part) is operator and part.args[needed] in extras:
                extra = extras[part.args[needed]]
                parts = [result(*part.args) if other is part else other for other in node.args if other is not extra]
                return connective(*parts)
    return None


# connective -> (operator, which of its operands G or F says more about, the operator that says both)
_COMPLETED: dict[type[Formula], tuple[tuple[type[Formula], int, type[Formula]], ...]] = {
    And: ((WeakUntil, 1, Until), (Release, 0, StrongRelease)),
    Or: ((Until, 0, WeakUntil), (StrongRelease, 1, Release)),
}


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="implied",
    laws="a & b = a if a -> b; a | b = b if a -> b; a & b = false if a -> !b; a | b = true if !a -> b",
    shared=True,
)
def _implied(node: Formula, known: Implications) -> Formula | None:
    """Drops operands that others imply (&) or that imply others (|), or finds that they contradict (exhaust)."""
    if len(node.args) > MAX_PAIRWISE:
        return None
    connective = type(node)
    conjunction = connective is And
    clash = known.contradict if conjunction else known.exhaust

    def redundant(part: Formula, other: Formula) -> bool:
        return known.implies(other, part) if conjunction else known.implies(part, other)

    kept: list[Formula] = []
    for part in node.args:
        if any(redundant(part, other) for other in kept):
            continue
        kept = [other for other in kept if not redundant(other, part)]
        if any(clash(other, part) for other in kept):
            return SIDES[connective].zero
        kept.append(part)
    return connective(*kept) if len(kept) < len(node.args) else None


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="unit-resolution",
    laws="a & (b | c) = a & b if a -> !c; a | (b & c) = a | b if !a -> c",
    having=(And, Or),
    shared=True,
)
def _unit_resolution(node: Formula, known: Implications) -> Formula | None:
    """Inside the disjunctions among conjuncts (and dually), drops what another operand rules out."""
    connective = type(node)
    dual = SIDES[connective].dual
    if len(node.args) > MAX_PAIRWISE:
        return None
    clash = known.contradict if connective is And else known.exhaust
    parts = list(node.args)
    for i, part in enumerate(parts):
        if type(part) is dual:
            others = parts[:i] + parts[i + 1 :]
            kept = [piece for piece in part.args if not any(clash(other, piece) for other in others)]
            parts[i] = dual(*kept) if len(kept) < len(part.args) else part
    return connective(*parts) if any(new is not old for new, old in zip(parts, node.args, strict=True)) else None


@BOOLEAN_RULES.rule(
    And,
    Or,
    name="common-factor",
    laws="(a & b) | (a & c) = a & (b | c); (a | b) & (a | c) = a | (b & c)",
    having=(And, Or),
    shared=True,
)
def _common_factor(node: Formula, _: Implications) -> Formula | None:
    connective = type(node)
    dual = SIDES[connective].dual
    if any(type(part) is not dual for part in node.args):
        return None
    common = set(node.args[0].args).intersection(*(part.args for part in node.args[1:]))
    if not common:
        return None
    factors = [piece for piece in node.args[0].args if piece in common]
    rests = [dual(*(piece for piece in part.args if piece not in common)) for part in node.args]
    return dual(*factors, connective(*rests))
