"""The canonical form of a Rabin automaton: the same bytes for the same construction on every run and system."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ltlc.automata.rabin import DRA, IntArray
from ltlc.budget import check_time

CANONICAL = "canonical"
"""the name of the form in `DRA.forms`."""


def canonical(automaton: DRA, entered: IntArray | None = None) -> DRA:
    """States numbered breadth-first from the initial state, letters in increasing order; unreachable ones dropped.

    Letter classes that no reachable state tells apart are merged, and numbered by their first letter. Propositions,
    pairs and their order stay. Two automata that differ in numbering alone get equal arrays.

    Args:
        automaton: any Rabin automaton.
        entered: shape (n_states,); the state with the same language that is entered in place of each state; by default
            itself.
    """
    if entered is None and CANONICAL in automaton.forms:
        return automaton
    by_first_letter: list[int] = np.argsort(automaton.alphabet.first_letter, kind="stable").tolist()
    table = automaton.delta if entered is None else entered[automaton.delta]
    rows: list[list[int]] = table[:, by_first_letter].tolist()
    order = [automaton.initial_state if entered is None else int(entered[automaton.initial_state])]
    number = {order[0]: 0}
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
    languages = automaton.languages if automaton.has_languages else None
    in_order = order == list(range(automaton.n_states))
    if in_order and len(columns) == automaton.n_classes and by_first_letter == merged and entered is None:
        return automaton.annotated(CANONICAL)
    kept = [merged.index(column) for column in range(len(columns))]
    fin, inf = automaton.fin[:, order], automaton.inf[:, order]
    if automaton.acceptance == "transition":
        chosen = [by_first_letter[position] for position in kept]
        fin, inf = fin[:, :, chosen], inf[:, :, chosen]
    merged_class = np.empty(automaton.n_classes, dtype=np.int32)
    merged_class[by_first_letter] = merged
    names = automaton.state_names
    return replace(
        automaton,
        delta=np.array(delta, dtype=np.int32)[:, kept],
        letter_class=merged_class[automaton.letter_class],
        fin=fin,
        inf=inf,
        initial_state=0,
        state_names=None if names is None else tuple(names[state] for state in order),
    ).annotated(CANONICAL, languages=None if languages is None else languages[order])


def tells_columns_apart(automaton: DRA) -> bool:
    """Whether no two letter classes do the same; a canonical automaton with other marks stays so exactly then."""
    tables = [automaton.delta] if automaton.acceptance == "state" else [automaton.delta, *automaton.fin, *automaton.inf]
    return len({column.tobytes() for column in np.concatenate(tables).T}) == automaton.n_classes
