"""Cutting a stream of HOA text into single automata, before the grammar sees it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ltlc.errors import FileFormatError

# What ends or interrupts the text at hand, by what the text at hand is. `x--ABORT--` is an identifier.
_CODE = re.compile(r'"|/\*|(?<![\w-])--(?:BODY|END|ABORT)--')
_STRING = re.compile(r'\\.|"', re.DOTALL)
_COMMENT = re.compile(r"/\*|\*/")
_NOT_NEWLINE = re.compile(r"[^\n]")


class Piece(NamedTuple):
    """The text of one automaton up to its --END--, comments blanked."""

    text: str
    line: int
    """line number of its first character, from 1."""
    column: int
    """column of its first character, from 1."""
    body: int
    """position behind --BODY-- in the text; 0 where there is none."""


def pieces(lines: Iterable[str]) -> Iterator[Piece]:
    """The automata of a stream, one by one as their lines arrive; what --ABORT-- calls back is left out.

    Raises:
        FileFormatError: a string, a comment or an automaton has no end.
    """
    parts: list[str] = []
    begin = opened = (1, 1)
    depth, in_string = 0, False
    number = body = length = 0
    for number, line in enumerate(lines, 1):
        position = 0
        while position < len(line):
            pattern = _COMMENT if depth else _STRING if in_string else _CODE
            match = pattern.search(line, position)
            stop = match.end() if match else len(line)
            length += stop - position
            chunk = line[position:stop]
            token = match.group() if match else ""
            if token == "/*" and not in_string:
                opened = opened if depth else (number, stop - 1)
                depth += 1
                parts.append(_NOT_NEWLINE.sub(" ", chunk) if depth > 1 else chunk[:-2] + "  ")
            elif depth:
                depth -= token == "*/"
                parts.append(_NOT_NEWLINE.sub(" ", chunk))
            else:
                parts.append(chunk)
                if token == '"':
                    opened = opened if in_string else (number, stop)
                    in_string = not in_string
                elif token == "--BODY--":
                    body = body or length
                elif token.startswith("--"):
                    if token == "--END--":
                        yield Piece("".join(parts), *begin, body)
                    parts, begin, body, length = [], (number, stop + 1), 0, 0
            position = stop
    if depth or in_string:
        what = "comment" if depth else "string"
        raise FileFormatError(f"line {opened[0]}, column {opened[1]}: this {what} has no end")
    if "".join(parts).strip():
        raise FileFormatError(f"line {number}: the file ends before the --END-- of an automaton")
