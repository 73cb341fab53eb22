"""LTL to deterministic Rabin automata to rewards."""

from pathlib import Path as _Path

# The wheel carries agents/ and grammars/ inside this package; a checkout keeps them beside it.
if not _Path(__path__[0], "agents").is_dir():
    __path__.append(str(_Path(__path__[0]).parent))
