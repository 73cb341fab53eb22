"""The deterministic Rabin automaton, as a frozen value.

Letters are sets of atomic propositions, written as a number: a bitmask, bit i is `aps[i]`, unless some letters are
impossible (`ltlc.automata.possible`). Letters that no state tells apart share a *letter class*, and the tables are
indexed by class: `delta[state, letter_class[letter]]`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from typing import Literal, NamedTuple

from ltlc import graph
from ltlc.arrays import BoolArray, IntArray, np
from ltlc.automata.acceptance import rabin_accepts, recurring_marks
from ltlc.automata.annotate import Annotations, annotate
from ltlc.automata.languages import language_numbers
from ltlc.automata.output import Output
from ltlc.automata.tables import AcceptanceKind, Tables
from ltlc.errors import InvalidArgumentError, UnknownNameError, check_type

__all__ = ["DRA", "AcceptanceKind", "Form", "RabinPair"]

Form = Literal["rabin", "parity", "buchi", "co-buchi"]
"""what `ltlc.automata.with_form` makes."""


class RabinPair(NamedTuple):
    """One pair (B, G): a run is accepted by it iff `fin` is visited finitely and `inf` infinitely often.

    The entries are states where acceptance is on states, and (state, letter class) where it is on transitions.
    """

    fin: frozenset[int] | frozenset[tuple[int, int]]
    inf: frozenset[int] | frozenset[tuple[int, int]]


@dataclass(frozen=True, eq=False, repr=False)
class DRA(Tables, Output):
    """A complete deterministic automaton with a Rabin acceptance condition.

    A run is accepted iff for some pair i it takes marks of `fin[i]` finitely often and marks of `inf[i]` infinitely
    often (thesis, definition 2.1.1, with B = fin, G = inf; HOA: Fin(2i) & Inf(2i+1)).

    Attributes:
        aps: the propositions; bit i of a letter is the i-th.
        delta: shape (n_states, n_classes), int32; entry = next state.
        letter_class: shape (n_letters,), int32; entry = class of the letter; every class occurs.
        fin: shape (n_pairs, n_states) if acceptance is "state", else (n_pairs, n_states, n_classes).
        inf: same shape as `fin`.
        initial_state: the state before any letter is read.
        acceptance: "state" or "transition": what carries marks.
        formula: the formula it was compiled from, as text.
        state_names: one name per state, or None; for readers only.
        translator: the construction that built it, or None.
        possible: which letters are possible, in the numbering of `ltlc.automata.possible`; None: all 2**len(aps).
        forms: normal forms that it is known to have, so that they are not made again; `replace` forgets them.
        known_languages: `language_numbers`, where they are known from how it was made; `replace` forgets them.
        alike: one entry per state, or None; states with equal entries are known to accept the same words from how it
            was made, others may do so, too; `replace` forgets it.
        is_listed: whether it was given as lists (`from_lists`): it is small, and lists are faster to look at.

    Raises:
        InvalidAutomatonError: the arrays do not fit together, or an entry is out of range.
        AlphabetLimitExceeded: more than 21 propositions, or 2**21 possible letters.
    """

    @cached_property
    def edge_fin(self) -> BoolArray:
        """Fin marks seen on entering `delta[state, class]`, shape (n_pairs, n_states, n_classes).

        State marks are those of the *entered* state, so that rewards and runs read one table for both kinds.
        """
        return self.fin[:, self.delta] if self.acceptance == "state" else self.fin

    @cached_property
    def edge_inf(self) -> BoolArray:
        """Inf marks, like `edge_fin`."""
        return self.inf[:, self.delta] if self.acceptance == "state" else self.inf

    @cached_property
    def pairs(self) -> tuple[RabinPair, ...]:
        """The pairs as sets of states, or of (state, letter class) for transition-based acceptance."""

        def entries(mark: int) -> frozenset[int] | frozenset[tuple[int, int]]:
            if self.acceptance == "state":
                return frozenset(q for q, marks in enumerate(self.mark_lists) if marks & mark)
            rows = enumerate(self.mark_lists)
            return frozenset((q, c) for q, row in rows for c, marks in enumerate(row) if marks & mark)

        return tuple(RabinPair(entries(1 << 2 * i), entries(2 << 2 * i)) for i in range(self.n_pairs))

    @cached_property
    def scc(self) -> list[int]:
        """Strong component of each state, numbered in topological order."""
        return graph.strong_components(self.successors)

    @cached_property
    def language_numbers(self) -> list[int]:
        """One entry per state; states with equal ones accept the same words, numbered by their first states."""
        return language_numbers(self) if self.known_languages is None else self.known_languages

    @property
    def languages(self) -> IntArray:
        """`language_numbers` as an array, shape (n_states,), int32."""
        return np.array(self.language_numbers, dtype=np.int32)

    @property
    def has_languages(self) -> bool:
        """Whether `languages` are known, so that asking for them costs nothing."""
        return self.known_languages is not None or "language_numbers" in vars(self)

    @cached_property
    def n_languages(self) -> int:
        """Number of different `languages`; no deterministic automaton for the same language has fewer states."""
        return max(self.language_numbers) + 1

    @cached_property
    def annotations(self) -> Annotations:
        """What is known about each state: its component, whether it can still accept or reject, and how far it is."""
        return annotate(self)

    @property
    def deadlocks(self) -> tuple[int, ...]:
        """States from which no word is accepted."""
        return self.annotations.deadlocks

    @property
    def accepting_sinks(self) -> tuple[int, ...]:
        """States from which every word is accepted."""
        return self.annotations.accepting_sinks

    @cached_property
    def _ap_bit(self) -> dict[str, int]:
        return {name: 1 << i for i, name in enumerate(self.aps)}

    @property
    def size(self) -> str:
        """Size and kind for a reader, e.g. "5 states, 1 pair, state-based"."""
        pairs = "1 pair" if self.n_pairs == 1 else f"{self.n_pairs} pairs"
        return f"{super().size}, {pairs}, {self.acceptance}-based"

    def letter(self, propositions: Iterable[str]) -> int:
        """The number of the letter in which these propositions hold: their bitmask, unless letters are impossible.

        Raises:
            UnknownNameError: a name is not one of `aps`.
            ImpossibleLetterError: the letter was declared impossible.
            InvalidArgumentError: it is no set of names, but, for example, a string.
        """
        if isinstance(propositions, str):
            hint = f"write {{{propositions!r}}} instead of {propositions!r}"
            raise InvalidArgumentError(f"a letter is a set of propositions: {hint}")
        check_type(propositions, Iterable, "a letter", "a set of names")
        mask = 0
        for name in propositions:
            bit = self._ap_bit.get(name) if isinstance(name, str) else None
            if bit is None:
                raise UnknownNameError("proposition", name, self.aps)
            mask |= bit
        return mask if self.possible is None else self.letter_numbers.number(mask)

    def step(self, state: int, propositions: Iterable[str]) -> int:
        """The state after reading one letter, given as the names of the propositions that hold.

        Raises:
            UnknownNameError: a name is not one of `aps`.
            InvalidArgumentError: there is no such state, or the letter was declared impossible.
        """
        check_type(state, Integral, "state", "a number")
        if not 0 <= state < self.n_states:
            raise InvalidArgumentError(f"state is {state}; there are the states 0 to {self.n_states - 1}")
        return int(self.delta[state, self.letter_class[self.letter(propositions)]])

    def accepts(self, prefix: Sequence[Iterable[str]] = (), cycle: Sequence[Iterable[str]] = ((),)) -> bool:
        """Whether the word `prefix` followed by `cycle` for ever is accepted.

        Raises:
            UnknownNameError: a name is not one of `aps`.
            InvalidArgumentError: the cycle is empty, or a letter is no set of names.
        """
        for name, letters in (("prefix", prefix), ("cycle", cycle)):
            check_type(letters, Iterable, name, "a sequence of letters")
        if not cycle:
            raise InvalidArgumentError("the cycle of a lasso word needs at least one letter")
        return self.accepts_letters([self.letter(a) for a in prefix], [self.letter(a) for a in cycle])

    def accepts_letters(self, prefix: Sequence[int], cycle: Sequence[int]) -> bool:
        """`accepts` for letters given as their numbers; `cycle` must not be empty."""
        state = self.initial_state
        for letter in prefix:
            state = int(self.delta[state, self.letter_class[letter]])
        classes = [int(self.letter_class[letter]) for letter in cycle]
        rows, marks = self.rows, self.edge_marks

        def run(state: int) -> tuple[int, int]:
            seen = 0
            for c in classes:
                seen |= marks[state][c]
                state = rows[state][c]
            return state, seen

        return rabin_accepts(self.n_pairs, recurring_marks(state, run))
