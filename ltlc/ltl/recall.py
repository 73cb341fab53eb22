"""A formula with operators of the past, taken apart into one of the future and what that one recalls."""

from __future__ import annotations

from typing import NamedTuple

from ltlc.ltl.formula import Formula, Not
from ltlc.ltl.names import unused
from ltlc.ltl.normal import negation
from ltlc.ltl.past import PAST
from ltlc.ltl.shape import NO_PAST
from ltlc.ltl.traversal import fold


class Recalled(NamedTuple):
    """What `without_past` makes of a formula."""

    future: Formula
    """the formula, with a proposition for each largest subformula of the past."""
    meaning: dict[Formula, Formula]
    """what these propositions stand for, in order of appearance."""

    def together(self, future: Formula) -> Formula:
        """A formula with these propositions, with what they stand for in their place.

        Negations go inwards: the result is in negation normal form if the argument is.
        """
        meaning = self.meaning
        negated: dict[Formula, Formula] = {}

        def rebuild(node: Formula, args: list[Formula]) -> Formula:
            if isinstance(node, Not) and node.args[0] in meaning:
                return negation(args[0], negated)
            return meaning.get(node) or node.with_args(tuple(args))

        return fold(future, {}, rebuild)


def without_past(formula: Formula) -> Recalled:
    """The formula with a new proposition for each largest subformula of the past.

    A subformula and its negation get one proposition, and the negation of it.

    Args:
        formula: in negation normal form.
    """
    free = unused(formula, "past")
    meaning: dict[Formula, Formula] = {}
    signs: dict[Formula, Formula] = {}  # the proposition, or its negation, for a subformula of the past
    negated: dict[Formula, Formula] = {}
    done: dict[Formula, Formula] = {}

    def recall(node: Formula) -> Formula:
        if node not in signs:
            sign = next(free)
            meaning[sign] = node
            signs[node], signs[negation(node, negated)] = sign, Not(sign)
        return signs[node]

    stack = [formula]
    while stack:
        node = stack[-1]
        if node in done:
            stack.pop()
        elif node.flags & NO_PAST:
            done[node] = node
        elif isinstance(node, PAST):
            done[node] = recall(node)
        else:
            missing = [arg for arg in node.args if arg not in done]
            stack.extend(missing[::-1])
            if not missing:
                done[node] = node.with_args(tuple([done[arg] for arg in node.args]))
    return Recalled(done[formula], meaning)
