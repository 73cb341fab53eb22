"""Reading the Hanoi Omega-Automata format, version 1: every deterministic automaton becomes a Rabin automaton.

References:
    T. Babiak, F. Blahoudek, A. Duret-Lutz, J. Klein, J. Kretinsky, D. Mueller, D. Parker, J. Strejcek, The Hanoi
    Omega-Automata Format, CAV 2015, doi 10.1007/978-3-319-21690-4_31.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from ltlc.automata.acceptance import NEVER, Acceptance, TooManyClausesError
from ltlc.automata.alphabet import truth_table
from ltlc.automata.emerson_lei import Edge, EmersonLei, localized
from ltlc.automata.rabin import MAX_APS, RabinAutomaton
from ltlc.automata.rabin_pairs import Way, to_rabin
from ltlc.budget import MAX_STATES, NO_LIMIT, Budget, check_time
from ltlc.errors import AlphabetLimitExceeded, FileFormatError, StateLimitExceeded
from ltlc.formats.edges import MAX_TABLE, a_letter_of, all_letters, guard_classes, letters_of, letters_with
from ltlc.formats.hoa_acceptance import MAX_CLAUSES, AcceptanceSet, acceptance_of, sets_of
from ltlc.formats.hoa_claims import Evidence, failing_claim
from ltlc.formats.hoa_names import is_misnamed, rabin
from ltlc.formats.hoa_parser import Header, HeaderItem, HoaSyntaxError, StateItem, parse_body, parse_header, parse_label
from ltlc.formats.hoa_stream import Piece, pieces
from ltlc.ltl.formula import FALSE, Formula

if TYPE_CHECKING:
    from lark import Token

_ONCE = ("states", "aps", "acceptance", "name")
_MAX_MARKS = 1 << 24
"""entries of the largest table of an automaton with counters, one for each state, letter class and pair."""
_NUMBER = re.compile(r"0|[1-9][0-9]*")


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
    `name:` becomes `formula`, whether or not it is one. What the headers `properties:` and `acc-name:` claim must hold,
    but for `stutter-invariant`, `tight` and names that HOA does not define: a claim that fails tells that something was
    lost.

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
    acceptance: Token | None = None
    condition: Formula = FALSE
    name: str | None = None
    claims: dict[str, Token] = field(default_factory=dict)
    """properties, with the place of each."""


@dataclass
class _Body:
    """States as they were listed: edges with the same source, target and marks are merged."""

    names: dict[int, str] = field(default_factory=dict)
    places: dict[int, int] = field(default_factory=dict)
    """where the number of each state is written."""
    state_marks: dict[int, frozenset[int]] = field(default_factory=dict)
    covered: dict[int, int] = field(default_factory=dict)
    """letters of the edges of each state."""
    sources: list[int] = field(default_factory=list)
    targets: list[int] = field(default_factory=list)
    guards: list[int] = field(default_factory=list)
    marks: list[frozenset[int]] = field(default_factory=list)
    """marks of each edge, those of its source included."""
    target_places: list[int] = field(default_factory=list)
    """where the target of each edge is written."""
    on_edges: bool = False
    """whether an edge has marks of its own."""


class _Reader:
    """Reads the text of one automaton; messages count lines and columns in the whole stream."""

    def __init__(self, piece: Piece) -> None:
        self.piece = piece
        self.header = _Header()
        self.body = _Body()
        self.labels: dict[str, int] = {}
        self.known_marks: dict[str | None, frozenset[int]] = {None: frozenset()}

    def automaton(self) -> RabinAutomaton:
        try:
            self._read_header(parse_header(self.piece.text, self.piece.body))
            for state in parse_body(self.piece.text, self.piece.body):
                check_time()
                self._read_state(state)
        except HoaSyntaxError as error:
            self._fail(error.position, error.message)
        return self._assemble()

    def _fail(self, place: Token | int, message: str) -> NoReturn:
        position = place if isinstance(place, int) else place.start_pos or 0
        line, column = self._line(position), position - self.piece.text.rfind("\n", 0, position)
        if line == self.piece.line:
            column += self.piece.column - 1
        raise FileFormatError(f"line {line}, column {column}: {message}") from None

    def _line(self, position: int) -> int:
        return self.piece.text.count("\n", 0, position) + self.piece.line

    def _int(self, text: str, place: Token | int) -> int:
        if len(text) > 10 or int(text) >= 1 << 31:
            self._fail(place, "numbers in HOA are below 2^31")
        return int(text)

    def _deny(self, claim: str, place: int, found: str) -> None:
        """Fail if the file claims a property that something in it contradicts."""
        if claim in self.header.claims:
            line = self._line(self.header.claims[claim].start_pos or 0)
            self._fail(place, f"{found}, though line {line} claims `{claim}`; the file is damaged or wrong")

    # The header

    def _read_header(self, parsed: Header) -> None:
        version = parsed.version
        if version != "v1" and not version.startswith("v1."):
            self._fail(version, f"this is HOA {version}; only version v1 can be read")
        by_kind: dict[str, list[HeaderItem]] = {}
        for item in parsed.items:
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
            ("other", self._read_other),
        ):
            for item in by_kind.get(kind, ()):
                read(item.keyword, *item.values)

    def _read_states(self, _keyword: Token, count: Token) -> None:
        self._int(count, count)
        self.header.states = count

    def _read_start(self, keyword: Token, state: Token, *more: Token) -> None:
        if more:
            self._fail(more[0], "universal branching: an alternating automaton is not deterministic")
        if self.header.starts:
            self._fail(keyword, "a second initial state: the automaton is not deterministic")
        self._int(state, state)
        self.header.starts.append(state)

    def _read_aps(self, _keyword: Token, count: Token, *names: Token) -> None:
        if self._int(count, count) != len(names):
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

    def _read_acceptance(self, _keyword: Token, count: Token, condition: Formula) -> None:
        self.header.n_sets = self._int(count, count)
        for number, _ in sets_of(condition):
            if number >= self.header.n_sets:
                self._fail(count, f"the condition speaks of set {number}, the number of sets is {count}")
        self.header.acceptance, self.header.condition = count, condition

    def _read_name(self, _keyword: Token, name: Token) -> None:
        self.header.name = _unquote(name)

    def _read_properties(self, _keyword: Token, *names: Token) -> None:
        for name in names:
            self.header.claims.setdefault(str(name), name)

    def _read_other(self, keyword: Token, *words: Token | None) -> None:
        if keyword == "acc-name:" and words and is_misnamed(self.header.condition, [str(word) for word in words]):
            name = " ".join(map(str, words))
            self._fail(keyword, f"the condition in the header Acceptance: is not what is called {name}")

    # Labels

    def _letters(self, expression: Formula, place: Token | int) -> int:
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

    def _label(self, text: str, place: int) -> int:
        if text not in self.labels:
            try:
                self.labels[text] = self._letters(parse_label(text), place)
            except HoaSyntaxError as error:
                self._fail(place + error.position, error.message)
        return self.labels[text]

    # The body

    def _marks(self, match: re.Match[str], group: str) -> frozenset[int]:
        text = match[group]
        if text not in self.known_marks:
            for mark in _NUMBER.finditer(text):
                place = match.start(group) + mark.start()
                if self._int(mark[0], place) >= self.header.n_sets:
                    n_sets = self.header.n_sets
                    self._fail(place, f"there is no acceptance set {mark[0]}, Acceptance: announces {n_sets}")
            self.known_marks[text] = frozenset(map(int, _NUMBER.findall(text)))
        return self.known_marks[text]

    def _read_state(self, item: StateItem) -> None:
        head, body = item.head, self.body
        place = head.start("state")
        state = self._int(head["state"], place)
        if state in body.places:
            self._fail(place, f"state {state} is listed twice")
        body.places[state] = place
        if head["name"] is not None:
            body.names[state] = _unquote(head["name"])
        marks = body.state_marks[state] = self._marks(head, "state_marks")
        if marks:
            self._deny("trans-acc", head.start("state_marks"), f"state {state} has marks")
        self._check_labels(state, item)
        body.covered[state] = self._read_edges(state, item, marks)

    def _check_labels(self, state: int, item: StateItem) -> None:
        """Check where labels are: at the state, at every edge, or nowhere if there is an edge for every letter."""
        head, edges, n_letters = item.head, item.edges, 1 << len(self.header.aps)
        with_label = next((edge for edge in edges if edge["label"] is not None), None)
        if head["state_label"] is not None:
            place = head.start("state_label")
            self._deny("trans-labels", place, f"state {state} has a label")
            self._deny("implicit-labels", place, f"state {state} has a label")
            if with_label is not None:
                self._fail(with_label.start("label"), "the state has a label already, so its edges have none")
        elif with_label is not None:
            self._deny("state-labels", with_label.start("label"), "this edge has a label")
            self._deny("implicit-labels", with_label.start("label"), "this edge has a label")
            without = next((edge for edge in edges if edge["label"] is None), None)
            if without is not None:
                self._fail(without.start("target"), "this edge has no label, others of the same state have one")
        elif edges:
            place = head.start("STATE")
            for claim in ("state-labels", "explicit-labels"):
                self._deny(claim, place, f"state {state} has neither a label nor edges with labels")
            if len(edges) != n_letters:
                self._fail(place, f"state {state} has {len(edges)} edges without label; there are {n_letters} letters")

    def _read_edges(self, state: int, item: StateItem, state_marks: frozenset[int]) -> int:
        """Take in the edges of a state; returns their letters."""
        state_label = item.head["state_label"]
        merged: dict[tuple[int, frozenset[int]], tuple[int, re.Match[str]]] = {}
        for i, edge in enumerate(item.edges):
            label, target, conjuncts, marks_text = edge.group("label", "target", "conjuncts", "marks")
            if conjuncts:
                place = edge.start("conjuncts") + _NUMBER.search(conjuncts).start()  # type: ignore[union-attr]
                self._fail(place, "universal branching: an alternating automaton is not deterministic")
            if label is not None:
                letters = self.labels.get(label) or self._label(label, edge.start("label"))
            elif state_label is not None:
                letters = self._label(state_label, item.head.start("state_label"))
            else:
                letters = 1 << i
            number = self._int(target, edge.start("target"))
            key = (number, self._marks(edge, "marks") if marks_text else frozenset())
            merged[key] = (merged[key][0] | letters if key in merged else letters, edge)
        taken = 0
        for (target, marks), (letters, edge) in merged.items():
            if letters & taken:
                letter = a_letter_of(letters & taken, self.header.aps)
                place = edge.start("target")
                self._fail(place, f"not deterministic: state {state} has a second edge for the letter {letter}")
            taken |= letters
            if letters:
                self._add_edge(state, target, letters, marks, state_marks, edge)
        return taken

    def _add_edge(
        self,
        source: int,
        target: int,
        letters: int,
        marks: frozenset[int],
        state_marks: frozenset[int],
        edge: re.Match[str],
    ) -> None:
        body = self.body
        if marks:
            body.on_edges = True
            self._deny("state-acc", edge.start("marks"), "this edge has marks")
        body.sources.append(source)
        body.targets.append(target)
        body.guards.append(letters)
        body.marks.append(marks | state_marks if state_marks else marks)
        body.target_places.append(edge.start("target"))

    # The whole

    def _assemble(self) -> RabinAutomaton:
        header, body = self.header, self.body
        n_states = len(body.places)
        if header.states is not None and int(header.states) != n_states:
            self._fail(header.states, f"States: announces {header.states}, and {n_states} are listed")
        unlisted = next((q for q in range(n_states) if q not in body.places), None)
        if unlisted is not None:
            self._fail(0, f"state {unlisted} is not listed, though a state with a higher number is")
        for target, place in zip(body.targets, body.target_places, strict=True):
            if target >= n_states:
                self._fail(place, f"there is no state {target}, {n_states} are listed")
        for start in header.starts:
            if int(start) >= n_states:
                self._fail(start, f"there is no state {start}, {n_states} are listed")
        if not header.starts or not n_states:
            self._deny("complete", 0, "there is no initial state")
            return self._empty()
        complete = self._is_complete()
        automaton = self._completed(n_states, complete)
        evidence = Evidence(n_states, int(header.starts[0]), body.sources, body.targets, body.marks, automaton)
        claim = failing_claim(header.claims, evidence)
        if claim is not None:
            self._fail(header.claims[claim], f"`{claim}` does not hold; the file is damaged or wrong")
        return automaton

    def _is_complete(self) -> bool:
        universe = all_letters(len(self.header.aps))
        for state, letters in self.body.covered.items():
            if letters != universe:
                letter = a_letter_of(universe ^ letters, self.header.aps)
                self._deny("complete", self.body.places[state], f"state {state} has no edge for the letter {letter}")
                return False
        return True

    def _empty(self) -> RabinAutomaton:
        """Without an initial state no word is accepted."""
        marks = np.zeros((0, 1), dtype=np.bool_)
        letters = np.zeros(1 << len(self.header.aps), dtype=np.int32)
        delta = np.zeros((1, 1), dtype=np.int32)
        return RabinAutomaton(tuple(self.header.aps), delta, letters, marks, marks, formula=self.header.name)

    def _acceptance(self, mark: Mapping[AcceptanceSet, int]) -> Acceptance:
        """Read the acceptance condition; of one that is no list of Rabin pairs, only the sets in use."""
        header, body = self.header, self.body
        used = set[int]().union(*set(body.state_marks.values()), *set(body.marks))
        if header.n_sets <= 2 * MAX_CLAUSES and header.condition is rabin(header.n_sets // 2):
            used = set(range(header.n_sets))
        try:
            return acceptance_of(header.condition, mark, used)
        except TooManyClausesError:
            message = f"the acceptance condition has more than {MAX_CLAUSES} terms when written as pairs"
            self._fail(header.acceptance or 0, message)

    def _completed(self, n_states: int, complete: bool) -> RabinAutomaton:
        """Form Rabin pairs; an incomplete automaton gets a rejecting sink."""
        header, body = self.header, self.body
        on_transitions = body.on_edges or ("trans-acc" in header.claims and "state-acc" not in header.claims)
        n_all = n_states + (not complete)
        letter_class, classes = guard_classes(len(header.aps), n_all, body.guards)
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
        found: list[RabinAutomaton] = []
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
    ) -> tuple[tuple[Edge, ...], ...]:
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

        rows: list[list[Edge]] = [[] for _ in range(n_states)]
        left = [everything] * n_states
        for source, target, guard, numbers in zip(body.sources, body.targets, body.guards, body.marks, strict=True):
            rows[source].append(Edge(classes[guard], target, marks_of(numbers)))
            left[source] &= ~classes[guard]
        for state, letters in enumerate(left):
            if letters:
                rows[state].append(Edge(letters, n_states, marks_of(body.state_marks[state])))
        if any(left):
            rows.append([Edge(everything, n_states, 0)])
        return tuple(map(tuple, rows))


def _unquote(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text[1:-1], flags=re.DOTALL)
