"""Formulas to automata of further forms, from what a construction built before Rabin pairs are formed.

References:
    D. Mueller, S. Sickert: LTL to Deterministic Emerson-Lei Automata. GandALF 2017, doi 10.4204/EPTCS.256.13.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from ltlc.arrays import np
from ltlc.automata.acceptance import Acceptance, Clause, rabin
from ltlc.automata.emerson_lei import EmersonLei, LetterEdge, localized, merged
from ltlc.automata.omega import OmegaAutomaton, aligned, edges_of, shared
from ltlc.automata.pair_choice import limit_deterministic
from ltlc.automata.rabin import DRA
from ltlc.budget import Budget, time_limit
from ltlc.errors import StateLimitExceeded, TimeLimitExceeded
from ltlc.ltl import Formula, Not
from ltlc.translate.constructions import CONSTRUCTIONS
from ltlc.translate.letters import Letters
from ltlc.translate.options import GeneralForm, Options
from ltlc.translate.pipeline import translate
from ltlc.translate.problem import PATIENCE, SLACK, built, problem_of, too_deep, worth_trying


def translate_to_form(formula: Formula, form: GeneralForm, options: Options, *, text: str) -> OmegaAutomaton:
    """An automaton of the form for the words that satisfy the formula.

    * `emerson-lei`: deterministic, with any condition: what the best construction built, or the Rabin automaton if that
      has fewer states.
    * `generalized-rabin`: deterministic; a disjunction, each part of which has one Fin set and any number of Inf sets.
    * `streett`: deterministic; the dual of a Rabin automaton for the negation, on the same states.
    * `limit-deterministic`: a Buchi automaton that is deterministic but for one choice in each run, and good for Markov
      decision processes; see `ltlc.automata.limit_deterministic`.

    Args:
        formula: any formula.
        form: see above.
        options: of the translation; `acceptance` has no effect.
        text: what to call the formula in messages and in the result.

    Raises:
        LimitExceeded: as `translate`.

    Example:
        >>> from ltlc.ltl import parse
        >>> translate_to_form(parse("GF a -> GF b"), "streett", Options(), text="response").n_states
        1
    """
    with time_limit(text, options.timeout):
        return _MAKERS[form](formula, options._replace(acceptance="transition"), text)


def _emerson_lei(formula: Formula, options: Options, text: str) -> OmegaAutomaton:
    automaton, source = _smallest(formula, options, text)
    one = shared(automaton)
    edges, n_sets, condition = one if one is not None else aligned(automaton)[:3]
    return _made(source, edges, n_sets, condition, "emerson-lei", text)


def _generalized_rabin(formula: Formula, options: Options, text: str) -> OmegaAutomaton:
    automaton, source = _smallest(formula, options, text)
    edges, n_sets, condition, _ = aligned(automaton)
    return _made(source, edges, n_sets, condition, "generalized-rabin", text)


def _streett(formula: Formula, options: Options, text: str) -> OmegaAutomaton:
    negation = translate(Not(formula), options, text=text)
    promises = tuple((1 << 2 * i, 2 << 2 * i) for i in range(negation.n_pairs))
    # In pair i, what was Inf comes first: if it is seen for ever, so is what was Fin.
    swapped = replace(negation, fin=negation.inf, inf=negation.fin)
    return _made(negation, edges_of(swapped), 2 * negation.n_pairs, (Clause(0, 0, promises),), "streett", text)


def _limit_deterministic(formula: Formula, options: Options, text: str) -> OmegaAutomaton:
    refinement = limit_deterministic(translate(formula, options, text=text))
    automaton, choices = refinement.automaton, refinement.select_pair.tolist()
    sink = automaton.n_states - 1 if any(place >= 0 for row in choices for place in row) else -1
    plain = [[edge._replace(marks=bool(edge.marks)) for edge in row] for row in edges_of(automaton)]
    edges = []
    for q, own in enumerate(choices):
        rows = [plain[q], *(plain[place] for place in own if place >= 0)]
        edges.append(tuple(merged(edge for row in rows for edge in row if edge.target != sink)))
    return _made(automaton, tuple(edges), 1, (Clause(0, 1),), "limit-deterministic", text)


_MAKERS: Mapping[GeneralForm, Callable[[Formula, Options, str], OmegaAutomaton]] = MappingProxyType(
    {
        "emerson-lei": _emerson_lei,
        "generalized-rabin": _generalized_rabin,
        "streett": _streett,
        "limit-deterministic": _limit_deterministic,
    }
)


def smallest_emerson_lei(formula: Formula, options: Options, *, text: str) -> tuple[EmersonLei, Letters]:
    """The deterministic automaton with the fewest states that the constructions build, and its letters.

    Args:
        formula: any formula.
        options: of the translation; with effort "fast" the first construction alone is tried.
        text: what to call the formula in messages.

    Raises:
        LimitExceeded: as `translate`.
    """
    options = options.checked()
    with time_limit(text, options.timeout):
        budget = Budget(text, options.max_states)
        try:
            problem = problem_of(formula, options, budget)
            best: EmersonLei | None = None
            for name in worth_trying(problem.closure(budget), options):
                most = budget.max_states if best is None else min(budget.max_states, PATIENCE * best.n_states + SLACK)
                try:
                    found = built(CONSTRUCTIONS[name], problem, budget.within(most), problem.closure(budget))
                except (StateLimitExceeded, TimeLimitExceeded):
                    if best is None:
                        raise
                    break
                best = found if best is None or found.n_states < best.n_states else best
                if best.is_weak or best.n_states == 1:
                    break
        except RecursionError:
            raise too_deep(budget) from None
    assert best is not None
    return best, problem.letters


def _smallest(formula: Formula, options: Options, text: str) -> tuple[EmersonLei, Letters | DRA]:
    """The smallest deterministic automaton found, its conditions localized, and what has its letters."""
    table = translate(formula, options, text=text)
    automaton, letters = smallest_emerson_lei(formula, options, text=text)
    if table.n_states < automaton.n_states:
        automaton = EmersonLei(edges_of(table), (rabin(table.n_pairs),) * table.n_states)
        return localized(automaton), table
    return localized(automaton), letters


def _made(
    source: Letters | DRA,
    edges: tuple[tuple[LetterEdge, ...], ...],
    n_sets: int,
    condition: Acceptance,
    form: GeneralForm,
    text: str,
) -> OmegaAutomaton:
    return OmegaAutomaton(
        source.aps,
        np.asarray(source.letter_class, dtype=np.int32),
        edges,
        n_sets,
        condition,
        form,
        formula=text,
        possible=source.possible,
    )
