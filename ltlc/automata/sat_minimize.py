"""Smallest deterministic Rabin automata, exactly: each strong component of the residual automaton by itself, by SAT."""

from __future__ import annotations

import time
from collections.abc import Sequence

from ltlc.automata.collapse import Minimized, Structure, assembled, collapsed, given
from ltlc.automata.lower_bound import part_lower_bound
from ltlc.automata.rabin import RabinAutomaton
from ltlc.automata.residuals import Part, residuals
from ltlc.automata.sat_search import Search, Word
from ltlc.errors import TimeLimitExceeded


def minimize(automaton: RabinAutomaton, *, timeout: float | None = None) -> Minimized:
    """A smallest equivalent automaton with the same kind of acceptance, and any number of Rabin pairs.

    A smallest automaton consists of one strong component for each strong component of the residual automaton (see
    `residuals`), so these are made smallest one after the other. The number of states is raised from the lower bound
    until a component is found, or the one that is there cannot be improved.

    Args:
        automaton: any Rabin automaton; practical for components of up to about ten states and sixteen letter classes.
        timeout: seconds, or None; what is found until then is kept.

    Raises:
        MissingProgramError: python-sat is not installed, and the lower bound does not settle the matter without it.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    found = residuals(automaton)
    on_states = automaton.acceptance == "state"
    structures, bound = [], found.n_residuals
    for i, part in enumerate(found.parts):
        now = time.monotonic()
        until = None if deadline is None else now + (deadline - now) / (len(found.parts) - i)
        structure, least = _smallest(part, given(found.automaton, part), on_states, until)
        structures.append(structure)
        bound += least - len(part.residuals)
    return Minimized(assembled(found, structures), bound)


def _smallest(part: Part, current: Structure, on_states: bool, deadline: float | None) -> tuple[Structure, int]:
    """A smallest structure for a part, or the given one; and a lower bound on the number of its states."""
    least = part_lower_bound(part, on_states)
    single = collapsed(part, on_states)
    if single is not None:
        return single, least
    words: Sequence[Word] = ()
    while least < len(current.step):
        try:
            search = Search(part, least, on_states, words)
            structure = search.run(deadline)
        except TimeLimitExceeded:
            return current, least
        if structure is not None:
            return structure, len(structure.step)
        words = tuple(search.words)
        least += 1
    return current, least
