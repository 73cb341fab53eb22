"""The grammar `ltlc/grammars/ltl.lark` at work: text to tokens, tokens to a value.

Lark works out its terminals and its LALR(1) table (`ltlc/ltl/tables.py`); both are run here, because most of what its
own loop does for this grammar is to walk up the levels of precedence, one reduction after the other, for each operand.
Here such a chain is followed once and remembered.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any, NamedTuple, Self

from ltlc.budget import check_time
from ltlc.ltl.tables import Rule, load

END = "$END"
"""The kind of what follows the last token."""


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


class UnexpectedToken(Exception):
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
        tables = load()
        self._pattern = re.compile(tables.pattern)
        self._is_suspect, self._in_context = is_suspect, in_context
        self._first_state, self._last_state = 0, tables.last_state
        reductions = [Reduction(rule.size, _build(rule, builders), rule.result, rule.is_chain) for rule in tables.rules]
        # state -> kind of the next token, or nonterminal just completed -> next state or reduction
        self._actions: list[dict[str, int | Reduction]] = [
            {symbol: target if target >= 0 else reductions[-1 - target] for symbol, target in row.items()}
            for row in tables.actions
        ]
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
            UnexpectedToken: its tokens are no sequence that the grammar allows.
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
                    raise UnexpectedToken(index)
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


def _build(rule: Rule, builders: object) -> Callable[[list[Any]], Any]:
    """How the operands of a rule become one value."""
    kept, spliced = rule.kept, frozenset(rule.spliced)
    if not rule.name and len(kept) == 1 and not rule.result.startswith("_"):
        (place,) = kept
        return lambda operands: operands[place]
    finish: Callable[[list[Any]], Any] = getattr(builders, rule.name) if rule.name else list

    def build(operands: list[Any]) -> Any:
        values: list[Any] = []
        for i in kept:
            if i in spliced:
                values += operands[i]
            else:
                values.append(operands[i])
        return finish(values)

    return build
