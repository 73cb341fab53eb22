"""LTL formulas as immutable, hash-consed nodes.

Two formulas built the same way are the same object, so `is`, `==` and dictionary look-up cost O(1). `And` and `Or`
are n-ary and flatten themselves: `And(a, And(b, c)) is And(a, b, c)`; `!!a` is `a`, `F F a` is `F a`, and `G G a` is
`G a`, so that runs of these operators cost nothing. Nothing else is simplified here. What is asked of formulas over and
over is worked out once, when the node is made.
"""

from __future__ import annotations

from typing import Any, ClassVar, Self
from zlib import crc32

from ltlc.errors import InvalidArgumentError, check_type
from ltlc.ltl.interning import find, intern
from ltlc.ltl.shape import EVENTUAL, LITERAL, NO_PAST, NORMAL, PRESENT, UNIVERSAL
from ltlc.ltl.syntax import PLAIN, PLAIN_WITH_PAST, write
from ltlc.ltl.traversal import postorder

_MASK_BITS = 120
"""Bits of a literal mask for propositions, and as many for their negations; a dozen of them may share one already."""


class Formula:
    """A node: an operator and its operands. Build nodes with the subclasses.

    Formulas are compared and hashed by identity, so that the order of a set of them, which may reach no result, differs
    from run to run; dictionaries keep the order of insertion.

    Attributes:
        args: the operands, left to right.
        size: number of nodes, written out as a tree.
        flags: what its shape shows, as bits of `ltlc.ltl.shape`.
        literal_mask: in negation normal form, a bit for each literal that occurs, and all bits if a constant does.
            Formulas without a common bit have no common literal; with one, they may.
        negated_literal_mask: the literal mask of the negation.
    """

    __slots__ = ("__weakref__", "args", "flags", "literal_mask", "negated_literal_mask", "size")

    symbol: ClassVar[str]
    """the operator as `parse` reads it; "proposition" and "constant" for the leaves."""
    args: tuple[Formula, ...]
    size: int
    flags: int
    literal_mask: int
    negated_literal_mask: int

    # Flags that hold if they hold of all operands (these two), if they hold of the last operand, and in any case.
    _flags_of_all: ClassVar[int] = 0
    _tense: ClassVar[int] = PRESENT
    _flags_of_last: ClassVar[int] = 0
    _own_flags: ClassVar[int] = 0

    def __new__(cls, *_: Any) -> Self:
        raise TypeError("use parse() or the class of an operator")

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"formulas are immutable: cannot set {name!r}")

    def __str__(self) -> str:
        return write(self, PLAIN if self.flags & NO_PAST else PLAIN_WITH_PAST)

    def __repr__(self) -> str:
        return f"parse({str(self)!r})"

    def with_args(self, args: tuple[Formula, ...]) -> Formula:
        """The same operator on other operands; itself if they are its own."""
        return self if args == self.args else type(self)(*args)

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


_set = object.__setattr__


def _make(key: tuple[Any, ...], args: tuple[Formula, ...], size: int, flags: int, mask: int, negated_mask: int) -> Any:
    node = object.__new__(key[0])
    _set(node, "args", args)
    _set(node, "size", size)
    _set(node, "flags", flags)
    _set(node, "literal_mask", mask)
    _set(node, "negated_literal_mask", negated_mask)
    if not args:
        _set(node, "name" if key[0] is Proposition else "value", key[1])
    return intern(key, node)


def _operator(cls: type[Formula], args: tuple[Formula, ...]) -> Any:
    """The node of an operator and its operands."""
    key = (cls, *args)
    try:
        known = find(key)
    except TypeError:  # an operand that cannot be hashed is no formula, as below
        known = None
    if known is not None:
        return known
    size, flags, literal_mask, negated_literal_mask = 1, cls._flags_of_all | cls._tense, 0, 0
    for arg in args:
        if not isinstance(arg, Formula):
            raise InvalidArgumentError(f"the operands of {cls.__name__} are formulas, not {type(arg).__name__}")
        size += arg.size
        flags &= arg.flags
        literal_mask |= arg.literal_mask
        negated_literal_mask |= arg.negated_literal_mask
    flags |= cls._flags_of_last & args[-1].flags | cls._own_flags
    if cls is Not:
        literal_mask, negated_literal_mask = negated_literal_mask, literal_mask
        flags = flags & PRESENT | (NORMAL | LITERAL if type(args[0]) is Proposition else 0)
    return _make(key, args, size, flags, literal_mask, negated_literal_mask)


class Constant(Formula):
    """`true` or `false`; use `TRUE` and `FALSE`."""

    __slots__ = ("value",)
    symbol = "constant"
    value: bool

    def __new__(cls, value: bool) -> Self:
        key = (cls, bool(value))
        node: Self = find(key) or _make(key, (), 1, EVENTUAL | UNIVERSAL | NORMAL | PRESENT, -1, -1)
        return node


class Proposition(Formula):
    """An atomic proposition, known by its name.

    Raises:
        InvalidArgumentError: the name is empty, no text, or no text that a file could hold.
    """

    __slots__ = ("name",)
    symbol = "proposition"
    name: str

    def __new__(cls, name: str) -> Self:
        check_type(name, str, "the name of a proposition", "a text")
        if not name:
            raise InvalidArgumentError("the name of a proposition has at least one character")
        key = (cls, str(name))
        node: Self | None = find(key)
        if node is None:
            try:
                code = name.encode("utf-8")
            except UnicodeEncodeError:
                raise InvalidArgumentError(f"the proposition {name!a} has half a character in its name") from None
            sign = 1 << crc32(code) % _MASK_BITS
            node = _make(key, (), 1, NORMAL | LITERAL | PRESENT, sign, sign << _MASK_BITS)
        return node


