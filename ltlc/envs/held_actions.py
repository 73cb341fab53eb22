"""Actions that are held for some steps, while learning and by what was learned."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ltlc.errors import InvalidArgumentError

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


class HeldActions:
    """The action of each copy of an environment, held for some steps, which are counted from the episode's beginning.

    Args:
        repeat: steps, >= 1.
        n_actions: of the environment; an action may also choose a pair, which is chosen once.

    Raises:
        InvalidArgumentError: `repeat` is below 1.

    Example:
        >>> held, ended = HeldActions(2, 4), np.array([False])
        >>> actions = []
        >>> for wanted in (3, 1, 2, 0):
        ...     actions += held.keep(np.array([wanted]), held.deciding(1)).tolist()
        ...     held.advance(np.arange(1), ended)
        >>> actions
        [3, 3, 2, 2]
    """

    def __init__(self, repeat: int, n_actions: int) -> None:
        if repeat < 1:
            raise InvalidArgumentError(f"repeat is {repeat}; an action is held for at least 1 step")
        self.repeat, self.n_actions = repeat, n_actions
        self._action = self._age = np.zeros(0, dtype=np.int64)

    def clear(self) -> None:
        """Begin everywhere anew, as episodes do."""
        self._age = np.zeros(0, dtype=np.int64)

    def deciding(self, n: int) -> BoolArray:
        """Where an action is to be chosen, of n copies, shape (n,); all begin anew if there were others before."""
        if len(self._age) != n:
            self._action, self._age = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
        return np.asarray(self._age % self.repeat == 0)

    def keep(self, chosen: npt.ArrayLike, deciding: BoolArray) -> IntArray:
        """The actions chosen where there was a choice, which are held from now on, and elsewhere those held."""
        chosen = np.asarray(chosen, dtype=np.int64)
        self._action = np.where(deciding, chosen % self.n_actions, self._action)
        return np.where(deciding, chosen, self._action)

    def advance(self, copies: IntArray, ended: BoolArray) -> None:
        """Take note that these copies made a step, and whether their episodes are over."""
        if len(self._age):
            self._age[copies] = np.where(ended, 0, self._age[copies] + 1)
