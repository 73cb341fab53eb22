"""The text of one HOA automaton, and messages that say where in the stream something in it is wrong."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NoReturn

from ltlc.errors import FileFormatError

if TYPE_CHECKING:
    from lark import Token

    from ltlc.formats.hoa_stream import Piece


class HoaText:
    """The text of one automaton; messages count lines and columns in the whole stream."""

    def __init__(self, piece: Piece) -> None:
        self.text, self.body = piece.text, piece.body
        self._line, self._column = piece.line, piece.column

    def fail(self, place: Token | int, message: str) -> NoReturn:
        """Raise a FileFormatError about a token, or a position in the text."""
        position = place if isinstance(place, int) else place.start_pos or 0
        line, column = self.line(position), position - self.text.rfind("\n", 0, position)
        if line == self._line:
            column += self._column - 1
        raise FileFormatError(f"line {line}, column {column}: {message}") from None

    def line(self, position: int) -> int:
        """The line of a position in the text."""
        return self.text.count("\n", 0, position) + self._line

    def number(self, text: str, place: Token | int) -> int:
        """The value of digits, which must be small enough for HOA."""
        if len(text) > 10 or int(text) >= 1 << 31:
            self.fail(place, "numbers in HOA are below 2^31")
        return int(text)


def unquote(text: str) -> str:
    """What a quoted string says."""
    return re.sub(r"\\(.)", r"\1", text[1:-1], flags=re.DOTALL)
