"""Rewrite rules for X F G and for U W R M."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
from ltlc.ltl.rule import MAX_PAIRWISE, RuleBook, operands

TEMPORAL_RULES = RuleBook()
_BINARY = (Until, WeakUntil, Release, StrongRelease)
MAX_COPIED = 60
"""Rules that write an operand twice leave one of more nodes alone, so that nesting cannot double it over and over."""


# --- one operand ------------------------------------------------------------------------------------------------------


@TEMPORAL_RULES.rule(Next, Eventually, Always, name="constant", laws="X true = true; F false = false; G true = true")
def _constant(node: Formula, _: Implications) -> Formula | None:
    return node.args[0] if isinstance(node.args[0], Constant) else None


@TEMPORAL_RULES.rule(Next, Eventually, Always, name="pure", laws="X s = s; F e = e; G u = u")
def _pure(node: Formula, known: Implications) -> Formula | None:
    eventual, universal = known.purity(node.args[0])
    enough = (eventual or isinstance(node, Always)) and (universal or isinstance(node, Eventually))
    return node.args[0] if enough else None


@TEMPORAL_RULES.rule(Eventually, Always, name="next-out", laws="F X a = X F a; G X a = X G a")
def _next_out(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    return Next(type(node)(operand.args[0])) if isinstance(operand, Next) else None


@TEMPORAL_RULES.rule(Eventually, name="eventually-binary", laws="F(a U b) = F b; F(a M b) = F(a & b)")
def _eventually_binary(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, Until):
        return Eventually(operand.args[1])
    if isinstance(operand, StrongRelease):
        return Eventually(And(*operand.args))
    return None


@TEMPORAL_RULES.rule(Always, name="always-binary", laws="G(a R b) = G b; G(a W b) = G(a | b)")
def _always_binary(node: Formula, _: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, Release):
        return Always(operand.args[1])
    if isinstance(operand, WeakUntil):
        return Always(Or(*operand.args))
    return None


@TEMPORAL_RULES.rule(
    Eventually, name="eventually-weak", laws="F(a W b) = F b | F G a; F(a R b) = F(a & b) | F G b", grows=True
)
def _eventually_weak(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, WeakUntil):
        a, b = operand.args
        return Or(Eventually(b), Eventually(Always(a)))
    if isinstance(operand, Release) and known.size(operand.args[1]) <= MAX_COPIED:
        a, b = operand.args
        return Or(Eventually(And(a, b)), Eventually(Always(b)))
    return None


@TEMPORAL_RULES.rule(
    Always, name="always-strong", laws="G(a M b) = G b & G F a; G(a U b) = G(a | b) & G F b", grows=True
)
def _always_strong(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    if isinstance(operand, StrongRelease):
        a, b = operand.args
        return And(Always(b), Always(Eventually(a)))
    if isinstance(operand, Until) and known.size(operand.args[1]) <= MAX_COPIED:
        a, b = operand.args
        return And(Always(Or(a, b)), Always(Eventually(b)))
    return None


@TEMPORAL_RULES.rule(
    Next,
    Eventually,
    Always,
    name="pure-part-out",
    laws="F(a | e) = F a | e; G(a & u) = G a & u; X(a & s) = X a & s; X(a | s) = X a | s; F(a & s) = F a & s; "
    "G(a | s) = G a | s",
)
def _pure_part_out(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    if not isinstance(operand, And | Or):
        return None
    distributes = isinstance(operand, Or if isinstance(node, Eventually) else And) and not isinstance(node, Next)

    def movable(part: Formula) -> bool:
        eventual, universal = known.purity(part)
        if distributes:
            return eventual if isinstance(node, Eventually) else universal
        return eventual and universal

    return _take_out(operand, movable, lambda rest: node.with_args((rest,)))


@TEMPORAL_RULES.rule(
    Eventually,
    Always,
    name="implied-in-time",
    laws="F(a | b) = F a if b -> F a; G(a & b) = G a if G a -> b",
)
def _implied_in_time(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    if not isinstance(operand, Or if isinstance(node, Eventually) else And) or len(operand.args) > MAX_PAIRWISE:
        return None
    connective = type(operand)
    for part in operand.args:
        rest = node.with_args((connective(*(other for other in operand.args if other is not part)),))
        if known.implies(part, rest) if connective is Or else known.implies(rest, part):
            return rest
    return None


@TEMPORAL_RULES.rule(
    Eventually,
    Always,
    name="nested-in-time",
    laws="F(a & F b) = F b if b -> a; G(a | G b) = G b if a -> b",
)
def _nested_in_time(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    eventually = isinstance(node, Eventually)
    if not isinstance(operand, And if eventually else Or) or len(operand.args) > MAX_PAIRWISE:
        return None
    for part in operand.args:
        if isinstance(part, type(node)):
            inner, others = part.args[0], [other for other in operand.args if other is not part]
            if all(known.implies(inner, other) if eventually else known.implies(other, inner) for other in others):
                return part
    return None


@TEMPORAL_RULES.rule(Eventually, Always, name="split", laws="F(a | u) = F a | F u; G(a & e) = G a & G e", grows=True)
def _split(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    eventually = isinstance(node, Eventually)
    if not isinstance(operand, Or if eventually else And):
        return None

    def movable(part: Formula) -> bool:
        eventual, universal = known.purity(part)
        return universal if eventually else eventual

    return _take_out(operand, movable, lambda rest: node.with_args((rest,)), node)


@TEMPORAL_RULES.rule(
    Eventually,
    Always,
    name="split-in-the-limit",
    laws="G F(a & e) = G F a & G e; F G(a | u) = F G a | F u",
    grows=True,
)
def _split_in_the_limit(node: Formula, known: Implications) -> Formula | None:
    (operand,) = node.args
    always = isinstance(node, Always)
    if not isinstance(operand, Eventually if always else Always):
        return None
    (inner,) = operand.args
    if not isinstance(inner, And if always else Or):
        return None

    def movable(part: Formula) -> bool:
        eventual, universal = known.purity(part)
        return eventual if always else universal

    return _take_out(inner, movable, lambda rest: node.with_args((operand.with_args((rest,)),)), node)


def _take_out(
    operand: Formula,
    movable: Callable[[Formula], bool],
    wrap: Callable[[Formula], Formula],
    around: Formula | None = None,
) -> Formula | None:
    """Splits an & or | into wrap(the parts that stay) and the movable ones, each of these under `around`."""
    moved = [part for part in operand.args if movable(part)]
    stay = [part for part in operand.args if not movable(part)]
    if not moved or not (stay or around):
        return None
    connective = type(operand)
    return connective(wrap(connective(*stay)), *(around.with_args((part,)) if around else part for part in moved))


# --- two operands -----------------------------------------------------------------------------------------------------


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="units",
    laws="a U true = true; a U false = false; true U a = F a; false U a = a; "
    "a W true = true; a W false = G a; true W a = true; false W a = a; "
    "a R true = true; a R false = false; true R a = a; false R a = G a; "
    "a M true = F a; a M false = false; true M a = a; false M a = false",
)
def _units(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if isinstance(b, Constant):
        if isinstance(node, StrongRelease if b.value else WeakUntil):
            return Eventually(a) if b.value else Always(a)
        return b
    if isinstance(a, Constant):
        if a.value == isinstance(node, Release | StrongRelease):
            return b
        if isinstance(node, Until):
            return Eventually(b)
        return Always(b) if isinstance(node, Release) else a
    return None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="implied-operand",
    laws="a U b = b if a -> b; a W b = b if a -> b; a R b = b if b -> a; a M b = b if b -> a",
)
def _implied_operand(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    narrow, wide = (a, b) if isinstance(node, Until | WeakUntil) else (b, a)
    return b if known.implies(narrow, wide) else None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="exhausted-or-contradicted",
    laws="a U b = F b if !b -> a; a W b = true if !b -> a; a R b = G b if b -> !a; a M b = false if b -> !a; "
    "a U b = F b if F b -> a; a R b = G b if a -> G b",
)
def _exhausted(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    if isinstance(node, Until | WeakUntil) and known.exhaust(a, b):
        return Eventually(b) if isinstance(node, Until) else TRUE
    if isinstance(node, Release | StrongRelease) and known.contradict(a, b):
        return Always(b) if isinstance(node, Release) else FALSE
    if isinstance(node, Until) and known.implies(Eventually(b), a):
        return Eventually(b)
    if isinstance(node, Release) and known.implies(a, Always(b)):
        return Always(b)
    return None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="pure-right",
    laws="a U e = e; a R u = u; s W b = s | b; s M b = s & b; u W b = u | b; e M b = e & b",
)
def _pure_right(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    if isinstance(node, Until) and known.purity(b).eventual:
        return b
    if isinstance(node, Release) and known.purity(b).universal:
        return b
    if isinstance(node, WeakUntil) and known.purity(a).universal:
        return Or(a, b)
    if isinstance(node, StrongRelease) and known.purity(a).eventual:
        return And(a, b)
    return None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="pure-operand",
    laws="a W e = G a | e; a M u = F a & u; a M e = F(a & e); a W u = G(a | u); "
    "u U b = b | u & F b; e R b = b & (e | G b)",
    grows=True,
)
def _pure_operand(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    left, right = known.purity(a), known.purity(b)
    if isinstance(node, WeakUntil) and right.eventual:
        return Or(Always(a), b)
    if isinstance(node, StrongRelease) and right.universal:
        return And(Eventually(a), b)
    if isinstance(node, StrongRelease) and right.eventual:
        return Eventually(And(a, b))
    if isinstance(node, WeakUntil) and right.universal:
        return Always(Or(a, b))
    if known.size(b) > MAX_COPIED:
        return None
    if isinstance(node, Until) and left.universal:
        return Or(b, And(a, Eventually(b)))
    if isinstance(node, Release) and left.eventual:
        return And(b, Or(a, Always(b)))
    return None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="pure-part-of-right-out",
    laws="a U (b | e) = (a U b) | e; a W (b | e) = (a W b) | e; a R (b & u) = (a R b) & u; "
    "a M (b & u) = (a M b) & u; a U (b & s) = (a U b) & s; a R (b | s) = (a R b) | s",
)
def _pure_part_of_right_out(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    until = isinstance(node, Until | WeakUntil)
    distributes = isinstance(b, Or if until else And)
    if not distributes and not (isinstance(b, And | Or) and isinstance(node, Until | Release)):
        return None

    def movable(part: Formula) -> bool:
        eventual, universal = known.purity(part)
        if distributes:
            return eventual if until else universal
        return eventual and universal

    return _take_out(b, movable, lambda rest: node.with_args((a, rest)))


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="next-out-of-both",
    laws="X a U X b = X(a U b); X a W X b = X(a W b); X a R X b = X(a R b); X a M X b = X(a M b)",
)
def _next_out_of_both(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if isinstance(a, Next) and isinstance(b, Next):
        return Next(node.with_args((a.args[0], b.args[0])))
    return None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="left-in-context",
    laws="(a | c) U b = a U b if c -> b; (a | c) W b = a W b if c -> b; (a & c) U b = a U b if !b -> c; "
    "(a & c) W b = a W b if !b -> c; (a & c) R b = a R b if b -> c; (a & c) M b = a M b if b -> c; "
    "(a | c) R b = a R b if c -> !b; (a | c) M b = a M b if c -> !b",
)
def _left_in_context(node: Formula, known: Implications) -> Formula | None:
    """The left operand matters only where the right one is false (U W), or true (R M)."""
    a, b = node.args
    if not isinstance(a, And | Or):
        return None
    context = known.negation(b) if isinstance(node, Until | WeakUntil) else b
    if isinstance(a, And):
        kept = [part for part in a.args if not known.implies(context, part)]
    else:
        kept = [part for part in a.args if not known.contradict(part, context)]
    return node.with_args((type(a)(*kept), b)) if len(kept) < len(a.args) else None


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="exchange",
    laws="a U (a & b) = b M a; a W (a & b) = b R a; a R (a | b) = b W a; a M (a | b) = b U a",
)
def _exchange(node: Formula, _: Implications) -> Formula | None:
    a, b = node.args
    if not isinstance(b, And if isinstance(node, Until | WeakUntil) else Or):
        return None
    shared = operands(a, type(b))
    if not set(shared) <= set(b.args):
        return None
    rest: Formula = type(b)(*(part for part in b.args if part not in shared))
    return _EXCHANGED[type(node)](rest, a)


_EXCHANGED: Mapping[type[Formula], type[Formula]] = MappingProxyType(
    {Until: StrongRelease, WeakUntil: Release, Release: WeakUntil, StrongRelease: Until}
)


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="nested",
    laws="a U (b U c) = b U c if a -> b; a U (b W c) = b W c if a -> b; a W (b W c) = b W c if a -> b; "
    "a R (b R c) = b R c if b -> a; a R (b M c) = b M c if b -> a; a M (b M c) = b M c if b -> a",
)
def _nested(node: Formula, known: Implications) -> Formula | None:
    a, b = node.args
    inner = _NESTED[type(node)]
    if not isinstance(b, inner):
        return None
    narrow, wide = (a, b.args[0]) if isinstance(node, Until | WeakUntil) else (b.args[0], a)
    return b if known.implies(narrow, wide) else None


_NESTED: Mapping[type[Formula], tuple[type[Formula], ...]] = MappingProxyType(
    {
        Until: (Until, WeakUntil),
        WeakUntil: (WeakUntil,),
        Release: (Release, StrongRelease),
        StrongRelease: (StrongRelease,),
    }
)


@TEMPORAL_RULES.rule(
    *_BINARY,
    name="nested-left",
    laws="(a U b) U c = a U b | c if b -> c; (a U b) W c = a U b | c if b -> c; (a W b) W c = a W b | c if b -> c; "
    "(a R b) R c = a R b & c if c -> b; (a R b) M c = a R b & c if c -> b; (a M b) M c = a M b & c if c -> b",
)
def _nested_left(node: Formula, known: Implications) -> Formula | None:
    a, c = node.args
    if isinstance(node, Until | WeakUntil):
        inner: tuple[type[Formula], ...] = (Until,) if isinstance(node, Until) else (Until, WeakUntil)
        return Or(a, c) if isinstance(a, inner) and known.implies(a.args[1], c) else None
    inner = (Release,) if isinstance(node, Release) else (Release, StrongRelease)
    return And(a, c) if isinstance(a, inner) and known.implies(c, a.args[1]) else None
