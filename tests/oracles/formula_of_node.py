"""Nodes and obligations of a closure written as formulas again, so that the oracle can judge them."""

from __future__ import annotations

from ltlc.budget import Budget
from ltlc.graph import bits
from ltlc.ltl import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    nnf,
    propositions,
)
from ltlc.translate.closure import Closure, Obligation
from ltlc.translate.letters import letters_of

_OPERATORS: dict[str, type[Formula]] = {
    "&": And,
    "|": Or,
    "X": Next,
    "F": Eventually,
    "G": Always,
    "U": Until,
    "R": Release,
    "W": WeakUntil,
    "M": StrongRelease,
}


def unlimited(formula: Formula) -> Budget:
    return Budget(str(formula), 100_000)


def closure_of(formula: Formula) -> Closure:
    simple = nnf(formula)
    return Closure(simple, letters_of(simple, propositions(formula)), unlimited(formula))


def formula_of_node(closure: Closure, node: int) -> Formula:
    kind, args, letters = closure.nodes[node]
    if kind == "letters":
        return _formula_of_letters(closure, letters)
    return _OPERATORS[kind](*(formula_of_node(closure, arg) for arg in args))


def formula_of_obligation(closure: Closure, obligation: Obligation) -> Formula:
    clauses = [And(*(formula_of_node(closure, atom) for atom in bits(clause))) for clause in obligation]
    return Or(*clauses)


def _formula_of_letters(closure: Closure, letters: int) -> Formula:
    if letters in (0, closure.letters.all):
        return TRUE if letters else FALSE
    aps, letter_class = closure.letters.aps, closure.letters.letter_class
    minterms = []
    for letter in range(2 ** len(aps)):
        if letters >> int(letter_class[letter]) & 1:
            names = [Proposition(name) for name in aps]
            minterms.append(And(*(name if letter >> i & 1 else Not(name) for i, name in enumerate(names))))
    return Or(*minterms)
