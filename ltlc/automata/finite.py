"""The deterministic automaton over finite traces, as a frozen value of arrays.

It is written and drawn like a Rabin automaton with state-based acceptance and one pair, whose marks (`inf`, a badge +0)
say where a trace may end.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

from ltlc import graph
from ltlc.arrays import BoolArray, IntArray, np, npt
from ltlc.automata.alphabet import Alphabet
from ltlc.automata.canonical import canonical
from ltlc.automata.output import Output
from ltlc.automata.partition import refine
from ltlc.automata.possible import LetterNumbers, Possible
from ltlc.automata.rabin import DRA
from ltlc.errors import InvalidArgumentError, check_type

Goal = Literal["reach", "end"]
"""When a task over finite traces is done: as soon as the trace so far is accepted, or where its episode ends."""
END = "end of episode"
"""The last proposition of automata that care where an episode ends: it holds where the environment terminates."""


def spoken(aps: tuple[str, ...]) -> tuple[str, ...]:
    """The propositions that labels are about: all but `END` in the last place."""
    return aps[:-1] if aps[-1:] == (END,) else aps


def end_letter(aps: tuple[str, ...], letter_class: npt.NDArray[Any]) -> int:
    """What `END` adds to the number of a letter without it; 0 if it is not in the last place."""
    return 0 if spoken(aps) == aps else len(letter_class) // 2


def spoken_letters(aps: tuple[str, ...], possible: Possible | None) -> LetterNumbers:
    """The numbering of the letters over all propositions but `END` in the last place."""
    known = possible[:-1] if possible is not None and spoken(aps) != aps else possible
    return LetterNumbers(spoken(aps), known)


class FiniteAnnotations(NamedTuple):
    """Facts about the states of an automaton over finite traces.

    Attributes:
        deadlocks: states from which no trace is accepted, and which are not accepting themselves.
        accepting_sinks: states that are accepting whatever follows.
        distances: from each state, letters to the nearest accepting state, -1 from a deadlock.
    """

    deadlocks: tuple[int, ...]
    accepting_sinks: tuple[int, ...]
    distances: Sequence[int]

    @property
    def distance(self) -> IntArray:
        """Shape (n_states,), int32; `distances` as an array."""
        return np.array(self.distances, dtype=np.int32)


@dataclass(frozen=True, eq=False, repr=False)
class DFA(Output):
    """A complete deterministic automaton that accepts a non-empty finite trace iff its run ends in an accepting state.

    Attributes:
        aps: the propositions; bit i of a letter is the i-th.
        delta: shape (n_states, n_classes), int32; entry = next state.
        letter_class: shape (n_letters,), int32; entry = class of the letter; every class occurs.
        accepting: shape (n_states,), bool.
        initial_state: the state before any letter is read; whether it is accepting matters only where it is entered
            again, since traces have a letter.
        formula: the formula it was compiled from, as text.
        state_names: one name per state, or None; for readers only.
        possible: which letters are possible, see `ltlc.automata.possible`; None: all 2**len(aps).

    Raises:
        InvalidAutomatonError: the arrays do not fit together, or an entry is out of range.
        AlphabetLimitExceeded: there are too many propositions for tables.

    Example:
        >>> import ltlc
        >>> dfa = ltlc.compile("F(a & WX b)", finite=True)
        >>> dfa.accepts([{"b"}, {"a"}]), dfa.accepts([{"a"}, {"a"}, set()])
        (True, False)
    """

    aps: tuple[str, ...]
    delta: IntArray
    letter_class: IntArray
    accepting: BoolArray
    initial_state: int = 0
    formula: str | None = None
    state_names: tuple[str, ...] | None = None
    possible: Possible | None = None

    acceptance = "state"
    n_pairs = 1
    translator = "finite"

    def __post_init__(self) -> None:
        accepting = np.array(self.accepting, dtype=np.bool_)[None]
        # A Rabin automaton with the same tables checks and freezes them.
        table = DRA(
            self.aps,
            self.delta,
            self.letter_class,
            np.zeros_like(accepting),
            accepting,
            initial_state=self.initial_state,
            formula=self.formula,
            state_names=self.state_names,
            possible=self.possible,
        )
        object.__setattr__(self, "_table", table)
        object.__setattr__(self, "delta", table.delta)
        object.__setattr__(self, "letter_class", table.letter_class)
        object.__setattr__(self, "accepting", table.inf[0])

    @property
    def table(self) -> DRA:
        """The same tables as a Rabin automaton, with a mark on accepting states: for writers, not for runs."""
        table: DRA = self.__dict__["_table"]
        return table

    @property
    def n_states(self) -> int:
        """Number of states, deadlock and sinks included."""
        return self.table.n_states

    @property
    def n_classes(self) -> int:
        """Number of letter classes."""
        return self.table.n_classes

    @property
    def fin(self) -> BoolArray:
        """No marks, shape (1, n_states)."""
        return self.table.fin

    @property
    def inf(self) -> BoolArray:
        """The accepting states as marks, shape (1, n_states)."""
        return self.table.inf

    @property
    def alphabet(self) -> Alphabet:
        """Propositions and letter classes, for guards."""
        return self.table.alphabet

    @cached_property
    def annotations(self) -> FiniteAnnotations:
        """What is known about each state."""
        rows = self.table.successors
        ends = np.flatnonzero(self.accepting).tolist()
        others = np.flatnonzero(~self.accepting).tolist()
        backwards = graph.predecessor_lists(rows)
        distance = graph.distances(backwards, ends)
        doubtful = set(graph.coreachable(rows, others))
        return FiniteAnnotations(
            tuple(q for q, d in enumerate(distance) if d < 0),
            tuple(q for q in range(self.n_states) if q not in doubtful),
            distance,
        )

    @property
    def deadlocks(self) -> tuple[int, ...]:
        """States from which no trace is accepted any more."""
        return self.annotations.deadlocks

    @property
    def accepting_sinks(self) -> tuple[int, ...]:
        """States that are accepting whatever follows."""
        return self.annotations.accepting_sinks

    def step(self, state: int, propositions: Iterable[str]) -> int:
        """The state after reading one letter; see `DRA.step`."""
        return self.table.step(state, propositions)

    def accepts(self, trace: Sequence[Iterable[str]]) -> bool:
        """Whether a trace is accepted.

        Raises:
            UnknownNameError: a name is not one of `aps`.
            InvalidArgumentError: the trace has no letter, or a letter is no set of names.
        """
        check_type(trace, Iterable, "trace", "a sequence of letters")
        letters = [self.table.letter(names) for names in trace]
        if not letters:
            raise InvalidArgumentError("a trace has at least one letter")
        state = self.initial_state
        for letter in letters:
            state = int(self.delta[state, self.letter_class[letter]])
        return bool(self.accepting[state])

    def canonical(self) -> DFA:
        """The same automaton, numbered breadth-first, letters in increasing order, without unreachable states."""
        return from_table(canonical(self.table))

    def minimal(self) -> DFA:
        """The smallest automaton for the same traces, canonical; all automata for the same traces give this one.

        References:
            E. F. Moore, Gedanken-experiments on sequential machines, Automata Studies 1956, doi
            10.1515/9781400882618-006.
        """
        reached = self.canonical()
        block = refine(reached.delta, reached.accepting.astype(np.int32))
        first = np.unique(block, return_index=True)[1]
        smallest = replace(
            reached,
            delta=block[reached.delta[first]],
            accepting=reached.accepting[first],
            initial_state=int(block[reached.initial_state]),
            state_names=None,
        )
        return smallest.canonical()

    def reached(self) -> DRA:
        """The automaton of the infinite words of which some beginning is accepted: done once, done for good.

        Its name is `reach(formula)`, which is no formula: the formula is about the beginnings.
        """
        sink = self.n_states
        delta = np.where(self.accepting[self.delta], sink, self.delta)
        delta = np.vstack([delta, np.full((1, self.n_classes), sink)])
        last = np.array([q == sink for q in range(sink + 1)])
        smallest = DFA(self.aps, delta, self.letter_class, last, self.initial_state, possible=self.possible).minimal()
        formula = None if self.formula is None else f"reach({self.formula})"
        return replace(smallest.table, formula=formula, translator=self.translator)

    def ended(self) -> DRA:
        """The automaton of the infinite words that are accepted up to the first letter in which `END` holds.

        It has that proposition in the last place. A word without it is not accepted.

        Raises:
            AlphabetLimitExceeded: there is no room for one more proposition.
            InvalidAutomatonError: the automaton has this proposition itself.
        """
        done, lost, k = self.n_states, self.n_states + 1, self.n_classes
        last = np.where(self.accepting[self.delta], done, lost)
        delta = np.vstack([np.hstack([self.delta, last]), np.full((1, 2 * k), done), np.full((1, 2 * k), lost)])
        letter_class = np.concatenate([self.letter_class, self.letter_class + k])
        is_done = np.array([q == done for q in range(self.n_states + 2)])
        possible = None if self.possible is None else (*self.possible, (0, 1 << len(self.aps)))
        smallest = DFA((*self.aps, END), delta, letter_class, is_done, self.initial_state, possible=possible).minimal()
        formula = None if self.formula is None else f"end({self.formula})"
        return replace(smallest.table, formula=formula, translator=self.translator)

    def with_goal(self, goal: Goal) -> DRA:
        """`reached` or `ended`.

        Raises:
            InvalidArgumentError: there is no such goal.
        """
        check_type(goal, str, "goal", "'reach' or 'end'")
        if goal not in ("reach", "end"):
            raise InvalidArgumentError(f"goal is {goal!r}; it can be 'reach' or 'end'")
        return self.reached() if goal == "reach" else self.ended()

    @property
    def size(self) -> str:
        """Size and kind for a reader, e.g. "5 states, finite traces"."""
        return f"{super().size}, finite traces"


def from_table(table: DRA) -> DFA:
    """The automaton over finite traces whose accepting states are those with an inf mark; the way back from `table`."""
    return DFA(
        table.aps,
        table.delta,
        table.letter_class,
        np.asarray(table.inf.any(axis=0)),
        table.initial_state,
        table.formula,
        table.state_names,
        table.possible,
    )
