"""From a formula to the smallest Rabin automaton that the constructions find."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ltlc.automata import canonical, simplify_marks, to_state_based
from ltlc.automata.compare import equivalent_states
from ltlc.automata.rabin import Acceptance, RabinAutomaton
from ltlc.automata.reduce import MAX_PRODUCT_EDGES, reduce
from ltlc.errors import InvalidArgumentError, StateLimitExceeded, UnknownNameError
from ltlc.ltl import Formula, nnf, propositions, simplify
from ltlc.translate.budget import Budget
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS, Construction
from ltlc.translate.emerson_lei import reduced
from ltlc.translate.pairs import rabin_automaton

FAIR = ("product",)
"""Tried for obligations with fairness conditions,"""
LOW = ("product", "safra", "dual-safra")
"""for other Boolean combinations of recurrence and persistence formulas,"""
HIGH = ("normal-form", "dual-normal-form", "safra", "dual-safra", "product")
"""and for all other formulas; the first is the one that wins most often."""
_ROUNDS = (500, 10_000)
_PATIENCE = 2
"""A further construction is given up once it has this many times the states of the best automaton so far,"""
_SLACK = 60
"""plus these."""


class Problem(NamedTuple):
    """What every construction is given."""

    formula: Formula
    """simplified, in negation normal form."""
    aps: tuple[str, ...]

    def closure(self, budget: Budget) -> Closure:
        """A fresh closure: what a construction leaves in it must not depend on the constructions before."""
        return Closure(self.formula, self.aps, budget)


class Candidate(NamedTuple):
    """What a construction found: transition-based, canonically numbered."""

    automaton: RabinAutomaton
    translator: str
    weak: bool
    smallest: bool
    """whether all states have different languages: then no automaton for the language has fewer states."""

    @property
    def size(self) -> tuple[int, int]:
        """States, then pairs."""
        return self.automaton.n_states, self.automaton.n_pairs


def translate(
    formula: Formula,
    *,
    translator: str = "auto",
    acceptance: Acceptance = "state",
    max_states: int = 100_000,
    timeout: float | None = None,
) -> RabinAutomaton:
    """A deterministic Rabin automaton that accepts exactly the words satisfying the formula.

    1. Simplify the formula; bring it to negation normal form; group the letters it cannot tell apart.
    2. Build a deterministic automaton with Emerson-Lei acceptance (a construction) and reduce it.
    3. Form Rabin pairs, strong component by strong component; reduce again; split states for state-based acceptance.
    4. With "auto": try the next construction, unless the result is proven smallest, and keep the smallest.

    Args:
        formula: any LTL formula.
        translator: "auto" or the name of a construction.
        acceptance: marks on states (thesis, definition 2.1.1) or on transitions (often fewer states).
        max_states: limit for every automaton on the way.
        timeout: seconds, or None.

    Returns:
        A complete automaton over the propositions of the formula in order of appearance, canonically numbered: the same
        formula gives the same automaton, bit for bit.

    Raises:
        UnknownNameError: no such translator.
        InvalidArgumentError: the translator does not apply to the formula, or an argument is out of range.
        StateLimitExceeded, TimeLimitExceeded, AlphabetLimitExceeded: a budget ran out.
    """
    if translator != "auto" and translator not in CONSTRUCTIONS:
        raise UnknownNameError("translator", translator, ("auto", *CONSTRUCTIONS))
    if acceptance not in ("state", "transition"):
        raise InvalidArgumentError(f"acceptance is {acceptance!r}; it can be 'state' or 'transition'")
    budget = Budget(str(formula), max_states, timeout)
    problem = Problem(nnf(simplify(formula)), propositions(formula))
    best = _best(problem, budget) if translator == "auto" else _build(CONSTRUCTIONS[translator], problem, budget)
    automaton = best.automaton if acceptance == "transition" else _state_based(best, problem, budget)
    return replace(automaton, formula=str(formula), translator=best.translator)


def _state_based(best: Candidate, problem: Problem, budget: Budget) -> RabinAutomaton:
    """The candidate with marks on states."""
    automaton = best.automaton
    if best.weak:
        return replace(
            automaton, acceptance="state", fin=np.any(automaton.fin, axis=2), inf=np.any(automaton.inf, axis=2)
        )
    if automaton.n_pairs == 1:
        return canonical(to_state_based(automaton))
    # Many pairs on few states split into many: the chain of marks of a parity condition may split into fewer.
    closure = problem.closure(budget)
    emerson_lei = reduced(CONSTRUCTIONS[best.translator].build(closure, budget))
    chain = to_state_based(rabin_automaton(emerson_lei, closure.letters, budget, parity=True))
    if sum(len(entered) for entered in _marks_on_entry(automaton)) <= _PATIENCE * chain.n_states:
        chain = min(to_state_based(automaton), chain, key=lambda a: a.n_states)
    return canonical(chain)


def _marks_on_entry(automaton: RabinAutomaton) -> list[set[int]]:
    """Per state, the different marks with which edges enter it."""
    marks: list[set[int]] = [set() for _ in range(automaton.n_states)]
    for targets, row in zip(automaton.delta.tolist(), automaton.edge_marks, strict=True):
        for target, mark in zip(targets, row, strict=True):
            marks[target].add(mark)
    return marks


def _best(problem: Problem, budget: Budget) -> Candidate:
    """The smallest result; constructions that explode are stopped early as long as others may succeed."""
    closure = problem.closure(budget)
    if closure.is_fair_obligation(closure.root):
        names: tuple[str, ...] = FAIR
    else:
        names = LOW if closure.is_low(closure.root) else HIGH
    for limit in (*(n for n in _ROUNDS if n < budget.max_states), budget.max_states):
        best: Candidate | None = None
        for name in names:
            cap = limit if best is None else min(limit, _PATIENCE * best.automaton.n_states + _SLACK)
            try:
                found = _build(CONSTRUCTIONS[name], problem, budget.within(cap))
            except StateLimitExceeded:
                if limit == budget.max_states and best is None and name == names[-1]:
                    raise
                continue
            if best is None or found.size < best.size:
                best = found
            if best.smallest:
                return best
        if best is not None:
            return best
    raise AssertionError("the last round returns or raises")


def _build(construction: Construction, problem: Problem, budget: Budget) -> Candidate:
    closure = problem.closure(budget)
    emerson_lei = reduced(construction.build(closure, budget))
    automaton = rabin_automaton(emerson_lei, closure.letters, budget)
    if emerson_lei.is_weak:  # minimized exactly
        return Candidate(automaton, construction.name, weak=True, smallest=True)
    if _has_distinct_languages(automaton):
        return Candidate(canonical(simplify_marks(automaton)), construction.name, weak=False, smallest=True)
    automaton = reduce(automaton)
    return Candidate(automaton, construction.name, weak=False, smallest=_has_distinct_languages(automaton))


def _has_distinct_languages(automaton: RabinAutomaton) -> bool:
    if automaton.n_states**2 * automaton.n_classes > 2 * MAX_PRODUCT_EDGES:  # would be left undecided
        return False
    return int(equivalent_states(automaton, MAX_PRODUCT_EDGES).max()) + 1 == automaton.n_states
