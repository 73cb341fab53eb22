"""The limit-deterministic automaton in which a policy says once which Rabin pair it will satisfy."""

from __future__ import annotations

from dataclasses import replace

from ltlc import graph
from ltlc.arrays import np
from ltlc.automata.emptiness import MarkedEdge
from ltlc.automata.marks import Component, components
from ltlc.automata.rabin import DRA
from ltlc.automata.refinement import Refinement
from ltlc.automata.transition_based import to_transition_based


def limit_deterministic(automaton: DRA) -> Refinement:
    """A Buchi automaton for the same language, deterministic but for one choice of a pair in each run.

    The first states are those of the automaton. In a strong component that is of Buchi type they accept by themselves.
    In another one, a pair i can be chosen in each strongly connected part that has no Fin edge of i and some Inf edge.
    The choice leads to a copy of that part, where the Inf edges accept and every other way out goes to the last state,
    a rejecting sink. There is no choice, and no sink, iff the automaton is of Buchi type.

    For Markov decision processes this is as good as the automaton itself: in an end component that satisfies pair i the
    automaton stays in one such part, so choosing i there loses nothing. And no choice makes a run accepted that is not.

    References:
        S. Sickert, J. Esparza, S. Jaax, J. Kretinsky, Limit-deterministic Buchi automata for linear temporal logic,
        CAV 2016, doi 10.1007/978-3-319-41540-6_17.
        E. M. Hahn, M. Perez, S. Schewe, F. Somenzi, A. Trivedi, D. Wojtczak, Good-for-MDPs automata for probabilistic
        analysis and reinforcement learning, TACAS 2020, doi 10.1007/978-3-030-45190-5_17.
    """
    automaton = to_transition_based(automaton)
    accepting: set[MarkedEdge] = set()
    parts: list[tuple[int, set[MarkedEdge], set[MarkedEdge]]] = []
    for component in components(automaton):
        pairs = component.pairs()
        if not any(fin for fin, _ in pairs):
            accepting |= {edge for _, marked in pairs for edge in marked}
            continue
        for i, (fin, marked) in enumerate(pairs):
            parts += [(i, inner, inner & marked) for inner in _parts(component, fin) if inner & marked]
    n = automaton.n_states
    select_pair = np.full((n, max((i + 1 for i, _, _ in parts), default=0)), -1, dtype=np.int32)
    copied: list[tuple[int, int]] = []
    for number, (i, inner, _) in enumerate(parts):
        for state in sorted({source for source, _, _ in inner}):
            select_pair[state, i] = n + len(copied)
            copied.append((state, number))
    sink = n + len(copied)
    delta = [*automaton.rows]
    inf_marks = [[edge in accepting for edge in _edges(automaton, state)] for state in range(n)]
    for state, number in copied:
        i, inner, marked = parts[number]
        edges = _edges(automaton, state)
        delta.append([int(select_pair[edge[1], i]) if edge in inner else sink for edge in edges])
        inf_marks.append([edge in marked for edge in edges])
    if copied:
        delta.append([sink] * automaton.n_classes)
        inf_marks.append([False] * automaton.n_classes)
    inf = np.array([inf_marks], dtype=np.bool_)
    return Refinement(
        replace(automaton, delta=np.array(delta), fin=np.zeros_like(inf), inf=inf, state_names=None),
        np.array([*range(n), *(state for state, _ in copied), *([-1] if copied else [])], dtype=np.int32),
        np.vstack((select_pair, np.full((len(delta) - n, select_pair.shape[1]), -1, dtype=np.int32))),
    )


def _parts(component: Component, fin: set[MarkedEdge]) -> list[set[MarkedEdge]]:
    """The strongly connected parts of the component without the Fin edges."""
    number = {node: i for i, node in enumerate(component.nodes)}
    allowed = [edge for edge in component.edges if edge not in fin]
    part = graph.strong_components(graph.from_edges(len(number), ((number[s], number[t]) for s, t, _ in allowed)))
    parts: dict[int, set[MarkedEdge]] = {}
    for edge in allowed:
        if part[number[edge[0]]] == part[number[edge[1]]]:
            parts.setdefault(part[number[edge[0]]], set()).add(edge)
    return [parts[key] for key in sorted(parts)]


def _edges(automaton: DRA, state: int) -> list[MarkedEdge]:
    """The edges of a state, a letter class each."""
    return [(state, t, m) for t, m in zip(automaton.rows[state], automaton.edge_marks[state], strict=True)]
