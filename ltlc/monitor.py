"""A verdict while a word is running: what its letters so far decide, and what they suggest."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

import numpy as np
import numpy.typing as npt

from ltlc.arrays import IntArray
from ltlc.automata import DFA
from ltlc.automata.partition import number_blocks, refine
from ltlc.automata.possible import possible_letters
from ltlc.automata.rabin import DRA
from ltlc.budget import MAX_STATES, Budget, check_time, time_limit
from ltlc.compiler import as_formula, check_size
from ltlc.errors import InvalidArgumentError, check_type
from ltlc.ltl import Formula, propositions
from ltlc.translate import Options, translate, translate_finite

CodeArray = npt.NDArray[np.int8]


class Verdict(Enum):
    """What the letters so far say about a formula.

    Example:
        >>> Verdict.VIOLATED.is_final, Verdict.PRESUMABLY_SATISFIED.is_final
        (True, False)
    """

    SATISFIED = "satisfied"
    """the formula holds however the word goes on"""
    VIOLATED = "violated"
    """it holds in no way in which the word can go on"""
    PRESUMABLY_SATISFIED = "presumably satisfied"
    """it would hold if the word ended here, as a finite trace"""
    PRESUMABLY_VIOLATED = "presumably violated"
    """it would not hold if the word ended here"""

    @property
    def is_final(self) -> bool:
        """Whether no further letter changes it."""
        return self in (Verdict.SATISFIED, Verdict.VIOLATED)

    @property
    def code(self) -> int:
        """Its number in arrays: the position among `VERDICTS`."""
        return VERDICTS.index(self)


VERDICTS = tuple(Verdict)
"""The verdicts by their codes."""


class Monitor:
    """Watches a word and says after each letter what is known of a formula.

    It is the smallest deterministic automaton that gives these verdicts: the product of the Rabin automaton, whose
    states without an accepted and without a rejected word give the final verdicts, and of the automaton for the same
    formula over finite traces, which gives the others.

    Attributes:
        aps: the propositions; bit i of a letter is the i-th.
        formula: the formula as text, or None.
        delta: shape (n_states, n_classes), int32; entry = next state; state 0 is before the first letter.
        letter_class: shape (n_letters,), int32; entry = class of the letter.
        codes: shape (n_states,), int8; `Verdict.code` of each state.
        state: where it is now.

    Args:
        formula: a formula, its text, or an automaton over finite traces.
        finite: whether the formula is about finite traces; then a verdict is final if it is so however the trace goes
            on, and else says what it is if the trace ends here.
        max_states: limit for every automaton on the way.
        timeout: seconds for making it, or None.
        exclusive: see `ltlc.compile`.
        letters: see `ltlc.compile`.

    Raises:
        LtlSyntaxError: the text is not a formula.
        LimitExceeded: `max_states`, `timeout` or the number of propositions does not suffice.
        InvalidArgumentError: an argument is something else.

    Example:
        >>> monitor = Monitor("G(request -> F grant) & G !error")
        >>> [monitor.step(letter).value for letter in ({"request"}, {"grant"}, {"error"})]
        ['presumably violated', 'presumably satisfied', 'violated']

    References:
        Andreas Bauer, Martin Leucker and Christian Schallhart, Comparing LTL semantics for runtime verification,
        Journal of Logic and Computation 20(3), 2010, doi:10.1093/logcom/exn075.
    """

    def __init__(
        self,
        formula: Formula | str | DFA,
        *,
        finite: bool = False,
        max_states: int = MAX_STATES,
        timeout: float | None = None,
        exclusive: Iterable[Iterable[str]] = (),
        letters: Iterable[Iterable[str]] | None = None,
    ) -> None:
        options = Options(effort="fast", max_states=max_states, timeout=timeout).checked()
        if isinstance(formula, DFA):
            trace, words = formula.canonical(), None
        else:
            with time_limit(formula if isinstance(formula, str) else "the formula", timeout):
                parsed = as_formula(formula, finite=finite)
                check_size(parsed)
                possible = possible_letters(propositions(parsed), exclusive, letters)
                options = options._replace(possible=possible)
                trace = translate_finite(parsed, max_states=options.max_states, possible=possible)
                words = None if finite else translate(parsed, options)
        self.aps: tuple[str, ...] = trace.aps
        self.formula: str | None = trace.formula
        self._table = trace.table
        self._make(trace, words, Budget(str(trace.formula), options.max_states))
        self._rows: list[list[int]] = self.delta.tolist()
        self._verdicts: list[Verdict] = [VERDICTS[code] for code in self.codes.tolist()]
        self.state = 0

    def _make(self, trace: DFA, words: DRA | None, budget: Budget) -> None:
        """The product of both automata, with as few states as its verdicts allow."""
        joined = trace.letter_class.astype(np.int64)
        if words is not None:
            joined = joined * words.n_classes + words.letter_class
        first, letter_class = np.unique(joined, return_index=True, return_inverse=True)[1:]
        in_trace = trace.delta[:, trace.letter_class[first]]
        in_words = np.zeros((1, len(first)), dtype=np.int32)
        if words is not None:
            in_words = words.delta[:, words.letter_class[first]]
        start = (trace.initial_state, 0 if words is None else words.initial_state)
        number = {start: 0}
        pairs = [start]
        rows = []
        for p, q in pairs:  # grows while it is read
            check_time()
            budget.check_states(len(pairs))
            row = []
            for pair in zip(in_trace[p].tolist(), in_words[q].tolist(), strict=True):
                if pair not in number:
                    number[pair] = len(pairs)
                    pairs.append(pair)
                row.append(number[pair])
            rows.append(row)
        place, certain = (0, trace) if words is None else (1, words)
        won, lost = set(certain.accepting_sinks), set(certain.deadlocks)
        codes = [
            0 if pair[place] in won else 1 if pair[place] in lost else 2 if trace.accepting[pair[0]] else 3
            for pair in pairs
        ]
        delta = np.array(rows, dtype=np.int32)
        block = refine(delta, number_blocks(codes))
        kept = np.unique(block, return_index=True)[1]
        columns, column = np.unique(block[delta[kept]], axis=1, return_inverse=True)
        self.delta: IntArray = columns.astype(np.int32)
        self.letter_class: IntArray = column.reshape(-1)[letter_class].astype(np.int32)
        self.codes: CodeArray = np.array(codes, dtype=np.int8)[kept]

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.codes)

    @property
    def verdict(self) -> Verdict:
        """What the letters so far say; before the first one, what is certain, and else `PRESUMABLY_VIOLATED`."""
        return self._verdicts[self.state]

    def reset(self) -> None:
        """Begin another word."""
        self.state = 0

    def step(self, propositions: Iterable[str]) -> Verdict:
        """Read one letter, given as the names of the propositions that hold.

        Raises:
            UnknownNameError: a name is not one of `aps`.
            ImpossibleLetterError: the letter was declared impossible.
            InvalidArgumentError: it is no set of names.
        """
        self.state = self._rows[self.state][self.letter_class[self._table.letter(propositions)]]
        return self._verdicts[self.state]

    def letter(self, propositions: Iterable[str]) -> int:
        """The number of a letter, as `run` takes it; see `DRA.letter`."""
        return self._table.letter(propositions)

    def run(self, letters: npt.ArrayLike) -> CodeArray:
        """The codes of the verdicts after each letter of one word or of many, from their beginning.

        The monitor itself stays where it is.

        Args:
            letters: shape (n_letters,) or (n_letters, n_words), whole numbers; bit i = `aps[i]` holds, unless letters
                are impossible: then as `letter` gives them.

        Returns:
            The same shape; `VERDICTS[code]` is the verdict.

        Raises:
            InvalidArgumentError: these are no letters.

        Example:
            >>> Monitor("a U b").run([1, 1, 2, 0]).tolist()
            [3, 3, 0, 0]
        """
        given = np.asarray(letters)
        check_type(letters, Iterable, "letters", "an array of whole numbers")
        if given.size == 0:
            return np.zeros(given.shape, dtype=np.int8)
        if given.ndim not in (1, 2) or given.dtype.kind not in "iu":
            raise InvalidArgumentError("letters must be whole numbers, one a step, or one a step and word")
        if given.min() < 0 or given.max() >= len(self.letter_class):
            what = f"a bit for each of {self.aps}" if self._table.possible is None else "as Monitor.letter gives them"
            raise InvalidArgumentError(f"letters are numbers from 0 to {len(self.letter_class) - 1}, {what}")
        classes = self.letter_class[given]
        states = np.empty(given.shape, dtype=np.int32)
        if given.ndim == 1:
            state, rows = 0, self._rows
            visited = []
            for c in classes.tolist():
                state = rows[state][c]
                visited.append(state)
            states[:] = visited
        else:
            now = np.zeros(given.shape[1], dtype=np.int32)
            for step, row in enumerate(classes):
                now = self.delta[now, row]
                states[step] = now
        codes: CodeArray = self.codes[states]
        return codes

    def __repr__(self) -> str:
        return f"<Monitor of {self.formula}: {self.n_states} states, now {self.verdict.value}>"
