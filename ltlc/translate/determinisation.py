"""Nondeterministic Buchi automata, as other tools write them, to deterministic Rabin automata.

References:
    S. Schewe, T. Varghese: Tight Bounds for the Determinisation and Complementation of Generalised Buchi Automata.
    ATVA 2012, doi 10.1007/978-3-642-33386-6_5.
"""

from __future__ import annotations

from dataclasses import replace

from ltlc.automata.acceptance import Clause
from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.canonical import canonical
from ltlc.automata.emerson_lei import reduced
from ltlc.automata.omega import OmegaAutomaton
from ltlc.automata.rabin import DRA
from ltlc.automata.rabin_pairs import to_rabin
from ltlc.automata.simulation import reduced_buchi
from ltlc.budget import MAX_STATES, Budget, time_limit
from ltlc.errors import InvalidArgumentError
from ltlc.minimize.merge_by_trial import merge_by_trial
from ltlc.minimize.reduce import normalized
from ltlc.translate.safra import determinize


def determinise(automaton: OmegaAutomaton, *, max_states: int = MAX_STATES, timeout: float | None = None) -> DRA:
    """A deterministic Rabin automaton for the same words, transition-based and reduced.

    Args:
        automaton: a Buchi or generalized Buchi automaton, or a deterministic one with any condition.
        max_states: limit for every automaton on the way.
        timeout: seconds, or None.

    Raises:
        InvalidArgumentError: it is nondeterministic, and of another kind.
        StateLimitExceeded, TimeLimitExceeded: the budget ran out.

    Example:
        >>> import ltlc
        >>> choosing = ltlc.compile("FG a | GF b", form="limit-deterministic")
        >>> choosing.is_deterministic, determinise(choosing).n_states
        (False, 1)
    """
    name = automaton.formula or "the automaton"
    with time_limit(name, timeout):
        if automaton.is_deterministic:
            found = automaton.to_rabin(max_states=max_states)
        else:
            everything = Clause(0, (1 << automaton.n_sets) - 1)
            if automaton.condition != (everything,):
                raise InvalidArgumentError(
                    f"{name} is nondeterministic, and its acceptance condition is not (generalized) Buchi; "
                    "only such automata are made deterministic"
                )
            budget = Budget(name, max_states)
            buchi = BuchiAutomaton(automaton.n_classes, automaton.initial_states, automaton.edges, automaton.n_sets)
            found = to_rabin(
                reduced(determinize(reduced_buchi(buchi), budget)),
                automaton.aps,
                automaton.letter_class,
                budget,
                possible=automaton.possible,
            )
        smallest = merge_by_trial(normalized(canonical(found)), least=1)
        return replace(smallest, formula=automaton.formula, translator="safra")
