"""From a formula to the smallest Rabin automaton that the constructions find."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ltlc.automata import canonical, to_state_based
from ltlc.automata.compare import equivalent_states
from ltlc.automata.rabin import Acceptance, RabinAutomaton
from ltlc.automata.reduce import reduce
from ltlc.errors import InvalidArgumentError, StateLimitExceeded, UnknownNameError
from ltlc.ltl import Formula, nnf, propositions, simplify
from ltlc.translate.budget import Budget
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS, Construction
from ltlc.translate.emerson_lei import reduced
from ltlc.translate.pairs import rabin_automaton

DIRECT = ("product", "safra", "dual-safra")
INDIRECT = ("normal-form", "dual-normal-form")
"""Tried too where the outer Boolean combination has parts above recurrence and persistence."""
_ROUNDS = (500, 10_000)
_PATIENCE = 4
"""A further construction is given up once it has this many times the states of the best automaton so far."""


class Problem(NamedTuple):
    """What every construction is given."""

    formula: Formula
    """simplified, in negation normal form."""
    aps: tuple[str, ...]
    acceptance: Acceptance


class Candidate(NamedTuple):
    """What a construction found: transition-based, canonically numbered."""

    automaton: RabinAutomaton
    translator: str
    weak: bool

    @property
    def size(self) -> tuple[int, int]:
        """States, then pairs."""
        return self.automaton.n_states, self.automaton.n_pairs

    def is_smallest(self) -> bool:
        """Whether all states have different languages: then no automaton for the language has fewer states."""
        return self.weak or len(set(equivalent_states(self.automaton).tolist())) == self.automaton.n_states


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
    problem = Problem(nnf(simplify(formula)), propositions(formula), acceptance)
    best = _best(problem, budget) if translator == "auto" else _build(CONSTRUCTIONS[translator], problem, budget)
    automaton = best.automaton
    described = {"formula": str(formula), "translator": best.translator}
    if acceptance == "transition":
        return replace(automaton, **described)
    if best.weak:
        marks = {"fin": automaton.fin.any(axis=2), "inf": automaton.inf.any(axis=2)}
        return replace(automaton, acceptance="state", **marks, **described)
    return replace(canonical(to_state_based(automaton)), **described)


def _best(problem: Problem, budget: Budget) -> Candidate:
    """The smallest result; constructions that explode are stopped early as long as others may succeed."""
    closure = Closure(problem.formula, problem.aps, budget)
    if closure.is_fair_obligation(closure.root):
        names: tuple[str, ...] = ("product",)
    else:
        names = DIRECT if closure.is_low(closure.root) else (*DIRECT, *INDIRECT)
    for limit in (*(n for n in _ROUNDS if n < budget.max_states), budget.max_states):
        best: Candidate | None = None
        for name in names:
            cap = limit if best is None else min(limit, _PATIENCE * best.automaton.n_states + 100)
            try:
                found = _build(CONSTRUCTIONS[name], problem, budget.within(cap))
            except StateLimitExceeded:
                if limit == budget.max_states and best is None and name == names[-1]:
                    raise
                continue
            if best is None or found.size < best.size:
                best = found
            if best.is_smallest():
                return best
        if best is not None:
            return best
    raise AssertionError("the last round returns or raises")


def _build(construction: Construction, problem: Problem, budget: Budget) -> Candidate:
    closure = Closure(problem.formula, problem.aps, budget)
    automaton = reduced(construction.build(closure, budget))
    arrays = rabin_automaton(automaton, closure.letters, budget)
    if automaton.is_weak:  # already minimized exactly, and state marks need no further state
        return Candidate(arrays, construction.name, weak=True)
    return Candidate(reduce(arrays), construction.name, weak=False)
