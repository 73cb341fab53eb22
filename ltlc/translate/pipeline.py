"""From a formula to the smallest Rabin automaton that the constructions find."""

from __future__ import annotations

from collections.abc import Sequence

from ltlc.automata.rabin import RabinAutomaton
from ltlc.ltl import Formula, nnf, propositions, simplify
from ltlc.translate.budget import Budget
from ltlc.translate.closure import Closure
from ltlc.translate.components import Breakpoint, Complement, Component, Finite
from ltlc.translate.emerson_lei import EmersonLei, reduced
from ltlc.translate.pairs import rabin_automaton
from ltlc.translate.product import Skeleton, antichain, combine
from ltlc.translate.safra import determinize
from ltlc.translate.tableau import tableau


class SafraComponent:
    """A subformula of any kind, determinized beforehand."""

    stable = False

    def __init__(self, closure: Closure, node: int, budget: Budget) -> None:
        self.automaton = reduced(determinize(tableau(closure, node, budget), budget))
        self.initial = 0
        self.acceptance = parity(self.n_marks) if False else None
        masks = [e.marks for out in self.automaton.edges for e in out]
        self.n_marks = max(m.bit_length() for m in masks)

    def successors(self, state):
        return [tuple(e) for e in self.automaton.edges[state]]

    def decided(self, state):
        return None


def decompose(closure: Closure, node: int, make) -> tuple[Skeleton, list[Component]]:
    components: list[Component] = []
    known: dict[int, int] = {}

    def leaf(node: int) -> Skeleton:
        if node not in known:
            known[node] = len(components)
            components.append(make(node))
        return (1 << known[node],)

    def skeleton(node: int) -> Skeleton:
        kind, args, _ = closure.nodes[node]
        if kind not in "&|" or closure.level(node) in ("sigma1", "pi1"):
            return leaf(node)
        grouped = {}
        for arg in args:
            level = closure.level(arg)
            key = level if level in ("sigma1", "pi1") else arg
            grouped.setdefault(key, []).append(arg)
        parts = [skeleton(closure.node(kind, *group)) for group in grouped.values()]
        result = parts[0]
        for part in parts[1:]:
            if kind == "&":
                result = antichain({a | b for a in result for b in part})
            else:
                result = antichain({*result, *part})
        return result

    return skeleton(node), components


def translate(formula: Formula, mode="product") -> RabinAutomaton:
    budget = Budget(str(formula), 100000, None)
    closure = Closure(nnf(simplify(formula)), propositions(formula), budget)

    def make(node):
        level = closure.level(node)
        if level in ("sigma1", "pi1"):
            return Finite(closure, node, safety=level == "pi1")
        if level == "pi2":
            return Breakpoint(closure, node)
        if level == "sigma2":
            return Complement(Breakpoint(closure, closure.negation(node)))
        return SafraComponent(closure, node, budget)

    if mode == "safra":
        el = reduced(determinize(tableau(closure, closure.root, budget), budget))
    else:
        skeleton, components = decompose(closure, closure.root, make)
        el = reduced(combine(skeleton, components, closure.letters.all, budget))
    return rabin_automaton(el, closure.letters, budget)
