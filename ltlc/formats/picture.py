"""The picture as SVG, PNG or PDF, drawn by Graphviz or by a package that needs no Graphviz."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from ltlc.atomic import atomic_write_all
from ltlc.automata.finite import DFA
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time, time_left
from ltlc.errors import InvalidArgumentError, MissingProgramError
from ltlc.formats.dot import FONT, to_dot

PICTURES = (".svg", ".png", ".pdf")
_PNG_RESOLUTION = 120
_PACKAGED_FONT = "Arial"
"""of `FONT`, the one whose widths graphviz-pure knows; it takes a list of fonts for the name of one."""
_IN_PACKAGED_FONT = {ord("✗"): "×", ord("✓"): "√"}
"""signs that this font lacks, for pictures that are drawn with it; a reader of an SVG brings fonts that have them."""


def render(automaton: DRA | DFA, path: str | os.PathLike[str], *, hide_deadlock: bool = False) -> Path:
    """Draw the automaton into a .svg, .png or .pdf file; all or nothing.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: the suffix is none of these.
        MissingProgramError: nothing that draws is installed; the message says where the .dot file was written.
        OSError: the folder is missing, not writable or full.
    """
    contents, problem = drawn(automaton, Path(path), hide_deadlock=hide_deadlock)
    atomic_write_all(contents)
    if problem is not None:
        raise problem
    return Path(path)


def drawn(
    automaton: DRA | DFA, target: Path, *, hide_deadlock: bool = False
) -> tuple[dict[Path, str | bytes], MissingProgramError | None]:
    """What `render` is to write, by path: the picture, or its source beside it and what to tell the user then.

    Raises:
        InvalidArgumentError: the suffix is none of `PICTURES`.
    """
    suffix = target.suffix.lower()
    if suffix not in PICTURES:
        raise InvalidArgumentError(f"{target}: no picture has the suffix {suffix!r}; known are {' '.join(PICTURES)}")
    source = to_dot(automaton, hide_deadlock=hide_deadlock)
    try:
        return {target: draw(source, suffix[1:])}, None
    except MissingProgramError as error:
        beside = target.with_suffix(".dot")
        advice = f"{error}\nThe picture was written as {beside}; afterwards: dot -T{suffix[1:]} {beside} -o {target}"
        return {beside: source}, MissingProgramError(advice)


def to_svg(automaton: DRA | DFA) -> bytes:
    """Draw the automaton as SVG; raises MissingProgramError as `draw` does."""
    return draw(to_dot(automaton), "svg")


def to_png(automaton: DRA | DFA) -> bytes:
    """Draw the automaton as PNG; raises MissingProgramError as `draw` does."""
    return draw(to_dot(automaton), "png")


def to_pdf(automaton: DRA | DFA) -> bytes:
    """Draw the automaton as PDF; raises MissingProgramError as `draw` does."""
    return draw(to_dot(automaton), "pdf")


def draw(source: str, kind: str) -> bytes:
    """What Graphviz makes of a DOT text, e.g. for `kind` "svg": the `dot` program, else the package graphviz-pure.

    Raises:
        MissingProgramError: neither is installed, or there is only the package, which makes no PDF.
    """
    if kind == "png":
        # Not in the text itself, because in an SVG the resolution scales the drawing out of its frame.
        source = source.replace("{", f"{{\n  graph [dpi={_PNG_RESOLUTION}]", 1)
    try:
        return _drawn("dot", source, kind)
    except FileNotFoundError:
        substitute = _substitute()
    if substitute is None or kind == "pdf":
        found = "" if substitute is None else "the package graphviz-pure draws .svg and .png, but no .pdf, and "
        raise MissingProgramError(
            f"{found}the program 'dot' of Graphviz is not installed or not on the PATH. Install it with: "
            "apt install graphviz (Debian, Ubuntu), brew install graphviz (macOS), "
            "winget install graphviz or choco install graphviz (Windows)"
            + ("" if found else '; or, for .svg and .png, the package graphviz-pure: pip install "ltlc[pictures]"')
        )
    text = source.replace(f'fontname="{FONT}"', f'fontname="{_PACKAGED_FONT}"')
    if kind == "png":
        text = text.translate(_IN_PACKAGED_FONT)
    drawn = _drawn(substitute, text, kind)
    return drawn.replace(f'font-family="{_PACKAGED_FONT}"'.encode(), f'font-family="{FONT}"'.encode())


def _drawn(program: str, source: str, kind: str) -> bytes:
    """What a program of Graphviz prints.

    Raises:
        FileNotFoundError: there is no such program.
        TimeLimitExceeded: the time of the call was over before.
    """
    check_time()
    try:
        return subprocess.run(
            [program, f"-T{kind}"], input=source.encode("utf-8"), capture_output=True, check=True, timeout=time_left()
        ).stdout
    except subprocess.TimeoutExpired:
        check_time()
        raise


def _substitute() -> str | None:
    """The program that graphviz-pure installs, on the PATH or beside the packages of this Python; None without it."""
    from importlib import metadata  # which takes long to load

    try:
        files = metadata.files("graphviz-pure") or []
    except metadata.PackageNotFoundError:
        files = []
    places = (str(file.locate()) for file in files if file.stem == "graphviz-pure")
    return next((place for place in places if os.access(place, os.X_OK)), None) or shutil.which("graphviz-pure")
