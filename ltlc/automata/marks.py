"""The marks of a Rabin automaton, brought to as few pairs as this finds and as regular as they can be.

Only cycles matter, so every strong component chooses its marks alone; pair i of one component has nothing to do with
pair i of another. Within a component, pairs are tried to be replaced by one: let *good* be the edges on a cycle that
they accept, and *bad* the good edges on a cycle among them that is rejected by all pairs. Then Fin = not good and
Inf = good but not bad accepts only what is accepted, and suffices iff no cycle of bad edges is accepted by them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from operator import and_, or_
from typing import Any

from ltlc import graph
from ltlc.arrays import BoolArray, np
from ltlc.automata.acceptance import Acceptance, rabin_pair
from ltlc.automata.canonical import CANONICAL, tells_columns_apart
from ltlc.automata.emptiness import MAX_MASK, MarkedEdge, accepting_parts
from ltlc.automata.rabin import DRA
from ltlc.automata.transition_based import to_transition_based
from ltlc.automata.wide import Columns
from ltlc.budget import check_time

SIMPLE_MARKS = "simple marks"
"""the name of the form in `DRA.forms`."""
EdgePair = tuple[set[MarkedEdge], set[MarkedEdge]]
"""Fin and Inf edges of one pair in one strong component."""


def simplify_marks(automaton: DRA) -> DRA:
    """Choose the marks anew: no mark on edges that are on no cycle, and only needed pairs.

    No Fin where there is no accepting cycle, no pair with Fin where one without does (Buchi type), one pair where one
    suffices (Rabin index 1), pairs merged or dropped otherwise. Every cycle keeps its acceptance; the kind of
    acceptance stays. One pair is kept even if nothing is accepted.

    References:
        S. C. Krishnan, A. Puri, R. K. Brayton, Deterministic omega-automata vis-a-vis deterministic Buchi automata,
        ISAAC 1994, doi 10.1007/3-540-58325-4_202, for the Buchi type; the same idea is used here for one Rabin pair.
    """
    if SIMPLE_MARKS in automaton.forms:
        return automaton
    chosen = [(c.nodes, c.pairs()) for c in components(automaton)]
    n_pairs = max([1, *(len(pairs) for _, pairs in chosen)])
    columns = Columns(automaton)
    marks: list[Any]
    if automaton.acceptance == "state":
        marks = [0] * automaton.n_states
        for _, pairs in chosen:
            for (_, target, _), mark in _marked(pairs).items():
                marks[target] |= mark
    else:
        marks = [[0] * automaton.n_classes] * automaton.n_states
        for nodes, pairs in chosen:
            check_time()
            known = _marked(pairs)
            for q in nodes if known else ():
                marks[q] = columns.spread(q, [known.get((q, t, m), 0) for t, m in columns.of(q)])
    result = automaton.with_marks(marks, n_pairs)
    if automaton.has_marks_of(result):
        return automaton.annotated(SIMPLE_MARKS)
    languages = automaton.language_numbers if automaton.has_languages else None
    result = result.annotated(SIMPLE_MARKS, languages=languages)
    stays = CANONICAL in automaton.forms and tells_columns_apart(result)
    return result.annotated(CANONICAL) if stays else result


def _marked(pairs: Sequence[EdgePair]) -> dict[MarkedEdge, int]:
    """The marks, as in `DRA.marks`, of each edge that has some."""
    known: dict[MarkedEdge, int] = {}
    for i, pair in enumerate(pairs):
        for place, edges in enumerate(pair):
            for edge in edges:
                known[edge] = known.get(edge, 0) | 1 << 2 * i + place
    return known


def buchi_edges(automaton: DRA) -> BoolArray | None:
    """Edges that make the automaton a Buchi automaton for its own language, or None if no choice of edges does.

    Returns:
        shape (n_states, n_classes), bool: the edges on a cycle but on no rejecting one; or None.

    References:
        S. C. Krishnan, A. Puri, R. K. Brayton, Deterministic omega-automata vis-a-vis deterministic Buchi automata,
        ISAAC 1994, doi 10.1007/3-540-58325-4_202; here for marks on edges.
    """
    automaton = to_transition_based(automaton)
    chosen: set[MarkedEdge] = set()
    for component in components(automaton):
        final = component.buchi_edges()
        if final is None:
            return None
        chosen |= final
    rows = [
        [(q, t, m) in chosen for t, m in zip(targets, marks, strict=True)]
        for q, (targets, marks) in enumerate(zip(automaton.rows, automaton.edge_marks, strict=True))
    ]
    return np.array(rows, dtype=np.bool_)


def components(automaton: DRA) -> Iterator[Component]:
    """The non-trivial strong components, in topological order."""
    scc = automaton.scc
    for nodes in graph.component_members(scc):
        inside = scc[nodes[0]]
        edges = [(q, t, m) for q in nodes for t, m in automaton.marked_graph[q] if scc[t] == inside]
        if edges:
            yield Component(nodes, edges, automaton.n_pairs, automaton.acceptance == "state")


@dataclass(frozen=True)
class Component:
    """A strong component, with marks as in `DRA.edge_marks`."""

    nodes: list[int]
    edges: list[MarkedEdge]
    n_pairs: int
    on_states: bool
    """whether all edges into a state must get the same marks."""

    def buchi_edges(self) -> set[MarkedEdge] | None:
        """The edges on no rejected cycle if every accepted cycle has one, else None: no choice of edges does then."""
        inner = set(self.edges)
        bad = self.rejected(inner)
        return None if self.accepted(range(self.n_pairs), bad) else inner - bad

    def pairs(self) -> list[EdgePair]:
        """Pairs that accept the same cycles, as few as found."""
        possible, certain = reduce(or_, marks := [m for *_, m in self.edges]), reduce(and_, marks)
        if not possible & sum(2 << 2 * i for i in range(self.n_pairs)):
            return []
        if any(certain >> 2 * i & 2 and not possible >> 2 * i & 1 for i in range(self.n_pairs)):
            return [(set(), set(self.edges))]
        final = self.buchi_edges()
        if final is not None:
            return [(set(), final)] if final else []
        single = self.one_pair(range(self.n_pairs))
        if single is not None:
            return [single]
        return self.irredundant(self.merged_pairs())

    def one_pair(self, pairs: Sequence[int]) -> EdgePair | None:
        """One pair that accepts all cycles that some of these accept, and none that all pairs reject; or None."""
        inner = set(self.edges)
        good = self.accepted(pairs, inner)
        bad = self.rejected(good) & good
        return None if self.accepted(pairs, bad) else (inner - good, good - bad)

    def merged_pairs(self) -> list[EdgePair]:
        """Pairs for groups of the old ones, groups joined greedily."""
        useful = [i for i in range(self.n_pairs) if self.accepted([i], set(self.edges))]
        groups: list[tuple[int, ...]] = [(i,) for i in useful]
        found = [pair for group in groups if (pair := self.one_pair(group)) is not None]
        joined = True
        while joined:
            joined = False
            for i, j in combinations(range(len(groups)), 2):
                pair = self.one_pair(groups[i] + groups[j])
                if pair is not None:
                    groups[i], found[i] = groups[i] + groups[j], pair
                    del groups[j], found[j]
                    joined = True
                    break
        return found

    def irredundant(self, pairs: list[EdgePair]) -> list[EdgePair]:
        """Without the pairs that accept only cycles that others accept."""
        by_new_marks = []
        for edge in self.edges:
            marks = sum((edge in fin) << (2 * i) | (edge in inf) << (2 * i + 1) for i, (fin, inf) in enumerate(pairs))
            by_new_marks.append((edge[0], edge[1], marks))
        renamed = Component(self.nodes, by_new_marks, len(pairs), self.on_states)
        kept = list(range(len(pairs)))
        for i in reversed(range(len(pairs))):
            others = [rabin_pair(j) for j in kept if j != i]
            alone = rabin_pair(i)._replace(promises=tuple((other.inf, other.fin) for other in others))
            if not renamed.on_cycles((alone,)):
                kept.remove(i)
        return [pairs[i] for i in kept]

    def accepted(self, pairs: Sequence[int], edges: set[MarkedEdge]) -> set[MarkedEdge]:
        """The edges on a cycle, among these, that some of the pairs accepts."""
        found: list[list[MarkedEdge]] = []
        for i in pairs:
            fin, inf = 1 << 2 * i, 2 << 2 * i
            parts = strong_parts(edge for edge in edges if not edge[2] & fin)
            found += [part for part, seen in parts if seen & inf]
        return self.covered(found)

    def rejected(self, edges: set[MarkedEdge]) -> set[MarkedEdge]:
        """The edges on a cycle, among these, that no pair accepts: a Streett condition (Emerson and Lei 1987)."""
        found: list[list[MarkedEdge]] = []
        todo = strong_parts(edges)
        while todo:
            part, seen = todo.pop()
            accepting = sum(2 << 2 * i for i in range(self.n_pairs) if seen >> 2 * i & 3 == 2)
            if accepting:
                todo += strong_parts(edge for edge in part if not edge[2] & accepting)
            else:
                found.append(part)
        return self.covered(found)

    def covered(self, parts: Sequence[Sequence[MarkedEdge]]) -> set[MarkedEdge]:
        """The edges of these strongly connected parts; with marks on states, all edges into their states."""
        found = {edge for part in parts for edge in part}
        if self.on_states:
            targets = {target for _, target, _ in found}
            found = {edge for edge in self.edges if edge[1] in targets}
        return found

    def on_cycles(self, acceptance: Acceptance) -> set[MarkedEdge]:
        """The edges on a cycle that satisfies the condition; with marks on states, all edges into such states."""
        index = {node: i for i, node in enumerate(self.nodes)}
        rows: list[list[tuple[int, int]]] = [[] for _ in self.nodes]
        for edge in self.edges:
            rows[index[edge[0]]].append((index[edge[1]], edge[2]))
        targets: set[int] = set()
        found: set[MarkedEdge] = set()
        for part in accepting_parts(rows, acceptance):
            check_time()
            inside = {self.nodes[i] for i in part.nodes}
            targets |= inside
            if not self.on_states:
                found |= {e for e in self.edges if e[0] in inside and e[1] in inside and not e[2] & part.avoided}
        return {edge for edge in self.edges if edge[1] in targets} if self.on_states else found


def strong_parts(edges: Iterable[MarkedEdge]) -> list[tuple[list[MarkedEdge], int]]:
    """The edges inside each strong component of a set of edges, and the marks that they have together."""
    edges = list(edges)
    number = {node: i for i, node in enumerate(dict.fromkeys([source for source, _, _ in edges]))}
    inner = [edge for edge in edges if edge[1] in number]  # nothing leads back from other targets
    if len(number) == 1:
        return [(inner, reduce(or_, [marks for _, _, marks in inner]))] if inner else []
    if len(number) <= MAX_MASK:
        bit = {node: 1 << i for node, i in number.items()}
        reached = dict.fromkeys(number, 0)
        for source, target, _ in inner:
            reached[source] |= bit[target]
        component = [-1] * len(number)
        for c, members in enumerate(graph.strong_sets(list(reached.values()), (1 << len(number)) - 1)):
            for i in graph.bits(members):
                component[i] = c
    else:
        arcs = [(number[source], number[target]) for source, target, _ in inner]
        component = graph.strong_components(graph.from_edges(len(number), arcs))
    here = {node: component[i] for node, i in number.items()}
    parts: dict[int, list[MarkedEdge]] = {}
    for edge in inner:
        c = here[edge[0]]
        if c == here[edge[1]] and c >= 0:
            parts.setdefault(c, []).append(edge)
    return [(part, reduce(or_, {marks for _, _, marks in part})) for part in parts.values()]
