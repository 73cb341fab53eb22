"""Deterministic automata for single subformulas, explored on the fly and multiplied by `product`.

* `Finite`: sigma1 (co-safety) and pi1 (safety): the state is what remains to be satisfied.
* `Breakpoint`: pi2 (recurrence): what remains, and the finite part of it that has to be completed next. sigma2
  (persistence) is the complement of a pi2 component.

References:
    S. Sickert, J. Esparza: An Efficient Normalisation Procedure for Linear Temporal Logic and Very Weak Alternating
    Automata. LICS 2020, doi 10.1145/3373718.3394743 (deterministic automata for sigma2 and pi2).
    S. Miyano, T. Hayashi: Alternating finite automata on omega-words. Theoretical Computer Science 32, 1984,
    doi 10.1016/0304-3975(84)90049-5 (breakpoints).
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Protocol

from ltlc.automata.acceptance import ALWAYS, NEVER, Acceptance, Clause, negation
from ltlc.budget import check_time
from ltlc.graph import bits
from ltlc.translate.closure import FALSE, TRUE, Closure, Obligation

_MANY = 16
"""A loop over more than so many moves asks for the time itself."""
Successors = list[tuple[int, Hashable, int]]


class Component(Protocol):
    """A deterministic automaton given by its successor function."""

    initial: Hashable
    n_marks: int
    stable: bool
    """whether the language is the same after every prefix, so that the state may be reset at any time."""

    def successors(self, state: Hashable) -> Successors:
        """(letter set, next state, marks) for each way on; the letter sets partition the letters."""

    def condition(self, state: Hashable) -> Acceptance:
        """The acceptance condition for runs that stay in the strong component of the state."""

    def decided(self, state: Hashable) -> bool | None:
        """True or False if every or no word is accepted from the state, else None."""


class Finite:
    """A co-safety or safety subformula."""

    n_marks = 0
    stable = False

    def __init__(self, closure: Closure, node: int, *, safety: bool) -> None:
        self._closure = closure
        closure.register(node)
        self.initial: Hashable = closure.obligation(node)
        self._condition = ALWAYS if safety else NEVER  # as long as nothing is decided

    def successors(self, state: Hashable) -> Successors:
        """See `Component`."""
        assert isinstance(state, tuple)
        return [(letters, f, 0) for f, letters in self._closure.after(state).items()]

    def condition(self, state: Hashable) -> Acceptance:
        """See `Component`."""
        return self._condition

    def decided(self, state: Hashable) -> bool | None:
        """See `Component`."""
        return True if state == TRUE else False if state == FALSE else None


class Breakpoint:
    """A recurrence subformula; mark 0 is seen whenever the finite part is completed."""

    n_marks = 1

    def __init__(self, closure: Closure, node: int) -> None:
        self._closure = closure
        closure.register(node)
        closure.register_finite_parts(node)
        kind, args, _ = closure.nodes[node]
        self.stable = kind == "G" and closure.nodes[args[0]].kind == "F"
        self._whole = closure.obligation(node)
        # G F f is the same after every prefix, so only F f has to be remembered, afresh after each time it is met.
        self._restart = closure.obligation(args[0]) if self.stable else FALSE
        self.initial: Hashable = (self._whole, self._restart if self.stable else self._finite(self._whole))

    def successors(self, state: Hashable) -> Successors:
        """See `Component`."""
        assert isinstance(state, tuple)
        whole, due = state
        due_after = self._closure.after(due)
        if self.stable:
            return [
                (letters, (whole, self._restart), 1) if remaining == TRUE else (letters, (whole, remaining), 0)
                for remaining, letters in due_after.items()
            ]
        result: Successors = []
        for following, letters in self._closure.after(whole).items():
            if len(due_after) > _MANY:
                check_time()
            for remaining, due_letters in due_after.items():
                common = letters & due_letters
                if common:
                    result.append((common, *self._next(following, remaining)))
        self._closure.budget.check_moves(len(result), self._closure.letters.n_classes)
        return result

    def _next(self, whole: Obligation, due: Obligation) -> tuple[Hashable, int]:
        if whole in (TRUE, FALSE):
            return (whole, TRUE), 0
        return ((whole, self._finite(whole)), 1) if due == TRUE else ((whole, due), 0)

    def _finite(self, whole: Obligation) -> Obligation:
        """The obligation with every greatest fixpoint (G, R, W) taken as satisfied: a co-safety formula.

        Clauses leave out what they imply, which may be finite: G F a stands for F a too.
        """
        closure = self._closure
        result = FALSE
        for clause in whole:
            part = TRUE
            for atom in bits(closure.closed(clause)):
                part = closure.both(part, closure.obligation(closure.finite_part(atom)))
            result = closure.either(result, part)
        return result

    def condition(self, state: Hashable) -> Acceptance:
        """See `Component`."""
        return (Clause(0, 1),)

    def decided(self, state: Hashable) -> bool | None:
        """See `Component`."""
        assert isinstance(state, tuple)
        return True if state[0] == TRUE else False if state[0] == FALSE else None


class Complement:
    """The complement of a component.

    Attributes:
        component: which is complemented.
    """

    def __init__(self, component: Component) -> None:
        self.component = component
        self.initial = component.initial
        self.n_marks = component.n_marks
        self.stable = component.stable

    def successors(self, state: Hashable) -> Successors:
        """See `Component`."""
        return self.component.successors(state)

    def condition(self, state: Hashable) -> Acceptance:
        """See `Component`."""
        return negation(self.component.condition(state))

    def decided(self, state: Hashable) -> bool | None:
        """See `Component`."""
        decided = self.component.decided(state)
        return None if decided is None else not decided
