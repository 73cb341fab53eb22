"""Labels: what a user says holds in an observation.

`labels` is given as a function of one observation, as a dict from name to predicate on one observation, as the text
`module:name` of either, or not at all where the environment's info has an entry "labels". A function may also ask for
the info and the environment, and then takes `(observation, info)` or `(observation, info, env)`.

A label says which propositions hold. Whatever produces it, it may come as a set, list or tuple of names, as an event
string ("A B", "A,B", ""), as a dict from name to bool, or, where the producer declares its vocabulary, as a bitmask
(bit i = i-th name) or a boolean array. `ltlc.envs.letters` turns labels into the letters an automaton reads.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.registry import Registry, import_object

ExtraLabels = Literal["error", "ignore"]
LabelSource = Callable[..., Any] | Mapping[str, Callable[..., Any] | str] | str | None

SIGNATURES = ("(observation)", "(observation, info)", "(observation, info, env)")
BATCH_SIGNATURES = ("(observations)", "(observations, infos)")
_FILLED_BY_NAME = ("", "info", "env")
_SHOWN = 200
"""characters of an observation in a message."""


@dataclass(frozen=True)
class LabelFunction:
    """A labelling function that declares which names it can produce.

    Declaring them lets misspelt propositions be found before the first step, and permits labels that are bitmasks.

    Attributes:
        function: what labels one observation, or a batch.
        propositions: the names; bit i of a bitmask is the i-th.
    """

    function: Callable[..., Any]
    propositions: tuple[str, ...]

    def __call__(self, *arguments: Any) -> Any:
        """The label of one observation, or of a batch."""
        return self.function(*arguments)


LABELLERS: Registry[Any] = Registry("labeller", "ltlc.labellers")
"""labelling functions and dicts of predicates by name; empty, but for what users and installed packages register."""

_L = TypeVar("_L")


def register_labeller(name: str) -> Callable[[_L], _L]:
    """Make labels known by a name, which then can be given wherever `module:name` can; a decorator.

    Installed packages offer theirs in the group of entry points "ltlc.labellers".

    Raises:
        InvalidArgumentError: the name is taken, or there is a colon in it.

    Example:
        >>> from ltlc.envs import register_labeller
        >>> @register_labeller("even")
        ... def even(observation: int) -> set[str]:
        ...     return {"even"} if observation % 2 == 0 else set()
        >>> Source("even").function(4)
        {'even'}
        >>> LABELLERS.remove("even")
    """
    return LABELLERS.register(name)


def _named(text: str) -> Any:
    """The labels that a text means."""
    if text in LABELLERS:
        return LABELLERS[text]
    if ":" not in text and len(LABELLERS):
        raise UnknownNameError("labeller", text, LABELLERS)
    return import_object(text, "labels")


class Source:
    """Labels as a user gives them, ready to be called.

    Attributes:
        labels: as they were given. Text is imported anew where this was pickled.
        given: the function or the predicates.
        function: what returns a label.
        arity: how many of (observation, info, env) it takes.
        propositions: the names it can produce; None if they are not declared.

    Args:
        labels: a function, a dict of predicates, or the text `module:name` of either, or the name of a registered one.
        signatures: what functions may take.

    Raises:
        InvalidArgumentError: `labels` is nothing of that kind, cannot be imported, or takes other arguments.
        UnknownNameError: the module has nothing of that name.
    """

    def __init__(self, labels: LabelSource, signatures: tuple[str, ...] = SIGNATURES) -> None:
        self.labels, self.signatures = labels, signatures
        self._find()

    def _find(self) -> None:
        found: Any = _named(self.labels) if isinstance(self.labels, str) else self.labels
        self.given = found
        self.function: Callable[..., Any]
        self.propositions: tuple[str, ...] | None = None
        if isinstance(found, Mapping):
            predicates = _Predicates(found, self.signatures)
            self.function, self.arity, self.propositions = predicates, predicates.arity, tuple(found)
        elif callable(found):
            self.function, self.arity = found, arity(found, self.signatures)
            declared = getattr(found, "propositions", None)
            self.propositions = None if declared is None else tuple(declared)
        else:
            what = f"{self.labels!r} is {found!r}" if isinstance(self.labels, str) else f"got {found!r}"
            raise InvalidArgumentError(
                f"labels must be a function of {_one_of(self.signatures)}, a dict of predicates, the text module:name "
                f"of either, or None; {what}"
            )

    def __getstate__(self) -> dict[str, Any]:
        return {"labels": self.labels, "signatures": self.signatures}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__ |= state
        self._find()


class _Predicates:
    """Evaluates every predicate on the observation."""

    def __init__(self, predicates: Mapping[str, Any], signatures: tuple[str, ...]) -> None:
        self.each: list[tuple[str, Callable[..., Any], int]] = []
        for name, given in predicates.items():
            predicate = import_object(given, f"the predicate {name!r}") if isinstance(given, str) else given
            if not callable(predicate):
                raise InvalidArgumentError(
                    f"the predicate {name!r} is {predicate!r}, not a function of {_one_of(signatures)}"
                )
            self.each.append((name, predicate, arity(predicate, signatures)))
        self.arity = max((n for _, _, n in self.each), default=1)

    def __call__(self, *arguments: Any) -> dict[str, Any]:
        if self.arity == 1:
            (observation,) = arguments
            return {name: predicate(observation) for name, predicate, _ in self.each}
        return {name: predicate(*arguments[:n]) for name, predicate, n in self.each}


def arity(function: Callable[..., Any], signatures: tuple[str, ...] = SIGNATURES) -> int:
    """How many arguments a labelling function takes: as many as it needs, and at least the observation.

    Arguments with a default value keep it, unless they are called `info` and `env`. Where nothing can be known, as with
    `*args` and some builtin functions, it is one.

    Raises:
        InvalidArgumentError: the function takes other arguments than `signatures` says.
    """
    if isinstance(function, LabelFunction):
        return arity(function.function, signatures)
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return 1
    parameters = signature.parameters.values()
    places = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    wanted = max(1, sum(p.default is p.empty for p in places))
    while wanted < min(len(places), len(signatures)) and places[wanted].name == _FILLED_BY_NAME[wanted]:
        wanted += 1
    takes_any = any(p.kind is p.VAR_POSITIONAL for p in parameters)
    by_name_only = any(p.kind is p.KEYWORD_ONLY and p.default is p.empty for p in parameters)
    if by_name_only or wanted > len(signatures) or not (places or takes_any):
        raise InvalidArgumentError(
            f"labels: {described(function)} takes {signature}; a labelling function takes {_one_of(signatures)}"
        )
    return wanted


def described(function: Any, place: bool = True) -> str:
    """What a function is called in messages, and where it is written."""
    if isinstance(function, LabelFunction):
        return described(function.function, place)
    if isinstance(function, _Predicates):
        return f"the predicates {', '.join(name for name, _, _ in function.each)}"
    function = inspect.unwrap(function)
    name = getattr(function, "__qualname__", None) or repr(function)
    code = getattr(function, "__code__", None)
    return f"{name} ({code.co_filename}:{code.co_firstlineno})" if code and place else name


def shown(observation: Any) -> str:
    """An observation on one line, cut where it is long."""
    text = " ".join(repr(observation).split())
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def importable(labels: LabelSource) -> LabelSource:
    """Functions as the text `module:name` where that leads back to them; all else as it is."""
    if isinstance(labels, Mapping):
        return {name: importable(predicate) for name, predicate in labels.items()}  # type: ignore[misc]
    module, name = getattr(labels, "__module__", None), getattr(labels, "__qualname__", None)
    if isinstance(labels, str) or not isinstance(module, str) or not isinstance(name, str):
        return labels
    found: Any = sys.modules.get(module)
    for step in name.split("."):
        found = getattr(found, step, None)
    return f"{module}:{name}" if found is labels else labels


def names_of(label: Any) -> dict[str, bool]:
    """The names that a single label speaks of, and whether each holds.

    Raises:
        InvalidArgumentError: the label is no set of names, event string or dict from name to bool.
    """
    if isinstance(label, Mapping):
        return {name: truth(name, holds) for name, holds in label.items()}
    if isinstance(label, str):
        return {name: True for name in re.split(r"[\s,;&]+", label) if name}
    if not isinstance(label, Iterable):
        raise InvalidArgumentError(f"a label is {label!r} ({type(label).__name__}); {_SINGLE}")
    names = list(label)
    for name in names:
        if not isinstance(name, str):
            raise InvalidArgumentError(f"a label contains {name!r} ({type(name).__name__}); {_SINGLE}")
    return dict.fromkeys(names, True)


def truth(name: str, value: Any) -> bool:
    """What a predicate says of a name.

    Raises:
        InvalidArgumentError: neither True nor False.
    """
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, np.ndarray) and value.dtype == np.bool_ and value.size == 1:
        return bool(value.item())
    raise InvalidArgumentError(
        f"the label {name!r} is {value!r} ({type(value).__name__}); a predicate must say True or False"
    )


_SINGLE = "expected a set of names, an event string, a dict from name to bool, or a bitmask"


def _one_of(signatures: tuple[str, ...]) -> str:
    return f"{', '.join(signatures[:-1])} or {signatures[-1]}"
