"""Writing to and reading from files, the format chosen by suffix or by content."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from ltlc.atomic import atomic_write_all
from ltlc.automata.finite import DFA
from ltlc.automata.formats import FORMATS, Format, format_of_content, format_of_suffix, suffixes
from ltlc.automata.omega import OmegaAutomaton
from ltlc.automata.rabin import DRA
from ltlc.errors import FileFormatError, InvalidArgumentError, MissingProgramError, check_type
from ltlc.formats.picture import PICTURES, drawn


def write(automaton: DRA | DFA | OmegaAutomaton, path: str | os.PathLike[str]) -> Path:
    """Write the automaton in the format that the suffix of the path names; all or nothing.

    Known are the suffixes of all formats of `FORMATS`: .json and .hoa, which `read` reads back; .dot; .mmd (Mermaid)
    and .md (Mermaid in a Markdown fence); .svg, .png and .pdf, which need Graphviz or, but for .pdf, the package
    graphviz-pure; and those of `register_format`.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: the suffix is not known.
        MissingProgramError: nothing that draws is installed; the .dot file was written beside.
        OSError: the folder is missing, not writable or full.
    """
    write_all(automaton, [path])
    return Path(path)


def write_all(automaton: DRA | DFA | OmegaAutomaton, paths: Iterable[str | os.PathLike[str]]) -> None:
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
        form = format_of_suffix(target.suffix)
        if form is None:
            raise InvalidArgumentError(
                f"{target}: no format has the suffix {target.suffix!r}; known are {' '.join(suffixes())}"
            )
        form.check(automaton)
        if form.suffixes[0] in PICTURES:
            assert not isinstance(automaton, OmegaAutomaton)  # `check` has refused it
            picture, without = drawn(automaton, target)
            contents |= picture
            problem = problem or without
        else:
            contents[target] = form.write(automaton)
    atomic_write_all(contents)
    if problem is not None:
        raise problem


def read(path: str | os.PathLike[str]) -> DRA | DFA:
    """The automaton in a .json or .hoa file, or of another format with a reader; with any other suffix content decides.

    Raises:
        FileFormatError: the content is not what the suffix promises, or neither format; the message names the path
            and the line or key.
        AlphabetLimitExceeded: it has too many propositions.
        StateLimitExceeded: Rabin pairs for its acceptance condition would need too many states.
        OSError: the file is missing or not readable.
    """
    automaton = _read(path, nondeterministic=False)
    assert not isinstance(automaton, OmegaAutomaton)
    return automaton


def read_any(path: str | os.PathLike[str]) -> DRA | DFA | OmegaAutomaton:
    """`read`, and a nondeterministic Buchi or generalized Buchi automaton in HOA as an `OmegaAutomaton`.

    Example:
        >>> import ltlc, tempfile
        >>> folder = Path(tempfile.mkdtemp())
        >>> read_any(ltlc.compile("FG a | GF b", form="limit-deterministic").save(folder / "any.hoa")).is_deterministic
        False
    """
    return _read(path, nondeterministic=True)


def _read(path: str | os.PathLike[str], *, nondeterministic: bool) -> DRA | DFA | OmegaAutomaton:
    check_type(path, (str, os.PathLike), "the path", "the name of a file")
    source = Path(path)
    try:
        text = source.read_bytes().decode("utf-8-sig")
        form = format_of_suffix(source.suffix)
        form = form if form is not None and form.reader is not None else _format_of(text)
        if nondeterministic and form.name == "hoa":
            from ltlc.formats.hoa_reader import from_hoa

            return from_hoa(text, nondeterministic=True)
        return form.read(text)
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{source}: not UTF-8 text (byte {error.start})") from None
    except FileFormatError as error:
        raise FileFormatError(f"{source}: {error}") from None


def _format_of(text: str) -> Format:
    form = format_of_content(text)
    if form is None:
        others = [name for name, one in FORMATS.items() if one.reader is not None and name not in ("json", "hoa")]
        more = "".join(f" nor {name}" for name in others)
        raise FileFormatError(f"neither JSON (which starts with '{{') nor HOA (which starts with 'HOA: v1'){more}")
    return form
