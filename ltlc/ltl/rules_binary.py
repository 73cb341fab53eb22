"""Rewrite rules for U W R M."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ltlc.ltl.formula import (
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
)
from ltlc.ltl.implication import Implications
from ltlc.ltl.rule import MAX_COPIED, RuleBook, factor_out, operands
from ltlc.ltl.shape import EVENTUAL, LITERAL, SUSPENDABLE, UNIVERSAL

BINARY_RULES = RuleBook()
_BINARY = (Until, WeakUntil, Release, StrongRelease)
_UNTILS = (Until, WeakUntil)
_RELEASES = (Release, StrongRelease)


@BINARY_RULES.rule(
    *_BINARY,
    name="units",
    laws="a U true = true; a U false = false; true U a = F a; false U a = a; "
    "a W true = true; a W false = G a; true W a = true; false W a = a; "
    "a R true = true; a R false = false; true R a = a; false R a = G a; "
    "a M true = F a; a M false = false; true M a = a; false M a = false",
    having=(Constant,),
)
def _units(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if isinstance(b, Constant):
        if isinstance(node, StrongRelease if b.value else WeakUntil):
            return Eventually(a) if b.value else Always(a)
        return b
    if isinstance(a, Constant):
        if a.value == (type(node) in _RELEASES):
            return b
        if type(node) is Until:
            return Eventually(b)
        return Always(b) if type(node) is Release else a
    return None


@BINARY_RULES.rule(
    *_BINARY,
    name="implied-operand",
    laws="a U b = b if a -> b; a W b = b if a -> b; a R b = b if b -> a; a M b = b if b -> a",
    shared=True,
)
def _implied_operand(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    narrow, wide = (a, b) if type(node) in _UNTILS else (b, a)
    return b if known.implies(narrow, wide) else None


@BINARY_RULES.rule(
    *_BINARY,
    name="exhausted-or-contradicted",
    laws="a U b = F b if !b -> a; a W b = true if !b -> a; a R b = G b if b -> !a; a M b = false if b -> !a; "
    "a U b = F b if F b -> a; a R b = G b if a -> G b",
    shared=True,
)
def _exhausted(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    if type(node) in _UNTILS and known.exhaust(a, b):
        return Eventually(b) if type(node) is Until else TRUE
    if type(node) in _RELEASES and known.contradict(a, b):
        return Always(b) if type(node) is Release else FALSE
    if not a.literal_mask & b.literal_mask or a.flags & LITERAL:  # nothing but itself says the same as a literal
        return None
    if type(node) is Until and known.implies(Eventually(b), a):
        return Eventually(b)
    if type(node) is Release and known.implies(a, Always(b)):
        return Always(b)
    return None


@BINARY_RULES.rule(
    *_BINARY,
    name="pure-right",
    laws="a U e = e; a R u = u; s W b = s | b; s M b = s & b; u W b = u | b; e M b = e & b",
)
def _pure_right(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    operator = type(node)
    if operator is Until:
        return b if b.flags & EVENTUAL else None
    if operator is Release:
        return b if b.flags & UNIVERSAL else None
    if operator is WeakUntil:
        return Or(a, b) if a.flags & UNIVERSAL else None
    return And(a, b) if a.flags & EVENTUAL else None


@BINARY_RULES.rule(
    *_BINARY,
    name="pure-operand",
    laws="a W e = G a | e; a M u = F a & u; a M e = F(a & e); a W u = G(a | u); "
    "u U b = b | u & F b; e R b = b & (e | G b)",
    grows=True,
)
def _pure_operand(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if not (a.flags | b.flags) & SUSPENDABLE:
        return None
    operator = type(node)
    if operator is WeakUntil and b.flags & EVENTUAL:
        return Or(Always(a), b)
    if operator is StrongRelease and b.flags & UNIVERSAL:
        return And(Eventually(a), b)
    if operator is StrongRelease and b.flags & EVENTUAL:
        return Eventually(And(a, b))
    if operator is WeakUntil and b.flags & UNIVERSAL:
        return Always(Or(a, b))
    if b.size > MAX_COPIED:
        return None
    if operator is Until and a.flags & UNIVERSAL:
        return Or(b, And(a, Eventually(b)))
    if operator is Release and a.flags & EVENTUAL:
        return And(b, Or(a, Always(b)))
    return None


@BINARY_RULES.rule(
    *_BINARY,
    name="pure-part-of-right-out",
    laws="a U (b | e) = (a U b) | e; a W (b | e) = (a W b) | e; a R (b & u) = (a R b) & u; "
    "a M (b & u) = (a M b) & u; a U (b & s) = (a U b) & s; a R (b | s) = (a R b) | s",
    having=(And, Or),
)
def _pure_part_of_right_out(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    until = type(node) in _UNTILS
    if type(b) is (Or if until else And):
        movable = EVENTUAL if until else UNIVERSAL
    elif isinstance(b, (And, Or)) and type(node) in (Until, Release):
        movable = SUSPENDABLE
    else:
        return None
    return factor_out(b, movable, lambda rest: node.with_args((a, rest)))


@BINARY_RULES.rule(
    *_BINARY,
    name="next-out-of-both",
    laws="X a U X b = X(a U b); X a W X b = X(a W b); X a R X b = X(a R b); X a M X b = X(a M b)",
    having=(Next,),
)
def _next_out_of_both(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if isinstance(a, Next) and isinstance(b, Next):
        return Next(node.with_args((a.args[0], b.args[0])))
    return None


@BINARY_RULES.rule(
    *_BINARY,
    name="left-in-context",
    laws="(a | c) U b = a U b if c -> b; (a | c) W b = a W b if c -> b; (a & c) U b = a U b if !b -> c; "
    "(a & c) W b = a W b if !b -> c; (a & c) R b = a R b if b -> c; (a & c) M b = a M b if b -> c; "
    "(a | c) R b = a R b if c -> !b; (a | c) M b = a M b if c -> !b",
    having=(And, Or),
    shared=True,
)
def _left_in_context(node: Formula, known: Implications) -> Formula | None:
    """The left operand matters only where the right one is false (U W), or true (R M)."""
    a, b = node.args
    if not isinstance(a, (And, Or)):
        return None
    until = type(node) in _UNTILS
    if type(a) is And:
        granted = known.exhaust if until else known.implies
        kept = [part for part in a.args if not granted(b, part)]
    else:
        useless = known.implies if until else known.contradict
        kept = [part for part in a.args if not useless(part, b)]
    return node.with_args((type(a)(*kept), b)) if len(kept) < len(a.args) else None


@BINARY_RULES.rule(
    *_BINARY,
    name="exchange",
    laws="a U (a & b) = b M a; a W (a & b) = b R a; a R (a | b) = b W a; a M (a | b) = b U a",
    having=(And, Or),
    shared=True,
)
def _exchange(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if type(b) is not (And if type(node) in _UNTILS else Or):
        return None
    shared = operands(a, type(b))
    if not set(shared) <= set(b.args):
        return None
    rest: Formula = type(b)(*(part for part in b.args if part not in shared))
    return _EXCHANGED[type(node)](rest, a)


_EXCHANGED: Mapping[type[Formula], type[Formula]] = MappingProxyType(
    {Until: StrongRelease, WeakUntil: Release, Release: WeakUntil, StrongRelease: Until}
)


@BINARY_RULES.rule(
    *_BINARY,
    name="nested",
    laws="a U (b U c) = b U c if a -> b; a U (b W c) = b W c if a -> b; a W (b W c) = b W c if a -> b; "
    "a R (b R c) = b R c if b -> a; a R (b M c) = b M c if b -> a; a M (b M c) = b M c if b -> a",
    having=_BINARY,
    shared=True,
)
def _nested(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    if type(b) not in _NESTED[type(node)]:
        return None
    narrow, wide = (a, b.args[0]) if type(node) in _UNTILS else (b.args[0], a)
    return b if known.implies(narrow, wide) else None


_NESTED: Mapping[type[Formula], tuple[type[Formula], ...]] = MappingProxyType(
    {
        Until: (Until, WeakUntil),
        WeakUntil: (WeakUntil,),
        Release: (Release, StrongRelease),
        StrongRelease: (StrongRelease,),
    }
)


@BINARY_RULES.rule(
    *_BINARY,
    name="nested-left",
    laws="(a U b) U c = a U b | c if b -> c; (a U b) W c = a U b | c if b -> c; (a W b) W c = a W b | c if b -> c; "
    "(a R b) R c = a R b & c if c -> b; (a R b) M c = a R b & c if c -> b; (a M b) M c = a M b & c if c -> b",
    having=_BINARY,
    shared=True,
)
def _nested_left(node: Formula, known: Implications) -> Formula | None:
    a, c = node.args
    if type(a) not in _NESTED_LEFT[type(node)]:
        return None
    if type(node) in _UNTILS:
        return Or(a, c) if known.implies(a.args[1], c) else None
    return And(a, c) if known.implies(c, a.args[1]) else None


_NESTED_LEFT: Mapping[type[Formula], tuple[type[Formula], ...]] = MappingProxyType(
    {
        Until: (Until,),
        WeakUntil: (Until, WeakUntil),
        Release: (Release,),
        StrongRelease: (Release, StrongRelease),
    }
)
