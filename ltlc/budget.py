"""What a call may spend: states, and seconds from when it began.

The time belongs to a call and to all that is called on the way, as the precision belongs to a computation in `decimal`.
So it is a context variable and not an argument of every function: `time_limit` sets it, the end of its block takes it
back, other threads do not see it, and each loop that can grow asks `check_time`.
"""

from __future__ import annotations

import math
import sys
import time
from contextvars import ContextVar
from enum import IntEnum

from ltlc.errors import StateLimitExceeded, TimeLimitExceeded

MAX_STATES = 100_000
"""of an automaton, where no other limit is given."""
MAX_ENTRIES = 1 << 26
"""a table with more entries, over all states and letter classes, counts as too many states."""
_MOVES_PER_STATE = 20_000
"""and so does a state with more moves, and an automaton with more letters in the moves of all states:"""
_MAX_BITS = 1 << 32
_OVERTIME = (0.015, 0.12)
"""What each stage of overtime has, as a share of the limit, and in addition, in seconds."""


class Overtime(IntEnum):
    """What may go on for a little while after the deadline, each until a later moment than the one before."""

    REDUCE = 1
    """a result is made smaller, which it can do without;"""
    SPLIT = 2
    """its states are split, which it cannot do without;"""
    REDUCE_AGAIN = 3
    """it is made smaller again,"""
    WRITE = 4
    """and written."""


class TimeLimit:
    """The time that a call has; in force in the block of a `with` statement.

    Attributes:
        name: what is done, for the message.
        timeout: seconds, infinite for no limit.
        deadline: as of `time.monotonic`.
        until: the same, or later in overtime.
    """

    __slots__ = ("_before", "deadline", "name", "timeout", "until")

    def __init__(self, name: str, timeout: float, deadline: float, until: float) -> None:
        self.name = name
        self.timeout = timeout
        self.deadline = deadline
        self.until = until

    def __enter__(self) -> TimeLimit:
        self._before = _IN_FORCE.set(self)
        return self

    def __exit__(self, *_: object) -> None:
        _IN_FORCE.reset(self._before)

    @property
    def remaining(self) -> float | None:
        """Seconds left until the deadline, at least 0; None for no limit."""
        return None if self.deadline == math.inf else max(0.0, self.deadline - time.monotonic())

    def exceeded(self) -> TimeLimitExceeded:
        """The error that says so."""
        return TimeLimitExceeded(f"{_cut(self.name)} is not done after {self.timeout:g} s: raise the limit (timeout)")


_IN_FORCE: ContextVar[TimeLimit | None] = ContextVar("time limit in force", default=None)


def time_limit(name: str, timeout: float | None, spent: float = 0.0) -> TimeLimit:
    """Limit the time of a block to some seconds from now, unless a block around it ends earlier.

    Args:
        name: what is done in the block, e.g. the text of a formula.
        timeout: seconds, or None for no limit.
        spent: seconds of these that are over already.
    """
    seconds = math.inf if timeout is None else float(timeout)
    deadline = time.monotonic() + seconds - spent
    around = _IN_FORCE.get()
    if around is not None and around.until <= deadline:
        return TimeLimit(around.name, around.timeout, around.deadline, around.until)
    return TimeLimit(name, seconds, deadline, deadline)


def overtime(stage: Overtime) -> TimeLimit:
    """Let a block go on after the deadline: so that what was found by then is not lost."""
    limit = _IN_FORCE.get()
    if limit is None:
        return time_limit("", None)
    share, least = _OVERTIME
    return TimeLimit(
        limit.name, limit.timeout, limit.deadline, limit.deadline + stage * (share * limit.timeout + least)
    )


def time_left() -> float | None:
    """Seconds that the call may still take, or None for no limit."""
    limit = _IN_FORCE.get()
    return None if limit is None or limit.until == math.inf else max(0.0, limit.until - time.monotonic())


def has_time() -> bool:
    """Whether the time of the call is not over."""
    limit = _IN_FORCE.get()
    return limit is None or time.monotonic() <= limit.until


def check_time() -> None:
    """Raise TimeLimitExceeded if the time of the call is over."""
    limit = _IN_FORCE.get()
    if limit is not None and time.monotonic() > limit.until:
        raise limit.exceeded()


class Budget:
    """A limit on states, checked inside every loop that can make more of them.

    Args:
        name: what is built, e.g. the text of a formula, for the message.
        max_states: of any intermediate or final automaton.
    """

    def __init__(self, name: str, max_states: int) -> None:
        self.name = _cut(name)
        self.max_states = max_states

    def within(self, max_states: int) -> Budget:
        """The same budget, with this limit on states if it is lower."""
        return Budget(self.name, min(self.max_states, max_states))

    def check_size(self, n_states: int) -> None:
        """Raise StateLimitExceeded if `n_states` is too many; and `check_time`."""
        self.check_states(n_states)
        check_time()

    def check_states(self, n_states: int) -> None:
        """Raise StateLimitExceeded if `n_states` is too many."""
        if n_states > self.max_states:
            raise StateLimitExceeded(
                f"{self.name} needs more than {self.max_states} states: raise the limit (max_states) or split the"
                " formula"
            )

    def check_moves(self, n_moves: int, n_letters: int) -> None:
        """Raise StateLimitExceeded if one state has so many moves that the limit on states would not help.

        Args:
            n_moves: number of moves.
            n_letters: number of letters, of which each move has a set.
        """
        if n_moves > _MOVES_PER_STATE:
            raise StateLimitExceeded(
                f"{self.name} needs a state with more than {_MOVES_PER_STATE} moves: split the formula"
            )
        self.check_sets(n_moves, n_letters)

    def check_sets(self, n_sets: int, n_letters: int) -> None:
        """Raise StateLimitExceeded if so many sets of letters would fill the memory."""
        if n_sets * n_letters > _MAX_BITS:
            raise StateLimitExceeded(
                f"{self.name} needs more than {n_sets - 1} sets of {n_letters} letters: split the formula"
            )

    def check_table(self, n_states: int, n_columns: int) -> None:
        """Raise StateLimitExceeded if a table of this shape would fill the memory."""
        if n_states * n_columns > MAX_ENTRIES:
            raise StateLimitExceeded(
                f"{self.name} needs a table of {n_states} states times {n_columns} letters or marks, more than"
                f" {MAX_ENTRIES} entries: split the formula"
            )


def _cut(name: str) -> str:
    """The name, cut to a readable length."""
    name = " ".join(name[:1000].split())
    return name if len(name) <= 80 else name[:77] + "..."


NO_LIMIT = Budget("the automaton", sys.maxsize)
