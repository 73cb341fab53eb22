"""Formulas with bounds as text: what `F[2:5] a` was written out to becomes `F[2:5] a` again, where that is shorter."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from ltlc.ltl.finite import WeakNext
from ltlc.ltl.formula import And, Constant, Formula, Next, Or, Proposition, Release, Until
from ltlc.ltl.past import Since, Triggered, WeakYesterday, Yesterday
from ltlc.ltl.syntax import PLAIN_WITH_PAST, write
from ltlc.ltl.traversal import postorder

_SHORTER = 3
"""From so many steps on, X[3] a is shorter than X X X a."""
_MAY_END = (Next, WeakNext, Yesterday, WeakYesterday, And, Or)
"""What the last operand of a writing out is."""
_SIDE_BY_SIDE = 4
"""operands of a conjunction or disjunction that are looked at together, at most."""
_CHAINS: Mapping[tuple[type[Formula], type[Formula]], str] = MappingProxyType(
    {(Or, Next): "F", (And, Next): "G", (And, WeakNext): "G", (Or, Yesterday): "O", (And, WeakYesterday): "H"}
)
"""The operator that looks at several distances, by how they are joined and how a step is made."""
_STEPS: Mapping[type[Formula], str] = MappingProxyType({Next: "X", Yesterday: "Y", WeakYesterday: "Z"})
_BINARY: Mapping[tuple[type[Formula], type[Formula]], str] = MappingProxyType(
    {(And, Next): "U", (Or, Next): "R", (Or, WeakNext): "R", (And, Yesterday): "S", (Or, WeakYesterday): "T"}
)
"""The operator that asks something of every smaller distance, by how that is joined to a step."""
_UNBOUNDED: Mapping[str, type[Formula]] = MappingProxyType({"U": Until, "R": Release, "S": Since, "T": Triggered})
_MIXED: Mapping[str, tuple[str, type[Formula]]] = MappingProxyType({"U": ("M", And), "R": ("W", Or)})
"""a M b is b U (a & b), and a W b is b R (a | b)."""


class _Shown(NamedTuple):
    """A node as it is written; see `ltlc.ltl.syntax.Node`."""

    symbol: str
    args: tuple[_Shown, ...] = ()
    name: str = ""
    value: bool = False


class _Chain(NamedTuple):
    """An operator that looks at the distances from `first` to `last`; a run of single steps if they are the same."""

    operator: str
    step: type[Formula]
    operand: Formula
    first: int
    last: int | None
    """None: without end."""
    left: Formula | None = None
    """what is asked of smaller distances, if it is a binary operator."""

    @property
    def bound(self) -> str:
        """As it is written."""
        if self.left is None and self.first == self.last:
            return f"[{self.first}]"
        return f"[{self.first}:{'' if self.last is None else self.last}]"

    def after(self, step: int) -> _Chain:
        """So many steps later."""
        return self._replace(first=self.first + step, last=None if self.last is None else self.last + step)


def to_bounded(formula: Formula) -> str:
    """The formula as text that `parse` reads back, with bounds where they make it shorter.

    `G` gets bounds back only where what it is written out with says what kind of words are meant: in a formula with WX
    that is about finite traces, and in one without about infinite words.

    Example:
        >>> from ltlc.ltl import parse
        >>> to_bounded(parse("G(a -> F[2:5] b) & X[4] c"))
        'G(a -> F[2:5] b) & X[4] c'
    """
    return _Writer(formula).text


class _Writer:
    """What is known of the parts of a formula on the way to its text."""

    def __init__(self, formula: Formula) -> None:
        nodes = list(postorder(formula))
        self.finite = any(isinstance(node, WeakNext) for node in nodes)
        self.shown: dict[Formula, _Shown] = {}
        self.chains: dict[Formula, _Chain] = {}
        self.bounded: dict[str, int] = {}
        """operators with bounds, and how many operands they have."""
        for node in nodes:
            chain = _chain(node, self.chains, self.finite)
            if chain is not None:
                self.chains[node] = chain
            if chain is not None and _is_shorter(chain):
                self.shown[node] = self.written(chain)
            elif isinstance(node, Proposition):
                self.shown[node] = _Shown("proposition", name=node.name)
            elif isinstance(node, Constant):
                self.shown[node] = _Shown("constant", value=node.value)
            else:
                self.shown[node] = _Shown(node.symbol, tuple(self.operands(node)))
        plain = PLAIN_WITH_PAST
        prefix, infix = ([symbol for symbol, n_args in self.bounded.items() if n_args == n] for n in (1, 2))
        style = plain._replace(
            prefix={**plain.prefix, **{symbol: f"{symbol} " for symbol in prefix}},
            infix={**plain.infix, **{symbol: f" {symbol} " for symbol in infix}},
            binding={**plain.binding, **{symbol: plain.binding[symbol[0]] for symbol in self.bounded}},
        )
        self.text = write(self.shown[formula], style)

    def written(self, chain: _Chain) -> _Shown:
        """The operator with its bound; `M` and `W` where an operand repeats the other one."""
        operator, left, operand = chain.operator, chain.left, chain.operand
        mixed, join = _MIXED.get(operator, ("", None))
        if left is not None and join is not None:
            parts, repeated = (f.args if isinstance(f, join) else (f,) for f in (operand, left))
            rest = parts[: -len(repeated)]
            if rest and parts[len(rest) :] == repeated:
                operator, left, operand = mixed, _joined(join, rest), left
        operands = (operand,) if left is None else (left, operand)
        self.bounded[operator + chain.bound] = len(operands)
        return _Shown(operator + chain.bound, tuple(map(self.part, operands)))

    def part(self, formula: Formula) -> _Shown:
        """A part of a longer conjunction or disjunction, or any other."""
        return self.shown.get(formula) or _Shown(formula.symbol, tuple(self.shown[arg] for arg in formula.args))

    def operands(self, node: Formula) -> list[_Shown]:
        """The operands of a node; where some that stand side by side are the writing out of one, that one."""
        parts: list[_Shown] = []
        kept: list[Formula] = []  # the last operands that are parts by themselves
        for arg in node.args:
            kept.append(arg)
            parts.append(self.shown[arg])
            if not isinstance(node, And | Or) or not isinstance(arg, _MAY_END):
                continue
            for size in range(2, min(len(kept), _SIDE_BY_SIDE) + 1):
                chain = _chain(type(node)(*kept[-size:]), self.chains, self.finite)
                if chain is not None and _is_shorter(chain):
                    parts[-size:] = [self.written(chain)]
                    kept = []
                    break
        return parts


def _is_shorter(chain: _Chain) -> bool:
    if chain.left is not None:
        return chain.last is None or chain.last > 1
    assert chain.last is not None
    if chain.first == chain.last:
        return chain.first >= _SHORTER
    return chain.last - chain.first > 1 or chain.first > 0


def _chain(node: Formula, chains: Mapping[Formula, _Chain], finite: bool) -> _Chain | None:
    """What a node is the writing out of, given the same of its operands."""
    if type(node) in (Next, WeakNext, Yesterday, WeakYesterday):
        return _stepped(node, chains.get(node.args[0]))
    if not isinstance(node, Or | And):
        return None
    last, rest = node.args[-1], _joined(type(node), node.args[:-1])
    if isinstance(last, Or | And) and type(last) is not type(node):
        inner = chains.get(last)
        # One more distance: a | b & X f, or the dual, where f asks for a at the next ones.
        if inner is None or inner.left is None or inner.first != 1 or inner.last is None or inner.operand is not rest:
            return None
        return inner._replace(first=0)
    if not isinstance(last, Next | WeakNext | Yesterday | WeakYesterday):
        return None
    step, inner = type(last), chains.get(last.args[0])
    operator = _CHAINS.get((type(node), step))
    if operator is not None and not (operator == "G" and (step is WeakNext) != finite):
        if last.args[0] is rest:
            return _Chain(operator, step, rest, 0, 1)
        if inner is not None and inner.left is None and inner[:4] == (operator, step, rest, 0):
            return inner._replace(last=(inner.last or 0) + 1)
    operator = _BINARY.get((type(node), step))
    if operator is None or (operator == "R" and (step is WeakNext) != finite):
        return None
    following = last.args[0]
    if inner is not None and (inner.operator, inner.step, inner.left) == (operator, step, rest):
        return inner.after(1)
    if type(following) is _UNBOUNDED[operator] and following.args[0] is rest:
        return _Chain(operator, step, following.args[1], 1, None, rest)
    return _Chain(operator, step, following, 1, 1, rest)


def _joined(join: type[Formula], parts: tuple[Formula, ...]) -> Formula:
    return parts[0] if len(parts) == 1 else join(*parts)


def _stepped(node: Formula, inner: _Chain | None) -> _Chain | None:
    """One step before what an operand is the writing out of."""
    step = type(node)
    if inner is not None and inner.step is step and inner.left is None:
        return inner.after(1)
    return _Chain(_STEPS[step], step, node.args[0], 1, 1) if step in _STEPS else None
