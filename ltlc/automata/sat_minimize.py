"""Smallest deterministic Rabin automata, exactly: each strong component of the residual automaton by itself, by SAT."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ltlc.automata.canonical import canonical
from ltlc.automata.lower_bound import part_lower_bound
from ltlc.automata.marks import simplify_marks
from ltlc.automata.rabin import RabinAutomaton
from ltlc.automata.rabin_type import LabelPair, rabin_condition
from ltlc.automata.residuals import Part, Residuals, residuals
from ltlc.automata.sat_search import Search, Structure, Word
from ltlc.errors import TimeLimitExceeded


@dataclass(frozen=True)
class Minimized:
    """The smallest automaton found, and what is known about smaller ones."""

    automaton: RabinAutomaton
    lower_bound: int
    """no equivalent automaton with the same kind of acceptance has fewer states."""

    @property
    def is_proven(self) -> bool:
        """Whether the automaton is a smallest one."""
        return self.automaton.n_states == self.lower_bound


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
        structure, least = _smallest(part, _given(found.automaton, part), on_states, until)
        structures.append(structure)
        bound += least - len(part.residuals)
    result = canonical(simplify_marks(canonical(_assembled(found, structures))))
    if result.n_states >= found.automaton.n_states:
        result = found.automaton
    return Minimized(result, bound)


def _smallest(part: Part, given: Structure, on_states: bool, deadline: float | None) -> tuple[Structure, int]:
    """A smallest structure for a part, or the given one; and a lower bound on the number of its states."""
    n_given, n_residuals = len(given.step), len(part.residuals)
    least = part_lower_bound(part, on_states)
    if least == n_residuals < n_given:
        residual_of = tuple(range(n_residuals))
        pairs = rabin_condition(part.cycle_graph(part.step, residual_of, on_states))
        if isinstance(pairs, list):
            return Structure(residual_of, part.step, tuple(pairs)), least
        least += 1
    words: Sequence[Word] = ()
    while least < n_given:
        try:
            search = Search(part, least, on_states, words)
            structure = search.run(deadline)
        except TimeLimitExceeded:
            return given, least
        if structure is not None:
            return structure, len(structure.step)
        words = tuple(search.words)
        least += 1
    return given, least


def _given(automaton: RabinAutomaton, part: Part) -> Structure:
    """The component of the automaton itself."""
    columns = [part.column.index(c) for c in range(part.n_columns)]
    states = list(part.states)
    if automaton.acceptance == "state":
        fin, inf = automaton.fin[:, states], automaton.inf[:, states]
    else:
        tables = (table[:, states][:, :, columns] for table in (automaton.fin, automaton.inf))
        fin, inf = (table.reshape(automaton.n_pairs, -1) for table in tables)
    pairs = [LabelPair(_mask(f), _mask(i)) for f, i in zip(fin, inf, strict=True)]
    return Structure(part.residual_of, part.delta, tuple(pairs))


def _mask(labels: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> int:
    return sum(1 << int(k) for k in np.flatnonzero(labels))


def _assembled(found: Residuals, structures: Sequence[Structure]) -> RabinAutomaton:
    """One structure per part, and one state for each residual in no part."""
    automaton = found.automaton
    first = np.unique(found.language, return_index=True)[1]
    rows = found.language[automaton.delta[first]].tolist()
    states: list[tuple[int, int]] = []  # (part or -1, state of the part or residual)
    number: dict[tuple[int, int], int] = {}
    entry: dict[int, int] = {}  # residual -> some state
    for i, (part, structure) in enumerate(zip(found.parts, structures, strict=True)):
        for k, residual in enumerate(structure.residual_of):
            entry.setdefault(part.residuals[residual], len(states))
            number[i, k] = len(states)
            states.append((i, k))
    for residual in range(found.n_residuals):
        if residual not in entry:
            entry[residual] = len(states)
            states.append((-1, residual))

    on_states = automaton.acceptance == "state"
    n_pairs = max([1, *(len(s.pairs) for s in structures)])
    shape = (n_pairs, len(states)) if on_states else (n_pairs, len(states), automaton.n_classes)
    fin, inf = np.zeros(shape, dtype=np.bool_), np.zeros(shape, dtype=np.bool_)
    delta = np.zeros((len(states), automaton.n_classes), dtype=np.int32)
    for q, (i, k) in enumerate(states):
        if i < 0:
            delta[q] = [entry[target] for target in rows[k]]
            continue
        part, structure = found.parts[i], structures[i]
        leaving = rows[part.residuals[structure.residual_of[k]]]
        for letter, column in enumerate(part.column):
            inside = structure.step[k][column]
            delta[q, letter] = number[i, inside] if inside >= 0 else entry[leaving[letter]]
            label = k if on_states else k * part.n_columns + column
            for p, pair in enumerate(structure.pairs):
                place = (p, q) if on_states else (p, q, letter)
                fin[place] = pair.fin >> label & 1
                inf[place] = pair.inf >> label & 1
    return replace(
        automaton,
        delta=delta,
        fin=fin,
        inf=inf,
        initial_state=entry[int(found.language[automaton.initial_state])],
        state_names=None,
    )
