"""Rewrite rules that put what some operands of & or | state into the others; each law has a dual."""

from __future__ import annotations

from collections.abc import Callable

from ltlc.ltl.formula import Always, And, Eventually, Formula, Or
from ltlc.ltl.implication import Implications
from ltlc.ltl.rule import MAX_PAIRWISE, RuleBook, operands
from ltlc.ltl.rules_boolean import SIDES
from ltlc.ltl.shape import EVENTUAL, LITERAL, SUSPENDABLE, UNIVERSAL
from ltlc.ltl.traversal import fold

INFORMED_RULES = RuleBook()

MAX_INFORMED = 500
"""Literals are put into operands of at most this many nodes."""


@INFORMED_RULES.rule(
    And,
    Or,
    name="literal-now",
    laws="p & (a | b & p) = p & (a | b); p | (a & (b | p)) = p | (a & b)",
    having=(And, Or),
    shared=True,
)
def _literal_now(node: Formula, known: Implications) -> Formula | None:
    stated = [part if part.flags & LITERAL else None for part in node.args]
    return _inform(node, known, stated, lambda part: isinstance(part, (And, Or)), (And, Or))


@INFORMED_RULES.rule(
    And,
    Or,
    name="literal-always",
    laws="G p & F(a & p) = G p & F a; G p & (a U (b | p)) = G p; F p | G(a | p) = F p | G a; F p | a U (b & p) = F p",
    having=(Eventually, Always),
    shared=True,
)
def _literal_always(node: Formula, known: Implications) -> Formula | None:
    lasting = SIDES[type(node)].lasting
    stated = [part.args[0] if type(part) is lasting else None for part in node.args]
    return _inform(node, known, stated, lambda _: True)


@INFORMED_RULES.rule(
    And,
    Or,
    name="literal-in-the-limit",
    laws="F G p & G F(a & p) = F G p & G F a; G F p | F G(a | p) = G F p | F G a",
    having=(Eventually, Always),
    shared=True,
)
def _literal_in_the_limit(node: Formula, known: Implications) -> Formula | None:
    side = SIDES[type(node)]
    stated = [_under(part, side.other, side.lasting) for part in node.args]
    return _inform(node, known, stated, lambda part: part.flags & SUSPENDABLE == SUSPENDABLE)


@INFORMED_RULES.rule(
    And,
    Or,
    name="answered-for-ever",
    laws="G F a & G(b | e) = G F a & G e if a -> !b; F G a | F(b & u) = F G a | F u if !a -> b",
    having=(Eventually, Always),
    shared=True,
)
def _answered_for_ever(node: Formula, known: Implications) -> Formula | None:
    """What is asked for again and again, and waits for a pure eventuality each time, asks for that again and again."""
    connective = type(node)
    side = SIDES[connective]
    clash, pure = (known.contradict, EVENTUAL) if connective is And else (known.exhaust, UNIVERSAL)
    recurring = [a for part in node.args if (a := _under(part, side.lasting, side.other)) is not None]
    if not recurring or len(node.args) > MAX_PAIRWISE:
        return None

    def answered(piece: Formula) -> Formula:
        rest = [part for part in operands(piece, side.dual) if part.flags & pure != pure]
        if not 0 < len(rest) < len(operands(piece, side.dual)):
            return piece
        if not any(all(clash(a, part) for part in rest) for a in recurring):
            return piece
        return side.dual(*(part for part in piece.args if part not in rest))

    parts = []
    for part in node.args:
        pieces = operands(part.args[0], connective) if type(part) is side.lasting else ()
        better = tuple(map(answered, pieces))
        parts.append(part if better == pieces else side.lasting(connective(*better)))
    return connective(*parts) if any(new is not old for new, old in zip(parts, node.args, strict=True)) else None


def _under(part: Formula, outer: type[Formula], inner: type[Formula]) -> Formula | None:
    """The operand of these two operators, or None."""
    operand = part.args[0] if type(part) is outer else None
    return operand.args[0] if operand is not None and type(operand) is inner else None


def _inform(
    node: Formula,
    known: Implications,
    stated: list[Formula | None],
    concerned: Callable[[Formula], bool],
    within: tuple[type[Formula], ...] | None = None,
) -> Formula | None:
    """Puts the literals that some operands state into the other operands.

    Args:
        node: the conjunction or disjunction.
        known: what is known about its parts.
        stated: for each operand, the formula whose literals it states, or None.
        concerned: whether a statement holds in an operand.
        within: the operators under which it holds; None for all.
    """
    connective = type(node)
    values: dict[Formula, Formula] = {}
    sources = set()
    mentioned = 0
    for part, statement in zip(node.args, stated, strict=True):
        for literal in operands(statement, connective) if statement is not None else ():
            if literal.flags & LITERAL:
                sources.add(part)
                mentioned |= literal.literal_mask | literal.negated_literal_mask
                values[literal] = SIDES[connective].unit
                values[known.negation(literal)] = SIDES[connective].zero
    if not values:
        return None
    parts = [
        fold(part, dict(values), lambda inner, args: inner.with_args(tuple(args)) if args else inner, within)
        if part.literal_mask & mentioned and part not in sources and concerned(part) and part.size <= MAX_INFORMED
        else part
        for part in node.args
    ]
    return connective(*parts) if any(new is not old for new, old in zip(parts, node.args, strict=True)) else None
