"""The states and edges of an HOA automaton, as they are listed."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ltlc.budget import check_time
from ltlc.formats.edges import a_letter_of
from ltlc.formats.hoa_header import HoaHeader
from ltlc.formats.hoa_parser import HoaSyntaxError, StateItem, parse_body, parse_label
from ltlc.formats.hoa_text import unquote

_HINT = "; Buchi automata are made deterministic when they are read with determinise"
_NUMBER = re.compile(r"0|[1-9][0-9]*")


def read_body(header: HoaHeader) -> HoaBody:
    """The states of the text that the headers belong to.

    Raises:
        HoaSyntaxError: they do not follow the grammar.
        FileFormatError: they contradict the headers or are not deterministic; names line and column.
    """
    reader = _Reader(header)
    for state in parse_body(header.text.text, header.text.body):
        check_time()
        reader.read_state(state)
    return reader.body


@dataclass
class HoaBody:
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
    is_deterministic: bool = True
    """whether no state has two edges for a letter."""
    on_edges: bool = False
    """whether an edge has marks of its own."""


class _Reader:
    def __init__(self, header: HoaHeader) -> None:
        self.header, self.text = header, header.text
        self.body = HoaBody()
        self.labels: dict[str, int] = {}
        self.known_marks: dict[str | None, frozenset[int]] = {None: frozenset()}

    def _label(self, text: str, place: int) -> int:
        if text not in self.labels:
            try:
                self.labels[text] = self.header.letters(parse_label(text), place)
            except HoaSyntaxError as error:
                self.text.fail(place + error.position, error.message)
        return self.labels[text]

    def _marks(self, match: re.Match[str], group: str) -> frozenset[int]:
        text = match[group]
        if text not in self.known_marks:
            for mark in _NUMBER.finditer(text):
                place = match.start(group) + mark.start()
                if self.text.number(mark[0], place) >= self.header.n_sets:
                    n_sets = self.header.n_sets
                    self.text.fail(place, f"there is no acceptance set {mark[0]}, Acceptance: announces {n_sets}")
            self.known_marks[text] = frozenset(map(int, _NUMBER.findall(text)))
        return self.known_marks[text]

    def read_state(self, item: StateItem) -> None:
        head, body = item.head, self.body
        place = head.start("state")
        state = self.text.number(head["state"], place)
        if state in body.places:
            self.text.fail(place, f"state {state} is listed twice")
        body.places[state] = place
        if head["name"] is not None:
            body.names[state] = unquote(head["name"])
        marks = body.state_marks[state] = self._marks(head, "state_marks")
        if marks:
            self.header.deny("trans-acc", head.start("state_marks"), f"state {state} has marks")
        self._check_labels(state, item)
        body.covered[state] = self._read_edges(state, item, marks)

    def _check_labels(self, state: int, item: StateItem) -> None:
        """Check where labels are: at the state, at every edge, or nowhere if there is an edge for every letter."""
        head, edges, n_letters = item.head, item.edges, self.header.numbers.size
        with_label = next((edge for edge in edges if edge["label"] is not None), None)
        if head["state_label"] is not None:
            place = head.start("state_label")
            self.header.deny("trans-labels", place, f"state {state} has a label")
            self.header.deny("implicit-labels", place, f"state {state} has a label")
            if with_label is not None:
                self.text.fail(with_label.start("label"), "the state has a label already, so its edges have none")
        elif with_label is not None:
            self.header.deny("state-labels", with_label.start("label"), "this edge has a label")
            self.header.deny("implicit-labels", with_label.start("label"), "this edge has a label")
            without = next((edge for edge in edges if edge["label"] is None), None)
            if without is not None:
                self.text.fail(without.start("target"), "this edge has no label, others of the same state have one")
        elif edges:
            place = head.start("STATE")
            for claim in ("state-labels", "explicit-labels"):
                self.header.deny(claim, place, f"state {state} has neither a label nor edges with labels")
            if len(edges) != n_letters:
                self.text.fail(
                    place, f"state {state} has {len(edges)} edges without label; there are {n_letters} letters"
                )

    def _read_edges(self, state: int, item: StateItem, state_marks: frozenset[int]) -> int:
        """Take in the edges of a state; returns their letters."""
        state_label = item.head["state_label"]
        merged: dict[tuple[int, frozenset[int]], tuple[int, re.Match[str]]] = {}
        for i, edge in enumerate(item.edges):
            label, target, conjuncts, marks_text = edge.group("label", "target", "conjuncts", "marks")
            if conjuncts:
                place = edge.start("conjuncts") + _NUMBER.search(conjuncts).start()  # type: ignore[union-attr]
                self.text.fail(place, "universal branching: an alternating automaton is not deterministic")
            if label is not None:
                letters = self.labels.get(label) or self._label(label, edge.start("label"))
            elif state_label is not None:
                letters = self._label(state_label, item.head.start("state_label"))
            else:
                letters = 1 << i
            number = self.text.number(target, edge.start("target"))
            key = (number, self._marks(edge, "marks") if marks_text else frozenset())
            merged[key] = (merged[key][0] | letters if key in merged else letters, edge)
        taken = 0
        for (target, marks), (letters, edge) in merged.items():
            if letters & taken and self.header.nondeterministic:
                place = edge.start("target")
                self.header.deny("deterministic", place, f"state {state} has two edges for one letter")
                self.body.is_deterministic = False
            elif letters & taken:
                letter = a_letter_of(letters & taken, self.header.numbers)
                place = edge.start("target")
                self.text.fail(
                    place, f"not deterministic: state {state} has a second edge for the letter {letter}{_HINT}"
                )
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
            self.header.deny("state-acc", edge.start("marks"), "this edge has marks")
        body.sources.append(source)
        body.targets.append(target)
        body.guards.append(letters)
        body.marks.append(marks | state_marks if state_marks else marks)
        body.target_places.append(edge.start("target"))
