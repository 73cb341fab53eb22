"""The nondeterministic automaton: transition-based generalized Buchi, edges labelled with sets of letters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ltlc.automata.acceptance import Clause
from ltlc.automata.emerson_lei import LetterEdge
from ltlc.automata.emptiness import accepting_nodes
from ltlc.errors import InvalidAutomatonError


@dataclass(frozen=True)
class BuchiAutomaton:
    """A run is accepted iff it takes edges of each acceptance set infinitely often; a word, iff one of its runs is.

    Attributes:
        n_letters: number of letters.
        initial: initial states.
        edges: outgoing edges per state; a letter without an edge ends the run.
        n_sets: number of acceptance sets; with none, every infinite run is accepted.

    Raises:
        InvalidAutomatonError: a state, letter or mark is out of range.
    """

    n_letters: int
    initial: tuple[int, ...]
    edges: tuple[tuple[LetterEdge, ...], ...]
    n_sets: int

    def __post_init__(self) -> None:
        n = len(self.edges)
        fits = all(0 <= q < n for q in self.initial) and all(
            0 <= edge.target < n and 0 <= edge.letters < 1 << self.n_letters and 0 <= edge.marks < 1 << self.n_sets
            for row in self.edges
            for edge in row
        )
        if not fits:
            raise InvalidAutomatonError("an initial state, a target, a letter or a mark is out of range")

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.edges)

    def successors(self, states: Iterable[int], letter: int) -> list[int]:
        """The states reached from some of these by one letter, in increasing order."""
        return sorted({e.target for q in states for e in self.edges[q] if e.letters >> letter & 1})

    def accepts(self, prefix: Sequence[int], cycle: Sequence[int]) -> bool:
        """Whether the word `prefix` followed by `cycle` for ever is accepted; `cycle` must not be empty."""
        states = list(self.initial)
        for letter in prefix:
            states = self.successors(states, letter)
        length = len(cycle)
        number = {(state, 0): i for i, state in enumerate(dict.fromkeys(states))}
        order = list(number)
        rows: list[list[tuple[int, int]]] = []
        for state, position in order:  # grows while it is read
            rows.append([])
            for letters, target, marks in self.edges[state]:
                if letters >> cycle[position] & 1:
                    node = (target, (position + 1) % length)
                    if node not in number:
                        number[node] = len(order)
                        order.append(node)
                    rows[-1].append((number[node], marks))
        return bool(accepting_nodes(rows, (Clause(0, (1 << self.n_sets) - 1),)))
