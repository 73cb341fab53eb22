"""The picture as SVG, PNG or PDF, drawn by Graphviz."""

from __future__ import annotations

import os
from pathlib import Path

from ltlc.atomic import atomic_write
from ltlc.automata.rabin import RabinAutomaton
from ltlc.errors import InvalidArgumentError, MissingProgramError
from ltlc.formats.dot import to_dot

PICTURES = (".svg", ".png", ".pdf")
_PNG_RESOLUTION = 120


def render(automaton: RabinAutomaton, path: str | os.PathLike[str], *, hide_deadlock: bool = False) -> Path:
    """Draw the automaton into a .svg, .png or .pdf file; all or nothing.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: the suffix is none of these.
        MissingProgramError: Graphviz is not installed; the .dot file was written beside, and the message says where.
        OSError: the folder is missing, not writable or full.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in PICTURES:
        raise InvalidArgumentError(f"{target}: no picture has the suffix {suffix!r}; known are {' '.join(PICTURES)}")
    source = to_dot(automaton, hide_deadlock=hide_deadlock)
    try:
        picture = draw(source, suffix[1:])
    except MissingProgramError as error:
        beside = atomic_write(target.with_suffix(".dot"), source)
        advice = f"{error}\nThe picture was written as {beside}; afterwards: dot -T{suffix[1:]} {beside} -o {target}"
        raise MissingProgramError(advice) from None
    return atomic_write(target, picture)


def draw(source: str, kind: str) -> bytes:
    """What the `dot` program makes of a DOT text, e.g. for `kind` "svg".

    Raises:
        MissingProgramError: Graphviz is not installed.
    """
    import graphviz

    if kind == "png":
        # Not in the text itself, because in an SVG the resolution scales the drawing out of its frame.
        source = source.replace("{", f"{{\n  graph [dpi={_PNG_RESOLUTION}]", 1)
    try:
        picture: bytes = graphviz.pipe("dot", kind, source.encode("utf-8"), quiet=True)
        return picture
    except graphviz.ExecutableNotFound:
        raise MissingProgramError(
            "the program 'dot' of Graphviz is not installed or not on the PATH. Install it with: "
            "apt install graphviz (Debian, Ubuntu), brew install graphviz (macOS), "
            "winget install graphviz or choco install graphviz (Windows)"
        ) from None
