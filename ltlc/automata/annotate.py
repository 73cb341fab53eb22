"""What is known about the states of a Rabin automaton: components, deadlocks, sinks, distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Protocol, TypeVar

from ltlc import graph
from ltlc.arrays import BoolArray, IntArray, np, npt
from ltlc.automata.acceptance import rabin_pair, streett
from ltlc.automata.emptiness import MarkedGraph, accepting_nodes

_Array = TypeVar("_Array", bound="npt.NDArray[np.generic]")


class ComponentKind(StrEnum):
    """What the runs that stay in a strong component do."""

    TRANSIENT = "transient"
    """there are none"""
    ACCEPTING = "accepting"
    """all are accepted"""
    REJECTING = "rejecting"
    """all are rejected"""
    MIXED = "mixed"
    """some are accepted, some rejected"""


@dataclass(frozen=True, eq=False)
class Annotations:
    """Facts about the states, reachable or not, of one automaton.

    Attributes:
        deadlocks: states from which no word is accepted.
        accepting_sinks: states from which every word is accepted.
        components: the strong component of each state, numbered in topological order.
        scc_kinds: one per strong component.
        live: for each pair, the states from which some word is accepted by it.
        distances: from each state, letters to the nearest state on an accepting cycle, -1 from a deadlock.
    """

    deadlocks: tuple[int, ...]
    accepting_sinks: tuple[int, ...]
    components: Sequence[int]
    scc_kinds: tuple[ComponentKind, ...]
    live: Sequence[Sequence[int]]
    distances: Sequence[int]

    @cached_property
    def scc(self) -> IntArray:
        """Shape (n_states,), int32; entry = strong component, numbered in topological order."""
        return _frozen(np.array(self.components, dtype=np.int32))

    @cached_property
    def distance(self) -> IntArray:
        """Shape (n_states,), int32; entry = letters to the nearest state on an accepting cycle, -1 from a deadlock."""
        return _frozen(np.array(self.distances, dtype=np.int32))

    @cached_property
    def live_pairs(self) -> BoolArray:
        """Shape (n_pairs, n_states), bool; entry = some word is accepted by this pair from this state."""
        table = np.zeros((len(self.live), len(self.components)), dtype=np.bool_)
        for row, states in zip(table, self.live, strict=True):
            row[states] = True
        return _frozen(table)

    @property
    def n_sccs(self) -> int:
        """Number of strong components, transient ones included."""
        return len(self.scc_kinds)


class HasMarkedGraph(Protocol):
    """The part of a Rabin automaton that annotations depend on."""

    @property
    def n_pairs(self) -> int:
        """Number of Rabin pairs."""

    @property
    def marked_graph(self) -> MarkedGraph:
        """Distinct (next state, marks) per state."""

    @property
    def scc(self) -> list[int]:
        """Strong component of each state, numbered in topological order."""


def annotate(automaton: HasMarkedGraph) -> Annotations:
    """Compute the annotations; `automaton.annotations` keeps them.

    A deadlock is found by emptiness and a sink by universality, both exactly and not by the look of a self-loop:
    a state is live for pair i iff it reaches a cycle without Fin and with Inf of i, and is not universal iff it
    reaches a cycle that no pair accepts.
    """
    edges = automaton.marked_graph
    n_states, n_pairs = len(edges), automaton.n_pairs
    successors = [list({target: None for target, _ in row}) for row in edges]
    predecessors = graph.predecessor_lists(successors)
    scc = automaton.scc
    members = graph.component_members(scc)
    cyclic = [part for part in members if len(part) > 1 or part[0] in successors[part[0]]]

    accepting: set[int] = set()
    live: list[list[int]] = []
    for i in range(n_pairs):
        on_cycle = accepting_nodes(edges, (rabin_pair(i),), cyclic)
        accepting |= on_cycle
        live.append(graph.reachable(predecessors, sorted(on_cycle)))
    rejecting = accepting_nodes(edges, (streett(n_pairs),), cyclic)

    distance = graph.distances(predecessors, sorted(accepting))
    not_universal = set(graph.reachable(predecessors, sorted(rejecting)))
    kinds = [ComponentKind.TRANSIENT] * len(members)
    for part in cyclic:
        accepts, rejects = not accepting.isdisjoint(part), not rejecting.isdisjoint(part)
        kinds[scc[part[0]]] = (
            ComponentKind.MIXED
            if accepts and rejects
            else ComponentKind.ACCEPTING
            if accepts
            else ComponentKind.REJECTING
        )
    return Annotations(
        deadlocks=tuple(q for q in range(n_states) if distance[q] < 0),
        accepting_sinks=tuple(q for q in range(n_states) if q not in not_universal),
        components=scc,
        scc_kinds=tuple(kinds),
        live=live,
        distances=distance,
    )


def _frozen(array: _Array) -> _Array:
    array.flags.writeable = False
    return array
