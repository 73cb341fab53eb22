"""From the text of one HOA automaton to its parts, with `ltlc/grammars/hoa.lark`; what they mean is `hoa_reader`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, cast

from ltlc.formats.hoa_acceptance import ALWAYS, MAX_TERMS, NEVER, Atom, Condition, TooManyTermsError, all_of, any_of
from ltlc.ltl.formula import FALSE, TRUE, And, Formula, Not, Or, Proposition

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.exceptions import UnexpectedInput


class HoaSyntaxError(Exception):
    """The text does not follow the grammar; line and column count from 1 in this text."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.line, self.column, self.message = line, column, message
        super().__init__(line, column, message)


class HeaderItem(NamedTuple):
    """One header."""

    kind: str
    """the name of its rule in the grammar."""
    keyword: Token
    values: list[Any]
    """tokens, and the Formula of an alias or the Condition of the acceptance."""


class EdgeItem(NamedTuple):
    """One edge of a state."""

    label: Token | None
    targets: list[Token]
    marks: list[Token]


class StateItem(NamedTuple):
    """One state with its edges."""

    keyword: Token
    label: Token | None
    number: Token
    name: Token | None
    marks: list[Token]
    edges: list[EdgeItem]


class Document(NamedTuple):
    """One automaton."""

    version: Token
    headers: list[HeaderItem]
    states: list[StateItem]


def parse_automaton(text: str) -> Document:
    """The parts of an automaton, from `HOA:` to `--END--`.

    Raises:
        HoaSyntaxError: it does not follow the grammar.
    """
    return cast(Document, _parse(text, "automaton"))


def parse_label(text: str) -> Formula:
    """A label in its square brackets; propositions are named by their number, or as `@alias`.

    Raises:
        HoaSyntaxError: it does not follow the grammar.
    """
    return cast(Formula, _parse(text, "label"))


def _parse(text: str, start: str) -> object:
    from lark.exceptions import UnexpectedInput

    try:
        return _parser().parse(text, start=start)
    except UnexpectedInput as error:
        _explain(error, text)
    except TooManyTermsError:
        line, column = _place(text, text.find("Acceptance:"))
        message = f"the acceptance condition has more than {MAX_TERMS} terms when written as pairs"
        raise HoaSyntaxError(line, column, message) from None


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

        def automaton(self, children: list[Any]) -> Document:
            headers = [child for child in children if isinstance(child, HeaderItem)]
            return Document(children[0], headers, [child for child in children if isinstance(child, StateItem)])

        def state(self, children: list[Any]) -> StateItem:
            tokens, marks = _sorted(children)
            edges = [child for child in children if isinstance(child, EdgeItem)]
            number, name = tokens["INT"][0], tokens.get("STRING", [None])[0]
            return StateItem(children[0], tokens.get("LABEL", [None])[0], number, name, marks, edges)

        def edge(self, children: list[Any]) -> EdgeItem:
            tokens, marks = _sorted(children)
            return EdgeItem(tokens.get("LABEL", [None])[0], tokens["INT"], marks)

        def marks(self, children: list[Any]) -> list[Token]:
            return children

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

        def marked(self, children: list[Any]) -> Condition:
            return _atom(*children, complement=False)

        def unmarked(self, children: list[Any]) -> Condition:
            return _atom(*children, complement=True)

        def always(self, _: list[Any]) -> Condition:
            return ALWAYS

        def never(self, _: list[Any]) -> Condition:
            return NEVER

        def all_of(self, children: list[Any]) -> Condition:
            return all_of(children)

        def any_of(self, children: list[Any]) -> Condition:
            return any_of(children)

    return Lark.open_from_package(
        "ltlc.grammars", "hoa.lark", parser="lalr", start=["automaton", "label"], transformer=Parts()
    )


def _header(kind: str) -> Callable[[object, list[Any]], HeaderItem]:
    return lambda _, children: HeaderItem(kind, children[0], children[1:])


def _sorted(children: list[Any]) -> tuple[dict[str, list[Any]], list[Token]]:
    """The tokens by type, and the marks."""
    tokens: dict[str, list[Any]] = {}
    for child in children:
        if isinstance(child, str):
            tokens.setdefault(cast("Token", child).type, []).append(child)
    return tokens, next((child for child in children if type(child) is list), [])


def _atom(kind: Token, number: Token, *, complement: bool) -> Condition:
    # A number with more digits than any set can have is refused later, as out of range.
    return (frozenset({Atom(kind == "Inf", complement, int(number[:12]))}),)


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
    raise HoaSyntaxError(*_place(text, position), f"unexpected {found}{expected}") from None


def _place(text: str, position: int) -> tuple[int, int]:
    """Line and column, from 1."""
    return text.count("\n", 0, position) + 1, position - text.rfind("\n", 0, position)
