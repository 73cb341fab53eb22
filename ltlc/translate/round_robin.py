"""Recurrence parts that are only asked for together wait for each other: their states are added, not multiplied.

G F f & G F g holds iff again and again f is met, and then g. So one automaton can look for f first, and for g from then
on, and has one state for each state of either. The same for F G parts that are alternatives, by complement.

References:
    Y. Choueka: Theories of automata on omega-tapes: A simplified approach. Journal of Computer and System Sciences 8,
    1974, doi 10.1016/S0022-0000(74)80051-6 (the intersection of Buchi conditions by turns).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from ltlc.automata.acceptance import Acceptance, Clause
from ltlc.automata.emerson_lei import explore
from ltlc.budget import Budget
from ltlc.errors import StateLimitExceeded
from ltlc.translate.components import Breakpoint, Complement, Component, Successors
from ltlc.translate.product import Skeleton, antichain, mentioned

_MANY_MARKS = 8
"""More marks than this of parts that are asked for together are one: a state has a move for each set of them;"""
_MANY_PAIRS = 12
"""and so are those of more alternatives than this, which would be a pair each,"""
_MANY_PARTS = 14
"""and any of these where there are more parts than this in all."""


class RoundRobin:
    """The conjunction of recurrence parts that do not depend on the prefix; mark 0 is seen whenever all had a turn."""

    n_marks = 1
    stable = True

    def __init__(self, parts: Sequence[Component]) -> None:
        self._parts = parts
        self.initial: Hashable = (0, parts[0].initial)

    def successors(self, state: Hashable) -> Successors:
        """See `Component`."""
        assert isinstance(state, tuple)
        turn, inner = state
        following = (turn + 1) % len(self._parts)
        start = (following, self._parts[following].initial)
        done = int(following == 0)
        return [
            (letters, start, done) if marks else (letters, (turn, target), 0)
            for letters, target, marks in self._parts[turn].successors(inner)
        ]

    def condition(self, state: Hashable) -> Acceptance:
        """See `Component`."""
        return (Clause(0, 1),)

    def decided(self, state: Hashable) -> bool | None:
        """See `Component`."""
        return None


def by_turns(skeleton: Skeleton, components: Sequence[Component], budget: Budget) -> tuple[Skeleton, list[Component]]:
    """Join recurrence components that are only asked for together, and persistence components that are alternatives.

    They are joined where that gives fewer states. If they are asked for together, their product is visited once for
    each of them; alternatives have a pair each, and merging by trial makes what is a little larger as small.

    Args:
        skeleton: the Boolean combination.
        components: what it combines.
        budget: for what is explored to count states.
    """
    joined = list(components)
    for kind in (_together, _alternatives) if len(joined) > 1 else ():
        for group in kind(skeleton, joined):
            parts = [joined[i] for i in group]
            rounds = RoundRobin([part.component if isinstance(part, Complement) else part for part in parts])
            n_states = len(explore(rounds.initial, rounds.successors, budget)[0])
            enough = n_states // len(parts) if kind is _together else n_states + n_states // 2
            most = _MANY_MARKS if kind is _together else _MANY_PAIRS
            has_many_marks = len(parts) > most or mentioned(skeleton).bit_count() > _MANY_PARTS
            if not has_many_marks and not _has_more_states(parts, enough, budget):
                continue
            joined[group[0]] = Complement(rounds) if kind is _alternatives else rounds
            others = sum(1 << i for i in group[1:])
            if kind is _together:
                skeleton = antichain({clause & ~others for clause in skeleton})
            else:
                skeleton = antichain({clause for clause in skeleton if not clause & others})
    return skeleton, joined


def _together(skeleton: Skeleton, components: Sequence[Component]) -> list[list[int]]:
    """Groups of recurrence components that are in the same clauses."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for i, component in enumerate(components):
        if isinstance(component, Breakpoint) and component.stable:
            inside = tuple(clause for clause in skeleton if clause >> i & 1)
            if inside:
                groups.setdefault(inside, []).append(i)
    return [group for group in groups.values() if len(group) > 1]


def _alternatives(skeleton: Skeleton, components: Sequence[Component]) -> list[list[int]]:
    """Groups of persistence components each of which can replace each other one in every clause."""
    groups: dict[frozenset[int], list[int]] = {}
    for i, component in enumerate(components):
        if isinstance(component, Complement) and isinstance(component.component, Breakpoint) and component.stable:
            context = frozenset(clause & ~(1 << i) for clause in skeleton if clause >> i & 1)
            if context:
                groups.setdefault(context, []).append(i)
    return [group for group in groups.values() if len(group) > 1]


def _has_more_states(parts: Sequence[Component], n_states: int, budget: Budget) -> bool:
    """Whether the product of components has more states than these."""
    everything = sum(letters for letters, _, _ in parts[0].successors(parts[0].initial))

    def successors(states: tuple[Hashable, ...]) -> list[tuple[int, tuple[Hashable, ...], int]]:
        ways: list[tuple[int, tuple[Hashable, ...]]] = [(everything, ())]
        for part, state in zip(parts, states, strict=True):
            moves = part.successors(state)
            ways = [(common, (*targets, t)) for n, targets in ways for m, t, _ in moves if (common := n & m)]
        return [(letters, targets, 0) for letters, targets in ways]

    try:
        explore(tuple(part.initial for part in parts), successors, budget.within(n_states))
    except StateLimitExceeded:
        return True
    return False
