"""From a formula to the smallest Rabin automaton that the constructions find."""

from __future__ import annotations

from dataclasses import replace

from ltlc.automata import canonical, to_state_based
from ltlc.automata.compare import equivalent_states
from ltlc.automata.rabin import Acceptance, RabinAutomaton
from ltlc.automata.reduce import reduce
from ltlc.errors import InvalidArgumentError, LimitExceeded, UnknownNameError
from ltlc.ltl import Formula, nnf, propositions, simplify
from ltlc.translate.budget import Budget
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS, Construction
from ltlc.translate.emerson_lei import reduced
from ltlc.translate.pairs import rabin_automaton

AUTO = ("product", "safra", "dual-safra")
_PATIENCE = 4
"""A further construction is given up once it has this many times the states of the best automaton so far."""


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
    closure = Closure(nnf(simplify(formula)), propositions(formula), budget)
    names = AUTO if translator == "auto" else (translator,)
    best: RabinAutomaton | None = None
    for name in names:
        try:
            found = _build(CONSTRUCTIONS[name], closure, budget if best is None else budget.within(_PATIENCE * best.n_states + 100), acceptance)
        except LimitExceeded:
            if best is None and name == names[-1]:
                raise
            continue
        if best is None or _size(found) < _size(best):
            best = found
        if _is_smallest(best):
            break
    assert best is not None
    return replace(best, formula=str(formula))


def _build(
    construction: Construction, closure: Closure, budget: Budget, acceptance: Acceptance
) -> RabinAutomaton:
    automaton = rabin_automaton(reduced(construction.build(closure, budget)), closure.letters, budget)
    automaton = reduce(automaton)
    if acceptance == "state":
        automaton = to_state_based(automaton)
    return replace(canonical(automaton), translator=construction.name)


def _size(automaton: RabinAutomaton) -> tuple[int, int]:
    return automaton.n_states, automaton.n_pairs


def _is_smallest(automaton: RabinAutomaton) -> bool:
    """Whether all states have different languages: then no automaton for the language has fewer states."""
    return len(set(equivalent_states(automaton).tolist())) == automaton.n_states
