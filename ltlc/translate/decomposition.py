"""A formula as a Boolean combination of subformulas that each have a deterministic automaton."""

from __future__ import annotations

from collections.abc import Hashable
from contextlib import suppress
from functools import reduce

from ltlc.automata.acceptance import ALWAYS, NEVER, Acceptance, TooManyClausesError
from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import EmersonLei, complement, localized, reduced
from ltlc.budget import Budget, check_time
from ltlc.translate.closure import Closure
from ltlc.translate.components import Breakpoint, Complement, Component, Finite, Successors
from ltlc.translate.product import Skeleton, antichain

_MAX_CLAUSES = 16
"""A condition with more clauses is not worth the states that it saves."""


def decompose(closure: Closure, root: int, budget: Budget) -> tuple[Skeleton, list[Component]]:
    """Split at the outer Boolean operators; safety parts stay together, and so do co-safety parts."""
    decomposition = _Decomposition(closure, budget)
    return decomposition.skeleton(root), decomposition.components


class _Decomposition:
    """Not a function inside `decompose`: one that calls itself would keep the closure until garbage is collected."""

    def __init__(self, closure: Closure, budget: Budget) -> None:
        self.components: list[Component] = []
        self._closure = closure
        self._budget = budget
        self._known: dict[int, Skeleton] = {}

    def skeleton(self, node: int) -> Skeleton:
        check_time()
        closure = self._closure
        node = distributed(closure, node)
        kind, args, _ = closure.nodes[node]
        if kind not in "&|" or closure.level(node) in ("sigma1", "pi1"):
            if node not in self._known:
                self._known[node] = (1 << len(self.components),)
                self.components.append(component(closure, node, self._budget))
            return self._known[node]
        groups: dict[str | int, list[int]] = {}
        for arg in args:
            level = closure.level(arg)
            groups.setdefault(level if level in ("sigma1", "pi1") else arg, []).append(arg)
        parts = [self.skeleton(closure.node(kind, *group)) for group in groups.values()]
        return reduce(_both if kind == "&" else _either, parts)


def distributed(closure: Closure, node: int) -> int:
    """The node with a disjunction or conjunction under its temporal operator pulled out, where the law allows it."""
    check_time()
    kind, args, _ = closure.nodes[node]
    if kind in "&|" or kind == "letters" or closure.level(node) in ("sigma1", "pi1"):
        return node
    for position, pulled in _DISTRIBUTES[kind]:
        inner = closure.nodes[args[position]]
        if inner.kind == pulled:
            ways = ((*args[:position], arg, *args[position + 1 :]) for arg in inner.args)
            return closure.make(pulled, *(distributed(closure, closure.make(kind, *way)) for way in ways))
    return node


# Operator -> (operand, Boolean operator that it distributes over in that operand).
_DISTRIBUTES = {
    "X": ((0, "&"), (0, "|")),
    "F": ((0, "|"),),
    "G": ((0, "&"),),
    "U": ((1, "|"), (0, "&")),
    "W": ((1, "|"), (0, "&")),
    "R": ((1, "&"), (0, "|")),
    "M": ((1, "&"), (0, "|")),
}


def _both(a: Skeleton, b: Skeleton) -> Skeleton:
    clauses: set[int] = set()
    for x in a:
        check_time()
        clauses.update([x | y for y in b])
    return antichain(clauses)


def _either(a: Skeleton, b: Skeleton) -> Skeleton:
    return antichain({*a, *b})


def component(closure: Closure, node: int, budget: Budget) -> Component:
    """The deterministic automaton of a subformula, by its place in the hierarchy."""
    level = closure.level(node)
    if level in ("sigma1", "pi1"):
        return Finite(closure, node, safety=level == "pi1")
    if level == "pi2":
        return Breakpoint(closure, node)
    if level == "sigma2":
        return Complement(Breakpoint(closure, closure.negation(node)))
    return Determinized(closure, node, budget)


class Determinized:
    """A subformula above sigma2 and pi2, determinized beforehand by Safra trees, directly or by its complement."""

    stable = False

    def __init__(self, closure: Closure, node: int, budget: Budget) -> None:
        ways = [reduced(safra(closure, node, budget)), reduced(dual_safra(closure, node, budget))]
        self._automaton = min(ways, key=lambda a: a.n_states)
        self.initial: Hashable = 0
        self.n_marks = max(e.marks.bit_length() for out in self._automaton.edges for e in out)

    def successors(self, state: Hashable) -> Successors:
        """See `Component`."""
        assert isinstance(state, int)
        return [(e.letters, e.target, e.marks) for e in self._automaton.edges[state]]

    def condition(self, state: Hashable) -> Acceptance:
        """See `Component`."""
        assert isinstance(state, int)
        return self._automaton.acceptance[state]

    def decided(self, state: Hashable) -> bool | None:
        """See `Component`."""
        assert isinstance(state, int)
        edges = self._automaton.edges[state]
        condition = self._automaton.acceptance[state]
        if condition not in (ALWAYS, NEVER) or any(e.target != state for e in edges):
            return None
        return condition == ALWAYS


def safra(closure: Closure, node: int, budget: Budget) -> EmersonLei:
    """Tableau and Safra trees."""
    from ltlc.translate.safra import determinize

    return determinize(_nondeterministic(closure, node, budget), budget)


def dual_safra(closure: Closure, node: int, budget: Budget) -> EmersonLei:
    """Tableau and Safra trees for the negation, then the complement."""
    from ltlc.translate.safra import determinize

    negation = _nondeterministic(closure, closure.negation(node), budget)
    with suppress(TooManyClausesError):
        return complement(localized(determinize(negation, budget)), _MAX_CLAUSES)
    return complement(determinize(negation, budget, apart=False))


def _nondeterministic(closure: Closure, node: int, budget: Budget) -> BuchiAutomaton:
    """The tableau, reduced."""
    from ltlc.automata.simulation import reduced_buchi
    from ltlc.translate.tableau import tableau

    return reduced_buchi(tableau(closure, node, budget))
