"""Formulas about finite traces to minimal deterministic automata, by formula progression.

After a letter, what is left of a formula is a positive Boolean combination of claims about the next position: strong
ones, that there is one and a subformula holds there, and weak ones, that a subformula holds there if there is one. A
trace that ends satisfies the combination in which strong claims are false and weak ones true; one that goes on has to
satisfy the subformulas. So a state is what has to hold from the next position on, and whether the trace may end.

References:
    G. De Giacomo, M. Y. Vardi: Linear Temporal Logic and Linear Dynamic Logic on Finite Traces. IJCAI 2013.
    J. A. Brzozowski: Derivatives of Regular Expressions. Journal of the ACM 11(4), 1964, doi 10.1145/321239.321249.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import reduce

from ltlc.arrays import np
from ltlc.automata.acceptance import ALWAYS, NEVER
from ltlc.automata.emerson_lei import EmersonLei, explore, quotient, refine
from ltlc.automata.finite import DFA
from ltlc.automata.possible import Possible
from ltlc.budget import MAX_STATES, Budget, check_time
from ltlc.graph import bits
from ltlc.ltl import (
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    nnf,
    postorder,
    propositions,
)
from ltlc.ltl.finite import WeakNext
from ltlc.ltl.shape import NO_PAST
from ltlc.translate.letters import Letters, letters_of
from ltlc.translate.memory import Memory

Combination = tuple[int, ...]
"""A positive Boolean combination in disjunctive normal form: an antichain of clauses, sorted; a bit for each claim."""
State = tuple[Combination, bool]
Expansion = dict[Combination, int]
"""What is claimed after each set of letters; the sets partition the letters."""

_TRUE: Combination = (0,)
_FALSE: Combination = ()
_STRONG = (Next, Eventually, Until, StrongRelease)
"""Operators that claim that there is a next position, unless they are satisfied here."""
_MANY = 16


def translate_finite(
    formula: Formula, *, max_states: int = MAX_STATES, text: str | None = None, possible: Possible | None = None
) -> DFA:
    """The smallest deterministic automaton that accepts exactly the finite traces satisfying the formula.

    Args:
        formula: over finite traces; X is the strong next.
        max_states: limit for every automaton on the way.
        text: what to call the formula in messages and in the result; by default its own text.
        possible: which letters over the propositions of the formula, in order of appearance, are possible; None: all.

    Raises:
        StateLimitExceeded, TimeLimitExceeded, AlphabetLimitExceeded: a budget ran out.

    Example:
        >>> from ltlc.ltl import parse
        >>> translate_finite(parse("F(a & last)", finite=True)).n_states
        2
    """
    text = str(formula) if text is None else text
    budget = Budget(text, max_states)
    normal = nnf(formula, finite=True)
    letters = letters_of(normal, propositions(formula), possible)
    if normal.flags & NO_PAST:
        automaton = _Progression(normal, letters, budget).automaton()
    else:
        memory = Memory(normal, letters, budget)
        automaton = memory.product(_Progression(memory.future, memory.letters, budget).automaton(), budget)
    # States with one mark and equally marked successors: for finite words that is language equivalence.
    smallest = quotient(automaton, refine(automaton.edges, automaton.acceptance))
    delta = np.zeros((smallest.n_states, letters.n_classes), dtype=np.int32)
    for q, edges in enumerate(smallest.edges):
        for edge in edges:
            delta[q, list(bits(edge.letters))] = edge.target
    accepting = np.array([condition == ALWAYS for condition in smallest.acceptance])
    return DFA(
        letters.aps, delta, np.asarray(letters.letter_class), accepting, formula=text, possible=possible
    ).canonical()


class _Progression:
    """The subformulas of a formula, and what each becomes after a letter.

    Claim 2 n is that there is a next position and node n holds there, claim 2 n + 1 that node n holds at the next
    position if there is one.
    """

    def __init__(self, formula: Formula, letters: Letters, budget: Budget) -> None:
        self.letters = letters
        self.budget = budget
        self._combined: dict[tuple[bool, Combination, Combination], Combination] = {}
        self._after: dict[Combination, Expansion] = {}
        self._number: dict[Formula, int] = {}
        self._expansion: list[Expansion] = []
        self._duty: list[Combination] = []
        needed = {formula}
        nodes = list(postorder(formula))
        for node in reversed(nodes):
            if node in needed and node not in letters.sets:
                needed.update(node.args)
        for node in nodes:
            if node in needed:
                check_time()
                self._number[node] = n = len(self._number)
                self._duty.append(self._duty_of(node, n))
                self._expansion.append(self._expanded(node, n))
        self.root = self._duty[-1]

    def automaton(self) -> EmersonLei:
        """All of it; a state accepts always if a trace that ends there is accepted, and else never."""
        start: State = (self.root, False)

        def successors(state: State) -> Iterator[tuple[int, State, int]]:
            for claims, letters in self.after(state[0]).items():
                yield letters, (self._continued(claims), self._may_end(claims)), 0

        states, edges = explore(start, successors, self.budget)
        return EmersonLei(tuple(map(tuple, edges)), tuple(ALWAYS if ends else NEVER for _, ends in states))

    def after(self, duties: Combination) -> Expansion:
        """What is claimed after a letter by what has to hold before it."""
        known = self._after.get(duties)
        if known is None:
            known = {_FALSE: self.letters.all}
            for clause in duties:
                parts = (self._expansion[n] for n in bits(clause))
                known = self._merged(self._either, known, reduce(self._both_after, parts, {_TRUE: self.letters.all}))
            self._after[duties] = known
        return known

    def _duty_of(self, node: Formula, n: int) -> Combination:
        """A node as something that has to hold: a combination of nodes that are neither & nor |."""
        if node in self.letters.sets:
            known = self.letters.sets[node]
            return _FALSE if not known else _TRUE if known == self.letters.all else (1 << n,)
        if isinstance(node, And | Or):
            combine = self._both if isinstance(node, And) else self._either
            return reduce(combine, [self._duty[self._number[arg]] for arg in node.args])
        return (1 << n,)

    def _expanded(self, node: Formula, n: int) -> Expansion:
        everything = self.letters.all
        if node in self.letters.sets:
            letters = self.letters.sets[node]
            parts = {_TRUE: letters, _FALSE: everything & ~letters}
            return {claims: part for claims, part in parts.items() if part}
        if isinstance(node, Next | WeakNext):
            n = self._number[node.args[0]]
        following: Expansion = {(1 << 2 * n + (not isinstance(node, _STRONG)),): everything}
        if isinstance(node, Next | WeakNext):
            return following
        operands = [self._expansion[self._number[arg]] for arg in node.args]
        left, right = operands[0], operands[-1]
        if isinstance(node, And):
            return reduce(self._both_after, operands)
        if isinstance(node, Or):
            return reduce(self._either_after, operands)
        if isinstance(node, Eventually):
            return self._either_after(left, following)
        if isinstance(node, Always):
            return self._both_after(left, following)
        if isinstance(node, Until | WeakUntil):
            return self._either_after(right, self._both_after(left, following))
        assert isinstance(node, Release | StrongRelease)
        return self._both_after(right, self._either_after(left, following))

    def _may_end(self, claims: Combination) -> bool:
        """Whether the claims hold where there is no next position."""
        return any(all(claim % 2 for claim in bits(clause)) for clause in claims)

    def _continued(self, claims: Combination) -> Combination:
        """What the claims demand of the next position."""
        result = _FALSE
        for clause in claims:
            duties = reduce(self._both, [self._duty[claim // 2] for claim in bits(clause)], _TRUE)
            result = self._either(result, duties)
        return result

    # -- Boolean combinations -----------------------------------------------------------------------------------------

    def _both(self, f: Combination, g: Combination) -> Combination:
        if f in (g, _FALSE) or g == _TRUE:
            return f
        if f == _TRUE or g == _FALSE:
            return g
        key = (True, f, g)
        if key not in self._combined:
            self._combined[key] = self._antichain({a | b for a in f for b in g})
        return self._combined[key]

    def _either(self, f: Combination, g: Combination) -> Combination:
        if f in (g, _TRUE) or g == _FALSE:
            return f
        if f == _FALSE or g == _TRUE:
            return g
        key = (False, f, g)
        if key not in self._combined:
            self._combined[key] = self._antichain({*f, *g})
        return self._combined[key]

    def _antichain(self, clauses: set[int]) -> Combination:
        self.budget.check_size(len(clauses))
        kept: list[int] = []
        for number, clause in enumerate(sorted(clauses, key=lambda c: (c.bit_count(), c))):
            if not number % _MANY:
                check_time()
            if not any(other & ~clause == 0 for other in kept):
                kept.append(clause)
        return tuple(sorted(kept))

    def _both_after(self, f: Expansion, g: Expansion) -> Expansion:
        return self._merged(self._both, f, g)

    def _either_after(self, f: Expansion, g: Expansion) -> Expansion:
        return self._merged(self._either, f, g)

    def _merged(
        self, combine: Callable[[Combination, Combination], Combination], f: Expansion, g: Expansion
    ) -> Expansion:
        merged: Expansion = {}
        for a, letters_a in f.items():
            check_time()
            for b, letters_b in g.items():
                if common := letters_a & letters_b:
                    c = combine(a, b)
                    merged[c] = merged.get(c, 0) | common
        self.budget.check_moves(len(merged), self.letters.n_classes)
        return merged
