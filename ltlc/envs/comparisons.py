"""Comparisons of numbers as propositions: what `"x > 0.45"` says of an observation.

A comparison is read by the small grammar below and never run as code:

    comparison: sum (relation sum)+            relation: < <= > >= == !=
    sum: term ((+ | -) term)*                  term: factor ((* | /) factor)*
    factor: number | name | -factor | +factor | abs(sum) | (sum)

A chain such as `0 < x <= 1` says that each of its relations holds. Numbers are those of IEEE 754 with 64 bits: nothing
but `!=` holds of what is not a number.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ltlc.automata import DFA, DRA
from ltlc.envs.labels import shown
from ltlc.errors import InvalidArgumentError, UnknownNameError, check_type
from ltlc.ltl import Formula, parse, propositions
from ltlc.ltl.diagnosis import error_at

Path = int | str | tuple[int | str, ...]
"""Where a variable stands in an observation: indices of arrays and tuples, keys of dicts, from outside to inside."""

_RELATIONS: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}
_ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
}
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w.]))|(?P<name>[^\W\d][\w.]*)|(?P<sign><=|>=|==|!=|[-+*/()<>]))"
)
_DEEPEST = 50
_RELATION = re.compile(r"[<>]|[=!]=")
_HINT = "a comparison reads: speed <= 0.07, or 0 < x + 2 * abs(y) < 1"

_Term = Callable[[Callable[[str], Any]], Any]
"""from the values of variables to the value of the term."""


def is_comparison(name: str) -> bool:
    """Whether a proposition is meant as a comparison: it has a relation in its name.

    Example:
        >>> is_comparison("x >= 0"), is_comparison("near goal")
        (True, False)
    """
    return _RELATION.search(name) is not None


class Comparison:
    """What a comparison says of an observation, or of each of a batch.

    Args:
        text: the comparison.
        variables: where each name stands in an observation; more names than the comparison has are allowed.

    Attributes:
        names: the variables that it is about.

    Raises:
        LtlSyntaxError: the text is no comparison; says where.
        UnknownNameError: a name is not among the variables.
        InvalidArgumentError: a path is none.

    Example:
        >>> fast = Comparison("abs(v) > 0.05", {"x": 0, "v": 1})
        >>> fast(np.array([0.5, -0.06])), fast(np.array([[0.5, 0.0], [0.5, 0.07]]))
        (True, array([False,  True]))
    """

    def __init__(self, text: str, variables: Mapping[str, Path]) -> None:
        check_type(text, str, "a comparison", "a text")
        self.text = text
        self.variables = {name: _path(name, path) for name, path in variables.items()}
        self._read()

    def _read(self) -> None:
        reader = _Reader(self.text, self.variables)
        self._holds, self._margin = reader.comparison()
        self.names = tuple(reader.names)

    def __call__(self, observation: Any) -> Any:
        """Whether it holds of one observation; of a batch, shape (n_observations,).

        Raises:
            InvalidArgumentError: a variable is not where it is said to be, or is no number there.
        """
        values = {name: _value(name, self.variables[name], observation) for name in self.names}
        with np.errstate(all="ignore"):
            holds = self._holds(values.__getitem__)
        return bool(holds) if np.ndim(holds) == 0 else holds

    def margin(self, observation: Any) -> Any:
        """How far it is from changing: 0 or more where it holds, 0 or less where not; as `__call__` for batches."""
        values = {name: _value(name, self.variables[name], observation) for name in self.names}
        with np.errstate(all="ignore"):
            margin = self._margin(values.__getitem__)
        return float(margin) if np.ndim(margin) == 0 else margin

    def __getstate__(self) -> dict[str, Any]:
        return {"text": self.text, "variables": self.variables}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__ |= state
        self._read()

    def __repr__(self) -> str:
        return f"Comparison({self.text!r}, {self.variables!r})"


def comparisons(
    source: Formula | str | DRA | DFA | Iterable[str], variables: Mapping[str, Path]
) -> dict[str, Comparison]:
    """Labels for the propositions of a formula that are comparisons.

    The result can be given as `labels`, or, as it is vectorised, as `batch_labels`; other labels can be added to it.

    Args:
        source: a formula, its text, its automaton, or names of propositions.
        variables: where each variable stands in an observation.

    Raises:
        LtlSyntaxError: the text is no formula, or a proposition no comparison; says where.
        UnknownNameError: a name is not among the variables.
        InvalidArgumentError: `variables` is no dictionary of paths.

    Example:
        >>> labels = comparisons('GF "x > 0.45" & G "abs(speed) <= 0.07"', {"x": 0, "speed": 1})
        >>> {name: holds([0.5, 0.1]) for name, holds in labels.items()}
        {'x > 0.45': True, 'abs(speed) <= 0.07': False}
    """
    check_type(variables, Mapping, "variables", "a dictionary from names to places in an observation")
    if isinstance(source, str):
        source = parse(source)
    names: Iterable[str]
    if isinstance(source, Formula):
        names = propositions(source)
    else:
        names = source.aps if isinstance(source, DRA | DFA) else source
    check_type(names, Iterable, "the propositions", "a formula, an automaton, or names")
    return {name: Comparison(name, variables) for name in names if is_comparison(name)}


def _path(name: str, path: Path) -> tuple[int | str, ...]:
    steps = path if isinstance(path, tuple | list) else (path,)
    for step in steps:
        if isinstance(step, bool) or not isinstance(step, int | str | np.integer):
            raise InvalidArgumentError(
                f"the variable {name!r} is at {path!r}; a place is an index, a key, or a tuple of these"
            )
    return tuple(step if isinstance(step, str) else int(step) for step in steps)


def _value(name: str, path: tuple[int | str, ...], observation: Any) -> Any:
    """The number at a place of an observation, or those at that place of a batch."""
    value: Any = observation
    indices: list[int] = []
    try:
        for step in path:
            if isinstance(step, str) or isinstance(value, tuple):
                value = value[step]
            else:
                indices.append(step)
        found: Any = np.asarray(value)
        if indices:
            found = found[(..., *indices)]
        if found.dtype.kind not in "biuf":
            raise TypeError(f"{found.dtype} is no kind of number")
        return found.astype(np.float64)
    except (LookupError, TypeError, ValueError) as error:
        place = "".join(f"[{step!r}]" for step in path)
        raise InvalidArgumentError(
            f"the variable {name!r} is no number at observation{place} of {shown(observation)}: {error}"
        ) from None


VARIABLES = "variables:"
"""What the labels of an `EnvSpec` begin with where they are places of variables."""


class Variables:
    """Variables whose comparisons become labels once the propositions are known, as the command line names them.

    Args:
        text: such as `x=0, speed=obs.velocity.1`: a name and a place each; indices and keys have `.` between them, and
            nothing stands for the observation itself.

    Raises:
        InvalidArgumentError: the text is nothing of that kind.

    Example:
        >>> Variables("x=0, v=speed.1").places
        {'x': (0,), 'v': ('speed', 1)}
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.places: dict[str, tuple[int | str, ...]] = {}
        for part in text.split(","):
            match = _ASSIGNED.fullmatch(part)
            if match is None:
                raise InvalidArgumentError(
                    f"variables: {part.strip()!r} is no variable with its place; write x=0, or x=position.0"
                )
            steps = [step for step in match["place"].split(".") if step]
            if match["name"] in self.places:
                raise InvalidArgumentError(f"variables: {match['name']!r} is given twice")
            self.places[match["name"]] = tuple(int(step) if step.isdecimal() else step for step in steps)

    def labels(self, aps: Iterable[str]) -> dict[str, Comparison]:
        """Labels for propositions, which have to be comparisons of these variables.

        Raises:
            LtlSyntaxError: a proposition is no comparison.
            UnknownNameError: it is about another variable.
        """
        return {name: Comparison(name, self.places) for name in aps}


