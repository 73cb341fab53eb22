"""What a translation may spend."""

from __future__ import annotations

import time

from ltlc.errors import StateLimitExceeded, TimeLimitExceeded

_MOVES_PER_STATE = 20_000
"""a state with more moves counts as too many states."""


class Budget:
    """Limits on states and seconds, checked inside every loop that can grow.

    Args:
        formula: as text, for the message.
        max_states: of any intermediate or final automaton.
        timeout: seconds from now, or None for no limit.
    """

    def __init__(self, formula: str, max_states: int, timeout: float | None) -> None:
        self.formula = formula
        self.max_states = max_states
        self.timeout = timeout
        self._deadline = None if timeout is None else time.monotonic() + timeout

    def within(self, max_states: int) -> Budget:
        """The same budget, with this limit on states if it is lower."""
        narrowed = Budget(self.formula, min(self.max_states, max_states), self.timeout)
        narrowed._deadline = self._deadline
        return narrowed

    @property
    def remaining(self) -> float | None:
        """Seconds left, at least 0, or None for no limit."""
        return None if self._deadline is None else max(0.0, self._deadline - time.monotonic())

    def has_time(self) -> bool:
        """Whether the time is not over."""
        return self._deadline is None or time.monotonic() <= self._deadline

    def check_size(self, n_states: int) -> None:
        """Raise StateLimitExceeded if `n_states` is too many; and `check_time`."""
        self.check_states(n_states)
        self.check_time()

    def check_states(self, n_states: int) -> None:
        """Raise StateLimitExceeded if `n_states` is too many."""
        if n_states > self.max_states:
            raise StateLimitExceeded(
                f"{self.name} needs more than {self.max_states} states: raise the limit (--max-states, max_states=)"
                " or split the formula"
            )

    def check_moves(self, n_moves: int) -> None:
        """Raise StateLimitExceeded if one state has so many moves that the limit on states would not help."""
        if n_moves > _MOVES_PER_STATE:
            self.check_size(n_moves // _MOVES_PER_STATE + self.max_states)

    def check_time(self) -> None:
        """Raise TimeLimitExceeded if the time is over."""
        if not self.has_time():
            raise TimeLimitExceeded(
                f"{self.name} is not translated after {self.timeout:g} s: raise the limit (--timeout, timeout=)"
            )

    @property
    def name(self) -> str:
        """The formula, cut to a readable length."""
        return self.formula if len(self.formula) <= 80 else self.formula[:77] + "..."
