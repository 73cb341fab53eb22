"""What an HOA file claims of its automaton beyond what is needed to read it, held against the automaton.

`complete`, which tells most about lost text, and where labels and marks stand, are checked while reading: the place of
a fault is known there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from ltlc import graph
from ltlc.automata.annotate import ComponentKind
from ltlc.automata.rabin import DRA


@dataclass(frozen=True)
class Evidence:
    """A deterministic automaton as it was written, and as it was read."""

    n_states: int
    initial_state: int
    sources: Sequence[int]
    """source state of each edge."""
    targets: Sequence[int]
    """target state of each edge."""
    marks: Sequence[frozenset[int]]
    """acceptance sets of each edge, those of its source included."""
    automaton: DRA
    """for the same language, its states perhaps multiplied."""

    @cached_property
    def inner_edges(self) -> list[tuple[int, int, frozenset[int], int]]:
        """Source, target, marks and strong component of each edge that can be taken again and again."""
        edges = list(zip(self.sources, self.targets, self.marks, strict=True))
        successors = graph.from_edges(self.n_states, zip(self.sources, self.targets, strict=True))
        reached = set(graph.reachable(successors, [self.initial_state]))
        component = graph.strong_components(successors)
        return [(q, t, marks, component[q]) for q, t, marks in edges if q in reached and component[q] == component[t]]

    @property
    def is_weak(self) -> bool:
        """Whether all edges of a strong component have the same marks."""
        marks_of: dict[int, frozenset[int]] = {}
        return all(marks_of.setdefault(component, marks) == marks for *_, marks, component in self.inner_edges)

    @property
    def is_very_weak(self) -> bool:
        """Whether it is weak, and the only cycles are self-loops."""
        return self.is_weak and all(source == target for source, target, *_ in self.inner_edges)

    @cached_property
    def cyclic_kinds(self) -> dict[int, ComponentKind]:
        """What the runs do that stay in the component of a state, for each state that can be reached."""
        kinds, scc = self.automaton.annotations.scc_kinds, self.automaton.annotations.scc
        reached = graph.reachable(self.automaton.delta, [self.automaton.initial_state])
        return {state: kinds[scc[state]] for state in reached}

    @property
    def is_inherently_weak(self) -> bool:
        """Whether no strong component has accepting and rejecting cycles."""
        return ComponentKind.MIXED not in self.cyclic_kinds.values()

    @property
    def is_terminal(self) -> bool:
        """Whether it is weak, and whatever follows after an accepting cycle was reached is accepted."""
        accepting = {state for state, kind in self.cyclic_kinds.items() if kind is ComponentKind.ACCEPTING}
        return self.is_weak and accepting <= set(self.automaton.accepting_sinks)

    @property
    def is_colored(self) -> bool:
        """Whether each edge is in exactly one set."""
        return all(len(marks) == 1 for marks in self.marks)


_HOLDS: Mapping[str, Callable[[Evidence], bool]] = {
    "deterministic": lambda _: True,
    "semi-deterministic": lambda _: True,
    "unambiguous": lambda _: True,
    "no-univ-branch": lambda _: True,
    "univ-branch": lambda _: False,
    "exist-branch": lambda _: False,
    "weak": lambda evidence: evidence.is_weak,
    "very-weak": lambda evidence: evidence.is_very_weak,
    "inherently-weak": lambda evidence: evidence.is_inherently_weak,
    "terminal": lambda evidence: evidence.is_terminal,
    "colored": lambda evidence: evidence.is_colored,
}


def failing_claim(claims: Iterable[str], evidence: Evidence) -> str | None:
    """The first property, or denial of one as `!name`, that does not hold; those not known here are passed over."""
    for claim in claims:
        name = claim.removeprefix("!")
        if name in _HOLDS and _HOLDS[name](evidence) == claim.startswith("!"):
            return claim
    return None
