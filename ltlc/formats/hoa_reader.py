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
from functools import cache
from typing import TYPE_CHECKING, Any, NoReturn, cast

import numpy as np

from ltlc.automata.rabin import MAX_APS, BoolArray, RabinAutomaton
from ltlc.errors import AlphabetLimitExceeded, FileFormatError
from ltlc.formats import hoa_acceptance
from ltlc.formats.edges import MAX_TABLE, a_letter_of, all_letters, letters_of, letters_with, tabulate
from ltlc.formats.hoa_acceptance import Atom, Condition, with_rabin_pairs
from ltlc.formats.hoa_stream import Piece, pieces
from ltlc.ltl.formula import FALSE, TRUE, And, Formula, Not, Or, Proposition

if TYPE_CHECKING:
    from lark import Lark, Token, Tree
    from lark.exceptions import UnexpectedInput


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
    version: Token | None = None
    states: Token | None = None
    starts: list[Token] = field(default_factory=list)
    aps: list[str] = field(default_factory=list)
    aliases: dict[str, int] = field(default_factory=dict)
    n_sets: int = 0
    condition: Condition = hoa_acceptance.NEVER
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
        tree = self._parse(self.piece.text, "automaton")
        items = [child for child in tree.children if _is_tree(child) and child.data != "state"]
        states = [child for child in tree.children if _is_tree(child) and child.data == "state"]
        self._read_header(tree.children[0], items)
        for state in states:
            self._read_state(state)
        return self._assemble()

    # Messages

    def _fail(self, place: Token, message: str) -> NoReturn:
        self._fail_at(place.line or 1, place.column or 1, message)

    def _fail_at(self, line: int, column: int, message: str) -> NoReturn:
        if line == 1:
            column += self.piece.column - 1
        raise FileFormatError(f"line {line + self.piece.line - 1}, column {column}: {message}")

    def _parse(self, text: str, start: str, place: Token | None = None) -> Tree[Any]:
        """The parse tree; `place` is the token that the text comes from, if it is not the whole piece."""
        from lark.exceptions import UnexpectedInput

        try:
            return cast("Tree[Any]", _parser().parse(text, start=start))
        except UnexpectedInput as error:
            line, column, message = *_position(error, text), _explain(error)
        except hoa_acceptance.TooManyTermsError:
            line, column = 1, 1
            message = f"the acceptance condition has more than {hoa_acceptance.MAX_TERMS} terms when written as pairs"
        if place is None:
            self._fail_at(line, column, message)
        column += (place.column or 1) - 1 if line == 1 else 0
        self._fail_at(line + (place.line or 1) - 1, column, message)

    def _int(self, token: Token) -> int:
        if len(token) > 10 or int(token) >= 1 << 31:
            self._fail(token, "numbers in HOA are below 2^31")
        return int(token)

    # The header

    def _read_header(self, version: Token, items: Sequence[Tree[Any]]) -> None:
        if version != "v1" and not version.startswith("v1."):
            self._fail(version, f"this is HOA {version}; only version v1 can be read")
        by_kind: dict[str, list[list[Token]]] = {}
        for item in items:
            by_kind.setdefault(item.data, []).append(item.children)
        for kind in ("states", "aps", "acceptance", "name"):
            if len(by_kind.get(kind, ())) > 1:
                again = by_kind[kind][1][0]
                self._fail(again, f"the header {again} occurs twice")
        for keyword, *_ in by_kind.get("other", ()):
            if keyword[0].isupper():
                self._fail(keyword, f"the header {keyword} is not known, and it may change what is accepted")
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
            for children in by_kind.get(kind, ()):
                read(*children)

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
            self.labels[text] = self._letters(cast(Formula, self._parse(text, "label", token)), token)
        return self.labels[text]

    # The body

    def _marks(self, tree: Tree[Any]) -> frozenset[int]:
        for token in tree.children:
            if self._int(token) >= self.header.n_sets:
                self._fail(token, f"there is no acceptance set {token}, Acceptance: announces {self.header.n_sets}")
        return frozenset(map(int, tree.children))

    def _read_state(self, tree: Tree[Any]) -> None:
        keyword, *rest = tree.children
        tokens = {child.type: child for child in rest if not _is_tree(child)}
        edges = [child for child in rest if _is_tree(child) and child.data == "edge"]
        number = tokens["INT"]
        state = self._int(number)
        if state in self.body.state_marks:
            self._fail(number, f"state {state} is listed twice")
        if "STRING" in tokens:
            self.body.names[state] = _unquote(tokens["STRING"])
        self.body.state_marks[state] = frozenset().union(
            *(self._marks(child) for child in rest if _is_tree(child) and child.data == "marks")
        )
        self._read_edges(state, keyword, tokens.get("LABEL"), edges)

    def _read_edges(self, state: int, keyword: Token, state_label: Token | None, trees: Sequence[Tree[Any]]) -> None:
        n_letters = 1 << len(self.header.aps)
        labelled = [tree.children[0].type == "LABEL" for tree in trees]
        implicit = state_label is None and not any(labelled)
        if implicit and len(trees) not in (0, n_letters):
            self._fail(keyword, f"state {state} has {len(trees)} edges without label; there are {n_letters} letters")
        merged: dict[tuple[int, frozenset[int]], tuple[int, Token]] = {}
        for i, (tree, has_label) in enumerate(zip(trees, labelled, strict=True)):
            place, *others = [child for child in tree.children if not _is_tree(child) and child.type == "INT"]
            if others:
                self._fail(others[0], "universal branching: an alternating automaton is not deterministic")
            if has_label and state_label is not None:
                self._fail(tree.children[0], "the state has a label already, so its edges have none")
            if not implicit and not has_label and state_label is None:
                self._fail(place, "this edge has no label, others of the same state have one")
            label = tree.children[0] if has_label else state_label
            letters = 1 << i if label is None else self._label(label)
            marks: frozenset[int] = frozenset().union(*(self._marks(c) for c in tree.children if _is_tree(c)))
            key = (self._int(place), marks)
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
            raise AlphabetLimitExceeded(f"tables of {edge.size} transitions and {len(header.condition)} pairs are too large")
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
                marked = np.array([atom.number in body.state_marks.get(q, ()) for q in range(len(edge))], dtype=np.bool_)
            return everything & ~marked if atom.complement else cast(BoolArray, marked)

        return with_rabin_pairs(skeleton, header.condition, members, everything)


