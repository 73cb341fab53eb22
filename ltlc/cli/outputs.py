"""Where results go: files by suffix, standard output by --format."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from ltlc.compiler import DRA

Format = Literal["hoa", "json", "dot", "mermaid", "svg"]

Output = Annotated[
    list[str] | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Where to write: .json .hoa .dot .mmd .svg .png .pdf, or - for standard output. May be repeated.",
    ),
]


def check_targets(targets: Sequence[str]) -> None:
    """Fail before the work, not after it, where a target cannot be written.

    Raises:
        UnknownNameError: a suffix stands for no format.
        NotADirectoryError: the folder of a target does not exist.
    """
    from ltlc.formats import check_suffix

    for target in targets:
        if target != "-":
            check_suffix(target)
            if not Path(target).absolute().parent.is_dir():
                raise NotADirectoryError(0, "there is no such folder to write to", str(Path(target).parent))


def write_targets(dra: DRA, targets: Sequence[str], form: Format = "hoa") -> None:
    """Write an automaton to every target; `form` is for standard output."""
    for target in targets:
        if target == "-":
            sys.stdout.write(as_text(dra, form))
        else:
            dra.save(target)


def as_text(dra: DRA, form: Format) -> str:
    """The automaton in one of the text formats."""
    text = {
        "hoa": dra.to_hoa,
        "json": dra.to_json,
        "dot": dra.to_dot,
        "mermaid": dra.to_mermaid,
        "svg": dra.to_svg,
    }[form]()
    return text if text.endswith("\n") else text + "\n"
