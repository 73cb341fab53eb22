"""Exact decisions on languages: emptiness, inclusion, equivalence, and a word as evidence.

All work on the product of the two automata, over the letters that are possible in both. L(a) is not inside L(b) iff the
product has a reachable cycle that some pair of a accepts and no pair of b: one Rabin pair together with a Streett
condition, for each pair of a.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ltlc.arrays import IntArray, np, npt
from ltlc.automata.acceptance import exactly_one, only_first
from ltlc.automata.emptiness import MarkedEdge, MarkedGraph, accepting_walk
from ltlc.automata.joint import joint_letters
from ltlc.automata.possible import LetterNumbers
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time
from ltlc.ltl.semantics import LassoWord

_ROWS_AT_ONCE = 1 << 16
_SMALL_PRODUCT = 50_000
"""product edges up to which plain lists are faster than arrays."""


class _Product(NamedTuple):
    """The reachable product of two automata; node 0 is initial."""

    edges: MarkedGraph
    """marks of the first automaton, and those of the second shifted by twice the pairs of the first."""
    delta: Sequence[Sequence[int]]
    """by node and letter: the next node."""
    marks: Sequence[Sequence[int]]
    """like `delta`; entry = marks of the edge."""
    numbers: LetterNumbers
    """of the joint alphabet."""
    letters: IntArray
    """shape (n_letters,); the number of one letter for each joint letter class."""

    def letters_along(self, edges: Sequence[MarkedEdge]) -> list[int]:
        """Letters that lead along these edges."""
        columns = (
            next(c for c in range(len(self.letters)) if self.delta[q][c] == target and self.marks[q][c] == marks)
            for q, target, marks in edges
        )
        return [int(self.letters[c]) for c in columns]


def is_empty(a: DRA) -> bool:
    """Whether no word is accepted."""
    return a.initial_state in a.annotations.deadlocks


def included(a: DRA, b: DRA) -> bool:
    """Whether every word that a accepts is accepted by b; a proposition that only one of them knows is free."""
    return accepting_walk(_product(a, b).edges, only_first(a.n_pairs, b.n_pairs), 0) is None


def equivalent(a: DRA, b: DRA) -> bool:
    """Whether the automata accept the same words; a proposition that only one of them knows is free."""
    return accepting_walk(_product(a, b).edges, exactly_one(a.n_pairs, b.n_pairs), 0) is None


def counterexample(a: DRA, b: DRA) -> LassoWord | None:
    """A word that exactly one of the automata accepts, or None if they are equivalent."""
    found = distinguishing_letters(a, b)
    if found is None:
        return None
    numbers, *letters = found
    prefix, cycle = [tuple(numbers.names(numbers.mask(letter)) for letter in part) for part in letters]
    return LassoWord(prefix, cycle)


def distinguishing_letters(a: DRA, b: DRA) -> tuple[LetterNumbers, list[int], list[int]] | None:
    """`counterexample` as the numbers of its letters, and what they are numbers of.

    The propositions are those of the automata, in the order of a and then b; some that do not matter may be missing.
    """
    product = _product(a, b)
    walk = accepting_walk(product.edges, exactly_one(a.n_pairs, b.n_pairs), 0)
    return walk and (product.numbers, product.letters_along(walk[0]), product.letters_along(walk[1]))


def _product(a: DRA, b: DRA) -> _Product:
    """The reachable pairs of states, and what is seen on the way from one to the next."""
    numbers, letters, class_a, class_b = joint_letters(a.alphabet, b.alphabet)
    if a.n_states * b.n_states * len(letters) <= _SMALL_PRODUCT:
        codes, delta = _explored(a, b, class_a.tolist(), class_b.tolist())
    else:
        codes, delta = _explored_in_layers(a, b, class_a, class_b)
    shift = 2 * a.n_pairs
    marks_a = [[row[c] for c in class_a.tolist()] for row in a.edge_marks]
    marks_b = [[row[c] << shift for c in class_b.tolist()] for row in b.edge_marks]
    marks = [
        [m | n for m, n in zip(marks_a[code // b.n_states], marks_b[code % b.n_states], strict=True)] for code in codes
    ]
    edges = [sorted(set(zip(targets, row, strict=True))) for targets, row in zip(delta, marks, strict=True)]
    return _Product(edges, delta, marks, numbers, letters)


def _explored(a: DRA, b: DRA, class_a: list[int], class_b: list[int]) -> tuple[list[int], list[list[int]]]:
    """State a * n_b + b of each product state, and the number of its successor for each letter; breadth-first."""
    n = b.n_states
    rows_a = [[row[c] * n for c in class_a] for row in a.rows]
    rows_b = [[row[c] for c in class_b] for row in b.rows]
    codes = [a.initial_state * n + b.initial_state]
    number = {codes[0]: 0}
    delta: list[list[int]] = []
    for code in codes:  # grows while it is read
        if not len(delta) & 255:
            check_time()
        row = [p + q for p, q in zip(rows_a[code // n], rows_b[code % n], strict=True)]
        for target in row:
            if target not in number:
                number[target] = len(codes)
                codes.append(target)
        delta.append([number[target] for target in row])
    return codes, delta


def _explored_in_layers(a: DRA, b: DRA, class_a: IntArray, class_b: IntArray) -> tuple[list[int], list[list[int]]]:
    """Like `_explored`, with whole layers of states at once in numpy."""
    delta_a, delta_b = a.delta[:, class_a].astype(np.int64), b.delta[:, class_b].astype(np.int64)
    layers = [np.array([a.initial_state * b.n_states + b.initial_state], dtype=np.int64)]
    seen = layers[0]
    successors: list[npt.NDArray[np.int64]] = []
    while len(layers[-1]):
        found = []
        for first in range(0, len(layers[-1]), _ROWS_AT_ONCE):
            check_time()
            state_a, state_b = np.divmod(layers[-1][first : first + _ROWS_AT_ONCE], b.n_states)
            successors.append(delta_a[state_a] * b.n_states + delta_b[state_b])
            found.append(np.setdiff1d(successors[-1], seen))
        layers.append(np.unique(np.concatenate(found)))
        check_time()
        seen = np.union1d(seen, layers[-1])
    codes = np.concatenate(layers)
    order = np.argsort(codes)
    delta = order[np.searchsorted(codes, np.concatenate(successors), sorter=order)]
    return codes.tolist(), delta.tolist()
