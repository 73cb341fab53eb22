"""Where results go: files by suffix, standard output by --format."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from ltlc.cli.options import Option
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA, OmegaAutomaton

Output = Annotated[
    list[str] | None,
    Option(
        "--output",
        "-o",
        metavar="FILE",
        is_path=True,
        help="Where to write: {suffixes}, or - for standard output. May be repeated.",
    ),
]


def check_targets(targets: Sequence[str]) -> None:
    """Fail before the work, not after it, where a target cannot be written.

    Raises:
        InvalidArgumentError: a suffix stands for no format, or the folder does not exist.
    """
    if not set(targets) - {"-"}:
        return
    from pathlib import Path

    from ltlc.automata.formats import format_of_suffix, suffixes

    for target in map(Path, targets):
        if target == Path("-"):
            continue
        if format_of_suffix(target.suffix) is None:
            raise InvalidArgumentError(f"{target}: the suffix must be one of {' '.join(suffixes())}")
        if target.is_dir():
            raise InvalidArgumentError(f"{target}: this is a folder; give the name of a file in it")
        if not target.absolute().parent.is_dir():
            raise InvalidArgumentError(f"{target}: there is no folder {target.parent}; create it first")


def write_targets(dra: DRA | DFA | OmegaAutomaton, targets: Sequence[str], form: str = "hoa") -> None:
    """Write an automaton to every target: the files, all or none, then standard output, in the format `form`."""
    from ltlc.formats import FORMATS

    files = [target for target in targets if target != "-"]
    if files:
        from ltlc.formats.files import write_all

        write_all(dra, files)
    if "-" in targets:
        write_bytes(FORMATS[form].write(dra))


def write_bytes(data: bytes) -> None:
    """Write to standard output at once: automata are UTF-8 whatever the terminal speaks."""
    sys.stdout.flush()
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()
