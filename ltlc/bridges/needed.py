"""What a bridge says where the library on the other side is missing."""

from __future__ import annotations

from ltlc.errors import MissingProgramError


def missing(library: str, extra: str, error: ImportError) -> MissingProgramError:
    """The error of a bridge whose library cannot be imported.

    Args:
        library: its name in the package index.
        extra: of ours that installs it.
        error: why.
    """
    how = f"pip install {library}, or pip install 'ltlc[{extra}]'"
    return MissingProgramError(f"{library} cannot be imported ({error}); install it with: {how}")
