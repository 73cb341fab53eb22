"""Parity acceptance: recognised on the structure of a Rabin automaton, or made with a record of the pairs.

Colours are on edges (state, letter class); a run is accepted iff the largest colour that it sees infinitely often is
odd.
"""

from __future__ import annotations

from dataclasses import replace

from ltlc.arrays import BoolArray, IntArray, np
from ltlc.automata.acceptance import holds, rabin
from ltlc.automata.cycles import CycleDecomposition
from ltlc.automata.emptiness import MarkedEdge
from ltlc.automata.marks import Component, components, strong_parts
from ltlc.automata.partition import number_blocks, refine
from ltlc.automata.rabin import DRA
from ltlc.automata.refinement import Refinement
from ltlc.automata.transition_based import to_transition_based
from ltlc.budget import MAX_STATES, check_time
from ltlc.errors import StateLimitExceeded

Colours = dict[MarkedEdge, int]
Copy = tuple[int, int]
"""A state and a record; where no record is needed, it is 0."""


def parity_colours(automaton: DRA) -> IntArray | None:
    """Colours that make the automaton a parity automaton for its own language, or None where no colours do.

    Every strong component gets the fewest colours it can have, from 0 up: {0, 1} is Buchi, {1, 2} co-Buchi, {0} rejects
    and {1} accepts everything. Edges on no cycle have colour 0. Whatever pairs the automaton is written with, the
    answer is the same.

    Returns:
        shape (n_states, n_classes), int32, or None.

    References:
        D. Niwinski, I. Walukiewicz, Relating hierarchies of word and tree automata, STACS 1998,
        doi 10.1007/BFb0028571 (how many colours); S. C. Krishnan, A. Puri, R. K. Brayton, Deterministic omega-automata
        vis-a-vis deterministic Buchi automata, ISAAC 1994, doi 10.1007/3-540-58325-4_202 (the Buchi type).
    """
    automaton = to_transition_based(automaton)
    colours: Colours = {}
    for component in components(automaton):
        own = _component_colours(component)
        if own is None:
            return None
        colours |= own
    return _table(automaton, colours)


def to_parity(automaton: DRA, *, max_states: int = MAX_STATES) -> Refinement:
    """A parity automaton for the same language, written as a chain of Rabin pairs with acceptance on transitions.

    Strong components that are of parity type as they are stay as they are. In each other one the state is joined by a
    record. An index appearance record is an order of the pairs, in which a pair whose Fin mark is seen comes to the
    front; then a run is judged by the last pair that is still marked. Many orders are not worth telling apart. Those
    that are can be read off the alternating cycle decomposition: the record is a branch of that tree, there are never
    more branches than orders, and no parity automaton made by joining records to these states has fewer states.

    Args:
        automaton: any Rabin automaton.
        max_states: bound on the states of the product.

    Raises:
        StateLimitExceeded: there are more.

    References:
        C. Loeding, Optimal bounds for transformations of omega-automata, FSTTCS 1999, doi 10.1007/3-540-46691-6_8.
        J. Kretinsky, T. Meggendorfer, C. Waldmann, M. Weininger, Index appearance record with preorders, Acta
        Informatica 2022, doi 10.1007/s00236-021-00412-y.
        A. Casares, T. Colcombet, N. Fijalkow, Optimal transformations of games and automata using Muller conditions,
        ICALP 2021, doi 10.4230/LIPIcs.ICALP.2021.123.
        A. Casares, A. Duret-Lutz, K. J. Meyer, F. Renkin, S. Sickert, Practical applications of the alternating cycle
        decomposition, TACAS 2022, doi 10.1007/978-3-030-99527-0_6.
    """
    automaton = to_transition_based(automaton)
    records: dict[int, CycleDecomposition] = {}
    colours: Colours = {}
    for component in components(automaton):
        own = _component_colours(component)
        if own is None:
            try:
                cycles = CycleDecomposition(rabin(component.n_pairs), component.edges, max_states)
            except OverflowError:
                raise _too_large(max_states) from None
            records |= dict.fromkeys(component.nodes, cycles)
        else:
            colours |= own
    product, origin = _product(automaton, records, colours, max_states)
    return _merged(Refinement(product, origin, np.zeros((len(origin), 0), dtype=np.int32)))


def _component_colours(component: Component) -> Colours | None:
    """The colours of one strong component, or None if it is not of parity type."""
    colours: Colours = {}
    return colours if _colour(component, set(component.edges), colours) is not None else None