def _is_tree(child: object) -> bool:
    return not isinstance(child, str)  # lark's tokens are strings


def _unquote(token: Token) -> str:
    return re.sub(r"\\(.)", r"\1", token[1:-1], flags=re.DOTALL)


# The parser


@cache
def _parser() -> Lark:
    from lark import Lark, Transformer, v_args

    class Expressions(Transformer):  # type: ignore[type-arg]
        """Labels become formulas over the numbers of propositions, acceptance conditions normal forms."""

        label = v_args(inline=True)(lambda _, formula: formula)
        proposition = v_args(inline=True)(lambda _, number: Proposition(number))
        negation = v_args(inline=True)(lambda _, operand: Not(operand))

        def true(self, _: list[Any]) -> Formula:
            return TRUE

        def false(self, _: list[Any]) -> Formula:
            return FALSE

        def conjunction(self, parts: list[Formula]) -> Formula:
            return cast(Formula, And(*parts))

        def disjunction(self, parts: list[Formula]) -> Formula:
            return cast(Formula, Or(*parts))

        def marked(self, children: list[Token]) -> Condition:
            return _atom(children, complement=False)

        def unmarked(self, children: list[Token]) -> Condition:
            return _atom(children, complement=True)

        def always(self, _: list[Any]) -> Condition:
            return hoa_acceptance.ALWAYS

        def never(self, _: list[Any]) -> Condition:
            return hoa_acceptance.NEVER

        def all_of(self, parts: list[Condition]) -> Condition:
            return hoa_acceptance.all_of(parts)

        def any_of(self, parts: list[Condition]) -> Condition:
            return hoa_acceptance.any_of(parts)

    return Lark.open_from_package(
        "ltlc.grammars", "hoa.lark", parser="lalr", start=["automaton", "label"], transformer=Expressions()
    )


def _atom(children: list[Token], *, complement: bool) -> Condition:
    kind, number = children
    # A number with more digits than any set can have is refused later, as out of range.
    return (frozenset({Atom(kind == "Inf", complement, int(number[:12]))}),)


_WORDS = {
    "INT": "a number",
    "STRING": "a quoted string",
    "IDENTIFIER": "a word",
    "VERSION": "a version",
    "ANAME": "an alias like @a",
    "LABEL": "a label like [0 & !1]",
    "HEADERNAME": "a header",
    "_HOA": "'HOA:'",
    "_BODY": "--BODY--",
    "_END": "--END--",
    "STATE": "'State:'",
    "FIN": "Fin",
    "INF": "Inf",
    "VBAR": "'|'",
    "BANG": "'!'",
    "AMPERSAND": "'&'",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "LBRACE": "'{'",
    "RBRACE": "'}'",
    "T": "'t'",
    "F": "'f'",
}


def _position(error: UnexpectedInput, text: str) -> tuple[int, int]:
    if error.line > 0:
        return error.line, error.column
    return text.count("\n") + 1, len(text) - text.rfind("\n")


def _explain(error: UnexpectedInput) -> str:
    from lark.exceptions import UnexpectedToken

    wanted = getattr(error, "accepts", None) or getattr(error, "expected", None) or getattr(error, "allowed", None) or ()
    # The headers all at once would hide what matters.
    words = sorted({_WORDS.get(name, "a header") for name in wanted})
    if isinstance(error, UnexpectedToken):
        found = "the end" if error.token.type == "$END" else repr(str(error.token)[:40])
    else:
        found = repr(getattr(error, "char", "?"))
    return f"unexpected {found}; expected {' or '.join(words)}" if words else f"unexpected {found}"
