"""Reading the Hanoi Omega-Automata format, version 1: every deterministic automaton becomes a Rabin automaton.

References:
    T. Babiak, F. Blahoudek, A. Duret-Lutz, J. Klein, J. Kretinsky, D. Mueller, D. Parker, J. Strejcek, The Hanoi
    Omega-Automata Format, CAV 2015, doi 10.1007/978-3-319-21690-4_31.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from ltlc.automata.rabin import MAX_APS, BoolArray, RabinAutomaton
from ltlc.errors import AlphabetLimitExceeded, FileFormatError
from ltlc.formats.edges import MAX_TABLE, a_letter_of, all_letters, letters_of, letters_with, tabulate
from ltlc.formats.hoa_acceptance import NEVER, Atom, Condition, with_rabin_pairs
from ltlc.formats.hoa_parser import Document, HeaderItem, HoaSyntaxError, StateItem, parse_automaton, parse_label
from ltlc.formats.hoa_stream import Piece, pieces
from ltlc.ltl.formula import Formula

if TYPE_CHECKING:
    from lark import Token

_ONCE = ("states", "aps", "acceptance", "name")


def from_hoa(text: str) -> RabinAutomaton:
    """The automaton of an HOA text, which holds exactly one; see `read_hoa_stream`.

    Raises:
        FileFormatError: there is not exactly one automaton, or it cannot be read; names line and column.
        AlphabetLimitExceeded: it has too many propositions.
        StateLimitExceeded: Rabin pairs for its acceptance condition would need too many states.
    """
    stream = read_hoa_stream(text)
    automaton = next(stream, None)
    if automaton is None:
        raise FileFormatError("there is no automaton: an HOA file starts with 'HOA: v1' and ends with '--END--'")
    if next(stream, None) is not None:
        raise FileFormatError("there is more than one automaton; read_hoa_stream reads them one by one")
    return automaton


def read_hoa_stream(source: str | Iterable[str]) -> Iterator[RabinAutomaton]:
    """The automata of an HOA stream in order, each as soon as its --END-- has arrived.

    The automata must be deterministic. Any acceptance condition over Fin and Inf is turned into Rabin pairs; state
    numbers stay as they are unless a counter has to be added for that. An incomplete automaton gets one more state,
    a deadlock. Acceptance is on states iff no transition carries a mark (and `trans-acc` is not claimed). The header
    `name:` becomes `formula`, whether or not it is one.

    Args:
        source: the text, or its lines with their line ends, as an open file gives them.

    Raises:
        FileFormatError: an automaton cannot be read; names line and column.
        AlphabetLimitExceeded: it has too many propositions.
        StateLimitExceeded: Rabin pairs for its acceptance condition would need too many states.
    """
    for piece in pieces(io.StringIO(source) if isinstance(source, str) else source):
        yield _Reader(piece).automaton()


@dataclass
class _Header:
    states: Token | None = None
    starts: list[Token] = field(default_factory=list)
    aps: list[str] = field(default_factory=list)
    aliases: dict[str, int] = field(default_factory=dict)
    n_sets: int = 0
    condition: Condition = NEVER
    name: str | None = None
    properties: set[str] = field(default_factory=set)


@dataclass
class _Body:
    """States as they were listed: edges with the same source, target and marks are merged."""

    names: dict[int, str] = field(default_factory=dict)
    state_marks: dict[int, frozenset[int]] = field(default_factory=dict)
    sources: list[int] = field(default_factory=list)
    targets: list[int] = field(default_factory=list)
    guards: list[int] = field(default_factory=list)
    edge_marks: list[frozenset[int]] = field(default_factory=list)
    places: list[Token] = field(default_factory=list)
    """where the target of each edge is written."""


class _Reader:
    """Reads the text of one automaton; messages count lines and columns in the whole stream."""

    def __init__(self, piece: Piece) -> None:
        self.piece = piece
        self.header = _Header()
        self.body = _Body()
        self.labels: dict[str, int] = {}

    def automaton(self) -> RabinAutomaton:
        try:
            document = parse_automaton(self.piece.text)
        except HoaSyntaxError as error:
            self._fail_at(error.line, error.column, error.message)
        self._read_header(document)
        for state in document.states:
            self._read_state(state)
        return self._assemble()

    def _fail(self, place: Token, message: str) -> NoReturn:
        self._fail_at(place.line or 1, place.column or 1, message)

    def _fail_at(self, line: int, column: int, message: str) -> NoReturn:
        if line == 1:
            column += self.piece.column - 1
        raise FileFormatError(f"line {line + self.piece.line - 1}, column {column}: {message}") from None

    def _int(self, token: Token) -> int:
        if len(token) > 10 or int(token) >= 1 << 31:
            self._fail(token, "numbers in HOA are below 2^31")
        return int(token)

    # The header

    def _read_header(self, document: Document) -> None:
        version = document.version
        if version != "v1" and not version.startswith("v1."):
            self._fail(version, f"this is HOA {version}; only version v1 can be read")
        by_kind: dict[str, list[HeaderItem]] = {}
        for item in document.headers:
            by_kind.setdefault(item.kind, []).append(item)
            if item.kind in _ONCE and len(by_kind[item.kind]) > 1:
                self._fail(item.keyword, f"the header {item.keyword} occurs twice")
            if item.kind == "other" and item.keyword[0].isupper():
                self._fail(item.keyword, f"the header {item.keyword} is not known, and it may change what is accepted")
        if "acceptance" not in by_kind:
            self._fail(version, "the header Acceptance: is missing")
        # Aliases may be written before the propositions they refer to.
        for kind, read in (
            ("states", self._read_states),
            ("start", self._read_start),
            ("aps", self._read_aps),
            ("alias", self._read_alias),
            ("acceptance", self._read_acceptance),
            ("name", self._read_name),
            ("properties", self._read_properties),
        ):
            for item in by_kind.get(kind, ()):
                read(item.keyword, *item.values)

    def _read_states(self, _keyword: Token, count: Token) -> None:
        self._int(count)
        self.header.states = count

    def _read_start(self, keyword: Token, state: Token, *more: Token) -> None:
        if more:
            self._fail(more[0], "universal branching: an alternating automaton is not deterministic")
        if self.header.starts:
            self._fail(keyword, "a second initial state: the automaton is not deterministic")
        self._int(state)
        self.header.starts.append(state)

    def _read_aps(self, _keyword: Token, count: Token, *names: Token) -> None:
        if self._int(count) != len(names):
            self._fail(count, f"AP: announces {count} propositions, and {len(names)} names follow")
        if len(names) > MAX_APS:
            raise AlphabetLimitExceeded(f"{len(names)} propositions; at most {MAX_APS} are supported")
        for token in names:
            name = _unquote(token)
            if not name:
                self._fail(token, "a proposition needs a name")
            if name in self.header.aps:
                self._fail(token, f"the proposition {token} is listed twice")
            self.header.aps.append(name)

    def _read_alias(self, _keyword: Token, alias: Token, expression: Formula) -> None:
        if alias in self.header.aliases:
            self._fail(alias, f"the alias {alias} is defined twice")
        self.header.aliases[str(alias)] = self._letters(expression, alias)

    def _read_acceptance(self, _keyword: Token, count: Token, condition: Condition) -> None:
        self.header.n_sets = self._int(count)
        for atom in sorted(frozenset[Atom]().union(*condition)):
            if atom.number >= self.header.n_sets:
                self._fail(count, f"the condition speaks of set {atom.number}, the number of sets is {count}")
        self.header.condition = condition

    def _read_name(self, _keyword: Token, name: Token) -> None:
        self.header.name = _unquote(name)

    def _read_properties(self, _keyword: Token, *names: Token) -> None:
        self.header.properties.update(map(str, names))

    # Labels

    def _letters(self, expression: Formula, place: Token) -> int:
        n_aps = len(self.header.aps)

        def atom(name: str) -> int:
            if name.startswith("@"):
                if name not in self.header.aliases:
                    self._fail(place, f"the alias {name} is not defined before it is used")
                return self.header.aliases[name]
            if len(name) > 10 or int(name) >= n_aps:
                self._fail(place, f"there is no proposition {name[:20]}, AP: lists {n_aps}")
            return letters_with(int(name), n_aps)

        return letters_of(expression, atom, n_aps)

    def _label(self, token: Token) -> int:
        text = str(token)
        if text not in self.labels:
            try:
                formula = parse_label(text)
            except HoaSyntaxError as error:
                column = error.column + (token.column or 1) - 1 if error.line == 1 else error.column
                self._fail_at((token.line or 1) + error.line - 1, column, error.message)
            self.labels[text] = self._letters(formula, token)
        return self.labels[text]

    # The body

    def _marks(self, tokens: Sequence[Token]) -> frozenset[int]:
        for token in tokens:
            if self._int(token) >= self.header.n_sets:
                self._fail(token, f"there is no acceptance set {token}, Acceptance: announces {self.header.n_sets}")
        return frozenset(map(int, tokens))

    def _read_state(self, item: StateItem) -> None:
        state = self._int(item.number)
        if state in self.body.state_marks:
            self._fail(item.number, f"state {state} is listed twice")
        if item.name is not None:
            self.body.names[state] = _unquote(item.name)
        self.body.state_marks[state] = self._marks(item.marks)
        self._read_edges(state, item)

    def _read_edges(self, state: int, item: StateItem) -> None:
        n_letters = 1 << len(self.header.aps)
        implicit = item.label is None and all(edge.label is None for edge in item.edges)
        if implicit and len(item.edges) not in (0, n_letters):
            n_edges = len(item.edges)
            self._fail(item.keyword, f"state {state} has {n_edges} edges without label; there are {n_letters} letters")
        merged: dict[tuple[int, frozenset[int]], tuple[int, Token]] = {}
        for i, edge in enumerate(item.edges):
            place, *others = edge.targets
            if others:
                self._fail(others[0], "universal branching: an alternating automaton is not deterministic")
            if edge.label is not None and item.label is not None:
                self._fail(edge.label, "the state has a label already, so its edges have none")
            label = edge.label if item.label is None else item.label
            if label is None and not implicit:
                self._fail(place, "this edge has no label, others of the same state have one")
            letters = 1 << i if label is None else self._label(label)
            key = (self._int(place), self._marks(edge.marks))
            merged[key] = (merged.get(key, (0, place))[0] | letters, place)
        taken = 0
        for (target, marks), (letters, place) in merged.items():
            if letters & taken:
                letter = a_letter_of(letters & taken, self.header.aps)
                self._fail(place, f"not deterministic: state {state} has a second edge for the letter {letter}")
            taken |= letters
            if letters:
                self._add_edge(state, target, letters, marks, place)

    def _add_edge(self, source: int, target: int, letters: int, marks: frozenset[int], place: Token) -> None:
        self.body.sources.append(source)
        self.body.targets.append(target)
        self.body.guards.append(letters)
        self.body.edge_marks.append(marks)
        self.body.places.append(place)

    # The whole

    def _assemble(self) -> RabinAutomaton:
        header, body = self.header, self.body
        n_states = len(body.state_marks)
        if header.states is not None and int(header.states) != n_states:
            self._fail(header.states, f"States: announces {header.states}, and {n_states} are listed")
        unlisted = next((q for q in range(n_states) if q not in body.state_marks), None)
        if unlisted is not None:
            self._fail_at(1, 1, f"state {unlisted} is not listed, though a state with a higher number is")
        for place in header.starts + body.places:
            if int(place) >= n_states:
                self._fail(place, f"there is no state {place}, {n_states} are listed")
        if not header.starts or not n_states:
            return self._empty()
        return self._completed(n_states)

    def _empty(self) -> RabinAutomaton:
        """Without an initial state no word is accepted."""
        marks = np.zeros((0, 1), dtype=np.bool_)
        letters = np.zeros(1 << len(self.header.aps), dtype=np.int32)
        delta = np.zeros((1, 1), dtype=np.int32)
        return RabinAutomaton(tuple(self.header.aps), delta, letters, marks, marks, formula=self.header.name)

    def _completed(self, n_states: int) -> RabinAutomaton:
        header, body = self.header, self.body
        covered = [0] * n_states
        for source, letters in zip(body.sources, body.guards, strict=True):
            covered[source] |= letters
        universe = all_letters(len(header.aps))
        complete = all(letters == universe for letters in covered)
        letter_class, edge = tabulate(len(header.aps), n_states + (not complete), body.sources, body.guards)
        if edge.size * 2 * len(header.condition) > MAX_TABLE:
            n_pairs = len(header.condition)
            raise AlphabetLimitExceeded(f"tables of {edge.size} transitions and {n_pairs} pairs are too large")
        targets = np.array([*body.targets, n_states], dtype=np.int32)  # the last one is taken where edge is -1
        on_transitions = any(body.edge_marks) or (
            "trans-acc" in header.properties and "state-acc" not in header.properties
        )
        names = tuple(body.names.get(q, str(q)) for q in range(n_states + (not complete))) if body.names else None
        no_marks = np.zeros((0, *(edge.shape if on_transitions else edge.shape[:1])), dtype=np.bool_)
        skeleton = RabinAutomaton(
            aps=tuple(header.aps),
            delta=targets[edge],
            letter_class=letter_class,
            fin=no_marks,
            inf=no_marks,
            initial_state=int(header.starts[0]),
            acceptance="transition" if on_transitions else "state",
            formula=header.name,
            state_names=names,
        )
        everything = edge >= 0 if on_transitions else np.arange(len(edge)) < n_states

        def members(atom: Atom) -> BoolArray:
            if on_transitions:
                sets = [marks | body.state_marks[q] for marks, q in zip(body.edge_marks, body.sources, strict=True)]
                marked = np.array([*(atom.number in numbers for numbers in sets), False], dtype=np.bool_)[edge]
            else:
                by_state = [atom.number in body.state_marks.get(q, ()) for q in range(len(edge))]
                marked = np.array(by_state, dtype=np.bool_)
            return everything & ~marked if atom.complement else marked

        return with_rabin_pairs(skeleton, header.condition, members, everything)


def _unquote(token: Token) -> str:
    return re.sub(r"\\(.)", r"\1", token[1:-1], flags=re.DOTALL)
