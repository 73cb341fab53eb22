"""The automaton as text and as a picture: JSON, HOA, DOT, Mermaid, SVG, PNG, PDF.

Readers and writers are imported on first use: most programs want one of them or none.

Examples: docs/examples.md.
"""

from typing import TYPE_CHECKING

from ltlc.automata.formats import FORMATS, Format, register_format
from ltlc.lazy import on_first_use

if TYPE_CHECKING:
    from ltlc.formats.dot import to_dot
    from ltlc.formats.files import read, read_any, write
    from ltlc.formats.hoa import to_hoa
    from ltlc.formats.hoa_reader import from_hoa, read_hoa_stream
    from ltlc.formats.json import from_json, to_json
    from ltlc.formats.mermaid import to_mermaid
    from ltlc.formats.picture import render

__all__ = [
    "FORMATS",
    "Format",
    "from_hoa",
    "from_json",
    "read",
    "read_any",
    "read_hoa_stream",
    "register_format",
    "render",
    "to_dot",
    "to_hoa",
    "to_json",
    "to_mermaid",
    "write",
]

_HOME = {
    "from_hoa": "ltlc.formats.hoa_reader",
    "from_json": "ltlc.formats.json",
    "read": "ltlc.formats.files",
    "read_any": "ltlc.formats.files",
    "read_hoa_stream": "ltlc.formats.hoa_reader",
    "render": "ltlc.formats.picture",
    "to_dot": "ltlc.formats.dot",
    "to_hoa": "ltlc.formats.hoa",
    "to_json": "ltlc.formats.json",
    "to_mermaid": "ltlc.formats.mermaid",
    "write": "ltlc.formats.files",
}

if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = on_first_use(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
