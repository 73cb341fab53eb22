"""Smallest deterministic Rabin automata, exactly: each strong component of the residual automaton by itself, by SAT."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import suppress

from ltlc.automata.rabin import DRA
from ltlc.budget import time_limit
from ltlc.errors import TimeLimitExceeded
from ltlc.minimize.collapse import Minimized, Structure, quotient, rebuild, source_structure
from ltlc.minimize.lower_bound import part_lower_bound
from ltlc.minimize.residuals import Part, residuals
from ltlc.minimize.sat_search import Search, Word


def minimize(automaton: DRA, *, timeout: float | None = None) -> Minimized:
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
    try:
        found = residuals(automaton)
        structures = [source_structure(found.automaton, part) for part in found.parts]
        bound = found.n_residuals
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        for i, part in enumerate(found.parts):
            share = max(0.0, deadline - time.monotonic()) / (len(found.parts) - i)
            structures[i], least = _smallest(part, structures[i], share)
            bound += least - len(part.residuals)
        return Minimized(rebuild(found, structures), bound)
    except TimeLimitExceeded:  # of the caller
        return Minimized(automaton, 1)


def _smallest(part: Part, current: Structure, seconds: float) -> tuple[Structure, int]:
    """A smallest structure for a part, or the given one; and a lower bound on the number of its states."""
    least = part_lower_bound(part, part.acceptance)
    single = quotient(part)
    if single is not None:
        return single, least
    words: Sequence[Word] = ()
    with suppress(TimeLimitExceeded), time_limit("a smallest component", seconds):
        while least < len(current.step):
            search = Search(part, least, words)
            structure = search.run()
            if structure is not None:
                return structure, len(structure.step)
            words = tuple(search.words)
            least += 1
    return current, least
