"""Writing to and reading from files, the format chosen by suffix or by content."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from ltlc.atomic import atomic_write_all
from ltlc.automata.rabin import RabinAutomaton
from ltlc.errors import FileFormatError, InvalidArgumentError, MissingProgramError, check_type
from ltlc.formats.dot import to_dot
from ltlc.formats.hoa import to_hoa
from ltlc.formats.hoa_reader import from_hoa
from ltlc.formats.json import from_json, to_json
from ltlc.formats.mermaid import to_mermaid
from ltlc.formats.picture import PICTURES, drawn

TEXT_WRITERS: Mapping[str, Callable[[RabinAutomaton], str]] = {
    ".json": to_json,
    ".hoa": to_hoa,
    ".dot": to_dot,
    ".mmd": to_mermaid,
    ".md": lambda automaton: f"```mermaid\n{to_mermaid(automaton)}```\n",
}
READERS: Mapping[str, Callable[[str], RabinAutomaton]] = {".json": from_json, ".hoa": from_hoa}


def write(automaton: RabinAutomaton, path: str | os.PathLike[str]) -> Path:
    """Write the automaton in the format that the suffix of the path names; all or nothing.

    Known suffixes: .json and .hoa, which `read` reads back; .dot; .mmd (Mermaid) and .md (Mermaid in a Markdown
    fence); .svg, .png and .pdf, which need Graphviz or, but for .pdf, the package graphviz-pure.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: the suffix is not known.
        MissingProgramError: nothing that draws is installed; the .dot file was written beside.
        OSError: the folder is missing, not writable or full.
    """
    write_all(automaton, [path])
    return Path(path)


def write_all(automaton: RabinAutomaton, paths: Iterable[str | os.PathLike[str]]) -> None:
    """Write the automaton to several files, each as `write` does; none takes its place before all are on the disk.

    Raises:
        InvalidArgumentError, OSError: as of `write`; nothing was written.
        MissingProgramError: as of `write`; all else was written.
    """
    paths = list(paths)
    for path in paths:
        check_type(path, (str, os.PathLike), "the path", "the name of a file")
    contents: dict[Path, str | bytes] = {}
    problem: MissingProgramError | None = None
    for target in map(Path, paths):
        suffix = target.suffix.lower()
        if suffix in TEXT_WRITERS:
            contents[target] = TEXT_WRITERS[suffix](automaton)
        elif suffix in PICTURES:
            picture, without = drawn(automaton, target)
            contents |= picture
            problem = problem or without
        else:
            known = " ".join([*TEXT_WRITERS, *PICTURES])
            raise InvalidArgumentError(f"{target}: no format has the suffix {suffix!r}; known are {known}")
    atomic_write_all(contents)
    if problem is not None:
        raise problem


def read(path: str | os.PathLike[str]) -> RabinAutomaton:
    """The automaton in a .json or .hoa file; with any other suffix the content decides.

    Raises:
        FileFormatError: the content is not what the suffix promises, or neither format; the message names the path
            and the line or key.
        AlphabetLimitExceeded: it has too many propositions.
        StateLimitExceeded: Rabin pairs for its acceptance condition would need too many states.
        OSError: the file is missing or not readable.
    """
    check_type(path, (str, os.PathLike), "the path", "the name of a file")
    source = Path(path)
    try:
        text = source.read_bytes().decode("utf-8-sig")
        reader = READERS.get(source.suffix.lower()) or _reader_for(text)
        return reader(text)
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{source}: not UTF-8 text (byte {error.start})") from None
    except FileFormatError as error:
        raise FileFormatError(f"{source}: {error}") from None


def _reader_for(text: str) -> Callable[[str], RabinAutomaton]:
    if text.lstrip().startswith(("{", "[")):
        return from_json
    # A comment may stand before HOA:.
    if text.lstrip().startswith(("HOA:", "/*")):
        return from_hoa
    raise FileFormatError("neither JSON (which starts with '{') nor HOA (which starts with 'HOA: v1')")
