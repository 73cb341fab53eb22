"""Walks through formulas without recursion, so that nesting is limited by memory alone.

The walks ask nothing of a node but its operands: `Node` is all they know of formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from typing import Protocol, Self, TypeVar

from ltlc.budget import check_time


class Node(Hashable, Protocol):
    """A node of a directed acyclic graph, such as a `Formula`."""

    @property
    def args(self) -> tuple[Self, ...]:
        """The operands, left to right."""
        ...


N = TypeVar("N", bound=Node)
T = TypeVar("T")


def postorder(formula: N) -> Iterator[N]:
    """Every distinct subformula once, operands before operators, left before right, without recursion."""
    seen: set[N] = set()
    stack: list[N | None] = [formula]
    waiting: list[N] = []  # for their operands, one for each None on the stack
    while stack:
        node = stack.pop()
        if node is None:
            yield waiting.pop()
        elif node not in seen:
            seen.add(node)
            if not len(seen) % 1024:
                check_time()
            if node.args:
                waiting.append(node)
                stack.append(None)
                stack.extend(node.args[::-1])
            else:
                yield node


def fold(
    formula: N,
    done: dict[N, T],
    compute: Callable[[N, list[T]], T],
    within: tuple[type[N], ...] | None = None,
) -> T:
    """Evaluates a formula bottom-up without recursion: `compute(node, values of its operands)`, once per node.

    Args:
        formula: where to start.
        done: values known already, kept between calls; the new ones are added.
        compute: the value of a node.
        within: the operators whose operands are looked at; other nodes are computed from no operands. None for all.
    """
    stack: list[N | None] = [formula]
    waiting: list[N] = []  # for their operands, one for each None on the stack
    while stack:
        node = stack.pop()
        if node is None:
            node = waiting.pop()
            if not len(done) % 1024:
                check_time()
            done[node] = compute(node, [done[child] for child in node.args])
        elif node not in done:
            if node.args and (within is None or isinstance(node, within)):
                waiting.append(node)
                stack.append(None)
                stack.extend(node.args)
            else:
                done[node] = compute(node, [])
    return done[formula]
