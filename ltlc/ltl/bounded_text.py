"""Formulas with bounds as text: what `F[2:5] a` was written out to becomes `F[2:5] a` again, where that is shorter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

from ltlc.ltl.finite import WeakNext
from ltlc.ltl.formula import And, Constant, Formula, Next, Or, Proposition
from ltlc.ltl.past import WeakYesterday, Yesterday
from ltlc.ltl.syntax import PLAIN_WITH_PAST, write
from ltlc.ltl.traversal import postorder

_SHORTER = 3
"""From so many steps on, X[3] a is shorter than X X X a."""
_CHAINS: Mapping[tuple[type[Formula], type[Formula]], str] = MappingProxyType(
    {(Or, Next): "F", (And, Next): "G", (And, WeakNext): "G", (Or, Yesterday): "O", (And, WeakYesterday): "H"}
)
"""The operator that looks at several distances, by how they are joined and how a step is made."""
_STEPS: Mapping[type[Formula], str] = MappingProxyType({Next: "X", Yesterday: "Y", WeakYesterday: "Z"})


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
    last: int


def to_bounded(formula: Formula) -> str:
    """The formula as text that `parse` reads back, with bounds where they make it shorter.

    `G` gets bounds back only where what it is written out with says what kind of words are meant: in a formula with WX
    that is about finite traces, and in one without about infinite words.

    Example:
        >>> from ltlc.ltl import parse
        >>> to_bounded(parse("G(a -> F[2:5] b) & X[4] c"))
        'G(a -> F[2:5] b) & X[4] c'
    """
    nodes = list(postorder(formula))
    finite = any(isinstance(node, WeakNext) for node in nodes)
    shown: dict[Formula, _Shown] = {}
    chains: dict[Formula, _Chain] = {}
    for node in nodes:
        chain = _chain(node, chains, finite)
        if chain is not None:
            chains[node] = chain
        if chain is not None and _is_shorter(chain):
            bound = f"[{chain.first}]" if chain.first == chain.last else f"[{chain.first}:{chain.last}]"
            shown[node] = _Shown(chain.operator + bound, (shown[chain.operand],))
        elif isinstance(node, Proposition):
            shown[node] = _Shown("proposition", name=node.name)
        elif isinstance(node, Constant):
            shown[node] = _Shown("constant", value=node.value)
        else:
            shown[node] = _Shown(node.symbol, tuple(shown[arg] for arg in node.args))
    symbols = {each.symbol for each in shown.values() if "[" in each.symbol}
    style = replace(
        PLAIN_WITH_PAST,
        prefix={**PLAIN_WITH_PAST.prefix, **{symbol: f"{symbol} " for symbol in symbols}},
        binding={**PLAIN_WITH_PAST.binding, **dict.fromkeys(symbols, PLAIN_WITH_PAST.binding["X"])},
    )
    return write(shown[formula], style)


def _is_shorter(chain: _Chain) -> bool:
    if chain.first == chain.last:
        return chain.first >= _SHORTER
    return chain.last - chain.first > 1 or chain.first > 0


def _chain(node: Formula, chains: Mapping[Formula, _Chain], finite: bool) -> _Chain | None:
    """What a node is the writing out of, given the same of its operands."""
    if type(node) in (Next, WeakNext, Yesterday, WeakYesterday):
        return _stepped(node, chains.get(node.args[0]))
    if not isinstance(node, Or | And) or not isinstance(node.args[-1], Next | WeakNext | Yesterday | WeakYesterday):
        return None
    last, rest = node.args[-1], node.args[:-1]
    step = type(last)
    operator = _CHAINS.get((type(node), step))
    if operator is None or (operator == "G" and (step is WeakNext) != finite):
        return None
    operand = rest[0] if len(rest) == 1 else type(node)(*rest)
    inner = chains.get(last.args[0])
    if last.args[0] is operand:
        return _Chain(operator, step, operand, 0, 1)
    if inner is not None and inner[:4] == (operator, step, operand, 0):
        return inner._replace(last=inner.last + 1)
    return None


def _stepped(node: Formula, inner: _Chain | None) -> _Chain | None:
    """One step before what an operand is the writing out of."""
    step = type(node)
    if inner is not None and inner.step is step:
        return inner._replace(first=inner.first + 1, last=inner.last + 1)
    return _Chain(_STEPS[step], step, node.args[0], 1, 1) if step in _STEPS else None
