"""What a command is given: a formula, a file, or `-` for standard input."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ltlc.budget import MAX_STATES

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


def given_automaton(
    source: str, *, determinise: bool = False, max_states: int = MAX_STATES, timeout: float | None = None
) -> DRA | DFA | str:
    """The automaton in a file, or on standard input; or the text itself, where it is a formula.

    Args:
        source: a path, `-`, or a formula.
        determinise: make a nondeterministic automaton deterministic.
        max_states: limit for that.
        timeout: seconds for that.
    """
    from ltlc.automata.formats import format_of_content, format_of_suffix
    from ltlc.compiler import deterministic, load

    if source == "-":
        text = "".join(standard_input())
        form = format_of_content(text)
        if form is None:
            return text
        return deterministic(text, max_states=max_states, timeout=timeout) if determinise else form.read(text)
    suffix = os.path.splitext(source)[1]
    form = format_of_suffix(suffix)
    if (form is not None and form.reader is not None) or (suffix and os.path.isfile(source)):
        return load(source, determinise=determinise, max_states=max_states, timeout=timeout)
    return source
