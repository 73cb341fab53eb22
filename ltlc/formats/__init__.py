"""The automaton as text and as a picture: JSON, HOA, DOT, Mermaid, SVG, PNG, PDF.

Examples: docs/examples.md.
"""

from ltlc.automata.formats import FORMATS, Format, register_format
from ltlc.formats.dot import to_dot
from ltlc.formats.files import read, write
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
    "read_hoa_stream",
    "register_format",
    "render",
    "to_dot",
    "to_hoa",
    "to_json",
    "to_mermaid",
    "write",
]
