"""The nondeterministic automaton: transition-based generalized Buchi acceptance, symbolic edges.

It stands between the tableau and determinization and never leaves the library. Letters are letter classes; a set of
them is a Python integer used as a bitmask.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ltlc import graph


class Edge(NamedTuple):
    """A move to `target` on any letter in `letters`, in the acceptance sets `marks`; both are bitmasks."""

    letters: int
    target: int
    marks: int


@dataclass(frozen=True)
class BuchiAutomaton:
    """A word is accepted iff some run on it takes edges of every acceptance set infinitely often."""

    n_classes: int
    """number of letter classes."""
    initial: tuple[int, ...]
    """the initial states."""
    edges: tuple[tuple[Edge, ...], ...]
    """outgoing edges by state."""
    n_sets: int
    """number of acceptance sets; with none, every infinite run is accepting."""

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.edges)

    def successors(self) -> list[list[int]]:
        """Target states of each state."""
        return [[edge.target for edge in out] for out in self.edges]

    def accepts(self, prefix: Sequence[int], cycle: Sequence[int]) -> bool:
        """Whether the word of letter classes `prefix` followed by `cycle` for ever has an accepting run.

        A search for a strong component with all marks in the product of states and word positions; for tests.
        """
        word = [*prefix, *cycle]
        n = len(word)
        following = [*range(1, n), len(prefix)]
        arcs: list[list[tuple[int, int]]] = [
            [(e.target * n + following[i], e.marks) for e in self.edges[q] if e.letters >> word[i] & 1]
            for q in range(self.n_states)
            for i in range(n)
        ]
        successors = [[target for target, _ in out] for out in arcs]
        component = graph.strong_components(successors)
        seen: dict[int, int] = {}
        for node in graph.reachable(successors, [q * n for q in self.initial]):
            for target, marks in arcs[node]:
                if component[target] == component[node]:
                    seen[component[node]] = seen.get(component[node], 0) | marks
        return any(marks == (1 << self.n_sets) - 1 for marks in seen.values())