class Unary(Formula):
    """An operator with one operand."""

    __slots__ = ()

    def __new__(cls, operand: Formula) -> Self:
        node: Self = _operator(cls, (operand,))
        return node


class Binary(Formula):
    """An operator with two operands."""

    __slots__ = ()

    def __new__(cls, left: Formula, right: Formula) -> Self:
        node: Self = _operator(cls, (left, right))
        return node


class Not(Unary):
    """Negation; of a negation it is the formula that was negated, whatever its type."""

    __slots__ = ()
    symbol = "!"

    def __new__(cls, operand: Formula) -> Self:
        # Not of that class if the operand is a negation, but callers of Not need no more than a Formula.
        node: Any = operand.args[0] if type(operand) is cls else _operator(cls, (operand,))
        return node  # type: ignore[no-any-return]


class _Idempotent(Unary):
    __slots__ = ()

    def __new__(cls, operand: Formula) -> Self:
        return operand if type(operand) is cls else super().__new__(cls, operand)


class Next(Unary):
    """X f: f holds at the next position."""

    __slots__ = ()
    symbol = "X"
    _tense = NO_PAST
    _flags_of_all = EVENTUAL | UNIVERSAL | NORMAL


class Eventually(_Idempotent):
    """F f: f holds now or later."""

    __slots__ = ()
    symbol = "F"
    _tense = NO_PAST
    _flags_of_all = UNIVERSAL | NORMAL
    _own_flags = EVENTUAL


class Always(_Idempotent):
    """G f: f holds now and for ever."""

    __slots__ = ()
    symbol = "G"
    _tense = NO_PAST
    _flags_of_all = EVENTUAL | NORMAL
    _own_flags = UNIVERSAL


class _Nary(Formula):
    __slots__ = ()
    _flags_of_all = EVENTUAL | UNIVERSAL | NORMAL
    _of_none: ClassVar[bool]

    def __new__(cls, *operands: Formula) -> Self:
        if cls in map(type, operands):
            operands = tuple(part for f in operands for part in (f.args if type(f) is cls else (f,)))
        node: Any = (
            _operator(cls, operands) if len(operands) > 1 else operands[0] if operands else Constant(cls._of_none)
        )
        return node  # type: ignore[no-any-return]  # perhaps another Formula: callers of And and Or need no more


class And(_Nary):
    """Conjunction of any number of formulas; of none it is `true`, of one it is that one, whatever its type."""

    __slots__ = ()
    symbol = "&"
    _of_none = True


class Or(_Nary):
    """Disjunction of any number of formulas; of none it is `false`, of one it is that one, whatever its type."""

    __slots__ = ()
    symbol = "|"
    _of_none = False


class Implies(Binary):
    """f -> g."""

    __slots__ = ()
    symbol = "->"


class Iff(Binary):
    """f <-> g."""

    __slots__ = ()
    symbol = "<->"


class Xor(Binary):
    """Exactly one of f and g."""

    __slots__ = ()
    symbol = "xor"


class Until(Binary):
    """f U g: g holds at some position, and f at all positions before it."""

    __slots__ = ()
    symbol = "U"
    _tense = NO_PAST
    _flags_of_all = NORMAL
    _flags_of_last = EVENTUAL | UNIVERSAL


class WeakUntil(Binary):
    """f W g: f U g, or f for ever."""

    __slots__ = ()
    symbol = "W"
    _tense = NO_PAST
    _flags_of_all = EVENTUAL | NORMAL
    _flags_of_last = UNIVERSAL


class Release(Binary):
    """f R g: g holds up to and including the first position where f holds, or for ever."""

    __slots__ = ()
    symbol = "R"
    _tense = NO_PAST
    _flags_of_all = NORMAL
    _flags_of_last = EVENTUAL | UNIVERSAL


class StrongRelease(Binary):
    """f M g: f R g, and f holds at some position."""

    __slots__ = ()
    symbol = "M"
    _tense = NO_PAST
    _flags_of_all = UNIVERSAL | NORMAL
    _flags_of_last = EVENTUAL


TRUE, FALSE = Constant(True), Constant(False)


def _flatten(formula: Formula) -> list[tuple[Any, ...]]:
    """The subformulas in postorder, each as its class with its name or value, or with the indices of its operands."""
    index: dict[Formula, int] = {}
    rows: list[tuple[Any, ...]] = []
    for node in postorder(formula):
        leaf = node.value if isinstance(node, Constant) else node.name if isinstance(node, Proposition) else None
        rows.append((type(node), *(index[child] for child in node.args)) if leaf is None else (type(node), leaf))
        index[node] = len(index)
    return rows


def _rebuild(rows: list[tuple[Any, ...]]) -> Formula:
    nodes: list[Formula] = []
    for cls, *parts in rows:
        nodes.append(cls(*(parts if cls in (Constant, Proposition) else (nodes[i] for i in parts))))
    return nodes[-1]
