"""Files that are either complete or not there."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path


def atomic_write(path: str | os.PathLike[str], data: str | bytes) -> Path:
    """Write a whole file at once: a reader sees the old content or the new one, never a part.

    The data goes to a temporary file in the same folder, which then replaces `path`. On any failure the temporary
    file is removed and `path` is as it was. An existing file keeps its permissions, a new one gets those the umask
    grants; a symbolic link stays a link, and the file it points to is replaced. Text is written as UTF-8, its line
    ends as they are.

    Returns:
        The path that was written.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    target = Path(path)
    real = Path(os.path.realpath(target))
    content = data.encode("utf-8") if isinstance(data, str) else data
    try:
        mode = stat.S_IMODE(real.stat().st_mode)
    except FileNotFoundError:
        mode = 0o666 & ~_umask()
    handle, temporary = tempfile.mkstemp(prefix=f".{real.name}.", suffix=".tmp", dir=real.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, mode)
        os.replace(temporary, real)
    except BaseException:
        os.unlink(temporary)
        raise
    return target


def _umask() -> int:
    # The umask can only be read by setting it; the value goes straight back.
    current = os.umask(0o077)
    os.umask(current)
    return current