def _colour(component: Component, edges: set[MarkedEdge], colours: Colours) -> int | None:
    """Colour strongly connected edges; returns the largest colour, or None if there are no such colours.

    Edges on no cycle that is judged otherwise than all edges together get the largest colour. The others fall into
    strongly connected parts. Were such a part, a union of cycles judged otherwise, judged like the whole, then so
    would two cycles judged alike have a union judged differently, which parity acceptance cannot say.
    """
    accepted = _accepts(component, edges)
    other = component.rejected(edges) if accepted else component.accepted(range(component.n_pairs), edges)
    largest = -1 if other else int(accepted) - 1
    for part in _parts(other):
        below = None if _accepts(component, part) == accepted else _colour(component, part, colours)
        if below is None:
            return None
        largest = max(largest, below)
    colours.update(dict.fromkeys(edges - other, largest + 1))
    return largest + 1


def _accepts(component: Component, edges: set[MarkedEdge]) -> bool:
    """Whether a run that takes exactly these edges for ever is accepted."""
    seen = 0
    for _, _, marks in edges:
        seen |= marks
    return holds(rabin(component.n_pairs), seen)


def _parts(edges: set[MarkedEdge]) -> list[set[MarkedEdge]]:
    """The strongly connected parts of a set of edges."""
    return [set(part) for part, _ in strong_parts(edges)]


def _product(
    automaton: DRA, records: dict[int, CycleDecomposition], colours: Colours, max_states: int
) -> tuple[DRA, IntArray]:
    """The automaton with records, breadth-first, and the state behind each of its states."""

    def enter(state: int) -> Copy:
        return state, records[state].leaf(state) if state in records else 0

    copies = [enter(automaton.initial_state)]
    number = {copies[0]: 0}
    delta: list[list[int]] = []
    table: list[list[int]] = []
    for state, record in copies:  # grows while it is read
        check_time()
        row, seen = [], []
        for target, marks in zip(automaton.rows[state], automaton.edge_marks[state], strict=True):
            edge = (state, target, marks)
            copy, colour = enter(target), colours.get(edge, 0)
            if state in records and automaton.scc[state] == automaton.scc[target]:
                cycles = records[state]
                after, depth = cycles.step(record, edge)
                highest = cycles.depth + (cycles.depth + cycles.root_accepts) % 2
                copy, colour = (target, after), highest - depth
            if copy not in number:
                number[copy] = len(copies)
                copies.append(copy)
            row.append(number[copy])
            seen.append(colour)
        delta.append(row)
        table.append(seen)
        if len(copies) > max_states:
            raise _too_large(max_states)
    names = automaton.state_names
    fin, inf = _chain(np.array(table, dtype=np.int32))
    product = replace(
        automaton,
        delta=np.array(delta, dtype=np.int32),
        fin=fin,
        inf=inf,
        initial_state=0,
        state_names=None if names is None else tuple(names[state] for state, _ in copies),
    )
    return product, np.array([state for state, _ in copies], dtype=np.int32)


def _merged(refinement: Refinement) -> Refinement:
    """Fewest colours, and copies of a state merged that have the same future."""
    automaton = refinement.automaton
    colours = parity_colours(automaton)
    assert colours is not None
    keys = zip(refinement.origin.tolist(), map(tuple, colours.tolist()), strict=True)
    block = refine(automaton.delta, number_blocks(keys))
    first = np.unique(block, return_index=True)[1]
    names = automaton.state_names
    fin, inf = _chain(colours[first])
    merged = replace(
        automaton,
        delta=block[automaton.delta[first]],
        fin=fin,
        inf=inf,
        initial_state=int(block[automaton.initial_state]),
        state_names=None if names is None else tuple(names[q] for q in first.tolist()),
    )
    return Refinement(merged, refinement.origin[first], refinement.select_pair[first])


def _chain(colours: IntArray) -> tuple[BoolArray, BoolArray]:
    """Fin and Inf marks that say the same as colours: a pair for each odd one, with every larger one in its Fin set."""
    odd = np.arange(1, max(2, int(colours.max(initial=0)) + 1), 2)[:, None, None]
    return colours > odd, colours == odd


def _table(automaton: DRA, colours: Colours) -> IntArray:
    rows = [
        [colours.get((q, target, marks), 0) for target, marks in zip(targets, row, strict=True)]
        for q, (targets, row) in enumerate(zip(automaton.rows, automaton.edge_marks, strict=True))
    ]
    return np.array(rows, dtype=np.int32)


def _too_large(max_states: int) -> StateLimitExceeded:
    return StateLimitExceeded(f"the parity automaton needs more than {max_states} states; raise max_states")
