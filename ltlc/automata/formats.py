"""File formats of automata by name and by suffix; what writes and reads them is imported when it is first needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ltlc.errors import InvalidArgumentError
from ltlc.registry import Registry, import_object

if TYPE_CHECKING:
    from ltlc.automata.finite import DFA
    from ltlc.automata.omega import OmegaAutomaton
    from ltlc.automata.rabin import DRA

Writer = Callable[["DRA"], str | bytes]
Reader = Callable[[str], "DRA | DFA"]


@dataclass(frozen=True)
class Format:
    """A way to keep an automaton in a file.

    Attributes:
        name: by which the command line knows it.
        suffixes: of files, in lower case, such as ".hoa".
        help: one sentence: what it is, and what for.
        writer: returns the content of a file for an automaton, or the text `module:function` of what does. It is given
            `ltlc.DFA`, too, which has the tables of a state-based automaton with one pair.
        reader: returns the automaton of a content, or raises FileFormatError; None where nothing reads it back.
        begins: what a content begins with, after blanks, so that it is recognised under any name.

    Example:
        >>> FORMATS["hoa"].suffixes
        ('.hoa',)
    """

    name: str
    suffixes: tuple[str, ...]
    help: str
    writer: Writer | str
    reader: Reader | str | None = None
    begins: tuple[str, ...] = ()

    def write(self, automaton: DRA | DFA | OmegaAutomaton) -> bytes:
        """The content of a file; text is UTF-8."""
        self.check(automaton)
        writer = self._imported(self.writer)
        content: str | bytes = writer(automaton)
        return content.encode("utf-8") if isinstance(content, str) else content

    def check(self, automaton: object) -> None:
        """Raise InvalidArgumentError if the automaton is of a form that this format does not have."""
        known = getattr(automaton, "formats", (self.name,))
        if self.name not in known:
            form, written = getattr(automaton, "form", ""), " or ".join(known)
            raise InvalidArgumentError(f"automata of the form {form} are written as {written}, not as {self.name}")

    def read(self, text: str) -> DRA | DFA:
        """The automaton of a content.

        Raises:
            InvalidArgumentError: nothing reads this format.
            FileFormatError: it is none; says where.
        """
        if self.reader is None:
            known = " and ".join(name for name, form in FORMATS.items() if form.reader is not None)
            raise InvalidArgumentError(f"nothing reads the format {self.name!r}; {known} are read")
        automaton: DRA | DFA = self._imported(self.reader)(text)
        return automaton

    def _imported(self, function: Any) -> Any:
        return import_object(function, f"the format {self.name!r}") if isinstance(function, str) else function


def _check(name: str, part: Any) -> Format:
    if not isinstance(part, Format):
        raise InvalidArgumentError(f"format {name!r}: {part!r} is no ltlc.formats.Format")
    odd = [suffix for suffix in part.suffixes if suffix[:1] != "." or suffix != suffix.lower() or len(suffix) < 2]
    if odd or isinstance(part.suffixes, str) or not part.suffixes:
        raise InvalidArgumentError(f"format {name!r}: suffixes are {part.suffixes!r}; expected some like ('.hoa',)")
    return part


FORMATS: Registry[Format] = Registry("format", "ltlc.formats", _check)
"""every format, by the name that the command line knows; `module:attribute` is a name, too."""


def register_format(form: Format) -> Format:
    """Make a format known by its name and its suffixes.

    Installed packages offer theirs in the group of entry points "ltlc.formats".

    Raises:
        InvalidArgumentError: it is no format, or another one has its name or one of its suffixes.

    Example:
        >>> from ltlc.formats import FORMATS, Format, register_format
        >>> form = register_format(Format("size", (".size",), "The number of states.", lambda dra: f"{dra.n_states}"))
        >>> FORMATS.remove("size")
    """
    _check(getattr(form, "name", ""), form)
    for suffix in form.suffixes:
        other = next((one.name for one in map(FORMATS.get, FORMATS) if one and suffix in one.suffixes), form.name)
        if other != form.name:
            raise InvalidArgumentError(f"format {form.name!r}: the suffix {suffix} is that of the format {other!r}")
    FORMATS.register(form.name, form)
    return form


for _form in (
    Format(
        "json",
        (".json",),
        "Everything about the automaton, annotations included; for programs.",
        "ltlc.formats.json:to_json",
        "ltlc.formats.json:from_json",
        ("{",),
    ),
    Format(
        "hoa",
        (".hoa",),
        "Hanoi Omega-Automata, version 1; for other tools.",
        "ltlc.formats.hoa:to_hoa",
        "ltlc.formats.hoa_reader:from_hoa",
        ("HOA:", "/*"),
    ),
    Format("dot", (".dot",), "The picture as Graphviz source.", "ltlc.formats.dot:to_dot"),
    Format("mermaid", (".mmd",), "The picture as a Mermaid diagram.", "ltlc.formats.mermaid:to_mermaid"),
    Format("markdown", (".md",), "The Mermaid diagram in a Markdown fence.", "ltlc.formats.mermaid:to_markdown"),
    Format("svg", (".svg",), "The picture, drawn by Graphviz or graphviz-pure.", "ltlc.formats.picture:to_svg"),
    Format("png", (".png",), "The picture, drawn by Graphviz or graphviz-pure.", "ltlc.formats.picture:to_png"),
    Format("pdf", (".pdf",), "The picture, drawn by Graphviz.", "ltlc.formats.picture:to_pdf"),
):
    FORMATS.register(_form.name, _form)


def suffixes() -> tuple[str, ...]:
    """Suffixes of all formats."""
    return tuple(suffix for form in FORMATS.values() for suffix in form.suffixes)


def format_of_suffix(suffix: str) -> Format | None:
    """The format whose files have a suffix; None if there is none."""
    return next((form for form in FORMATS.values() if suffix.lower() in form.suffixes), None)


def format_of_content(text: str) -> Format | None:
    """The format whose contents begin as a text does; None if there is none."""
    start = text.lstrip()
    return next((form for form in FORMATS.values() if form.reader and start.startswith(form.begins)), None)
