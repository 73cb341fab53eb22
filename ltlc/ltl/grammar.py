"""The grammar `ltlc/grammars/ltl.lark` at work: text to tokens, tokens to a value.

Lark reads the grammar and works out its terminals and its LALR(1) table; both are run here, because most of what its
own loop does for this grammar is to walk up the levels of precedence, one reduction after the other, for each operand.
Here such a chain is followed once and remembered.

References:
    Frank DeRemer and Thomas Pennello, Efficient computation of LALR(1) look-ahead sets, ACM TOPLAS 4(4), 1982,
    doi:10.1145/69622.357187.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import Any, NamedTuple, Self

from ltlc.budget import check_time

END = "$END"
"""The kind of what follows the last token."""
UNKNOWN = "_UNKNOWN"
"""The kind of a character with which no token starts."""


class Token(NamedTuple):
    """A piece of the text that has a meaning of its own."""

    kind: str
    """the name of its terminal in the grammar, or `UNKNOWN`."""
    text: str
    start: int
    """where it starts, and..."""
    end: int
    """...the first position behind it, in characters from 0."""

    def __str__(self) -> str:
        return excerpt(self.text)


def excerpt(text: str) -> str:
    """The text, shortened in the middle for a message if it is long."""
    return text if len(text) <= _EXCERPT else f"{text[: _EXCERPT // 2]}...{text[-_EXCERPT // 4 :]}"


_EXCERPT = 60


class Misfit(Exception):
    """The token at `index` cannot stand where it stands; `index` is the number of tokens if the text ends too early."""

    def __init__(self, index: int) -> None:
        super().__init__(index)
        self.index = index


class Placed(str):
    """The text of a token, with the place where an error about it is shown."""

    __slots__ = ("start",)
    start: int

    def __new__(cls, text: str, start: int) -> Self:
        """The text of a token that starts there."""
        placed = super().__new__(cls, text)
        placed.start = start
        return placed


class Unbuildable(Exception):
    """What the tokens mean is no formula, although they stand where they may.

    Args:
        message, hint: for the error.
        start: the place that they speak of, in characters from 0.
    """

    def __init__(self, message: str, hint: str, start: int) -> None:
        super().__init__(message)
        self.message, self.hint, self.start = message, hint, start


class Reduction(NamedTuple):
    """What the table demands where operands are complete: to make one value of the last `size` ones."""

    size: int
    build: Callable[[list[Any]], Any]
    result: str
    """the nonterminal that the value stands for."""
    is_chain: bool
    """whether it only renames the nonterminal of a single value."""


class Grammar:
    """The terminals and the table of the grammar.

    Args:
        builders: a function from operands to value for each named rule of the grammar.
        is_suspect: whether the kind of some token may depend on the tokens around it, or builders may need places.
        in_context: the tokens of such a text with their right kinds.
    """

    def __init__(
        self,
        builders: object,
        is_suspect: Callable[[str], bool],
        in_context: Callable[[Iterator[Token]], Iterator[Token]],
    ) -> None:
        from lark import Lark
        from lark.parsers.lalr_analysis import Shift

        lark = Lark.open_from_package(
            "ltlc.grammars", "ltl.lark", parser="lalr", lexer="basic", transformer=builders, maybe_placeholders=False
        )
        # In the order in which Lark tries them.
        terminals = sorted(
            lark.terminals, key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name)
        )
        ignored = "|".join(t.pattern.to_regexp() for t in terminals if t.name in lark.ignore_tokens)
        named = [f"(?P<{t.name}>{t.pattern.to_regexp()})" for t in terminals if t.name not in lark.ignore_tokens]
        self._pattern = re.compile("|".join([ignored, *named, f"(?P<{UNKNOWN}>(?s:.))"]))

        self._is_suspect, self._in_context = is_suspect, in_context

        table = lark.parse_interactive("").parser_state.parse_conf
        self._first_state: int = table.start_state
        self._last_state: int = table.end_state
        # state -> kind of the next token, or nonterminal just completed -> next state or reduction
        self._actions: dict[int, dict[str, int | Reduction]] = {}
        for state, row in table.states.items():
            self._actions[state] = {
                str(symbol): target if action is Shift else _reduction(target, table.callbacks)
                for symbol, (action, target) in row.items()
            }
        self._known: dict[tuple[int, str, str], int] = {}

    def scan(self, text: str) -> Iterator[Token]:
        """The tokens, one after the other: a long text has more of them than memory should hold."""
        tokens = self.lexed(text)
        return self._in_context(tokens) if self._is_suspect(text) else tokens

    def lexed(self, text: str) -> Iterator[Token]:
        """As `scan`, with every word a name that is one to the lexer."""
        for match in self._pattern.finditer(text):
            if match.lastgroup:
                yield Token(match.lastgroup, match[0], *match.span())

    def parse(self, text: str) -> Any:
        """The value of a text.

        Raises:
            Misfit: its tokens are no sequence that the grammar allows.
            Unbuildable: a builder says so.
            TimeLimitExceeded: the time is over.
        """
        actions = self._actions
        states = [self._first_state]
        values: list[Any] = []
        tokens: Iterator[tuple[str, str]]
        if self._is_suspect(text):
            tokens = ((token.kind, Placed(token.text, token.start)) for token in self.scan(text))
        else:
            matches = self._pattern.finditer(text)
            tokens = ((match.lastgroup, match[0]) for match in matches if match.lastgroup)
        for index, (kind, word) in enumerate(chain(tokens, [(END, "")])):
            while True:
                action = actions[states[-1]].get(kind)
                if action is None:
                    raise Misfit(index)
                if isinstance(action, int):
                    break
                size, build, result, _ = action
                operands = values[-size:]
                del values[-size:], states[-size:]
                values.append(build(operands))
                if not len(values) & 255:
                    check_time()
                before = states[-1]
                state = self._known.get((before, result, kind))
                states.append(self._state_after(before, result, kind) if state is None else state)
                if states[-1] == self._last_state:
                    return values[0]
            states.append(action)
            values.append(word)
            if not index & 255:
                check_time()
        raise AssertionError("the last token ends the formula or does not fit")

    def _state_after(self, before: int, result: str, kind: str) -> int:
        """The state after a nonterminal, with all reductions that only rename it before a token of this kind."""
        name = result
        while True:
            state = self._actions[before][name]
            assert isinstance(state, int)
            action = self._actions[state].get(kind)
            if state == self._last_state or not isinstance(action, Reduction) or not action.is_chain:
                self._known[before, result, kind] = state
                return state
            name = action.result


def _reduction(rule: Any, callbacks: Mapping[Any, Callable[[list[Any]], Any]]) -> Reduction:
    size = len(rule.expansion)
    is_chain = size == 1 and rule.options.expand1 and rule.alias is None
    return Reduction(size, callbacks[rule], str(rule.origin.name), is_chain)
