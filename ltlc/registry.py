"""Parts by name: those of this package, those that a user's module registers, and those that installed packages offer.

A registry holds one kind of part (constructions, reward schemes, agents, formats, labellers). A name is looked for

1. among the parts that were registered, in the order of registration;
2. among the entry points of installed packages, in the group of the registry;
3. as `module:attribute`, in the current folder first; `path/to/file.py:attribute` works too.

A part may be registered as such a text. It is then imported when it is first asked for, and a list of names costs
nothing. A registry can be added to for as long as the program runs, because users register their own parts: that is its
purpose, and nothing else in the package changes after import.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from types import ModuleType
from typing import Any, Generic, TypeVar, overload

from ltlc.errors import InvalidArgumentError, UnknownNameError

T = TypeVar("T")


class Registry(Mapping[str, T], Generic[T]):
    """Parts of one kind by name; reads like a dictionary.

    Args:
        kind: what a part is called in messages, such as "reward scheme".
        group: the group of entry points in which installed packages offer parts.
        check: called with the name and what was registered or imported under it; returns the part, or raises
            InvalidArgumentError if it is none.

    Example:
        >>> colours = Registry[str]("colour", "ltlc.colours")
        >>> colours.register("teal", "string:digits")
        'string:digits'
        >>> list(colours), colours["teal"]
        (['teal'], '0123456789')
    """

    def __init__(self, kind: str, group: str, check: Callable[[str, Any], T] | None = None) -> None:
        self.kind = kind
        self.group = group
        self._check = check
        self._registered: dict[str, T | str] = {}
        self._found: dict[str, T] = {}
        self._offered: dict[str, Any] | None = None

    @overload
    def register(self, name: str, part: T | str) -> T | str: ...
    @overload
    def register(self, name: str) -> Callable[[T], T]: ...
    def register(self, name: str, part: T | str | None = None) -> Any:
        """Register a part, or the text `module:attribute` of one; without a part, a decorator.

        Returns:
            The part.

        Raises:
            InvalidArgumentError: the name is empty, contains a colon or is taken, or the part is none.
        """
        if part is None:
            return lambda decorated: self._add(name, decorated)
        return self._add(name, part)

    def _add(self, name: str, part: Any) -> Any:
        if not name or ":" in name or name != name.strip():
            raise InvalidArgumentError(f"{self.kind} {name!r}: a name has no colon and no spaces around")
        if name in self._registered and not _is_reloaded(self._registered[name], part):
            raise InvalidArgumentError(f"{self.kind} {name!r}: the name is taken; choose another")
        if not isinstance(part, str) and self._check is not None:
            part = self._check(name, part)
        self._registered[name] = part
        self._found.pop(name, None)
        return part

    def remove(self, name: str) -> None:
        """Forget a registered part, for tests and notebooks that register it again."""
        self._registered.pop(name, None)
        self._found.pop(name, None)

    def __getitem__(self, name: str) -> T:
        """The part of a name.

        Raises:
            UnknownNameError: there is none; suggests the nearest names.
            InvalidArgumentError: `module:attribute` cannot be imported or is no such part.
        """
        if name in self._found:
            return self._found[name]
        if name in self._registered:
            part: Any = self._registered[name]
            found = import_object(part, f"{self.kind} {name!r}") if isinstance(part, str) else part
        elif name in self._entry_points():
            found = self._load(name)
        elif ":" in name:
            found = import_object(name, self.kind)
        else:
            raise UnknownNameError(self.kind, name, self)
        self._found[name] = found if self._check is None else self._check(name, found)
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        yield from self._registered
        yield from (name for name in self._entry_points() if name not in self._registered)

    def registered(self) -> list[T]:
        """The parts that were registered, in this order: those that depend on nothing that happens to be installed."""
        return [self[name] for name in self._registered]

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __contains__(self, name: object) -> bool:
        return name in self._registered or name in self._entry_points()

    def _entry_points(self) -> dict[str, Any]:
        if self._offered is None:
            from importlib.metadata import entry_points  # a sixth of the time in which a program starts

            self._offered = {point.name: point for point in entry_points(group=self.group)}
        return self._offered

    def _load(self, name: str) -> Any:
        point = self._entry_points()[name]
        try:
            return point.load()
        except Exception as error:  # the package is somebody else's, so anything may happen
            raise InvalidArgumentError(
                f"{self.kind} {name!r}: the entry point {point.value} cannot be loaded "
                f"({type(error).__name__}: {error})"
            ) from error


def _is_reloaded(before: Any, now: Any) -> bool:
    """Whether a definition was run again, as in a notebook, or as a module that is imported by path and by name."""
    name = getattr(now, "__qualname__", None)
    return name is not None and getattr(before, "__qualname__", None) == name and before is not now


def import_object(text: str, purpose: str) -> Any:
    """What `module:attribute` means; modules of the current folder come first, `path/to/file.py:attribute` works too.

    Args:
        text: module and attribute, or file and attribute.
        purpose: what it is for, as messages begin.

    Raises:
        InvalidArgumentError: there is no such module, or it fails when it is imported.
        UnknownNameError: the module has nothing of that name.
    """
    place, colon, attribute = text.rpartition(":")
    if not colon or not place or not attribute:
        raise InvalidArgumentError(
            f"{purpose} {text!r}: expected module:name, such as sensors:labels for what sensors.py calls labels"
        )
    module = import_module(place, f"{purpose} {text!r}")
    found = module
    for step in attribute.split("."):
        if not hasattr(found, step):
            known = [key for key in vars(found) if not key.startswith("_")]
            raise UnknownNameError(f"name in {place}:", attribute, known)
        found = getattr(found, step)
    return found


def import_plugins() -> None:
    """Import the modules that the environment variable LTLC_PLUGINS names, with commas between, so that they register.

    Raises:
        InvalidArgumentError: one cannot be imported.
    """
    for place in filter(None, map(str.strip, os.environ.get("LTLC_PLUGINS", "").split(","))):
        import_module(place, "LTLC_PLUGINS")


def import_module(place: str, purpose: str) -> ModuleType:
    """A module by its name, from the current folder first, or by its file.

    Raises:
        InvalidArgumentError: there is none, or it fails when it is imported; the message begins with `purpose`.
    """
    try:
        if place.endswith(".py"):
            return _from_file(place)
        sys.path.insert(0, os.getcwd())
        try:
            return importlib.import_module(place)
        finally:
            sys.path.pop(0)
    except (Exception, SystemExit) as error:  # the module is the user's, so anything may happen
        absent = isinstance(error, FileNotFoundError) or (
            isinstance(error, ModuleNotFoundError) and error.name in (place, place.split(".", maxsplit=1)[0])
        )
        if absent:
            why = f"there is no module {place} here in {os.getcwd()}, nor installed"
        else:
            why = f"importing {place} fails ({type(error).__name__}: {error})"
        raise InvalidArgumentError(f"{purpose}: {why}") from error


def _from_file(place: str) -> ModuleType:
    from importlib.util import module_from_spec, spec_from_file_location
    from pathlib import Path

    path = Path(place)
    spec = spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise FileNotFoundError(path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
