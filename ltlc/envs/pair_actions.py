"""Actions that also choose the Rabin pair to satisfy, and masks that say which actions there are."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


class PairActionSpace:
    """The actions of a wrapped environment whose task has choices (`RewardTables.select_pair`).

    Of an environment with n actions, action a + n * (1 + i) chooses pair i and then does a; action a only does a.

    Args:
        tables: of the task.
        space: the actions of the environment.

    Attributes:
        space: all actions; that of the environment where there are no choices.
        mask: shape (n_table_states, n_all_actions), which of them there are in each state; None if the actions of the
            environment cannot be counted, and then there are no choices.

    Raises:
        InvalidArgumentError: there are choices, and the actions of the environment are not discrete from 0.
    """

    def __init__(self, tables: RewardTables, space: spaces.Space[object]) -> None:
        self.space = space
        self.n_base = int(space.n) if isinstance(space, spaces.Discrete) else 0
        self.mask: BoolArray | None = None
        self.active = tables.n_choices > 0
        if self.active and (not self.n_base or space.start != 0):  # type: ignore[attr-defined]
            raise InvalidArgumentError(
                f"the task has a choice between Rabin pairs, which becomes part of a discrete action, and the actions "
                f'here are {space}; use the reward scheme "parity", which needs no choices'
            )
        if self.active:
            self.space = spaces.Discrete(self.n_base * (1 + tables.n_choices))
        if self.n_base:
            stay = np.ones((tables.n_states, 1), dtype=np.bool_)
            self.mask = np.repeat(np.hstack((stay, tables.select_pair >= 0)), self.n_base, axis=1)
        self._then = np.hstack((np.arange(tables.n_states)[:, None], tables.select_pair)).astype(np.int64)

    def split(self, action: int, state: int) -> tuple[int, int]:
        """What the environment does, and the table state in which it is done.

        Raises:
            InvalidArgumentError: the pair cannot be chosen in this state.
        """
        choice, base = divmod(int(action), self.n_base)
        if not (0 <= choice < self._then.shape[1] and self._then[state, choice] >= 0):
            raise InvalidArgumentError(
                f"action {action} does not exist in automaton state {state}; action_masks() says which actions do"
            )
        return base, int(self._then[state, choice])

    def split_all(self, actions: npt.ArrayLike, states: IntArray, where: BoolArray) -> tuple[IntArray, IntArray]:
        """`split` for a batch; elsewhere than `where` actions do not count, and no pair is chosen.

        Raises:
            InvalidArgumentError: a pair cannot be chosen in its state.
        """
        choice, base = np.divmod(np.asarray(actions, dtype=np.int64), self.n_base)
        choice = np.where(where, choice, 0)
        then = self._then[states, np.clip(choice, 0, self._then.shape[1] - 1)]
        wrong = (then < 0) | (choice < 0) | (choice >= self._then.shape[1])
        if wrong.any():
            i = int(np.flatnonzero(wrong)[0])
            raise InvalidArgumentError(
                f"action {np.asarray(actions)[i]} of sub-environment {i} does not exist in automaton state {states[i]}"
                "; action_masks() says which actions do"
            )
        return base, then
