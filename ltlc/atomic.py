"""Files that are either complete or not there, and locks on them."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_TEMPORARY = re.compile(r"\.ltlc-[0-9a-f]{16}\.tmp")
_LONG_AGO = 86_400.0
"""seconds after which a temporary file is nobody's, where locks cannot say so."""

Content = str | bytes | memoryview
"""of a file."""


def atomic_write(path: str | os.PathLike[str], data: Content) -> Path:
    """Write a whole file at once: a reader sees the old content or the new one, never a part.

    The data goes to a temporary file in the same folder, which then replaces `path`. On any failure the temporary
    file is removed and `path` is as it was; what a killed process left is removed by the next write into the folder.
    An existing file keeps its permissions, a new one gets those the umask grants; a symbolic link stays a link, and
    the file it points to is replaced. A device or a pipe is written to. Text is written as UTF-8, its line ends as they
    are.

    Returns:
        The path that was written.

    Raises:
        OSError: the folder is missing, not writable or full; `filename` is the path.
    """
    return atomic_write_all({Path(path): data})[0]


def atomic_write_all(files: Mapping[Path, Content], *, instead_of: Iterable[Path] = ()) -> tuple[Path, ...]:
    """Write several files, each as `atomic_write` does; none takes its place before all are on the disk.

    Args:
        files: contents by path.
        instead_of: files to remove, in this order, when the new ones are on the disk and not yet in place.

    Returns:
        The paths that were written. A process killed while files take their places leaves the first ones.

    Raises:
        OSError: as of `atomic_write`; all files are as they were, but for a failure while they take their places.
    """
    with contextlib.ExitStack() as stack:
        staged = [stack.enter_context(_Staged(target, data)) for target, data in files.items()]
        for old in instead_of:
            old.unlink(missing_ok=True)
        for file in staged:
            file.place()
    return tuple(files)


def remove_leftovers(folder: str | os.PathLike[str]) -> None:
    """Remove the temporary files that killed processes have left in a folder; those of living ones stay."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _TEMPORARY.fullmatch(entry.name):
                with contextlib.suppress(OSError):
                    _remove_if_abandoned(entry.path)


def lock_file(handle: int) -> bool:
    """Lock an open file for this process; False where it is locked already.

    The lock ends when the file is closed, thus also with the process, however that ends.

    Raises:
        OSError: the file system knows no locks.
    """
    if sys.platform == "win32":
        os.lseek(handle, 1 << 30, os.SEEK_SET)  # far behind the content, which stays readable
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
    else:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


def is_at(handle: int, path: str | os.PathLike[str]) -> bool:
    """Whether the open file is the one at the path, and not one that was removed or replaced."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


class _Staged:
    """A file that is written and not yet in its place; the end of the context removes it if it never gets there."""

    def __init__(self, target: Path, data: Content) -> None:
        self._target = target
        self._content = data.encode("utf-8") if isinstance(data, str) else data
        self._real = Path(os.path.realpath(target))
        self._handle, self._name = -1, ""

    def __enter__(self) -> _Staged:
        with _named(self._target), contextlib.ExitStack() as on_failure:
            on_failure.push(self.__exit__)
            mode = self._mode_there()
            if mode is not None and stat.S_ISDIR(mode):
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            if mode is None or stat.S_ISREG(mode):
                remove_leftovers(self._real.parent)
                self._handle, self._name = _open_temporary(self._real.parent)
                self._fill()
            on_failure.pop_all()
        return self

    def place(self) -> None:
        """Put the file in its place."""
        with _named(self._target):
            if self._handle < 0:  # a device or a pipe
                self._real.write_bytes(self._content)
                return
            if not self._name:
                self._name = self._linked()
            if sys.platform == "win32":
                self._close()
            os.replace(self._name, self._real)
            self._name = ""

    def __exit__(self, *_: object) -> None:
        self._close()
        if self._name:
            with contextlib.suppress(OSError):
                os.unlink(self._name)

    def _mode_there(self) -> int | None:
        try:
            return self._real.stat().st_mode
        except FileNotFoundError:
            return None

    def _fill(self) -> None:
        """Write the content to the open file; an older file passes its permissions on."""
        with open(self._handle, "wb", closefd=False) as stream:
            stream.write(self._content)
        os.fsync(self._handle)
        mode = self._mode_there()
        if mode is not None:
            os.chmod(self._handle if os.chmod in os.supports_fd else self._name, stat.S_IMODE(mode))

    def _linked(self) -> str:
        """A name for the open file, which has none."""
        name = _temporary_name(self._real.parent)
        try:
            # Only with a folder given is the link followed to the file; the path is absolute, so any does.
            os.link(f"/proc/self/fd/{self._handle}", name, src_dir_fd=self._handle)
        except OSError:  # a system without /proc, or one that forbids it: write once more
            self._close()
            self._handle, self._name = _open_named(self._real.parent)
            self._fill()
            return self._name
        return name

    def _close(self) -> None:
        if self._handle >= 0:
            os.close(self._handle)
        self._handle = -1


def _open_temporary(folder: Path) -> tuple[int, str]:
    """A new file, locked, and its name; on Linux it has none, so that it vanishes with a process that is killed."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):  # not every file system can
            handle = os.open(folder, os.O_TMPFILE | os.O_WRONLY, 0o666)
            _lock_if_possible(handle)
            return handle, ""
    return _open_named(folder)


def _open_named(folder: Path) -> tuple[int, str]:
    while True:
        name = _temporary_name(folder)
        flags = os.O_CREAT | os.O_EXCL | os.O_WRONLY | getattr(os, "O_BINARY", 0)
        handle = os.open(name, flags, 0o666)
        if _lock_if_possible(handle) and is_at(handle, name):
            return handle, name
        os.close(handle)  # removed as a leftover before it was locked


def _temporary_name(folder: Path) -> str:
    return str(folder / f".ltlc-{os.urandom(8).hex()}.tmp")


def _lock_if_possible(handle: int) -> bool:
    """Lock a file; True also where there are no locks, since nobody takes the file for a leftover there."""
    try:
        return lock_file(handle)
    except OSError:
        return True


def _remove_if_abandoned(path: str) -> None:
    if sys.platform == "win32":  # an open file cannot be removed; one that waits to be renamed is young
        if time.time() - os.stat(path).st_mtime > _LONG_AGO:
            os.unlink(path)
        return
    handle = os.open(path, os.O_WRONLY | os.O_NOFOLLOW)
    try:
        if lock_file(handle):
            os.unlink(path)
    finally:
        os.close(handle)


@contextlib.contextmanager
def _named(target: Path) -> Iterator[None]:
    """Let errors speak of the file that was wanted, not of a temporary one."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(target)) from error
