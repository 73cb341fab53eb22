"""The tables of a deterministic automaton: arrays, or lists where they have few entries.

What the translator builds is mostly small, and lists are faster there; the arrays are made when they are first asked
for, and numpy is imported then.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Literal, Self, TypeAlias

from ltlc.arrays import BoolArray, IntArray, Numbers, np, npt
from ltlc.automata.alphabet import Alphabet
from ltlc.automata.partition import numbered
from ltlc.automata.possible import LetterNumbers, Possible
from ltlc.automata.wide import Entries, entries, joined_marks
from ltlc.errors import InvalidAutomatonError

AcceptanceKind = Literal["state", "transition"]
Row: TypeAlias = "Sequence[int] | npt.NDArray[Any]"
Marks: TypeAlias = "Sequence[int] | Sequence[Row]"
"""An integer for each state, or one per letter class for each; as in `Tables.mark_lists`."""
MARKS_IN_WORD = 31
"""pairs of marks fit into a machine word."""
FEW_ENTRIES = 4096
"""of a table are faster looked at one by one, in lists."""
_FEW_LETTERS = 64
"""are looked at faster one by one than as an array."""


@dataclass(frozen=True, eq=False, repr=False)
class Tables:
    """Next states and marks of each state and letter class; `DRA` says what the attributes are.

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

    def with_tables(
        self, rows: Sequence[Row], marks: Marks, n_pairs: int, initial_state: int, acceptance: AcceptanceKind
    ) -> Self:
        """Other states, without names, over the same letter classes.

        Args:
            rows: next states, as in `rows`.
            marks: as in `mark_lists`.
            n_pairs: number of Rabin pairs.
            initial_state: the state before any letter is read.
            acceptance: what carries the marks.
        """
        if self.entries is None and len(rows) * self.n_classes <= FEW_ENTRIES and n_pairs <= MARKS_IN_WORD:
            return self.from_lists(
                self.aps,
                rows,
                marks,
                self.alphabet.classes,
                n_pairs,
                initial_state=initial_state,
                acceptance=acceptance,
                formula=self.formula,
                translator=self.translator,
                possible=self.possible,
            )
        fin, inf = _as_columns(marks, n_pairs)
        return replace(
            self,
            delta=np.array(rows, dtype=np.int32),
            fin=fin,
            inf=inf,
            initial_state=initial_state,
            acceptance=acceptance,
            state_names=None,
        )

    def has_marks_of(self, other: Tables) -> bool:
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
        return joined_marks(self.fin, self.inf, np.dtype(np.int64 if self.n_pairs <= MARKS_IN_WORD else object))

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
    def alphabet(self) -> Alphabet:
        """Propositions and letter classes, for guards."""
        classes = self.class_list if "class_list" in vars(self) else self.letter_class
        return Alphabet(self.aps, classes, self.possible)

    @cached_property
    def letter_numbers(self) -> LetterNumbers:
        """The numbering of the letters."""
        return LetterNumbers(self.aps, self.possible)


_ARRAYS = frozenset({"delta", "letter_class", "fin", "inf"})
_SETTINGS = frozenset(field.name for field in fields(Tables) if field.init) - _ARRAYS
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


def _freeze(tables: Tables, field: str, dtype: type[np.generic], shape: tuple[int | None, ...]) -> None:
    given = getattr(tables, field)
    is_frozen = isinstance(given, np.ndarray) and given.dtype == dtype and given.base is None
    array = given if is_frozen and not given.flags.writeable else np.array(given, dtype=dtype)
    known = len(shape) - shape.count(None)  # the sizes that are known come last
    if array.ndim != len(shape) or array.shape[array.ndim - known :] != shape[len(shape) - known :]:
        raise InvalidAutomatonError(f"{field} has shape {array.shape}, expected {shape} (None: any size)")
    array.flags.writeable = False
    object.__setattr__(tables, field, array)
