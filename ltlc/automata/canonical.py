"""The canonical form of a Rabin automaton: the same bytes for the same construction on every run and system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ltlc.arrays import np
from ltlc.automata.partition import first_places
from ltlc.automata.rabin import DRA
from ltlc.automata.wide import told_apart
from ltlc.budget import check_time

CANONICAL = "canonical"
"""the name of the form in `DRA.forms`."""


def canonical(automaton: DRA, entered: Sequence[int] | None = None) -> DRA:
    """States numbered breadth-first from the initial state, letters in increasing order; unreachable ones dropped.

    Letter classes that no reachable state tells apart are merged, and numbered by their first letter. Propositions,
    pairs and their order stay. Two automata that differ in numbering alone get equal arrays.

    Args:
        automaton: any Rabin automaton.
        entered: the state with the same language that is entered in place of each state; by default itself.
    """
    if entered is None and CANONICAL in automaton.forms:
        return automaton
    by_first_letter = automaton.alphabet.by_first_letter
    rows = _rows(automaton, by_first_letter, entered)
    order = [automaton.initial_state if entered is None else entered[automaton.initial_state]]
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
    languages = [automaton.language_numbers[state] for state in order] if automaton.has_languages else None
    in_order = order == list(range(automaton.n_states))
    if in_order and len(columns) == automaton.n_classes and by_first_letter == merged and entered is None:
        return automaton.annotated(CANONICAL)
    kept = first_places(merged)
    names = automaton.state_names
    names = None if names is None else tuple(names[state] for state in order)
    if automaton.is_listed:
        return _listed(automaton, told_apart_by, order, kept, merged, names).annotated(CANONICAL, languages=languages)
    fin, inf = automaton.fin[:, order], automaton.inf[:, order]
    if automaton.acceptance == "transition":
        chosen = [by_first_letter[position] for position in kept]
        fin, inf = fin[:, :, chosen], inf[:, :, chosen]
    merged_class = np.empty(automaton.n_classes, dtype=np.int32)
    merged_class[by_first_letter] = merged
    return replace(
        automaton,
        delta=np.array(delta, dtype=np.int32)[:, kept],
        letter_class=merged_class[automaton.letter_class],
        fin=fin,
        inf=inf,
        initial_state=0,
        state_names=names,
    ).annotated(CANONICAL, languages=languages)


def _rows(automaton: DRA, by_first_letter: list[int], entered: Sequence[int] | None) -> list[list[int]]:
    """Next states, letter classes in this order."""
    if automaton.is_listed:
        if entered is None:
            return [[row[c] for c in by_first_letter] for row in automaton.rows]
        return [[entered[row[c]] for c in by_first_letter] for row in automaton.rows]
    table = automaton.delta if entered is None else np.array(entered, dtype=np.int32)[automaton.delta]
    rows: list[list[int]] = table[:, by_first_letter].tolist()
    return rows


def _listed(
    automaton: DRA,
    table: list[list[int]],
    order: list[int],
    kept: list[int],
    merged: list[int],
    names: tuple[str, ...] | None,
) -> DRA:
    """The result for a listed automaton: a table of next states and of marks, of which these columns are kept."""
    chosen = [[row[c] for c in kept] for row in table]
    class_of = dict(zip(automaton.alphabet.by_first_letter, merged, strict=True))
    classes = automaton.alphabet.classes
    on_states = automaton.acceptance == "state"
    return DRA.from_lists(
        automaton.aps,
        chosen[: len(order)],
        [automaton.mark_lists[state] for state in order] if on_states else chosen[len(order) :],
        [class_of[c] for c in classes]
        if isinstance(classes, list)
        else np.array([class_of[c] for c in range(len(class_of))], dtype=np.int32)[classes],
        automaton.n_pairs,
        acceptance=automaton.acceptance,
        formula=automaton.formula,
        state_names=names,
        translator=automaton.translator,
        possible=automaton.possible,
    )


def tells_columns_apart(automaton: DRA) -> bool:
    """Whether no two letter classes do the same; a canonical automaton with other marks stays so exactly then."""
    if automaton.is_listed:
        lists = automaton.rows if automaton.acceptance == "state" else automaton.rows + automaton.mark_lists
        return len(set(zip(*lists, strict=True))) == automaton.n_classes
    tables = [automaton.delta] if automaton.acceptance == "state" else [automaton.delta, *automaton.fin, *automaton.inf]
    if automaton.entries is not None:
        rows = (row for table in tables for row in table)
        return int(told_apart(rows, automaton.n_classes).max()) + 1 == automaton.n_classes
    return len({column.tobytes() for column in np.concatenate(tables).T}) == automaton.n_classes
