"""The edges of an automaton as every writer wants them, and the tables a reader builds from guarded edges.

A set of letters is an int: bit k is set iff letter k is in the set. Conjunction, disjunction and the two checks of a
reader (do guards overlap, do they cover every letter) are then single operations, also with 21 propositions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import NamedTuple

from ltlc.arrays import BoolArray, IntArray, np, npt
from ltlc.automata.columns import letter_classes, truth_column
from ltlc.automata.finite import DFA
from ltlc.automata.possible import LetterNumbers
from ltlc.automata.rabin import DRA
from ltlc.automata.wide import has_codes
from ltlc.budget import check_time
from ltlc.errors import AlphabetLimitExceeded
from ltlc.formats.wide_edges import CodedEdge, Names, wide_edges
from ltlc.graph import bits
from ltlc.ltl.formula import And, Constant, Formula, Iff, Implies, Not, Or, Proposition, Xor
from ltlc.ltl.traversal import postorder

MAX_TABLE = 1 << 27
"""Entries of the largest transition table a reader builds."""

_COLUMNS_AT_ONCE = 32
_WIDE, _LARGE = 24, 320
"""With so many letter classes and entries a table is looked at by arrays."""


class LabelledEdge(NamedTuple):
    """All letters that lead from one state to another with the same marks."""

    source: int
    target: int
    guard: str
    fin: tuple[int, ...]
    """pairs whose fin contains the edge; empty where acceptance is on states."""
    inf: tuple[int, ...]


def edges(automaton: DRA | DFA, names: Names | None = None) -> list[LabelledEdge]:
    """Parallel transitions merged, ordered by source, then by the smallest letter.

    The order does not depend on how the letter classes are numbered, so that reading and writing gives the same text.

    Args:
        automaton: the automaton.
        names: what guards consist of; None: LTL syntax, as in `guard_text`.
    """
    table = automaton.table if isinstance(automaton, DFA) else automaton
    names = Names(table.alphabet.names) if names is None else names
    n_pairs = table.n_pairs if table.acceptance == "transition" else 0
    is_wide = table.n_classes >= _WIDE and table.n_states * table.n_classes >= _LARGE
    if is_wide and has_codes(table.n_states, n_pairs):
        found = wide_edges(table.alphabet, table.delta, table.fin[:n_pairs], table.inf[:n_pairs], names)
    else:
        found = _few_edges(table, names)
    pairs: dict[int, tuple[tuple[int, ...], tuple[int, ...]]] = {}
    result: list[LabelledEdge] = []
    for source, target, mark, guard in found:
        if mark not in pairs:
            pairs[mark] = _pairs_with(mark, 0), _pairs_with(mark, 1)
        result.append(LabelledEdge(source, target, guard, *pairs[mark]))
    return result


def _few_edges(automaton: DRA, names: Names) -> Iterator[CodedEdge]:
    """The edges of an automaton with few letter classes, which are looked at one by one."""
    guards: dict[tuple[int, ...], str] = {}
    order = automaton.alphabet.by_first_letter
    no_marks = [0] * automaton.n_classes
    for source, targets in enumerate(automaton.rows):
        check_time()
        marks = automaton.edge_marks[source] if automaton.acceptance == "transition" else no_marks
        groups: dict[tuple[int, int], list[int]] = {}
        for c in order:
            groups.setdefault((targets[c], marks[c]), []).append(c)
        for (target, mark), group in groups.items():
            classes = tuple(group)
            if classes not in guards:
                guards[classes] = automaton.alphabet.guard(classes).text(*names)
            yield source, target, mark, guards[classes]


def state_marks(automaton: DRA | DFA, state: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The pairs whose fin, and those whose inf, contain the state; empty where acceptance is on transitions."""
    if automaton.acceptance == "transition":
        return (), ()
    if isinstance(automaton, DRA) and automaton.is_listed:
        marks: int = automaton.mark_lists[state]
        return _pairs_with(marks, 0), _pairs_with(marks, 1)
    return _indices(automaton.fin[:, state]), _indices(automaton.inf[:, state])


def hidden_states(automaton: DRA | DFA, hide_deadlock: bool) -> set[int]:
    """The deadlock states, if they are not to be drawn; an initial state always is."""
    return set(automaton.deadlocks) - {automaton.initial_state} if hide_deadlock else set()


