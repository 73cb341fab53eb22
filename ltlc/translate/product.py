"""Boolean combinations of deterministic components, with suspension.

A product state holds the state of every component that still matters: what is decided is folded into the Boolean
skeleton, and a component that the remaining skeleton no longer mentions is forgotten. Components whose language does
not depend on the prefix (G F and F G parts) rest in their initial state until the others have settled.

References:
    D. Mueller, S. Sickert: LTL to Deterministic Emerson-Lei Automata. GandALF 2017, doi 10.4204/EPTCS.256.13.
    T. Babiak, T. Badie, A. Duret-Lutz, M. Kretinsky, J. Strejcek: Compositional Approach to Suspension and Other
    Improvements to LTL Translation. SPIN 2013, doi 10.1007/978-3-642-39176-7_6.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from functools import reduce
from typing import Any, TypeAlias

from ltlc import graph
from ltlc.automata.acceptance import ALWAYS, NEVER, Acceptance, Clause, conjunction, disjunction
from ltlc.automata.emerson_lei import EmersonLei, explore
from ltlc.budget import Budget, check_time
from ltlc.graph import bits
from ltlc.translate.components import Component, Successors

Skeleton = tuple[int, ...]
"""A positive Boolean combination of components: clauses of component bits, an antichain, sorted."""
_MANY = 16
"""A loop over more than so many moves asks for the time itself."""
ProductState = tuple[Skeleton, tuple[Hashable, ...]]
_Chain: TypeAlias = "tuple[Any, Hashable] | None"  # an alias of itself would crash mypyc
"""Next states of components, the last one outermost: moves share what they have in common."""

_TRUE: Skeleton = (0,)
_FALSE: Skeleton = ()
_DECIDED: dict[Hashable, Acceptance] = {_TRUE: ALWAYS, _FALSE: NEVER}


def combine(skeleton: Skeleton, components: Sequence[Component], letters: int, budget: Budget) -> EmersonLei:
    """The deterministic automaton of a Boolean combination of components; `letters` is the set of all letters."""
    if skeleton == (1,):
        return _alone(components[0], letters, budget)
    product = _Product(components, letters, budget)
    start = product.settle(skeleton, [c.initial for c in components])
    states, edges = explore(start, product.restless, budget)
    if product.stable:
        component = graph.strong_components([[e.target for e in out] for out in edges])
        component_of = dict(zip(states, component, strict=True))
        states, edges = explore(start, lambda s: product.all_moves(s, component_of), budget)
    rested: dict[ProductState, int] = {}
    alike = [rested.setdefault(product.rested(state), len(rested)) for state in states]
    return EmersonLei(tuple(map(tuple, edges)), tuple(map(product.condition, states)), alike=alike)


def _alone(component: Component, letters: int, budget: Budget) -> EmersonLei:
    """What `combine` gives for a single component; the states that are decided are two at most."""

    def settle(state: Hashable) -> Hashable:
        decided = component.decided(state)
        return state if decided is None else _TRUE if decided else _FALSE

    def successors(state: Hashable) -> Successors:
        if state in _DECIDED:
            return [(letters, state, 0)]
        return [(n, settle(target), marks) for n, target, marks in component.successors(state)]

    states, edges = explore(settle(component.initial), successors, budget)
    acceptance = tuple([_DECIDED[s] if s in _DECIDED else component.condition(s) for s in states])
    known: dict[Hashable, int] = {}
    rested = (component.initial if component.stable and s not in _DECIDED else s for s in states)
    alike = [known.setdefault(s, len(known)) for s in rested]
    return EmersonLei(tuple(map(tuple, edges)), acceptance, alike=alike)


class _Product:
    def __init__(self, components: Sequence[Component], letters: int, budget: Budget) -> None:
        self.components = components
        self.budget = budget
        self.letters = letters
        self._condition: dict[tuple[Skeleton, tuple[tuple[int, Acceptance], ...]], Acceptance] = {}
        self._ways: dict[tuple[int, Hashable], Successors] = {}
        self._assigned: dict[tuple[Skeleton, int, bool], Skeleton] = {}
        self.stable = sum(1 << i for i, c in enumerate(components) if c.stable)
        self._first_mark = [sum(c.n_marks for c in components[:i]) for i in range(len(components))]

    def settle(self, skeleton: Skeleton, states: list[Hashable]) -> ProductState:
        """Fold decided components into the skeleton, and forget the irrelevant ones."""
        for i in bits(mentioned(skeleton)):
            decided = self.components[i].decided(states[i])
            if decided is not None:
                key = (skeleton, i, decided)
                if key not in self._assigned:
                    self._assigned[key] = assign(*key)
                skeleton = self._assigned[key]
        relevant = mentioned(skeleton)
        return skeleton, tuple([s if relevant >> i & 1 else None for i, s in enumerate(states)])

    def restless(self, state: ProductState) -> Iterable[tuple[int, ProductState, int]]:
        """Moves in which the stable components rest."""
        return self._moves(state, resting=self.stable)

    def all_moves(
        self, state: ProductState, component_of: dict[ProductState, int]
    ) -> Iterable[tuple[int, ProductState, int]]:
        """Moves in which the stable components rest only while the others pass from component to component."""
        here = component_of[self.rested(state)]
        for letters, (skeleton, states), marks in self._moves(state, resting=0):
            target = self.rested((skeleton, states))
            if component_of[target] == here:
                yield letters, (skeleton, states), marks
            else:
                yield letters, target, marks

    def rested(self, state: ProductState) -> ProductState:
        """The state with the same language in which stable components rest."""
        skeleton, states = state
        relevant = mentioned(skeleton) & self.stable
        return skeleton, tuple(self.components[i].initial if relevant >> i & 1 else s for i, s in enumerate(states))

    def _moves(self, state: ProductState, resting: int) -> list[tuple[int, ProductState, int]]:
        skeleton, states = state
        relevant = mentioned(skeleton)
        n_letters = self.letters.bit_length()
        moving = bits(relevant & ~resting)
        partial: list[tuple[int, _Chain, int]] = [(self.letters, None, 0)]
        for i in moving:
            shift = self._first_mark[i]
            ways = self._successors(i, states[i])
            before, partial = partial, []
            for letters, chain, marks in before:
                partial += [
                    (common, (chain, target), marks | more << shift)
                    for letters_i, target, more in ways
                    if (common := letters & letters_i)
                ]
                self.budget.check_moves(len(partial), n_letters)
        moves = []
        for letters, chain, marks in partial:
            if len(partial) > _MANY:
                check_time()
            targets = list(states)
            for i in reversed(moving):
                assert chain is not None
                chain, targets[i] = chain
            moves.append((letters, self.settle(skeleton, targets), marks))
        return moves

    def _successors(self, component: int, state: Hashable) -> Successors:
        """Asked once: the closure learns atoms on the way, and could write a later answer with other obligations."""
        key = (component, state)
        known = self._ways.get(key)
        if known is None:
            known = self._ways[key] = self.components[component].successors(state)
        return known

    def condition(self, state: ProductState) -> Acceptance:
        """The acceptance condition while the skeleton and the components' strong components stay as they are."""
        skeleton, states = state
        conditions = {i: self._shifted(i, self.components[i].condition(states[i])) for i in bits(mentioned(skeleton))}
        key = (skeleton, tuple(conditions.items()))
        known = self._condition.get(key)
        if known is None:
            known = NEVER
            for clause in skeleton:
                known = disjunction(known, reduce(conjunction, (conditions[i] for i in bits(clause)), ALWAYS))
            self._condition[key] = known
        return known

    def _shifted(self, component: int, condition: Acceptance) -> Acceptance:
        shift = self._first_mark[component]
        return tuple([Clause(c.fin << shift, c.inf << shift) for c in condition])


def mentioned(skeleton: Skeleton) -> int:
    """The components that the skeleton depends on, as bits."""
    union = 0
    for clause in skeleton:
        union |= clause
    return union


def assign(skeleton: Skeleton, component: int, value: bool) -> Skeleton:
    """The skeleton once a component is decided."""
    bit = 1 << component
    if value:
        return antichain({clause & ~bit for clause in skeleton})
    return tuple(clause for clause in skeleton if not clause & bit)


def antichain(clauses: set[int]) -> Skeleton:
    """The clauses that no other clause implies, sorted."""
    kept: list[int] = []
    for n, c in enumerate(sorted(clauses, key=int.bit_count), 1):
        if not n & 63:
            check_time()
        if not any(d & ~c == 0 for d in kept):
            kept.append(c)
    return tuple(sorted(kept))
