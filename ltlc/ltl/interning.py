"""Interning: of all objects with one key, at most one is alive.

This is invisible from outside: an entry goes with the last reference to its object.
"""

from __future__ import annotations

from threading import RLock
from typing import Any
from weakref import ref


class _Entry(ref[Any]):
    """The way to a living object from its key."""

    __slots__ = ("key",)
    key: tuple[Any, ...]


_entries: dict[tuple[Any, ...], _Entry] = {}
_replacing = RLock()  # held while an entry is taken out or replaced; to put one in where none is takes one step


def find(key: tuple[Any, ...]) -> Any:
    """The living object of a key, or None."""
    entry = _entries.get(key)
    return None if entry is None else entry()


def intern(key: tuple[Any, ...], made: Any) -> Any:
    """The object of a key: the one that was made, or the one that another thread put in before."""
    entry = _Entry(made, _forget)
    entry.key = key
    if _entries.setdefault(key, entry) is entry:
        return made
    with _replacing:  # another thread was faster, or the entry of an object that is no more is about to go
        known = find(key)
        if known is None:
            _entries[key] = entry
        return made if known is None else known


def _forget(entry: _Entry) -> None:
    with _replacing:
        if _entries.get(entry.key) is entry:
            del _entries[entry.key]
