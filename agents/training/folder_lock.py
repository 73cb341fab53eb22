"""The sole right to write into a run folder."""

from __future__ import annotations

import contextlib
import os
import platform
import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from ltlc.atomic import is_at, lock_file, remove_leftovers
from ltlc.errors import InvalidArgumentError

LOCK_FILE = "run.lock"


@contextlib.contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Make a folder if it is not there, and keep every other process from training in it meanwhile.

    The operating system holds the lock, so that of a killed process is gone. Folders that were made and stay empty are
    removed.

    Raises:
        InvalidArgumentError: somebody else has the lock, the message says who; or the path is that of a file.
        OSError: the folder cannot be made or written.
    """
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        what = "is a file" if folder.exists() else "is a link that leads nowhere"
        raise InvalidArgumentError(f"{folder} {what}; give a folder for the run") from None
    try:
        with _locked(folder / LOCK_FILE):
            remove_leftovers(folder)
            yield
    finally:
        for place in made:
            with contextlib.suppress(OSError):  # it is not empty
                place.rmdir()


def is_locked(folder: Path) -> bool:
    """Whether some process has the sole right to write into a folder now."""
    try:
        with (folder / LOCK_FILE).open("r+", encoding="utf-8") as stream:
            return not lock_file(stream.fileno())
    except OSError:  # there is no such file, or no locks in this file system
        return False


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    stream = _open_locked(path)
    try:
        with contextlib.suppress(OSError):  # whoever cannot read the name is refused all the same
            stream.truncate(0)
            stream.write(f"process {os.getpid()} on {platform.node()} since {time.strftime('%Y-%m-%d %H:%M:%S')}\n")
            stream.flush()
        yield
    finally:
        if sys.platform == "win32":  # which does not remove open files, whoever has opened them
            stream.close()
        with contextlib.suppress(OSError):
            path.unlink()
        stream.close()


def _open_locked(path: Path) -> TextIO:
    while True:
        stream = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o666), "r+", encoding="utf-8", errors="replace")
        try:
            free = lock_file(stream.fileno())
        except OSError as error:
            warnings.warn(
                f"{path.parent}: the file system has no locks ({error.strerror}); see to it that nothing else trains "
                "in this folder",
                stacklevel=2,
            )
            return stream
        if not free:
            with stream:
                holder = stream.read(200).strip() or "another process"
            raise InvalidArgumentError(
                f"{path.parent} is in use: {holder} trains in it; wait until that ends, or give another folder"
            )
        if is_at(stream.fileno(), path):
            return stream
        stream.close()  # the holder before has just removed it
