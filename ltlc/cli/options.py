"""What a command takes, described once, and plain command lines read by that description.

A parameter of a command is `Annotated[type, Option(...)]` or `Annotated[type, Argument(...)]`, with its default as that
of the parameter. `ltlc.cli.typer_app` makes the same description into an application of typer, which knows all ways to
write a command line, explains what is wrong with one, prints help and completes words. To load it takes longer than to
compile a small formula, so what `read` understands does without.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from types import NoneType, UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints


class Argument:
    """A word at its place.

    Attributes:
        metavar: what the help calls it; None: as the parameter.
        help: one sentence.
        is_path: an empty one, as of a variable that is not set, is an error.
    """

    def __init__(self, *, metavar: str | None = None, help: str, is_path: bool = False) -> None:
        self.metavar, self.help, self.is_path = metavar, help, is_path


class Option:
    """A flag if its type is bool, else a name with a value behind it.

    Attributes:
        names: the long one first.
        help: one sentence.
        metavar: what the help calls the value; None: as the type says.
        is_path: an empty one, as of a variable that is not set, is an error.
        least: the smallest number allowed, or None.
        shown_default: what the help says of the default; None: the value.
        completion: the values that begin with a text.
    """

    def __init__(
        self,
        *names: str,
        help: str,
        metavar: str | None = None,
        is_path: bool = False,
        least: float | None = None,
        shown_default: str | None = None,
        completion: Callable[[str], list[str]] | None = None,
    ) -> None:
        self.names, self.help, self.metavar, self.is_path = names, help, metavar, is_path
        self.least, self.shown_default, self.completion = least, shown_default, completion


def parameters_of(command: Callable[..., object]) -> Iterator[tuple[inspect.Parameter, Any, Option | Argument]]:
    """The parameters of a command, each with its type and what describes it."""
    hints = get_type_hints(command, include_extras=True)
    for parameter in inspect.signature(command).parameters.values():
        kind, description = get_args(hints[parameter.name])
        yield parameter, kind, description


def read(command: Callable[..., object], words: Sequence[str]) -> dict[str, Any] | None:
    """The values that a command line gives to the parameters of a command.

    Args:
        command: whose parameters are described.
        words: behind its name.

    Returns:
        A value for each parameter; None if the words ask for help, are wrong, or are written in a way that only typer
        knows: as `--name=value`, or with a value or a word at its place that begins with a dash.
    """
    options: dict[str, tuple[str, Any, Option]] = {}
    places: list[tuple[str, Any, Argument]] = []
    values: dict[str, Any] = {}
    missing: set[str] = set()
    for parameter, kind, description in parameters_of(command):
        if parameter.default is inspect.Parameter.empty:
            missing.add(parameter.name)
        values[parameter.name] = parameter.default
        if isinstance(description, Argument):
            places.append((parameter.name, kind, description))
        else:
            options |= dict.fromkeys(description.names, (parameter.name, kind, description))
    given: dict[str, Any] = {}
    waiting, named = iter(places), iter(words)
    try:
        for word in named:
            is_dashed = word.startswith("-") and word != "-"
            name, kind, description = options[word] if is_dashed else next(waiting)
            if kind is bool:
                given[name] = True
                continue
            text = next(named) if is_dashed else word
            value = _value(text, _without_none(kind), description)
            given[name] = [*given.get(name, ()), *value] if isinstance(value, list) else value
    except (KeyError, StopIteration, ValueError):
        return None
    return values | given if missing <= given.keys() else None


def _value(text: str, kind: Any, description: Option | Argument) -> Any:
    """The value of a word; that of an option which may be repeated is a list of one.

    Raises:
        ValueError: only typer can say what to make of it.
    """
    if (text.startswith("-") and text != "-") or (description.is_path and not text.strip()):
        raise ValueError
    if get_origin(kind) is list:
        return [_value(text, get_args(kind)[0], description)]
    if get_origin(kind) is Literal:
        return get_args(kind)[get_args(kind).index(text)]
    if kind in (int, float):
        number = kind(text)
        least = getattr(description, "least", None)
        if least is not None and not number >= least:
            raise ValueError
        return number
    if kind is not str:
        raise ValueError
    return text


def _without_none(kind: Any) -> Any:
    """`T` of `T | None`."""
    if not isinstance(kind, UnionType):
        return kind
    (rest,) = (each for each in get_args(kind) if each is not NoneType)
    return rest
