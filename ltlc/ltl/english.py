"""Formulas in plain English, with brackets wherever a sentence stands inside another, so that it has one reading."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from ltlc.budget import check_time
from ltlc.ltl.finite import WeakNext
from ltlc.ltl.formula import (
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
from ltlc.ltl.past import PAST, Historically, Once, Since, Triggered, WeakYesterday, Yesterday
from ltlc.ltl.syntax import quote
from ltlc.ltl.traversal import postorder

PHRASES: Mapping[type[Formula], tuple[str, ...]] = MappingProxyType(
    {
        Not: ("it is not so that ", ""),
        Next: ("at the next step ", ""),
        WeakNext: ("at the next step, if there is one, ", ""),
        Eventually: ("at some step from now on ", ""),
        Always: ("at every step from now on ", ""),
        And: ("", ", and ", ""),
        Or: ("", ", or ", ""),
        Implies: ("if ", ", then ", ""),
        Iff: ("", " exactly when ", ""),
        Xor: ("either ", " or ", ", but not both"),
        Until: ("", " until ", ", which must happen"),
        WeakUntil: ("", " until ", ", or for ever if that never happens"),
        Yesterday: ("there was a step before this one, and at it ", ""),
        WeakYesterday: ("at the step before this one, if there was one, ", ""),
        Once: ("at some step up to now ", ""),
        Historically: ("at every step up to now ", ""),
        Since: ("", " at every step after some step up to now at which ", ""),
    }
)
"""What stands before, between and behind the operands; what stands between two stands between any."""
SWAPPED: Mapping[type[Formula], tuple[str, ...]] = MappingProxyType(
    {
        Release: ("", " up to and including the first step at which ", ", or for ever if there is none"),
        StrongRelease: ("", " up to and including the first step at which ", ", which must come"),
        Triggered: ("", " from the last step up to now at which ", " on, or at every step up to now if there was none"),
    }
)
"""The same for operators whose right operand is said first."""
RECURRENTLY, FINALLY = "again and again, without end, ", "from some step on, for ever, "
"""G F and F G."""
TRUE_PHRASE, FALSE_PHRASE = "anything goes", "nothing will do"


def to_english(formula: Formula) -> str:
    """What a formula says of a word, from its first step on.

    >>> from ltlc.ltl import parse
    >>> to_english(parse("G(request -> F grant)"))
    'at every step from now on (if request holds, then (at some step from now on grant holds))'
    >>> to_english(parse("!hole U goal & GF home"))
    '(hole does not hold until goal holds, which must happen), and (again and again, without end, home holds)'
    """
    pieces: list[str] = []
    pending: list[str | tuple[Formula, bool]] = [(formula, False)]
    while pending:
        item = pending.pop()
        if isinstance(item, str):
            pieces.append(item)
            continue
        if not len(pieces) & 255:
            check_time()
        node, inside = item
        simple = _simple(node)
        if simple is not None:
            pieces.append(simple)
            continue
        parts = list(_parts(node))
        pending += reversed(["(", *parts, ")"] if inside else parts)
    return "".join(pieces)


def _simple(node: Formula) -> str | None:
    """What needs no brackets."""
    if isinstance(node, Constant):
        return TRUE_PHRASE if node.value else FALSE_PHRASE
    if isinstance(node, Proposition):
        return f"{_name(node)} holds"
    if isinstance(node, Not) and isinstance(node.args[0], Proposition):
        return f"{_name(node.args[0])} does not hold"
    return None


def _name(node: Proposition) -> str:
    return quote(node.name) if node.name in _WORDS else str(node)


_WORDS = (
    frozenset(re.findall(r"\w+", " ".join((*sum((*PHRASES.values(), *SWAPPED.values()), ()), RECURRENTLY, FINALLY))))
    .union(("holds", "does", "not", "hold", "anything", "goes", "nothing", "will", "do"))
    .difference("a")
)
"""Names that would be read as words of the sentence."""


def _parts(node: Formula) -> Iterator[Any]:
    inner = node.args[0]
    if isinstance(node, Always) and isinstance(inner, Eventually):
        yield from (RECURRENTLY, (inner.args[0], True))
    elif isinstance(node, Eventually) and isinstance(inner, Always):
        yield from (FINALLY, (inner.args[0], True))
    else:
        swapped = type(node) in SWAPPED
        before, *between, behind = SWAPPED[type(node)] if swapped else PHRASES[type(node)]
        yield before
        for number, arg in enumerate(node.args[::-1] if swapped else node.args):
            if number:
                yield between[0]
            yield arg, True
        yield behind


def misreadings(formula: Formula) -> list[str]:
    """What of a formula is often meant otherwise: a sentence for each, in the order of the formula.

    >>> from ltlc.ltl import parse
    >>> misreadings(parse("request -> F grant"))
    ['request -> F grant is about the first step only; for every step write G(request -> F grant)']
    >>> misreadings(parse("G(a -> F b)"))
    []
    """
    found: dict[str, None] = {}
    for part in formula.args if isinstance(formula, And) else (formula,):
        if isinstance(part, Implies | Iff) and not isinstance(part.args[0], _TEMPORAL):
            found[f"{part} is about the first step only; for every step write G({part})"] = None
    for node in postorder(formula):
        if isinstance(node, Implies) and isinstance(node.args[0], Always | Eventually):
            operator, inner = type(node.args[0]).symbol, node.args[0].args[0]
            meant = Implies(inner, node.args[1])
            whole = f"{operator}({meant})"
            found[f"{node} has the condition {node.args[0]}; if {operator} is about all of it, write {whole}"] = None
        elif isinstance(node, Eventually) and isinstance(node.args[0], Implies):
            left, right = node.args[0].args
            found[f"{node} holds as soon as {left} does not; that both happen is {Eventually(And(left, right))}"] = None
        elif isinstance(node, Always) and _promises(node.args[0]):
            left = next(part for part in node.args[0].args if isinstance(part, Proposition))
            found[f"{node} demands {left} at every step; a condition is written with ->"] = None
        elif isinstance(node, WeakUntil):
            found[f"{node} does not demand that {node.args[1]} ever happens; {Until(*node.args)} does"] = None
    return list(found)


_TEMPORAL = (Next, WeakNext, Eventually, Always, Until, WeakUntil, Release, StrongRelease, *PAST)


def _promises(inner: Formula) -> bool:
    """Whether a conjunction has a literal beside a promise, as in G(a & F b), which is mostly meant as G(a -> F b)."""
    return (
        isinstance(inner, And)
        and any(isinstance(part, Proposition) for part in inner.args)
        and any(isinstance(part, Eventually | Next) for part in inner.args)
    )
