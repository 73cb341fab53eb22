"""Reading the Hanoi Omega-Automata format, version 1: every deterministic automaton becomes a Rabin automaton.

References:
    T. Babiak, F. Blahoudek, A. Duret-Lutz, J. Klein, J. Kretinsky, D. Mueller, D. Parker, J. Strejcek, The Hanoi
    Omega-Automata Format, CAV 2015, doi 10.1007/978-3-319-21690-4_31.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Literal, overload

from ltlc.arrays import np
from ltlc.automata.acceptance import NEVER, Acceptance, Clause, TooManyClausesError
from ltlc.automata.columns import truth_table
from ltlc.automata.emerson_lei import EmersonLei, LetterEdge, localized
from ltlc.automata.finite import DFA, from_table
from ltlc.automata.omega import OmegaAutomaton
from ltlc.automata.rabin import DRA
from ltlc.automata.rabin_pairs import Way, to_rabin
from ltlc.budget import MAX_STATES, NO_LIMIT, Budget
from ltlc.errors import AlphabetLimitExceeded, FileFormatError, StateLimitExceeded
from ltlc.formats.edges import MAX_TABLE, a_letter_of, guard_classes
from ltlc.formats.hoa_acceptance import MAX_CLAUSES, AcceptanceSet, acceptance_of, sets_of
from ltlc.formats.hoa_body import read_body
from ltlc.formats.hoa_claims import Evidence, failing_claim
from ltlc.formats.hoa_header import read_header
from ltlc.formats.hoa_names import rabin
from ltlc.formats.hoa_parser import HoaSyntaxError
from ltlc.formats.hoa_stream import pieces
from ltlc.formats.hoa_text import HoaText

_MAX_MARKS = 1 << 24
"""entries of the largest table of an automaton with counters, one for each state, letter class and pair."""


@overload
def from_hoa(text: str, *, nondeterministic: Literal[False] = False) -> DRA | DFA: ...


@overload
def from_hoa(text: str, *, nondeterministic: bool) -> DRA | DFA | OmegaAutomaton: ...


def from_hoa(text: str, *, nondeterministic: bool = False) -> DRA | DFA | OmegaAutomaton:
    """The automaton of an HOA text, which holds exactly one; see `read_hoa_stream`.

    Raises:
        FileFormatError: there is not exactly one automaton, or it cannot be read; names line and column.
        AlphabetLimitExceeded: it has too many propositions.
        StateLimitExceeded: Rabin pairs for its acceptance condition would need too many states.
    """
    stream = read_hoa_stream(text, nondeterministic=nondeterministic)
    automaton = next(stream, None)
    if automaton is None:
        raise FileFormatError("there is no automaton: an HOA file starts with 'HOA: v1' and ends with '--END--'")
    if next(stream, None) is not None:
        raise FileFormatError("there is more than one automaton; read_hoa_stream reads them one by one")
    return automaton


@overload
def read_hoa_stream(
    source: str | Iterable[str], *, nondeterministic: Literal[False] = False
) -> Iterator[DRA | DFA]: ...


@overload
def read_hoa_stream(source: str | Iterable[str], *, nondeterministic: bool) -> Iterator[DRA | DFA | OmegaAutomaton]: ...


def read_hoa_stream(
    source: str | Iterable[str], *, nondeterministic: bool = False
) -> Iterator[DRA | DFA | OmegaAutomaton]:
    """The automata of an HOA stream in order, each as soon as its --END-- has arrived.

    The automata must be deterministic. Any acceptance condition over Fin and Inf is turned into Rabin pairs; state
    numbers stay as they are unless a counter has to be added for that. An incomplete automaton gets one more state,
    a deadlock. Acceptance is on states iff no transition carries a mark (and `trans-acc` is not claimed). The header
    `name:` becomes `formula`, whether or not it is one. What the headers `properties:` and `acc-name:` claim must hold,
    but for `stutter-invariant`, `tight` and names that HOA does not define: a claim that fails tells that something was
    lost.

    Args:
        source: the text, or its lines with their line ends, as an open file gives them.
        nondeterministic: give a nondeterministic automaton with (generalized) Buchi acceptance back as an
            `OmegaAutomaton`, instead of an error.

    Raises:
        FileFormatError: an automaton cannot be read; names line and column.
        AlphabetLimitExceeded: it has too many propositions.
        StateLimitExceeded: Rabin pairs for its acceptance condition would need too many states.
    """
    for piece in pieces(io.StringIO(source) if isinstance(source, str) else source):
        yield _Reader(HoaText(piece), nondeterministic).assembled()


class _Reader:
    """Makes an automaton of what is listed."""

    def __init__(self, text: HoaText, nondeterministic: bool) -> None:
        self.text = text
        try:
            self.header = read_header(text, nondeterministic=nondeterministic)
            self.body = read_body(self.header)
        except HoaSyntaxError as error:
            text.fail(error.position, error.message)

    def assembled(self) -> DRA | DFA | OmegaAutomaton:
        header, body = self.header, self.body
        n_states = len(body.places)
        if header.states is not None and int(header.states) != n_states:
            self.text.fail(header.states, f"States: announces {header.states}, and {n_states} are listed")
        unlisted = next((q for q in range(n_states) if q not in body.places), None)
        if unlisted is not None:
            self.text.fail(0, f"state {unlisted} is not listed, though a state with a higher number is")
        for target, place in zip(body.targets, body.target_places, strict=True):
            if target >= n_states:
                self.text.fail(place, f"there is no state {target}, {n_states} are listed")
        for start in header.starts:
            if int(start) >= n_states:
                self.text.fail(start, f"there is no state {start}, {n_states} are listed")
        if not header.starts or not n_states:
            self.header.deny("complete", 0, "there is no initial state")
            return from_table(self._empty()) if header.finite else self._empty()
        if len(header.starts) > 1 or not body.is_deterministic:
            return self._nondeterministic()
        complete = self._is_complete()
        automaton = self._completed(n_states, complete)
        evidence = Evidence(n_states, int(header.starts[0]), body.sources, body.targets, body.marks, automaton)
        claim = failing_claim(header.claims, evidence)
        if claim is not None:
            self.text.fail(header.claims[claim], f"`{claim}` does not hold; the file is damaged or wrong")
        return self._of_traces(automaton) if header.finite else automaton

    def _nondeterministic(self) -> OmegaAutomaton:
        header, body = self.header, self.body
        header.deny("deterministic", 0, "there are several runs on a word")
        letter_class, classes = guard_classes(header.numbers.size, len(body.places), body.guards)
        mark = {of: 1 << i for i, of in enumerate(sets_of(header.condition))}
        acceptance = self._acceptance(mark, set(range(header.n_sets)))
        everything = Clause(0, (1 << len(mark)) - 1)
        if acceptance != (everything,) or header.finite:
            self.text.fail(
                header.acceptance or 0,
                "only Buchi and generalized Buchi automata are read if they are nondeterministic",
            )
        sets = {g: truth_table(column) for g, column in classes.items()}
        return OmegaAutomaton(
            tuple(header.aps),
            letter_class,
            self._edges(len(body.places), 0, sets, mark),
            len(mark),
            acceptance,
            "nondeterministic",
            tuple(dict.fromkeys(map(int, header.starts))),
            header.name,
            header.possible,
        )

    def _of_traces(self, automaton: DRA) -> DFA:
        if automaton.acceptance != "state" or automaton.n_pairs > 1 or automaton.fin.any():
            self.text.fail(self.header.acceptance or 0, "finite traces end in states of one Inf set, and no Fin set")
        return from_table(automaton)

    def _is_complete(self) -> bool:
        universe = self.header.numbers.all
        for state, letters in self.body.covered.items():
            if letters != universe:
                letter = a_letter_of(universe ^ letters, self.header.numbers)
                place, found = self.body.places[state], f"state {state} has no edge for the letter {letter}"
                self.header.deny("complete", place, found)
                if self.header.possible is not None:
                    self.text.fail(place, f"{found}, which the headers possible: allow; the file is damaged or wrong")
                return False
        return True

    def _empty(self) -> DRA:
        """Without an initial state no word is accepted."""
        marks = np.zeros((0, 1), dtype=np.bool_)
        letters = np.zeros(self.header.numbers.size, dtype=np.int32)
        delta = np.zeros((1, 1), dtype=np.int32)
        header = self.header
        return DRA(tuple(header.aps), delta, letters, marks, marks, formula=header.name, possible=header.possible)

    def _acceptance(self, mark: Mapping[AcceptanceSet, int], used: set[int] | None = None) -> Acceptance:
        """Read the acceptance condition; of one that is no list of Rabin pairs, only the sets in use."""
        header, body = self.header, self.body
        if used is None:
            used = set[int]().union(*set(body.state_marks.values()), *set(body.marks))
        if header.n_sets <= 2 * MAX_CLAUSES and header.condition is rabin(header.n_sets // 2):
            used = set(range(header.n_sets))
        try:
            return acceptance_of(header.condition, mark, used)
        except TooManyClausesError:
            message = f"the acceptance condition has more than {MAX_CLAUSES} terms when written as pairs"
            self.text.fail(header.acceptance or 0, message)

    def _completed(self, n_states: int, complete: bool) -> DRA:
        """Form Rabin pairs; an incomplete automaton gets a rejecting sink."""
        header, body = self.header, self.body
        on_transitions = body.on_edges or ("trans-acc" in header.claims and "state-acc" not in header.claims)
        n_all = n_states + (not complete)
        letter_class, classes = guard_classes(header.numbers.size, n_all, body.guards)
        n_classes = int(letter_class.max()) + 1
        mark = {of: 1 << i for i, of in enumerate(sets_of(header.condition))}
        acceptance = self._acceptance(mark)
        if n_all * n_classes * 2 * len(acceptance) > MAX_TABLE:
            message = f"tables of {n_all * n_classes} transitions and {len(acceptance)} pairs are too large"
            raise AlphabetLimitExceeded(message)
        edges = self._edges(n_states, (1 << n_classes) - 1, {g: truth_table(c) for g, c in classes.items()}, mark)
        conditions = (*[acceptance] * n_states, *[NEVER] * (n_all - n_states))
        has_counters = any(clause.inf.bit_count() > 1 for clause in acceptance)
        if has_counters:
            automaton = localized(EmersonLei(edges, conditions))
        else:  # marks stay as they are, on no cycle, too: the states in the file count as one component
            automaton = EmersonLei(edges, conditions, [*[0] * n_states, *[1] * (n_all - n_states)])
        most = min(MAX_STATES, _MAX_MARKS // (n_classes * max(1, len(acceptance))))
        ways: list[Way] = ["smaller", "counters"] if has_counters and on_transitions else ["counters"]
        found: list[DRA] = []
        for way in ways:
            with suppress(StateLimitExceeded):
                found.append(
                    to_rabin(
                        automaton,
                        tuple(header.aps),
                        letter_class,
                        Budget("the acceptance condition", most) if has_counters else NO_LIMIT,
                        initial_state=int(header.starts[0]),
                        on_states=not on_transitions,
                        way=way,
                        least_pairs=0,
                        possible=header.possible,
                    )
                )
        if not found:
            message = f"turning the acceptance condition into Rabin pairs needs more than {most} states"
            raise StateLimitExceeded(message)
        result = min(found, key=lambda a: (a.n_states, a.n_pairs))
        names = tuple(body.names.get(q, str(q)) for q in range(n_all)) if body.names and not has_counters else None
        return replace(result, formula=header.name, state_names=names)

    def _edges(
        self, n_states: int, everything: int, classes: Mapping[int, int], mark: Mapping[AcceptanceSet, int]
    ) -> tuple[tuple[LetterEdge, ...], ...]:
        """Put the edges into rows; letters that a state has no edge for lead to one more state.

        Args:
            n_states: of the file.
            everything: the set of all letter classes.
            classes: the set of letter classes of each guard.
            mark: of each acceptance set, as a bit mask.
        """
        body = self.body
        known: dict[frozenset[int], int] = {}

        def marks_of(numbers: frozenset[int]) -> int:
            if numbers not in known:
                known[numbers] = sum(bit for of, bit in mark.items() if (of.number in numbers) != of.complement)
            return known[numbers]

        rows: list[list[LetterEdge]] = [[] for _ in range(n_states)]
        left = [everything] * n_states
        for source, target, guard, numbers in zip(body.sources, body.targets, body.guards, body.marks, strict=True):
            rows[source].append(LetterEdge(classes[guard], target, marks_of(numbers)))
            left[source] &= ~classes[guard]
        for state, letters in enumerate(left):
            if letters:
                rows[state].append(LetterEdge(letters, n_states, marks_of(body.state_marks[state])))
        if any(left):
            rows.append([LetterEdge(everything, n_states, 0)])
        return tuple(map(tuple, rows))
