"""What a command is given: a formula, a file, or `-` for standard input."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA


def formula_text(argument: str) -> str:
    """The formula or word given as an argument, or on standard input for `-`."""
    return "".join(standard_input()) if argument == "-" else argument


def standard_input() -> Iterator[str]:
    """The lines of standard input.

    Raises:
        OSError: it cannot be read; `filename` says what.
    """
    try:
        yield from sys.stdin
    except OSError as error:
        raise OSError(error.errno, error.strerror, "standard input") from error


def given_automaton(source: str) -> DRA | DFA | str:
    """The automaton in a file, or on standard input; or the text itself, where it is a formula."""
    from ltlc.automata.formats import format_of_content, format_of_suffix
    from ltlc.compiler import load

    if source == "-":
        text = "".join(standard_input())
        form = format_of_content(text)
        return text if form is None else form.read(text)
    suffix = os.path.splitext(source)[1]
    form = format_of_suffix(suffix)
    if (form is not None and form.reader is not None) or (suffix and os.path.isfile(source)):
        return load(source)
    return source
