"""What goes to stderr: one paragraph per problem."""

from __future__ import annotations

import sys
from typing import TextIO


def complain(problem: object, *, code: int = 2) -> int:
    """Print a problem, after what has been printed so far, and give the exit code back."""
    sys.stdout.flush()
    print(f"ltlc: {problem}", file=sys.stderr)
    return code


def show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Print a Python warning without the place in the code, which means nothing to a user."""
    complain(f"warning: {message}")
