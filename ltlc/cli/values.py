"""`key=value` texts as typed values: a word is what the key says it is, and no text is taken for true."""

from __future__ import annotations

import dataclasses
import json
import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ltlc.errors import InvalidArgumentError, UnknownNameError

_BOOLEANS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
_NOTHING = {"none": None, "null": None}
_WANTED: dict[Any, str] = {
    bool: "on or off (true or false, yes or no)",
    int: "a whole number",
    float: "a number",
    type(None): "none",
    tuple: "a list, such as 64,64",
}


def assignments(texts: Sequence[str] | None, option: str, kinds: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """`key=value` texts as a dict, each value of the kind of its key.

    Args:
        texts: as typed.
        option: that they are of, for messages.
        kinds: an annotation for each key, made of `bool`, `int`, `float`, `str`, `None`, `Literal`, and tuples. The
            value of another key is JSON where it can be read so, `True`, `False` and `None` as Python writes them, and
            text elsewhere.

    Raises:
        InvalidArgumentError: one has no `=`, a key is there twice, or a value is of another kind.
        UnknownNameError: a value is none of those that its key can have.
    """
    values: dict[str, Any] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        key = name.strip().replace("-", "_")
        if not equals or not key:
            raise InvalidArgumentError(f"{option} {text!r}: expected KEY=VALUE")
        if key in values:
            raise InvalidArgumentError(f"{option} gives {key} twice; give it once")
        values[key] = _read(key, value.strip(), (kinds or {}).get(key, Any))
    return values


def kinds_of(fields: type[Any]) -> dict[str, Any]:
    """The annotation of each field of a dataclass."""
    hints = typing.get_type_hints(fields)
    return {field.name: hints[field.name] for field in dataclasses.fields(fields)}


def _read(key: str, text: str, kind: Any) -> Any:
    alternatives = typing.get_args(kind) if typing.get_origin(kind) in (typing.Union, types.UnionType) else (kind,)
    for alternative in alternatives:
        try:
            return _read_as(text, alternative)
        except ValueError:
            continue
    wanted = []
    for alternative in alternatives:
        if typing.get_origin(alternative) is Literal:
            raise UnknownNameError(f"value of {key}", text, typing.get_args(alternative))
        wanted.append(_WANTED[typing.get_origin(alternative) or alternative])
    raise InvalidArgumentError(f"{key} is {text!r:.80}; it must be {' or '.join(wanted)}")


def _read_as(text: str, kind: Any) -> Any:
    """The text as one kind.

    Raises:
        ValueError: it is of another kind.
    """
    base = typing.get_origin(kind) or kind
    if base is types.NoneType:
        return _of(_NOTHING, text.lower())
    if base is bool:
        return _of(_BOOLEANS, text.lower())
    if base is float and not _is_whole(text):
        return float(text)
    if base in (int, float):
        return int(text)
    if base is tuple:
        return tuple(json.loads(text if text.startswith("[") else f"[{text}]"))
    if base is Literal:
        return _of({word: word for word in typing.get_args(kind)}, _unquoted(text))
    if base is str:
        return _unquoted(text)
    return _guessed(text)


def _is_whole(text: str) -> bool:
    return text.lstrip("+-").isdigit()


def _of(words: Mapping[str, Any], text: str) -> Any:
    if text not in words:
        raise ValueError(text)
    return words[text]


def _unquoted(text: str) -> str:
    quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "\"'"
    return text[1:-1] if quoted else text


def _guessed(text: str) -> Any:
    if text in ("True", "False", "None"):
        return {"True": True, "False": False, "None": None}[text]
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text
