"""What goes to stderr: one paragraph per problem."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Callable

_ADVICE = {
    errno.ENOSPC: "free some space, or choose another place",
    errno.EFBIG: "the size of files is limited here; choose another place, or raise the limit",
    errno.EACCES: "choose another place, or change the permissions",
    errno.EPERM: "choose another place, or change the permissions",
    errno.EROFS: "choose another place",
    errno.ENAMETOOLONG: "choose a shorter name",
}
"""what to do about an error of the operating system."""
_ADVICE[getattr(errno, "EDQUOT", errno.ENOSPC)] = _ADVICE[errno.ENOSPC]
_OF_WRITING = (errno.ENOSPC, errno.EFBIG, errno.EBADF, errno.EIO, errno.EPIPE)


def complain(problem: object, *, code: int = 2) -> int:
    """Print a problem, after what has been printed so far, and give the exit code back."""
    with contextlib.suppress(OSError):  # standard output may be the problem
        sys.stdout.flush()
    with contextlib.suppress(OSError):
        print(f"ltlc: {problem}", file=sys.stderr)
    return code


def complain_of_system(error: OSError) -> int:
    """Print an error of the operating system: where, what, and what to do about it."""
    if error.errno is None or not error.strerror:
        return complain(error)
    where = error.filename2 or error.filename
    if where is None and error.errno in _OF_WRITING:  # all else that is written has a name
        where = "standard output"
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # else the interpreter tries once more when it ends, and complains
    advice = _ADVICE.get(error.errno)
    what = f"{error.strerror}; {advice}" if advice else error.strerror
    return complain(what if where is None else f"{where}: {what}")


def shown_once() -> Callable[..., None]:
    """What prints a Python warning the first time: without the place in the code, which means nothing to a user."""
    shown: set[str] = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in shown:
            shown.add(str(message))
            complain(f"warning: {message}")

    return show
