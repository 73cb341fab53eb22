"""The canonical form of a Rabin automaton: the same bytes for the same construction on every run and system."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ltlc.automata.rabin import RabinAutomaton


def canonical(automaton: RabinAutomaton) -> RabinAutomaton:
    """States numbered breadth-first from the initial state, letters in increasing order; unreachable ones dropped.

    Letter classes that no reachable state tells apart are merged, and numbered by their first letter. Propositions,
    pairs and their order stay. Two automata that differ in numbering alone get equal arrays.
    """
    by_first_letter = np.argsort(automaton.alphabet.first_letter, kind="stable")
    rows = automaton.delta[:, by_first_letter].tolist()
    order = [automaton.initial_state]
    number = {automaton.initial_state: 0}
    for state in order:  # grows while it is read
        for target in rows[state]:
            if target not in number:
                number[target] = len(order)
                order.append(target)

    on_edges = automaton.acceptance == "transition"
    delta = [[number[target] for target in rows[state]] for state in order]
    marks = automaton.edge_marks if on_edges else []
    columns: dict[tuple[object, ...], int] = {}
    merged = np.empty(automaton.n_classes, dtype=np.int32)
    kept: list[int] = []
    for position, old_class in enumerate(by_first_letter.tolist()):
        column: tuple[object, ...] = tuple(row[position] for row in delta)
        if on_edges:
            column = (column, tuple(marks[state][old_class] for state in order))
        if column not in columns:
            columns[column] = len(columns)
            kept.append(position)
        merged[old_class] = columns[column]

    if on_edges:
        chosen = by_first_letter[kept]
        fin, inf = automaton.fin[:, order][:, :, chosen], automaton.inf[:, order][:, :, chosen]
    else:
        fin, inf = automaton.fin[:, order], automaton.inf[:, order]
    names = automaton.state_names
    return replace(
        automaton,
        delta=np.array(delta, dtype=np.int32)[:, kept],
        letter_class=merged[automaton.letter_class],
        fin=fin,
        inf=inf,
        initial_state=0,
        state_names=None if names is None else tuple(names[state] for state in order),
    )