_ASSIGNED = re.compile(r"\s*(?P<name>[^\W\d]\w*)\s*=\s*(?P<place>[\w.-]*)\s*")


def _margin(relation: str, left: Any, right: Any) -> Any:
    if relation in ("==", "!="):
        return np.abs(left - right) * (1 if relation == "!=" else -1)
    return left - right if relation[0] == ">" else right - left


class _Reader:
    """Recursive descent."""

    def __init__(self, text: str, variables: Mapping[str, Any]) -> None:
        self.text = text
        self.variables = variables
        self.names: dict[str, None] = {}
        self.position = self.start = 0
        self.kind, self.token = "", ""
        self.depth = 0
        self.advance()

    def advance(self) -> None:
        match = _TOKEN.match(self.text, self.position)
        rest = self.text[self.position :]
        self.start = self.position + len(rest) - len(rest.lstrip())
        if match is None:
            if rest.strip():
                raise error_at(f"'{rest.strip()[:1]}' does not belong into a comparison", self.text, self.start, _HINT)
            self.kind, self.token = "end", ""
            return
        self.kind = str(match.lastgroup)
        self.token = match[self.kind]
        self.start, self.position = match.start(self.kind), match.end()

    def comparison(self) -> tuple[_Term, _Term]:
        """Whether it holds, and by how much."""
        terms, relations = [self.sum()], []
        while self.token in _RELATIONS:
            relations.append(self.token)
            self.advance()
            terms.append(self.sum())
        if self.kind != "end":
            raise error_at(f"'{self.token}' cannot stand here", self.text, self.start, _HINT)
        if not relations:
            raise error_at("a comparison needs a relation, such as <=", self.text, self.start, _HINT)

        def holds(value: Callable[[str], Any]) -> Any:
            values = [term(value) for term in terms]
            result: Any = True
            for relation, left, right in zip(relations, values, values[1:], strict=False):
                result = np.logical_and(result, _RELATIONS[relation](left, right))
            return result

        def margin(value: Callable[[str], Any]) -> Any:
            values = [term(value) for term in terms]
            return np.minimum.reduce(list(map(_margin, relations, values, values[1:])))

        return holds, margin

    def sum(self) -> _Term:
        return self.chain("+-", self.product)

    def product(self) -> _Term:
        return self.chain("*/", self.factor)

    def chain(self, signs: str, part: Callable[[], _Term]) -> _Term:
        first = part()
        more: list[tuple[Callable[[Any, Any], Any], _Term]] = []
        while self.kind == "sign" and self.token in signs:
            operation = _ARITHMETIC[self.token]
            self.advance()
            more.append((operation, part()))
        if not more:
            return first

        def value_of(value: Callable[[str], Any]) -> Any:
            result = first(value)
            for operation, term in more:
                result = operation(result, term(value))
            return result

        return value_of

    def factor(self) -> _Term:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise error_at("the comparison is nested too deeply", self.text, self.start, _HINT)
        kind, token, start = self.kind, self.token, self.start
        if kind == "end" or (kind == "sign" and token not in "(+-"):
            what = "the comparison ends too early" if kind == "end" else f"'{token}' cannot stand here"
            raise error_at(f"{what}: expected a number or a name", self.text, start, _HINT)
        self.advance()
        if token in ("-", "+"):
            inner = self.factor()
            result = inner if token == "+" else lambda value: np.negative(inner(value))
        elif token == "(" or (token == "abs" and self.token == "("):
            if token == "abs":
                self.advance()
            inner = self.sum()
            if self.token != ")":
                raise error_at("this bracket is never closed", self.text, start, _HINT)
            self.advance()
            result = inner if token == "(" else lambda value: np.abs(inner(value))
        elif kind == "number":
            number = float(token)
            result = lambda _: number  # noqa: E731
        else:
            result = self.variable(token)
        self.depth -= 1
        return result

    def variable(self, name: str) -> _Term:
        if name not in self.variables:
            raise UnknownNameError("variable", name, tuple(self.variables))
        self.names[name] = None
        return lambda value: value(name)
