"""LTL formulas as immutable, hash-consed nodes.

Two formulas built the same way are the same object, so `is`, `==` and dictionary look-up cost O(1). `And` and `Or`
are n-ary and flatten themselves: `And(a, And(b, c)) is And(a, b, c)`; nothing else is simplified here. What is asked of
formulas over and over is worked out once, when the node is made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import RLock
from typing import Any, ClassVar, Self, TypeVar
from weakref import ref
from zlib import crc32

from ltlc.errors import InvalidArgumentError

T = TypeVar("T")

EVENTUAL, UNIVERSAL, NORMAL, LITERAL = 1, 2, 4, 8
"""Bits of `Formula.facts`: it is seen to be a pure eventuality, a pure universality (see `ltlc.ltl.purity`); it is in
negation normal form; it is a proposition or the negation of one."""
SUSPENDABLE = EVENTUAL | UNIVERSAL
_SIGNS = 120
"""Among more propositions than this, some share a sign for sure, and among a dozen perhaps."""


class Formula:
    """A node: an operator and its operands. Build nodes with the subclasses.

    Formulas are compared and hashed by identity. No order of a set of formulas may reach a result, because it differs
    from run to run; dictionaries keep the order of insertion.

    Attributes:
        args: the operands, left to right.
        size: number of nodes, written out as a tree.
        facts: which of EVENTUAL, UNIVERSAL, NORMAL and LITERAL hold.
        signs: in negation normal form, a bit for each literal that occurs, and all bits if a constant does. Formulas
            without a common bit have no common literal; with one, they may.
        opposite: the signs of the negation.
    """

    __slots__ = ("__weakref__", "args", "facts", "opposite", "signs", "size")

    symbol: ClassVar[str]
    args: tuple[Formula, ...]
    size: int
    facts: int
    signs: int
    opposite: int

    # Facts that hold if they hold of all operands, facts that hold if they hold of the last one, and those that hold.
    _of_all: ClassVar[int] = 0
    _of_last: ClassVar[int] = 0
    _of_itself: ClassVar[int] = 0

    def __new__(cls, *_: Any) -> Self:
        raise TypeError("use parse() or the class of an operator")

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


class _Entry(ref[Formula]):
    """The way to a living node from its key: its class, then its operands, or its name or value."""

    __slots__ = ("key",)
    key: tuple[Any, ...]


# Interning is invisible from outside: an entry goes with the last reference to its node.
_entries: dict[tuple[Any, ...], _Entry] = {}
_replacing = RLock()  # held while an entry is taken out or replaced; to put one in where none is takes one step
_set = object.__setattr__


def _find(key: tuple[Any, ...]) -> Any:
    entry = _entries.get(key)
    return None if entry is None else entry()


def _forget(entry: _Entry) -> None:
    with _replacing:
        if _entries.get(entry.key) is entry:
            del _entries[entry.key]


def _make(key: tuple[Any, ...], args: tuple[Formula, ...], size: int, facts: int, signs: int, opposite: int) -> Any:
    node = object.__new__(key[0])
    _set(node, "args", args)
    _set(node, "size", size)
    _set(node, "facts", facts)
    _set(node, "signs", signs)
    _set(node, "opposite", opposite)
    if not args:
        _set(node, "name" if key[0] is Proposition else "value", key[1])
    entry = _Entry(node, _forget)
    entry.key = key
    if _entries.setdefault(key, entry) is entry:
        return node
    with _replacing:  # another thread was faster, or the entry of a node that is no more is about to go
        known = _find(key)
        if known is None:
            _entries[key] = entry
        return node if known is None else known


def _operator(cls: type[Formula], args: tuple[Formula, ...]) -> Any:
    """The node of an operator and its operands."""
    key = (cls, *args)
    entry = _entries.get(key)
    known = None if entry is None else entry()
    if known is not None:
        return known
    size, facts, signs, opposite = 1, cls._of_all, 0, 0
    for arg in args:
        size += arg.size
        facts &= arg.facts
        signs |= arg.signs
        opposite |= arg.opposite
    facts |= cls._of_last & args[-1].facts | cls._of_itself
    if cls is Not:
        signs, opposite = opposite, signs
        facts = NORMAL | LITERAL if type(args[0]) is Proposition else 0
    return _make(key, args, size, facts, signs, opposite)


class Constant(Formula):
    """`true` or `false`; use `TRUE` and `FALSE`."""

    __slots__ = ("value",)
    value: bool

    def __new__(cls, value: bool) -> Self:
        key = (cls, bool(value))
        node: Self | None = _find(key)
        if node is None:
            node = _make(key, (), 1, EVENTUAL | UNIVERSAL | NORMAL, -1, -1)
        return node


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
        key = (cls, str(name))
        node: Self | None = _find(key)
        if node is None:
            sign = 1 << crc32(name.encode("utf-8", "surrogatepass")) % _SIGNS
            node = _make(key, (), 1, NORMAL | LITERAL, sign, sign << _SIGNS)
        return node


class _Unary(Formula):
    __slots__ = ()

    def __new__(cls, operand: Formula) -> Self:
        node: Self = _operator(cls, (operand,))
        return node


class _Binary(Formula):
    __slots__ = ()

    def __new__(cls, left: Formula, right: Formula) -> Self:
        node: Self = _operator(cls, (left, right))
        return node


class Not(_Unary):
    """Negation."""

    __slots__ = ()
    symbol = "!"


class Next(_Unary):
    """X f: f holds at the next position."""

    __slots__ = ()
    symbol = "X"
    _of_all = EVENTUAL | UNIVERSAL | NORMAL


class Eventually(_Unary):
    """F f: f holds now or later."""

    __slots__ = ()
    symbol = "F"
    _of_all = UNIVERSAL | NORMAL
    _of_itself = EVENTUAL


class Always(_Unary):
    """G f: f holds now and for ever."""

    __slots__ = ()
    symbol = "G"
    _of_all = EVENTUAL | NORMAL
    _of_itself = UNIVERSAL


class And(Formula):
    """Conjunction of any number of formulas; of none it is `true`, of one it is that one, whatever its type."""

    __slots__ = ()
    symbol = "&"
    _of_all = EVENTUAL | UNIVERSAL | NORMAL

    def __new__(cls, *operands: Formula) -> Self:
        node: Self = _flat(cls, operands, TRUE)
        return node


class Or(Formula):
    """Disjunction of any number of formulas; of none it is `false`, of one it is that one, whatever its type."""

    __slots__ = ()
    symbol = "|"
    _of_all = EVENTUAL | UNIVERSAL | NORMAL

    def __new__(cls, *operands: Formula) -> Self:
        node: Self = _flat(cls, operands, FALSE)
        return node


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
    _of_all = NORMAL
    _of_last = EVENTUAL | UNIVERSAL


class WeakUntil(_Binary):
    """f W g: f U g, or f for ever."""

    __slots__ = ()
    symbol = "W"
    _of_all = EVENTUAL | NORMAL
    _of_last = UNIVERSAL


class Release(_Binary):
    """f R g: g holds up to and including the first position where f holds, or for ever."""

    __slots__ = ()
    symbol = "R"
    _of_all = NORMAL
    _of_last = EVENTUAL | UNIVERSAL


class StrongRelease(_Binary):
    """f M g: f R g, and f holds at some position."""

    __slots__ = ()
    symbol = "M"
    _of_all = UNIVERSAL | NORMAL
    _of_last = EVENTUAL


TRUE = Constant(True)
FALSE = Constant(False)


def _flat(cls: type[Formula], operands: tuple[Formula, ...], empty: Formula) -> Any:
    for operand in operands:
        if type(operand) is cls:
            operands = tuple(part for f in operands for part in (f.args if type(f) is cls else (f,)))
            break
    if len(operands) > 1:
        return _operator(cls, operands)
    # Not of that class, but callers of And and Or need no more than a Formula.
    return operands[0] if operands else empty


def postorder(formula: Formula) -> Iterator[Formula]:
    """Every distinct subformula once, operands before operators, left before right, without recursion."""
    seen: set[Formula] = set()
    stack: list[Formula | None] = [formula]
    waiting: list[Formula] = []  # for their operands, one for each None on the stack
    while stack:
        node = stack.pop()
        if node is None:
            yield waiting.pop()
        elif node not in seen:
            seen.add(node)
            if node.args:
                waiting.append(node)
                stack.append(None)
                stack.extend(node.args[::-1])
            else:
                yield node


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
    stack: list[Formula | None] = [formula]
    waiting: list[Formula] = []  # for their operands, one for each None on the stack
    while stack:
        node = stack.pop()
        if node is None:
            node = waiting.pop()
            done[node] = compute(node, [done[child] for child in node.args])
        elif node not in done:
            if node.args and (within is None or isinstance(node, within)):
                waiting.append(node)
                stack.append(None)
                stack.extend(node.args)
            else:
                done[node] = compute(node, [])
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
