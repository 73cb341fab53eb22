"""A JSON document that is read piece by piece, with a message that names the place where it is wrong."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from typing import Any

from ltlc.errors import FileFormatError


def load_json(text: str) -> object:
    """The value of a JSON text.

    Raises:
        FileFormatError: it is none, or a key occurs twice in one object.
    """
    try:
        return json.loads(text, object_pairs_hook=_object, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise FileFormatError(f"line {error.lineno}, column {error.colno}: not JSON: {error.msg}") from None
    except RecursionError:
        raise FileFormatError("not an automaton: brackets are nested too deeply") from None
    except ValueError as error:  # an integer with thousands of digits, or one of the two hooks below
        raise FileFormatError(f"not JSON that can be read: {error}") from None


def _object(members: list[tuple[str, object]]) -> dict[str, object]:
    result = dict(members)
    if len(result) < len(members):
        twice = Counter(key for key, _ in members).most_common(1)[0][0]
        raise ValueError(f"the key {twice!r} occurs twice in one object")
    return result


def _no_constant(name: str) -> object:
    raise ValueError(f"{name} is not a JSON number")


class Node:
    """A value of the document together with its key path, which every message names."""

    def __init__(self, value: object, path: str) -> None:
        self.value = value
        self.path = path

    def fail(self, message: str) -> FileFormatError:
        """The error with the key path."""
        return FileFormatError(f"{self.path}: {message}" if self.path else message)

    def check(self, condition: bool, message: str) -> None:
        """Raise it unless the condition holds."""
        if not condition:
            raise self.fail(message)

    def _expect(self, kind: type, wanted: str) -> Any:
        # JSON's true is an int for Python, but not for a reader.
        if not isinstance(self.value, kind) or isinstance(self.value, bool):
            raise self.fail(f"expected {wanted}, found {describe(self.value)}")
        return self.value

    def _members(self) -> Mapping[str, object]:
        members: Mapping[str, object] = self._expect(dict, "an object")
        return members

    def has(self, key: str) -> bool:
        """Whether an object has a key."""
        return key in self._members()

    def __getitem__(self, key: str) -> Node:
        members = self._members()
        if key not in members:
            raise self.fail(f"the key {key!r} is missing")
        return Node(members[key], f"{self.path}.{key}" if self.path else key)

    def items(self) -> list[Node]:
        """The entries of a list."""
        return [Node(item, f"{self.path}[{i}]") for i, item in enumerate(self._expect(list, "a list"))]

    def text(self) -> str:
        """The value as text."""
        value: str = self._expect(str, "a string")
        # Half of a surrogate pair cannot be written to any file again.
        self.check(not any("\ud800" <= letter <= "\udfff" for letter in value), "half of a surrogate pair")
        return value

    def name(self) -> str:
        """The value as text that is not empty."""
        value = self.text()
        self.check(bool(value), "a proposition needs a name")
        return value

    def text_or_none(self) -> str | None:
        """The value as text, or None for null."""
        return None if self.value is None else self.text()

    def one_of(self, *known: str) -> str:
        """The value as one of some texts."""
        value = self.text()
        self.check(value in known, f"expected {' or '.join(map(repr, known))}, found {describe(value)}")
        return value

    def index(self, count: int | None = None, what: str = "") -> int:
        """The value as a number from 0 on, below `count`."""
        value: int = self._expect(int, "a number")
        self.check(value >= 0, f"{describe(value)} is negative")
        self.check(count is None or value < count, f"{describe(value)} is out of range, there are {count} {what}")
        return value


def describe(value: object) -> str:
    """A value for a message."""
    if isinstance(value, (dict, list)):
        return "an object" if isinstance(value, dict) else "a list"
    if isinstance(value, int) and value.bit_length() > 100:
        return "a huge number"
    shown = json.dumps(value)
    return shown if len(shown) <= 40 else shown[:37] + "..."
