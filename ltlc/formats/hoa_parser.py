"""From the text of one HOA automaton to its parts; what they mean is `hoa_reader`.

`ltlc/grammars/hoa.lark` defines the format, and Lark reads headers and labels with it. Bodies are long and of few
shapes, so that a regular expression cuts them into states and edges; where it finds neither, Lark says what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, cast

from ltlc.ltl.formula import FALSE, TRUE, And, Formula, Not, Or, Proposition

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.exceptions import UnexpectedInput


class HoaSyntaxError(Exception):
    """The text does not follow the grammar at this position, which counts characters from 0."""

    def __init__(self, position: int, message: str) -> None:
        self.position, self.message = position, message
        super().__init__(position, message)


class HeaderItem(NamedTuple):
    """One header."""

    kind: str
    """the name of its rule in the grammar."""
    keyword: Token
    values: list[Any]
    """tokens, and the Formula of an alias or of the acceptance; atoms of the latter are named like `Fin(!3)`."""


class Header(NamedTuple):
    """Everything before --BODY--."""

    version: Token
    items: list[HeaderItem]


class StateItem(NamedTuple):
    """One state with its edges, as matches."""

    head: re.Match[str]
    """with groups state_label, state, name, state_marks."""
    edges: list[re.Match[str]]
    """with groups label, target, conjuncts, marks."""


_SPACE, _NUMBER, _MARKS = r"[ \t\r\n]*+", r"(?:0|[1-9][0-9]*+)", r"\{[0-9 \t\r\n]*+\}"
_LABEL, _STRING = r'\[[^\]"]*+\]', r'"(?:\\.|[^\\"])*+"'
_STATE = (
    rf"State:{_SPACE}(?P<state_label>{_LABEL})?+{_SPACE}(?P<state>{_NUMBER})"
    rf"(?:{_SPACE}(?P<name>{_STRING}))?+(?:{_SPACE}(?P<state_marks>{_MARKS}))?+"
)
_EDGE = (
    rf"(?P<label>{_LABEL})?+{_SPACE}(?P<target>{_NUMBER})"
    rf"(?P<conjuncts>(?:{_SPACE}&{_SPACE}{_NUMBER})*+)(?:{_SPACE}(?P<marks>{_MARKS}))?+"
)
_LITERAL = re.compile(rf"{_SPACE}(!?){_SPACE}({_NUMBER}|@[0-9a-zA-Z_-]++|t|f){_SPACE}")
_CONSTANTS = {"t": TRUE, "f": FALSE}
_ITEM = re.compile(rf"{_SPACE}(?:(?P<EDGE>{_EDGE})|(?P<STATE>{_STATE})|(?P<END>--END--)|(?P<OTHER>.|\Z))", re.DOTALL)


def parse_header(text: str, body: int) -> Header:
    """The headers of an automaton.

    Args:
        text: from `HOA:` to `--END--`.
        body: position behind `--BODY--`; 0 where there is none.

    Raises:
        HoaSyntaxError: it does not follow the grammar.
    """
    return cast(Header, _parse(text[:body], "header") if body else _parse(text, "automaton"))


def parse_body(text: str, body: int) -> Iterator[StateItem]:
    """The states of an automaton one by one.

    Args:
        text: from `HOA:` to `--END--`.
        body: position behind `--BODY--`.

    Raises:
        HoaSyntaxError: it does not follow the grammar.
    """
    state: StateItem | None = None
    for match in _ITEM.finditer(text, body):
        kind = match.lastgroup
        if kind == "EDGE" and state is not None:
            state.edges.append(match)
        elif kind in ("STATE", "END"):
            if state is not None:
                yield state
            if kind == "END":
                return
            state = StateItem(match, [])
        else:
            _parse(text, "automaton")
            raise HoaSyntaxError(match.start(str(kind)), "this is neither a state nor an edge")


def parse_label(text: str) -> Formula:
    """A label in its square brackets; propositions are named by their number, or as `@alias`.

    Raises:
        HoaSyntaxError: it does not follow the grammar.
    """
    formula = _sum_of_products(text[1:-1])
    return cast(Formula, _parse(text, "label")) if formula is None else formula


def _sum_of_products(text: str) -> Formula | None:
    """A label without brackets inside, as most tools write them; None if it is something else."""
    terms = []
    for term in text.split("|"):
        factors = []
        for literal in term.split("&"):
            match = _LITERAL.fullmatch(literal)
            if match is None:
                return None
            atom = _CONSTANTS.get(match[2]) or Proposition(match[2])
            factors.append(Not(atom) if match[1] else atom)
        terms.append(And(*factors))
    return Or(*terms)


def _parse(text: str, start: str) -> object:
    from lark.exceptions import UnexpectedInput

    try:
        return _parser().parse(text, start=start)
    except UnexpectedInput as error:
        _explain(error, text)


@cache
def _parser() -> Lark:
    from lark import Lark, Transformer

    class Parts(Transformer):  # type: ignore[type-arg]
        """Turns each rule into its part as soon as it is complete; one method per rule of the grammar."""

        states = _header("states")
        start = _header("start")
        aps = _header("aps")
        alias = _header("alias")
        acceptance = _header("acceptance")
        name = _header("name")
        properties = _header("properties")
        other = _header("other")

        def header(self, children: list[Any]) -> Header:
            return Header(children[0], children[1:])

        def denial(self, children: list[Token]) -> Token:
            return children[0].update(value=f"!{children[0]}")

        def constant(self, _: list[Any]) -> None:
            return None

        def label(self, children: list[Any]) -> Formula:
            return cast(Formula, children[0])

        def proposition(self, children: list[Any]) -> Formula:
            return Proposition(children[0])

        def negation(self, children: list[Any]) -> Formula:
            return Not(children[0])

        def true(self, _: list[Any]) -> Formula:
            return TRUE

        def false(self, _: list[Any]) -> Formula:
            return FALSE

        def conjunction(self, children: list[Any]) -> Formula:
            return cast(Formula, And(*children))

        def disjunction(self, children: list[Any]) -> Formula:
            return cast(Formula, Or(*children))

        def marked(self, children: list[Any]) -> Formula:
            return Proposition(f"{children[0]}({children[1]})")

        def unmarked(self, children: list[Any]) -> Formula:
            return Proposition(f"{children[0]}(!{children[1]})")

        always, never, all_of, any_of = true, false, conjunction, disjunction

    return Lark.open_from_package(
        "ltlc.grammars", "hoa.lark", parser="lalr", start=["automaton", "header", "label"], transformer=Parts()
    )


def _header(kind: str) -> Callable[[object, list[Any]], HeaderItem]:
    return lambda _, children: HeaderItem(kind, children[0], children[1:])


# What went wrong

_WORDS = {
    "INT": "a number",
    "STRING": "a quoted string",
    "IDENTIFIER": "a word",
    "VERSION": "a version",
    "ANAME": "an alias like @a",
    "LABEL": "a label like [0 & !1]",
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


def _explain(error: UnexpectedInput, text: str) -> NoReturn:
    from lark.exceptions import UnexpectedToken

    if isinstance(error, UnexpectedToken):
        at_end = error.token.type == "$END"
        found = "the end" if at_end else repr(str(error.token)[:40])
        wanted = error.accepts or error.expected
    else:
        at_end, found = False, repr(text[error.pos_in_stream or 0])
        wanted = getattr(error, "allowed", None) or set()
    # All headers one by one would hide what matters.
    words = sorted({_WORDS.get(name, "a header") for name in wanted})
    expected = f"; expected {' or '.join(words)}" if words else ""
    position = len(text) if at_end else error.pos_in_stream or 0
    raise HoaSyntaxError(position, f"unexpected {found}{expected}") from None
