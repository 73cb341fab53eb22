"""The canonical form of a Rabin automaton: the same bytes for the same construction on every run and system."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ltlc.automata.rabin import RabinAutomaton
from ltlc.budget import check_time


def canonical(automaton: RabinAutomaton) -> RabinAutomaton:
    """States numbered breadth-first from the initial state, letters in increasing order; unreachable ones dropped.

    Letter classes that no reachable state tells apart are merged, and numbered by their first letter. Propositions,
    pairs and their order stay. Two automata that differ in numbering alone get equal arrays.
    """
    if "canonical" in automaton.facts:
        return automaton
    by_first_letter: list[int] = np.argsort(automaton.alphabet.first_letter, kind="stable").tolist()
    rows = [[row[c] for c in by_first_letter] for row in automaton.rows]
    order = [automaton.initial_state]
    number = {automaton.initial_state: 0}
    for state in order:  # grows while it is read
        if not state & 255:
            check_time()
        for target in rows[state]:
            if target not in number:
                number[target] = len(order)
                order.append(target)

    delta = [[number[target] for target in rows[state]] for state in order]
    told_apart_by = delta
    if automaton.acceptance == "transition":
        marks = automaton.edge_marks
        told_apart_by = delta + [[marks[state][c] for c in by_first_letter] for state in order]
    columns: dict[tuple[int, ...], int] = {}
    merged = [columns.setdefault(column, len(columns)) for column in zip(*told_apart_by, strict=True)]
    in_order = order == list(range(automaton.n_states))
    if in_order and len(columns) == automaton.n_classes and by_first_letter == merged:
        automaton.facts.add("canonical")
        return automaton
    kept = [merged.index(column) for column in range(len(columns))]
    fin, inf = automaton.fin[:, order], automaton.inf[:, order]
    if automaton.acceptance == "transition":
        chosen = [by_first_letter[position] for position in kept]
        fin, inf = fin[:, :, chosen], inf[:, :, chosen]
    merged_class = np.empty(automaton.n_classes, dtype=np.int32)
    merged_class[by_first_letter] = merged
    names = automaton.state_names
    result = replace(
        automaton,
        delta=np.array(delta, dtype=np.int32)[:, kept],
        letter_class=merged_class[automaton.letter_class],
        fin=fin,
        inf=inf,
        initial_state=0,
        state_names=None if names is None else tuple(names[state] for state in order),
    ).keeping_languages(automaton, order)
    result.facts.add("canonical")
    return result
