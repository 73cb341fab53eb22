"""The acceptance conditions of HOA files, as they are parsed, in the algebra of `ltlc.automata.acceptance`."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial, reduce
from typing import NamedTuple

from ltlc.automata.acceptance import ALWAYS, NEVER, Acceptance, Clause, conjunction, simplify
from ltlc.ltl.formula import TRUE, And, Formula, Or, Proposition
from ltlc.ltl.traversal import postorder

MAX_CLAUSES = 1024
"""Clauses of the largest condition that is built."""


class AcceptanceSet(NamedTuple):
    """A set of states or transitions, or its complement."""

    number: int
    complement: bool


class Atom(NamedTuple):
    """Fin or Inf of an acceptance set or of its complement."""

    is_inf: bool
    of: AcceptanceSet

    @classmethod
    def parse(cls, name: str) -> Atom:
        """Read the name of a proposition like `Fin(!3)`."""
        # a number with more digits than any set can have is refused later, as out of range
        return cls(name.startswith("Inf"), AcceptanceSet(int(name[4:-1].lstrip("!")[:12]), name[4] == "!"))


def sets_of(condition: Formula) -> list[AcceptanceSet]:
    """List the sets that a condition speaks of, by their numbers."""
    return sorted({Atom.parse(node.name).of for node in postorder(condition) if isinstance(node, Proposition)})


def acceptance_of(condition: Formula, mark: Mapping[AcceptanceSet, int], used: Collection[int]) -> Acceptance:
    """Write a condition as a disjunction of clauses, for an automaton where only the sets in `used` have members.

    What is true of the others is put in first, since the number of clauses can grow exponentially with that of sets.

    Args:
        condition: its atoms are named like `Fin(!3)`.
        mark: of each set, as a bit mask.
        used: numbers of the sets with members.

    Raises:
        TooManyClausesError: there are more than `MAX_CLAUSES`.
    """
    value: dict[Formula, Acceptance] = {}
    for node in postorder(condition):
        parts = [value[arg] for arg in node.args]
        if isinstance(node, Proposition):
            is_inf, of = Atom.parse(node.name)
            if of.number in used:
                value[node] = (Clause(0, mark[of]) if is_inf else Clause(mark[of], 0),)
            else:
                value[node] = ALWAYS if is_inf == of.complement else NEVER
        elif isinstance(node, And):
            value[node] = reduce(partial(conjunction, limit=MAX_CLAUSES), parts, ALWAYS)
        elif isinstance(node, Or):
            value[node] = simplify([clause for part in parts for clause in part], MAX_CLAUSES)
        else:
            value[node] = ALWAYS if node is TRUE else NEVER
    return value[condition]
