"""The deterministic Rabin automaton, as a frozen value of arrays.

A small one that the translator builds is given as lists (`DRA.from_lists`), which are faster where there are few
entries; its arrays are made when they are first asked for.

Letters are sets of atomic propositions, written as a number: a bitmask, bit i is `aps[i]`, unless some letters are
impossible (`ltlc.automata.possible`). Letters that no state tells apart share a *letter class*, and the tables are
indexed by class: `delta[state, letter_class[letter]]`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from numbers import Integral
from typing import Any, Literal, NamedTuple, Self, TypeAlias

from ltlc import graph
from ltlc.arrays import BoolArray, IntArray, Numbers, np, npt
from ltlc.automata.acceptance import rabin_accepts, recurring_marks
from ltlc.automata.alphabet import Alphabet
from ltlc.automata.annotate import Annotations, annotate
from ltlc.automata.languages import language_numbers
from ltlc.automata.output import Output
from ltlc.automata.partition import numbered
from ltlc.automata.possible import LetterNumbers, Possible
from ltlc.automata.wide import Entries, entries
from ltlc.errors import (
    InvalidArgumentError,
    InvalidAutomatonError,
    UnknownNameError,
    check_type,
)

AcceptanceKind = Literal["state", "transition"]
Row: TypeAlias = "Sequence[int] | npt.NDArray[Any]"
Marks: TypeAlias = "Sequence[int] | Sequence[Row]"
"""An integer for each state, or one per letter class for each; as in `DRA.mark_lists`."""
MARKS_IN_WORD = 31
"""pairs of marks fit into a machine word."""
FEW_ENTRIES = 4096
"""of a table are faster looked at one by one, in lists."""
_FEW_LETTERS = 64
"""are looked at faster one by one than as an array."""
Form = Literal["rabin", "parity", "buchi", "co-buchi"]
"""what `ltlc.automata.with_form` makes."""


class RabinPair(NamedTuple):
    """One pair (B, G): a run is accepted by it iff `fin` is visited finitely and `inf` infinitely often.

    The entries are states where acceptance is on states, and (state, letter class) where it is on transitions.
    """

    fin: frozenset[int] | frozenset[tuple[int, int]]
    inf: frozenset[int] | frozenset[tuple[int, int]]


@dataclass(frozen=True, eq=False, repr=False)
class DRA(Output):
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

    aps: tuple[str, ...]
    delta: IntArray
    letter_class: IntArray
    fin: BoolArray
    inf: BoolArray
    initial_state: int = 0
    acceptance: AcceptanceKind = "state"
    formula: str | None = None
    state_names: tuple[str, ...] | None = None
    translator: str | None = None
    possible: Possible | None = None
    forms: frozenset[str] = field(default=frozenset(), init=False, compare=False)
    known_languages: list[int] | None = field(default=None, init=False, compare=False)
    alike: Sequence[int] | None = field(default=None, init=False, compare=False)
    is_listed: bool = field(default=False, init=False, compare=False)

    def __post_init__(self) -> None:
        _check_names(self.aps)
        _freeze(self, "delta", np.int32, (None, None))
        _freeze(self, "letter_class", np.int32, (self.letter_numbers.size,))
        n_states, n_classes = self.delta.shape
        _check(self.acceptance in ("state", "transition"), f"acceptance is {self.acceptance!r}")
        marks = (None, n_states) if self.acceptance == "state" else (None, n_states, n_classes)
        _freeze(self, "fin", np.bool_, marks)
        _freeze(self, "inf", np.bool_, marks)
        _check(self.fin.shape == self.inf.shape, "fin and inf have different shapes")
        _check(n_states > 0 and n_classes > 0, "there is no state or no letter class")
        _check(0 <= self.initial_state < n_states, f"initial state {self.initial_state} of {n_states} states")
        _check(int(self.delta.view(np.uint32).max()) < n_states, "delta leads outside the states")  # -1 is large
        _check(_takes_all(self.letter_class, n_classes), f"letter classes are not exactly 0..{n_classes - 1}")
        _check(self.state_names is None or len(self.state_names) == n_states, "not one name per state")

    @classmethod
    def from_lists(
        cls,
        aps: tuple[str, ...],
        rows: Sequence[Row],
        marks: Marks,
        letter_class: Numbers,
        n_pairs: int,
        **others: Any,
    ) -> Self:
        """An automaton whose arrays are made when they are first asked for.

        Args:
            aps: the propositions.
            rows: `delta` as lists, which must fit.
            marks: `mark_lists`, which must fit.
            letter_class: a list, or an array.
            n_pairs: number of Rabin pairs, 31 at most.
            others: attributes that have a default.
        """
        _check_names(aps)
        known = {"aps": aps, "rows": rows, "mark_lists": marks, "n_pairs": n_pairs, **others}
        known |= {"n_states": len(rows), "n_classes": len(rows[0]), "is_listed": True}
        known["class_list" if isinstance(letter_class, list) else "letter_class"] = letter_class
        return cls._with(known)

    def __getattr__(self, name: str) -> object:
        known = vars(self)
        if name not in _ARRAYS or "mark_lists" not in known:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        array: npt.NDArray[Any]
        if name in ("fin", "inf"):
            array = _as_columns(self.mark_lists, self.n_pairs)[name == "inf"]
        else:
            array = np.array(self.rows if name == "delta" else self.class_list, dtype=np.int32)
        array.flags.writeable = False
        known[name] = array
        return array

    def annotated(
        self, *forms: str, languages: Iterable[int] | None = None, alike: Sequence[int] | None = None
    ) -> Self:
        """The same automaton with these normal forms, and these `languages` of its states if they are given.

        Args:
            forms: names, kept in addition to those known already.
            languages: one entry per state; equal ones for states that accept the same words, however numbered.
            alike: what the attribute `alike` is to be, if it is given.
        """
        known = vars(self) | {"forms": self.forms.union(forms)}
        if languages is not None:
            known["known_languages"] = numbered(languages)
        if alike is not None:
            known["alike"] = alike
        return self._with(known)

    def named(self, formula: str, translator: str | None = None, aps: tuple[str, ...] | None = None) -> Self:
        """What `replace` gives for these attributes, without asking again whether the arrays fit together.

        Args:
            formula: the text.
            translator: the construction; None: as before.
            aps: other names of the propositions; None: as before.
        """
        known = {name: value for name, value in vars(self).items() if name in _GIVEN}
        known["formula"] = formula
        if translator is not None:
            known["translator"] = translator
        if aps is not None:
            _check_names(aps)
            known["aps"] = aps
        return self._with(known)

    def with_marks(self, marks: Marks, n_pairs: int, acceptance: AcceptanceKind | None = None) -> Self:
        """The same states and letters with other marks, as in `mark_lists`; acceptance as before if it is None."""
        acceptance = acceptance or self.acceptance
        if self.is_listed and n_pairs <= MARKS_IN_WORD:
            known = {name: value for name, value in vars(self).items() if name in _LISTED}
            return self._with(known | {"mark_lists": marks, "n_pairs": n_pairs, "acceptance": acceptance})
        fin, inf = _as_columns(marks, n_pairs)
        return replace(self, fin=fin, inf=inf, acceptance=acceptance)

    def with_tables(self, rows: Sequence[Row], marks: Marks, initial_state: int, acceptance: AcceptanceKind) -> Self:
        """Other states without names, over the same letter classes and with as many pairs.

        Args:
            rows: next states, as in `rows`.
            marks: as in `mark_lists`.
            initial_state: the state before any letter is read.
            acceptance: what carries the marks.
        """
        if self.entries is None and len(rows) * self.n_classes <= FEW_ENTRIES and self.n_pairs <= MARKS_IN_WORD:
            return self.from_lists(
                self.aps,
                rows,
                marks,
                self.alphabet.classes,
                self.n_pairs,
                initial_state=initial_state,
                acceptance=acceptance,
                formula=self.formula,
                translator=self.translator,
                possible=self.possible,
            )
        fin, inf = _as_columns(marks, self.n_pairs)
        return replace(
            self,
            delta=np.array(rows, dtype=np.int32),
            fin=fin,
            inf=inf,
            initial_state=initial_state,
            acceptance=acceptance,
            state_names=None,
        )

    def has_marks_of(self, other: DRA) -> bool:
        """Whether another automaton, with the same states and letters, has the same marks."""
        if self.n_pairs != other.n_pairs:
            return False
        if self.is_listed and other.is_listed:
            return self.mark_lists == other.mark_lists
        return np.array_equal(self.fin, other.fin) and np.array_equal(self.inf, other.inf)

    @classmethod
    def _with(cls, known: Mapping[str, object]) -> Self:
        """An automaton with these attributes."""
        twin = object.__new__(cls)
        vars(twin).update(known)
        return twin

    @cached_property
    def n_states(self) -> int:
        """Number of states, deadlock and sinks included."""
        return int(self.delta.shape[0])

    @cached_property
    def n_classes(self) -> int:
        """Number of letter classes."""
        return int(self.delta.shape[1])

    @cached_property
    def n_pairs(self) -> int:
        """Number of Rabin pairs; with none, no word is accepted."""
        return int(self.fin.shape[0])

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
    def rows(self) -> list[list[int]]:
        """`delta` as lists, which are faster than arrays to look at entry by entry."""
        rows: list[list[int]] = self.delta.tolist()
        return rows

    @cached_property
    def class_list(self) -> list[int]:
        """`letter_class` as a list."""
        classes: list[int] = self.letter_class.tolist()
        return classes

    @cached_property
    def mark_lists(self) -> list[Any]:
        """`marks` as lists: an integer for each state, or a list of one per letter class for each."""
        marks: list[Any] = self.marks.tolist()
        return marks

    @cached_property
    def marks(self) -> npt.NDArray[np.int64] | npt.NDArray[np.object_]:
        """Marks as integers, shape as one pair of `fin`: bit 2i is Fin, bit 2i + 1 is Inf of pair i (as in HOA)."""
        kind = np.int64 if self.n_pairs <= MARKS_IN_WORD else object
        marks = np.zeros(self.fin.shape[1:], dtype=kind)
        for i, (fin, inf) in enumerate(zip(self.fin, self.inf, strict=True)):
            marks |= (fin.astype(kind) | inf.astype(kind) << 1) << (2 * i)
        return marks

    @cached_property
    def edge_marks(self) -> list[list[int]]:
        """`marks` seen on `delta[state, class]`, as lists; those of the entered state if acceptance is on states."""
        if self.acceptance == "transition":
            return self.mark_lists
        if self.is_listed:
            return [[self.mark_lists[target] for target in row] for row in self.rows]
        on_edges: list[list[int]] = self.marks[self.delta].tolist()
        return on_edges

    @cached_property
    def marked_graph(self) -> list[list[tuple[int, int]]]:
        """Per state, its distinct (next state, marks) in increasing order; marks as in `edge_marks`."""
        if self.entries is not None:
            return self.entries.marked(self.marks.tolist() if self.acceptance == "state" else None)
        return [
            sorted(set(zip(targets, marks, strict=True)))
            for targets, marks in zip(self.rows, self.edge_marks, strict=True)
        ]

    @cached_property
    def entries(self) -> Entries | None:
        """The different entries of the rows where there are so many columns that lists of all are slow, else None."""
        return None if self.is_listed else entries(self.delta, self.fin, self.inf)

    @property
    def successors(self) -> list[list[int]]:
        """The next states of each state in the order of the letter classes; repeated only where these are few."""
        return self.rows if self.entries is None else self.entries.successors()

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
    def alphabet(self) -> Alphabet:
        """Propositions and letter classes, for guards."""
        classes = self.class_list if "class_list" in vars(self) else self.letter_class
        return Alphabet(self.aps, classes, self.possible)

    @cached_property
    def letter_numbers(self) -> LetterNumbers:
        """The numbering of the letters."""
        return LetterNumbers(self.aps, self.possible)

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


_ARRAYS = frozenset({"delta", "letter_class", "fin", "inf"})
_SETTINGS = frozenset(field.name for field in fields(DRA) if field.init) - _ARRAYS
_LISTED = _SETTINGS | {"delta", "letter_class", "is_listed", "rows", "class_list", "n_states", "n_classes"}
"""of a listed automaton, what does not depend on its marks;"""
_GIVEN = _LISTED | {"fin", "inf", "mark_lists", "n_pairs"}
"""and what does not depend on names."""


def _as_columns(marks: Marks, n_pairs: int) -> tuple[BoolArray, BoolArray]:
    """Marks of states or edges as `fin` and `inf`."""
    words = np.array(marks, dtype=np.min_scalar_type((1 << 2 * n_pairs) - 1))
    signs = [np.array([words >> 2 * i + place & 1 for i in range(n_pairs)], dtype=np.bool_) for place in (0, 1)]
    fin, inf = (table.reshape(n_pairs, *words.shape) for table in signs)
    return fin, inf


def _takes_all(numbers: IntArray, n: int) -> bool:
    """Whether the numbers are exactly 0..n - 1."""
    if len(numbers) <= _FEW_LETTERS:
        return set(numbers.tolist()) == set(range(n))
    return int(numbers.view(np.uint32).max()) < n and bool(np.bincount(numbers, minlength=n).all())


def _check_names(aps: tuple[str, ...]) -> None:
    _check(len(set(aps)) == len(aps), "an atomic proposition is listed twice")
    _check(all(map(_is_name, aps)), "the name of an atomic proposition is no text that a file could hold")


def _is_name(name: object) -> bool:
    """Whether it is a text that UTF-8 can write: half a surrogate pair is none."""
    return isinstance(name, str) and (name.isascii() or name == name.encode("utf-8", "replace").decode("utf-8"))


def _check(condition: bool, message: str) -> None:
    if not condition:
        raise InvalidAutomatonError(message)


def _freeze(automaton: DRA, field: str, dtype: type[np.generic], shape: tuple[int | None, ...]) -> None:
    given = getattr(automaton, field)
    is_frozen = isinstance(given, np.ndarray) and given.dtype == dtype and given.base is None
    array = given if is_frozen and not given.flags.writeable else np.array(given, dtype=dtype)
    known = len(shape) - shape.count(None)  # the sizes that are known come last
    if array.ndim != len(shape) or array.shape[array.ndim - known :] != shape[len(shape) - known :]:
        raise InvalidAutomatonError(f"{field} has shape {array.shape}, expected {shape} (None: any size)")
    array.flags.writeable = False
    object.__setattr__(automaton, field, array)
