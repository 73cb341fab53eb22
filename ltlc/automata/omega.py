"""Automata over infinite words with any acceptance condition, deterministic or not: for exchange with other tools."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from ltlc.arrays import IntArray, np
from ltlc.automata.acceptance import NEVER, Acceptance, Clause, TooManyClausesError, conjunction, disjunction
from ltlc.automata.alphabet import Alphabet
from ltlc.automata.emerson_lei import EmersonLei, LetterEdge, localized, merged
from ltlc.automata.emptiness import accepting_nodes
from ltlc.automata.output import Output
from ltlc.automata.possible import Possible
from ltlc.automata.rabin import DRA
from ltlc.automata.rabin_pairs import to_rabin
from ltlc.budget import MAX_STATES, Budget
from ltlc.errors import InvalidArgumentError, InvalidAutomatonError, StateLimitExceeded
from ltlc.graph import bits

_CLAUSES = 1000
"""A condition is not written out with more clauses than this."""


@dataclass(frozen=True, eq=False, repr=False)
class OmegaAutomaton(Output):
    """An automaton whose acceptance sets are on transitions, with any condition on what a run takes infinitely often.

    A word is accepted iff one of its runs is; a deterministic automaton has at most one run on a word.

    Attributes:
        aps: the propositions; bit i of a letter is the i-th.
        letter_class: shape (n_letters,), int32; entry = class of the letter.
        edges: per state; the letters of an edge are letter classes, bit k of its marks is acceptance set k. A letter
            without an edge ends the run.
        n_sets: number of acceptance sets.
        condition: in the form of `ltlc.automata.acceptance`.
        form: its name, such as "emerson-lei".
        initial_states: where runs begin.
        formula: the formula it was compiled from, as text.
        possible: which letters are possible; None: all 2**len(aps).

    Raises:
        InvalidAutomatonError: a state, a letter class or a set is out of range.

    Example:
        >>> import ltlc
        >>> fair = ltlc.compile("GF a & GF b", form="emerson-lei")
        >>> fair.n_states, fair.accepts([], [{"a"}, {"b"}]), fair.accepts([], [{"a"}])
        (1, True, False)
    """

    aps: tuple[str, ...]
    letter_class: IntArray
    edges: tuple[tuple[LetterEdge, ...], ...]
    n_sets: int
    condition: Acceptance
    form: str
    initial_states: tuple[int, ...] = (0,)
    formula: str | None = None
    possible: Possible | None = None

    acceptance = "transition"
    formats = ("hoa",)
    """The names of the formats that it is written in."""

    def __post_init__(self) -> None:
        n, classes = len(self.edges), self.n_classes
        used = 0
        for clause in self.condition:
            used |= clause.fin | clause.inf
            for mark, partners in clause.promises:
                used |= mark | partners
        fits = all(0 <= q < n for q in self.initial_states) and used < 1 << self.n_sets
        fits = fits and len(self.letter_class) == self.alphabet.numbers.size and n > 0
        fits = fits and all(
            0 <= e.target < n and 0 <= e.letters < 1 << classes and 0 <= e.marks < 1 << self.n_sets
            for row in self.edges
            for e in row
        )
        if not fits:
            raise InvalidAutomatonError("a state, a letter class or an acceptance set is out of range")

    @property
    def n_states(self) -> int:
        """Number of states; states that are missing because no word is accepted from them are not counted."""
        return len(self.edges)

    @property
    def n_classes(self) -> int:
        """Number of letter classes."""
        return int(np.max(self.letter_class)) + 1

    @cached_property
    def alphabet(self) -> Alphabet:
        """Propositions and letter classes, for guards."""
        return Alphabet(self.aps, self.letter_class, self.possible)

    @cached_property
    def is_deterministic(self) -> bool:
        """Whether there is one initial state, and one edge at most for a letter in each state."""
        return len(self.initial_states) == 1 and all(
            sum(e.letters.bit_count() for e in row) == _union(row).bit_count() for row in self.edges
        )

    @property
    def is_complete(self) -> bool:
        """Whether there is an edge for every letter in each state."""
        return all(_union(row) == (1 << self.n_classes) - 1 for row in self.edges)

    @property
    def size(self) -> str:
        """Size and kind for a reader."""
        sets = "1 acceptance set" if self.n_sets == 1 else f"{self.n_sets} acceptance sets"
        kind = "" if self.is_deterministic else ", nondeterministic"
        return f"{super().size}, {sets}, {self.form}{kind}"

    def accepts(self, prefix: Sequence[Iterable[str]] = (), cycle: Sequence[Iterable[str]] = ((),)) -> bool:
        """Whether the word `prefix` followed by `cycle` for ever is accepted; see `DRA.accepts`.

        Raises:
            UnknownNameError: a name is not one of `aps`.
            InvalidArgumentError: the cycle is empty, or a letter is no set of names.
        """
        if not cycle:
            raise InvalidArgumentError("the cycle of a lasso word needs at least one letter")
        word = [int(self.letter_class[self._letters.letter(letter)]) for letter in (*prefix, *cycle)]
        number = {(q, 0): i for i, q in enumerate(self.initial_states)}
        order = list(number)
        rows: list[list[tuple[int, int]]] = []
        for state, position in order:  # grows while it is read
            following = position + 1 if position + 1 < len(word) else len(word) - len(cycle)
            rows.append([])
            for edge in self.edges[state]:
                if edge.letters >> word[position] & 1:
                    node = (edge.target, following)
                    if node not in number:
                        number[node] = len(order)
                        order.append(node)
                    rows[-1].append((number[node], edge.marks))
        return bool(accepting_nodes(rows, self.condition))

    @cached_property
    def _letters(self) -> DRA:
        """An automaton with the same letters."""
        marks = np.zeros((0, 1), dtype=np.bool_)
        table = np.zeros((1, self.n_classes), dtype=np.int32)
        return DRA(self.aps, table, self.letter_class, marks, marks, possible=self.possible)

    def to_rabin(self, *, max_states: int = MAX_STATES) -> DRA:
        """A Rabin automaton for the same words, of a deterministic automaton.

        Raises:
            InvalidArgumentError: it is not deterministic.
            StateLimitExceeded: Rabin pairs need more states.
        """
        if not self.is_deterministic:
            raise InvalidArgumentError(
                "the automaton is not deterministic; ltlc.translate.determinise makes a deterministic one of it"
            )
        sink, everything = self.n_states, (1 << self.n_classes) - 1
        rows = [list(row) for row in self.edges]
        for row in rows:
            left = everything & ~_union(row)
            if left:
                row.append(LetterEdge(left, sink, 0))
        conditions = [_without_promises(self.condition)] * sink
        if any(edge.target == sink for row in rows for edge in row):
            rows.append([LetterEdge(everything, sink, 0)])
            conditions.append(())
        automaton = localized(EmersonLei(tuple(tuple(merged(row)) for row in rows), tuple(conditions)))
        return to_rabin(
            automaton,
            self.aps,
            self.letter_class,
            Budget(self.formula or "the automaton", max_states),
            initial_state=self.initial_states[0],
            possible=self.possible,
        )


def _without_promises(condition: Acceptance) -> Acceptance:
    """The condition with clauses of Fin and Inf alone.

    Raises:
        StateLimitExceeded: there are too many of them.
    """
    result: Acceptance = NEVER
    try:
        for fin, inf, promises in condition:
            part: Acceptance = (Clause(fin, inf),)
            for mark, partners in promises:
                part = conjunction(part, (Clause(mark, 0), *(Clause(0, 1 << i) for i in bits(partners))), _CLAUSES)
            result = disjunction(result, part, _CLAUSES)
    except TooManyClausesError:
        raise StateLimitExceeded(f"the acceptance condition has more than {_CLAUSES} terms as a disjunction") from None
    return result


def edges_of(automaton: DRA) -> tuple[tuple[LetterEdge, ...], ...]:
    """The edges of a Rabin automaton with marks as in `DRA.marks`."""
    return tuple(
        tuple(merged((1 << c, target, marks) for c, (target, marks) in enumerate(zip(row, seen, strict=True))))
        for row, seen in zip(automaton.rows, automaton.edge_marks, strict=True)
    )


def aligned(automaton: EmersonLei) -> tuple[tuple[tuple[LetterEdge, ...], ...], int, Acceptance, tuple[int, ...]]:
    """One generalized Rabin condition for all strong components, on the same graph.

    Clause k of the condition is Fin of one set and Inf of several. Each component takes the sets of clause k for its
    own k-th clause, with sets that it does not need on all of its edges.

    Args:
        automaton: `localized`, without promises.

    Returns:
        The edges, the number of sets, the condition, and the number of Inf sets of each clause.
    """
    component = automaton.component
    cyclic = {component[q] for q, row in enumerate(automaton.edges) for e in row if component[e.target] == component[q]}
    clauses = {component[q]: automaton.acceptance[q] for q in range(automaton.n_states) if component[q] in cyclic}
    n_clauses = max((len(own) for own in clauses.values()), default=0)
    widths = [
        max((own[k].inf.bit_count() for own in clauses.values() if k < len(own)), default=0) for k in range(n_clauses)
    ]
    first = [sum(widths[:k]) + k for k in range(n_clauses)]

    def renamed(here: int, marks: int) -> int:
        result = 0
        for k, (start, width) in enumerate(zip(first, widths, strict=True)):
            if k >= len(clauses[here]):
                result |= 1 << start
                continue
            fin, inf, _ = clauses[here][k]
            own = [1 << i for i in range(inf.bit_length()) if inf >> i & 1]
            seen = [place >= len(own) or bool(marks & own[place]) for place in range(width)]
            result |= bool(marks & fin) << start | sum(1 << start + 1 + place for place, s in enumerate(seen) if s)
        return result

    edges = tuple(
        tuple(
            merged(
                (e.letters, e.target, renamed(component[q], e.marks) if component[e.target] == component[q] else 0)
                for e in row
            )
        )
        for q, row in enumerate(automaton.edges)
    )
    condition = tuple(
        Clause(1 << start, sum(1 << start + 1 + place for place in range(width)))
        for start, width in zip(first, widths, strict=True)
    )
    return edges, sum(widths) + n_clauses, condition, tuple(widths)


def shared(automaton: EmersonLei) -> tuple[tuple[tuple[LetterEdge, ...], ...], int, Acceptance] | None:
    """The edges, number of sets and condition, if all strong components have the same one; else None.

    Args:
        automaton: `localized`.
    """
    component = automaton.component
    conditions = {
        automaton.acceptance[q]
        for q, row in enumerate(automaton.edges)
        for e in row
        if component[e.target] == component[q]
    }
    if len(conditions) > 1:
        return None
    condition = next(iter(conditions), ())
    used = 0
    for clause in condition:
        used |= clause.fin | clause.inf
        for mark, partners in clause.promises:
            used |= mark | partners
    place = {i: k for k, i in enumerate(i for i in range(used.bit_length()) if used >> i & 1)}

    def renamed(marks: int) -> int:
        return sum(1 << k for i, k in place.items() if marks >> i & 1)

    edges = tuple(tuple(merged((e.letters, e.target, renamed(e.marks)) for e in row)) for row in automaton.edges)
    clauses = tuple(
        Clause(renamed(c.fin), renamed(c.inf), tuple((renamed(m), renamed(p)) for m, p in c.promises))
        for c in condition
    )
    return edges, len(place), clauses


def _union(row: Iterable[LetterEdge]) -> int:
    union = 0
    for edge in row:
        union |= edge.letters
    return union