def arrows(automaton: DRA | DFA, hidden: Collection[int]) -> dict[tuple[int, int], list[LabelledEdge]]:
    """The edges of a drawing by source and target: one arrow each, as parallel ones would hide each other."""
    result: dict[tuple[int, int], list[LabelledEdge]] = {}
    for edge in edges(automaton):
        if edge.source not in hidden and edge.target not in hidden:
            result.setdefault((edge.source, edge.target), []).append(edge)
    return result


def _pairs_with(marks: int, place: int) -> tuple[int, ...]:
    """The pairs with Fin (place 0) or Inf (place 1) among marks as in `DRA.marks`."""
    return tuple(m // 2 for m in bits(marks) if m % 2 == place)


def _indices(column: BoolArray) -> tuple[int, ...]:
    return tuple(np.flatnonzero(column).tolist())


def letters_of(guard: Formula, atom: Callable[[str], int], universe: int) -> int:
    """The set of letters that satisfy a Boolean formula; `atom` gives the letters of a proposition by its name.

    Args:
        guard: the formula.
        atom: see above.
        universe: the set of all letters.

    Raises:
        ValueError: the formula has a temporal operator; the argument is its symbol.
    """
    value: dict[Formula, int] = {}
    for node in postorder(guard):
        check_time()
        args = [value[child] for child in node.args]
        match node:
            case Constant():
                value[node] = universe if node.value else 0
            case Proposition():
                value[node] = atom(node.name)
            case Not():
                value[node] = universe ^ args[0]
            case And() | Or():
                total = args[0]
                for letters in args[1:]:
                    total = total & letters if isinstance(node, And) else total | letters
                value[node] = total
            case Implies():
                value[node] = (universe ^ args[0]) | args[1]
            case Xor():
                value[node] = args[0] ^ args[1]
            case Iff():
                value[node] = universe ^ args[0] ^ args[1]
            case _:
                raise ValueError(getattr(node, "symbol", type(node).__name__))
    return value[guard]


def a_letter_of(letters: int, numbers: LetterNumbers) -> str:
    """The smallest letter of a non-empty set, in words for a message."""
    mask = numbers.mask((letters & -letters).bit_length() - 1)
    return " & ".join(f"{'' if mask >> i & 1 else '!'}{name}" for i, name in enumerate(numbers.aps)) or "true"


def tabulate(n_letters: int, n_states: int, sources: Sequence[int], guards: Sequence[int]) -> tuple[IntArray, IntArray]:
    """The coarsest letter classes that the guards tell apart, and which edge each state takes on each class.

    Args:
        n_letters: number of letters.
        n_states: number of states.
        sources: source state of each edge.
        guards: set of letters of each edge; those of one state are disjoint.

    Returns:
        `letter_class`, shape (n_letters,), classes numbered by their smallest letter; and the index of the edge
        taken, shape (n_states, n_classes), -1 where a state has none.

    Raises:
        AlphabetLimitExceeded: the table would not fit into memory.
    """
    letter_class, classes = guard_classes(n_letters, n_states, guards)
    taken = {guard: np.flatnonzero(column) for guard, column in classes.items()}
    table = np.full((n_states, int(letter_class.max()) + 1), -1, dtype=np.int32)
    for edge, (source, guard) in enumerate(zip(sources, guards, strict=True)):
        if not edge & 255:
            check_time()
        table[source, taken[guard]] = edge
    return letter_class, table


def guard_classes(n_letters: int, n_states: int, guards: Iterable[int]) -> tuple[IntArray, dict[int, BoolArray]]:
    """Group the letters as `tabulate` does, and find the classes of each guard, shape (n_classes,).

    Raises:
        AlphabetLimitExceeded: a table over states and classes would not fit into memory.
    """
    distinct = list(dict.fromkeys(guards))
    letter_class, smallest = letter_classes(_columns(distinct, n_letters), n_letters)
    if smallest.size * n_states > MAX_TABLE:
        raise AlphabetLimitExceeded(
            f"{n_states} states times {smallest.size} letter classes: the transition table would have more than "
            f"{MAX_TABLE} entries. Use fewer propositions."
        )
    return letter_class, {guard: truth_column(guard, n_letters)[smallest] for guard in distinct}


def _columns(guards: Sequence[int], n_letters: int) -> Iterator[npt.NDArray[np.int64]]:
    """The guards as columns over the letters, many in one column as the bits of an integer: that saves sorting."""
    for start in range(0, len(guards), _COLUMNS_AT_ONCE):
        column = np.zeros(n_letters, dtype=np.int64)
        for guard in guards[start : start + _COLUMNS_AT_ONCE]:
            column = 2 * column + truth_column(guard, n_letters)
        yield column
