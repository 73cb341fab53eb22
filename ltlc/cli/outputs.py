"""Where results go: files by suffix, standard output by --format."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from ltlc.cli import flags
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.compiler import DRA

Format = Literal["hoa", "json", "dot", "mermaid", "svg", "png", "pdf"]

Output = Annotated[
    list[str] | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        callback=flags.path_given,
        help="Where to write: .json .hoa .dot .mmd .md .svg .png .pdf, or - for standard output. May be repeated.",
    ),
]


def check_targets(targets: Sequence[str]) -> None:
    """Fail before the work, not after it, where a target cannot be written.

    Raises:
        InvalidArgumentError: a suffix stands for no format, or the folder does not exist.
    """
    from ltlc.formats.files import TEXT_WRITERS
    from ltlc.formats.picture import PICTURES

    suffixes = (*TEXT_WRITERS, *PICTURES)
    for target in map(Path, targets):
        if target == Path("-"):
            continue
        if target.suffix.lower() not in suffixes:
            raise InvalidArgumentError(f"{target}: the suffix must be one of {' '.join(suffixes)}")
        if target.is_dir():
            raise InvalidArgumentError(f"{target}: this is a folder; give the name of a file in it")
        if not target.absolute().parent.is_dir():
            raise InvalidArgumentError(f"{target}: there is no folder {target.parent}; create it first")


def write_targets(dra: DRA, targets: Sequence[str], form: Format = "hoa") -> None:
    """Write an automaton to every target: the files, all or none, then standard output, in the format `form`."""
    from ltlc.formats.files import write_all

    write_all(dra, [target for target in targets if target != "-"])
    if "-" in targets:
        write_bytes(_as_bytes(dra, form))


def write_bytes(data: bytes) -> None:
    """Write to standard output at once: automata are UTF-8 whatever the terminal speaks."""
    sys.stdout.flush()
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


def _as_bytes(dra: DRA, form: Format) -> bytes:
    from ltlc.formats.picture import draw

    if form in ("svg", "png", "pdf"):
        return draw(dra.to_dot(), form)
    writers = {"hoa": dra.to_hoa, "json": dra.to_json, "dot": dra.to_dot, "mermaid": dra.to_mermaid}
    return writers[form]().encode("utf-8")
