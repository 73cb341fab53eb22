"""The names of the propositions of a formula, and names that it leaves free."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from ltlc.ltl.formula import Formula, Proposition
from ltlc.ltl.traversal import postorder


def propositions(formula: Formula) -> tuple[str, ...]:
    """Names of the atomic propositions, in order of first appearance."""
    return tuple(node.name for node in postorder(formula) if isinstance(node, Proposition))


def unused(formula: Formula, stem: str) -> Iterator[Proposition]:
    """Propositions that do not occur in the formula: the stem with a number each, without end."""
    taken = set(propositions(formula))
    for number in count():
        name = f"{stem} {number}"
        if name not in taken:
            yield Proposition(name)
