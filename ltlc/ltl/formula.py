"""LTL formulas as immutable, hash-consed nodes.

Two formulas built the same way are the same object, so `is`, `==` and dictionary look-up cost O(1). `And` and `Or`
are n-ary and flatten themselves: `And(a, And(b, c)) is And(a, b, c)`; nothing else is simplified here.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from threading import RLock
from typing import Any, ClassVar, Self, TypeVar, cast
from weakref import WeakValueDictionary

from ltlc.errors import InvalidArgumentError

F = TypeVar("F", bound="Formula")
T = TypeVar("T")


class Formula:
    """A node: an operator and its operands. Build nodes with the subclasses.

    Attributes:
        args: the operands, left to right.
    """

    __slots__ = ("__weakref__", "_hash", "args")

    symbol: ClassVar[str]
    args: tuple[Formula, ...]
    _hash: int

    def __new__(cls, *_: Any) -> Self:
        raise TypeError("use parse() or the class of an operator")

    def __hash__(self) -> int:
        # Structural and independent of PYTHONHASHSEED, so that no set of formulas can leak an order into a result.
        return self._hash

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"formulas are immutable: cannot set {name!r}")

    def __str__(self) -> str:
        from ltlc.ltl.printer import to_text

        return to_text(self)

    def __repr__(self) -> str:
        return f"parse({str(self)!r})"

    def with_args(self, args: tuple[Formula, ...]) -> Formula:
        """The same operator on other operands; itself if they are its own."""
        if args == self.args:
            return self
        return type(self)(*args)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: object) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A flat list instead of nested objects: pickle recurses into those.
        return _rebuild, (_flatten(self),)

    def __invert__(self) -> Formula:
        return Not(self)

    def __and__(self, other: Formula) -> Formula:
        return And(self, other)

    def __or__(self, other: Formula) -> Formula:
        return Or(self, other)

    def __rshift__(self, other: Formula) -> Formula:
        return Implies(self, other)


# Interning is invisible from outside: an entry dies with the last reference to its node.
_interned: WeakValueDictionary[tuple[object, ...], Formula] = WeakValueDictionary()
_interning = RLock()  # two threads that build one formula must get one object


def _intern(cls: type[F], args: tuple[Formula, ...], payload: str | bool | None = None) -> F:
    key = (cls, payload, args)
    node = _interned.get(key)
    if node is None:
        node = object.__new__(cls)
        object.__setattr__(node, "args", args)
        seed = zlib.crc32(f"{cls.__name__}:{payload}".encode())
        object.__setattr__(node, "_hash", hash((seed, *(child._hash for child in args))))
        if payload is not None:
            object.__setattr__(node, "name" if isinstance(payload, str) else "value", payload)
        with _interning:
            node = _interned.setdefault(key, node)
    return cast(F, node)


class Constant(Formula):
    """`true` or `false`; use `TRUE` and `FALSE`."""

    __slots__ = ("value",)
    value: bool

    def __new__(cls, value: bool) -> Self:
        return _intern(cls, (), bool(value))


class Proposition(Formula):
    """An atomic proposition, known by its name.

    Raises:
        InvalidArgumentError: the name is empty.
    """

    __slots__ = ("name",)
    name: str

    def __new__(cls, name: str) -> Self:
        if not name:
            raise InvalidArgumentError("the name of a proposition has at least one character")
        return _intern(cls, (), str(name))


class _Unary(Formula):
    __slots__ = ()

    def __new__(cls, operand: Formula) -> Self:
        return _intern(cls, (operand,))


class _Binary(Formula):
    __slots__ = ()

    def __new__(cls, left: Formula, right: Formula) -> Self:
        return _intern(cls, (left, right))


class Not(_Unary):
    """Negation."""

    __slots__ = ()
    symbol = "!"


class Next(_Unary):
    """X f: f holds at the next position."""

    __slots__ = ()
    symbol = "X"


class Eventually(_Unary):
    """F f: f holds now or later."""

    __slots__ = ()
    symbol = "F"


class Always(_Unary):
    """G f: f holds now and for ever."""

    __slots__ = ()
    symbol = "G"


class And(Formula):
    """Conjunction of any number of formulas; of none it is `true`, of one it is that one, whatever its type."""

    __slots__ = ()
    symbol = "&"

    def __new__(cls, *operands: Formula) -> Self:
        return _flat(cls, operands, TRUE)


class Or(Formula):
    """Disjunction of any number of formulas; of none it is `false`, of one it is that one, whatever its type."""

    __slots__ = ()
    symbol = "|"

    def __new__(cls, *operands: Formula) -> Self:
        return _flat(cls, operands, FALSE)


class Implies(_Binary):
    """f -> g."""

    __slots__ = ()
    symbol = "->"


class Iff(_Binary):
    """f <-> g."""

    __slots__ = ()
    symbol = "<->"


class Xor(_Binary):
    """Exactly one of f and g."""

    __slots__ = ()
    symbol = "xor"


class Until(_Binary):
    """f U g: g holds at some position, and f at all positions before it."""

    __slots__ = ()
    symbol = "U"


class WeakUntil(_Binary):
    """f W g: f U g, or f for ever."""

    __slots__ = ()
    symbol = "W"


class Release(_Binary):
    """f R g: g holds up to and including the first position where f holds, or for ever."""

    __slots__ = ()
    symbol = "R"


class StrongRelease(_Binary):
    """f M g: f R g, and f holds at some position."""

    __slots__ = ()
    symbol = "M"


TRUE = Constant(True)
FALSE = Constant(False)


def _flat(cls: type[F], operands: tuple[Formula, ...], empty: Formula) -> F:
    if any(type(operand) is cls for operand in operands):
        operands = tuple(part for f in operands for part in (f.args if type(f) is cls else (f,)))
    if len(operands) > 1:
        return _intern(cls, operands)
    # Not an F, but callers of And and Or need no more than a Formula.
    return cast(F, operands[0] if operands else empty)


def postorder(formula: Formula) -> Iterator[Formula]:
    """Every distinct subformula once, operands before operators, left before right, without recursion."""
    seen: set[int] = set()
    stack: list[tuple[Formula, bool]] = [(formula, False)]
    while stack:
        node, expanded = stack.pop()
        if expanded:
            yield node
        elif id(node) not in seen:
            seen.add(id(node))
            stack.append((node, True))
            stack.extend((child, False) for child in reversed(node.args))


def fold(
    formula: Formula,
    done: dict[Formula, T],
    compute: Callable[[Formula, list[T]], T],
    within: tuple[type[Formula], ...] | None = None,
) -> T:
    """Evaluates a formula bottom-up without recursion: `compute(node, values of its operands)`, once per node.

    Args:
        formula: where to start.
        done: values known already, kept between calls; the new ones are added.
        compute: the value of a node.
        within: the operators whose operands are looked at; other nodes are computed from no operands. None for all.
    """
    stack = [] if formula in done else [formula]
    while stack:
        node = stack[-1]
        args = node.args if within is None or isinstance(node, within) else ()
        missing = [] if node in done else [child for child in args if child not in done]
        if missing:
            stack.extend(missing)
            continue
        if node not in done:
            done[node] = compute(node, [done[child] for child in args])
        stack.pop()
    return done[formula]


def _flatten(formula: Formula) -> list[tuple[Any, ...]]:
    """The subformulas in postorder, each as (class name, payload or indices of its operands)."""
    index: dict[Formula, int] = {}
    rows: list[tuple[Any, ...]] = []
    for node in postorder(formula):
        if isinstance(node, Constant):
            rows.append(("Constant", node.value))
        elif isinstance(node, Proposition):
            rows.append(("Proposition", node.name))
        else:
            rows.append((type(node).__name__, *(index[child] for child in node.args)))
        index[node] = len(index)
    return rows


def _rebuild(rows: list[tuple[Any, ...]]) -> Formula:
    nodes: list[Formula] = []
    for name, *payload in rows:
        cls = _CLASSES[name]
        nodes.append(cls(*payload) if cls in (Constant, Proposition) else cls(*(nodes[i] for i in payload)))
    return nodes[-1]


_CLASSES: dict[str, Any] = {
    cls.__name__: cls
    for cls in (
        Constant,
        Proposition,
        Not,
        Next,
        Eventually,
        Always,
        And,
        Or,
        Implies,
        Iff,
        Xor,
        Until,
        WeakUntil,
        Release,
        StrongRelease,
    )
}


def propositions(formula: Formula) -> tuple[str, ...]:
    """Names of the atomic propositions, in order of first appearance."""
    return tuple(node.name for node in postorder(formula) if isinstance(node, Proposition))
