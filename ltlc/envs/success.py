"""Success of an episode: whether its word, continued by its last letter for ever, satisfies the formula."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.automata import DRA

BoolArray = npt.NDArray[np.bool_]


class Success:
    """Follows the words of episodes with the automaton itself, in which a deadlock is final.

    Letters are single ones, or arrays of shape (n,) for n episodes at once.

    Args:
        automaton: of the formula.
        skip: whether the first letter of an episode is left out of its word.

    Attributes:
        state: of the automaton, after the last letter; of each episode where there are many.
    """

    def __init__(self, automaton: DRA, skip: bool) -> None:
        self.state: Any = automaton.initial_state
        self._initial, self._skip = automaton.initial_state, skip
        self._classes, self._next = automaton.letter_class, automaton.delta
        self._holds = accepted_forever(automaton)

    def read(self, letters: Any, begun: Any = False) -> Any:
        """Read a letter, the first one where an episode has begun.

        Returns:
            whether the word so far satisfies the formula if the letter is repeated for ever.
        """
        classes = self._classes[letters]
        before = np.where(begun, self._initial, self.state)
        after = self._next[before, classes]
        self.state = np.where(begun, self._initial, after) if self._skip else after
        return self._holds[self.state, classes]


def accepted_forever(automaton: DRA) -> BoolArray:
    """From which states the word is accepted that repeats one letter class, shape (n_states, n_classes).

    Each entry follows a lasso; paths of length 2^k are made of two halves, until they are longer than any cycle.
    """
    target, fin, inf = automaton.delta.astype(np.int64), automaton.edge_fin, automaton.edge_inf
    same_class = np.arange(automaton.n_classes)
    for _ in range(automaton.n_states.bit_length()):
        fin, inf = fin | fin[:, target, same_class], inf | inf[:, target, same_class]
        target = target[target, same_class]
    # every target is on its cycle now, and the marks on the way from there are those of the whole cycle
    return np.asarray((inf & ~fin)[:, target, same_class].any(axis=0))
