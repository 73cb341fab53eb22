"""The automata of the thesis' case studies, as its tool chain (ltl2ba, ltl2dstar) built them.

Rewards of the thesis depend on the automaton, so its experiments are reproduced with these. What was recorded are the
states, the acceptance sets, and the transitions on letters of at most one proposition; no cell of the thesis' maps has
more. The transitions on larger letters are filled in here so that each automaton accepts exactly the words of its
formula, which a test proves; they need not be those of the original.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ltlc.automata import DRA
from ltlc.errors import UnknownNameError


class _Record(NamedTuple):
    formula: str
    initial_state: int
    fin: tuple[int, ...]
    inf: tuple[int, ...]
    rows: str
    """per state its successors on {}, A, B, AB, T, AT, BT, ABT; a row with one entry goes there on every letter."""
    sink: int | None = None
    """where every letter with C leads."""


_PHI_1 = """
0
1 2 1 3 1 2 1 3
2 2 3 3 2 2 3 3
3 3 3 3 4 4 4 4
3 3 3 3 5 5 5 5
3 3 3 3 5 5 5 5
"""
_PHI_2 = """
13  1 13  0 13  1 13  0
14 14 13  0 14 14 13  0
 2
 4  5  4  8  4  5  4 10
 4  7  4  8  4  7  4 10
 5  7  6  8  5  7  9 10
 6  8  6  8  9 10  9 10
 7  7  8  8  7  7 10 10
 8  8  8  8 10 10 10 10
 9 11  9 12  9 11  9 12
10 11 10 12 10 11 10 12
11 11 12 12 11 11 12 12
15 14 15  0 15 14 15  0
13  1 13  0 13  1 13  0
14 14 13  0 14 14 13  0
15 14 15  0 15 14 15  0
"""
_PHI_3 = """
0
1 1 1 1 0 0 0 0
2 2 1 1 2 2 0 0
3 2 3 1 3 2 3 0
"""
_PHI_4 = """
12  1 12  0 12  1 12  0
13 13 12  0 13 13 12  0
 3  4  3  7  3  4  3  9
 3  6  3  7  3  6  3  9
 4  6  5  7  4  6  8  9
 5  7  5  7  8  9  8  9
 6  6  7  7  6  6  9  9
 7  7  7  7  9  9  9  9
 8 10  8 11  8 10  8 11
 9 10  9 11  9 10  9 11
10 10 11 11 10 10 11 11
14 13 14  0 14 13 14  0
12  1 12  0 12  1 12  0
13 13 12  0 13 13 12  0
14 13 14  0 14 13 14  0
"""
_RECORDS = {
    "phi_1": _Record("F(A & F B) & G !C & F G T", 1, (0, 1, 2, 3, 4), (5,), _PHI_1, sink=0),
    "phi_2": _Record("F(A & F(B & F T)) & G F A & G F B & G !C", 3, tuple(range(2, 13)), (0, 1), _PHI_2, sink=2),
    "phi_3": _Record("F(A & F(B & F T))", 3, (), (0,), _PHI_3),
    "phi_4": _Record("F(A & F(B & F T)) & G F A & G F B", 2, tuple(range(2, 12)), (0, 1), _PHI_4),
}
RECORDED: tuple[str, ...] = tuple(_RECORDS)
"""names that `recorded_automaton` knows."""


def recorded_automaton(name: str) -> DRA:
    """One of the automata of the thesis: phi_1 (6 states), phi_2 (16), phi_3 (4), phi_4 (15).

    States are numbered as in the thesis; phi_4 is phi_2 without its sink, numbers above closed up.

    Raises:
        UnknownNameError: there is no such automaton.

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, chapter 5;
        J. Klein, C. Baier, Experiments with deterministic omega-automata for formulas of linear temporal logic,
        Theoretical Computer Science 2006, doi 10.1016/j.tcs.2006.07.022 (ltl2dstar).
    """
    if name not in _RECORDS:
        raise UnknownNameError("recorded automaton", name, RECORDED)
    record = _RECORDS[name]
    rows = [[int(entry) for entry in line.split()] for line in record.rows.strip().splitlines()]
    delta = np.array([row * 8 if len(row) == 1 else row for row in rows], dtype=np.int32)
    aps: tuple[str, ...] = ("A", "B", "T")
    if record.sink is not None:
        aps = (*aps, "C")
        delta = np.hstack([delta, np.full_like(delta, record.sink)])
    letter_class, columns = _classes(delta)
    states = np.arange(len(delta))
    return DRA(
        aps=aps,
        delta=delta[:, columns],
        letter_class=letter_class,
        fin=np.isin(states, record.fin)[None],
        inf=np.isin(states, record.inf)[None],
        initial_state=record.initial_state,
        formula=record.formula,
    )


def _classes(delta: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Class of each letter, numbered in order of letters, and the first letter of each class."""
    first: dict[bytes, int] = {}
    columns: list[int] = []
    letter_class = np.empty(delta.shape[1], dtype=np.int32)
    for letter, column in enumerate(delta.T):
        key = column.tobytes()
        if key not in first:
            first[key] = len(columns)
            columns.append(letter)
        letter_class[letter] = first[key]
    return letter_class, columns
