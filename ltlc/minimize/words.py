"""Lasso words that tell a state from another, and runs over them in which a state is entered in place of another."""

from __future__ import annotations

from ltlc.automata.acceptance import rabin_accepts, recurring_marks
from ltlc.automata.rabin import DRA

Words = list[tuple[list[int], list[int]]]
"""Lasso words: the numbers of the letters of a prefix and of a cycle."""


class Word:
    """A lasso word that some redirection got wrong.

    Attributes:
        letters: of the prefix, and of the cycle.
        accepted: whether it is, from each state of the reference that was asked for.
        classes: of these letters, in the automaton.
        entered: the states of the automaton that a run over the word enters, from each state asked for, as a bit mask.
    """

    def __init__(self, letters: tuple[list[int], list[int]]) -> None:
        self.letters = letters
        self.accepted: dict[int, bool] = {}
        self.classes: tuple[list[int], list[int]] = ([], [])
        self.entered: dict[int, int] = {}


def entered_states(automaton: DRA, start: int, word: tuple[list[int], list[int]]) -> int:
    """The states that the run over a lasso word of letter classes enters, as a bit mask."""
    prefix, cycle = word
    state, entered, seen = start, 0, 0
    for c in prefix:
        state = automaton.rows[state][c]
        entered |= 1 << state
    while not seen >> state & 1:
        seen |= 1 << state
        for c in cycle:
            state = automaton.rows[state][c]
            entered |= 1 << state
    return entered


def accepts(
    automaton: DRA, start: int, word: tuple[list[int], list[int]], old: int = -1, entered: int | None = None
) -> bool:
    """Whether a lasso word of letter classes is accepted from a state when it is entered in place of `old`, too.

    Args:
        automaton: the automaton.
        start: the state.
        word: prefix and cycle.
        old: by default no state.
        entered: the marks on entering the state, where acceptance is on states.
    """
    rows, marks = automaton.rows, automaton.edge_marks

    def run(state: int, classes: list[int]) -> tuple[int, int]:
        seen = 0
        for c in classes:
            target = rows[state][c]
            if target != old:
                seen |= marks[state][c]
                state = target
            else:
                seen |= marks[state][c] if entered is None else entered
                state = start
        return state, seen

    state, _ = run(start, word[0])
    return rabin_accepts(automaton.n_pairs, recurring_marks(state, lambda state: run(state, word[1])))
