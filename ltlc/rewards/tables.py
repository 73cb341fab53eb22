"""Reward tables: what a reward scheme says, compiled to arrays over (state, letter class)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from ltlc.automata.possible import LetterNumbers, Possible
from ltlc.errors import InvalidArgumentError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]
BoolArray = npt.NDArray[np.bool_]
OnTermination = Literal["repeat", "cut"]


@dataclass(frozen=True, eq=False)
class RewardTables:
    """A reward scheme compiled for one automaton: stepping a product is a look-up in these arrays.

    One step from table state q with a letter of class c pays `reward[q, c]` and moves to `next_state[q, c]`. With
    probability `stop[q, c]` the episode ends there, `stop_reward[q, c]` is paid on top, and nothing follows; otherwise
    what follows is worth `discount[q, c]` of itself.

    Where the scheme needs to be told which Rabin pair a policy is going to satisfy, the policy may go from q to
    `select_pair[q, i]` before the environment makes a step: together with an action, for free, once in an episode.

    Where the *environment* ends the episode with the step, and the tables do not, what follows is worth
    `closing[next_state[q, c], c]`, discounted as anything else that follows.

    Attributes:
        aps: the propositions that the tables read.
        letter_class: shape (n_letters,), int32; entry = class of the letter.
        initial_state: table state before any letter is read.
        next_state: shape (n_states, n_classes), int32; entry = next table state, after a deadlock has been dealt with.
        reward: shape (n_states, n_classes), float64; computed from the state entered, deadlock included.
        discount: shape (n_states, n_classes), float64 in [0, 1]; weight of all that follows the step.
        stop: shape (n_states, n_classes), float64 in [0, 1]; probability that the step ends the episode.
        stop_reward: shape (n_states, n_classes), float64; paid on top of `reward` when the step ends the episode.
        violated: shape (n_states, n_classes), bool; whether the step enters a deadlock of the automaton.
        accepted: shape (n_states, n_classes), bool; whether the step carries an acceptance mark.
        automaton_state: shape (n_states,), int32; the automaton state behind each table state (a scheme may refine
            states).
        progress: shape (n_states,), float64 in [0, 1]; 1 on an accepting cycle, less the more letters away, 0 in a
            deadlock.
        select_pair: shape (n_states, n_choices), int32; the state after choosing pair i, -1 where it cannot be chosen;
            usually there are no choices.
        closing: shape (n_states, n_classes), float64; value of standing in a state where the environment has terminated
            and the last letter, of that class, is repeated for ever; usually 0 if nothing follows the end of the
            environment.
        possible: which letters are possible, see `ltlc.automata.possible`; None: all 2**len(aps).
        on_termination: whether `closing` is about the last letter for ever (`repeat`), or nothing follows (`cut`).

    Raises:
        InvalidArgumentError: the arrays do not fit together, or an entry is out of range or not finite.
    """

    aps: tuple[str, ...]
    letter_class: IntArray
    initial_state: int
    next_state: IntArray
    reward: FloatArray
    discount: FloatArray
    stop: FloatArray
    stop_reward: FloatArray
    violated: BoolArray
    accepted: BoolArray
    automaton_state: IntArray
    progress: FloatArray
    select_pair: IntArray = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int32))
    closing: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    on_termination: OnTermination = "cut"
    possible: Possible | None = None

    def __post_init__(self) -> None:
        table = np.shape(self.next_state)
        _check(len(table) == 2 and min(table) > 0, f"next_state has shape {table}, expected (n_states, n_classes)")
        _freeze(self, "letter_class", np.int32, (LetterNumbers(self.aps, self.possible).size,))
        _freeze(self, "next_state", np.int32, table)
        for name in ("reward", "discount", "stop", "stop_reward"):
            _freeze(self, name, np.float64, table)
        for name in ("violated", "accepted"):
            _freeze(self, name, np.bool_, table)
        _freeze(self, "automaton_state", np.int32, table[:1])
        _freeze(self, "progress", np.float64, table[:1])
        if not np.size(self.select_pair):
            object.__setattr__(self, "select_pair", np.zeros((table[0], 0)))
        _freeze(self, "select_pair", np.int32, (table[0], np.shape(self.select_pair)[-1]))
        if not np.size(self.closing):
            object.__setattr__(self, "closing", np.zeros(table))
        _freeze(self, "closing", np.float64, table)
        _check(self.on_termination in get_args(OnTermination), f"on_termination is {self.on_termination!r}")
        for name in ("reward", "stop_reward", "closing"):
            _check(bool(np.isfinite(getattr(self, name)).all()), f"{name} has an entry that is not finite")
        for name in ("discount", "stop", "progress"):
            values = getattr(self, name)
            _check(bool(((values >= 0) & (values <= 1)).all()), f"{name} has an entry outside [0, 1]")
        _check(_within(self.next_state, self.n_states), "next_state leads outside the states")
        _check(_within(self.select_pair + 1, self.n_states + 1), "select_pair leads outside the states")
        _check(_within(self.letter_class, self.n_classes), "letter_class names a class that has no column")
        _check(0 <= self.initial_state < self.n_states, f"initial state {self.initial_state} of {self.n_states} states")

    @property
    def n_states(self) -> int:
        """Number of table states."""
        return int(self.next_state.shape[0])

    @property
    def n_classes(self) -> int:
        """Number of letter classes."""
        return int(self.next_state.shape[1])

    @property
    def n_choices(self) -> int:
        """Number of Rabin pairs that can be chosen between; mostly 0."""
        return int(self.select_pair.shape[1])

    @property
    def final_value(self) -> FloatArray:
        """What all that follows a step is worth where the environment ends the episode with it, (n_states, n_classes).

        It takes the place of the value of the next state, so the discount of the step applies to it.
        """
        return np.take_along_axis(self.closing, self.next_state.astype(np.int64), axis=0)

    @property
    def terminal(self) -> BoolArray:
        """Steps that surely end the episode, shape (n_states, n_classes)."""
        return np.asarray(self.stop == 1)

    @property
    def expected_reward(self) -> FloatArray:
        """Mean reward of a step, over whether the episode stops; shape (n_states, n_classes)."""
        return self.reward + self.stop * self.stop_reward

    @property
    def expected_discount(self) -> FloatArray:
        """Mean weight of what follows a step, over whether the episode stops; shape (n_states, n_classes)."""
        return self.discount * (1 - self.stop)


def _check(condition: bool, message: str) -> None:
    if not condition:
        raise InvalidArgumentError(f"reward tables: {message}")


def _within(array: IntArray, bound: int) -> bool:
    return bool(((array >= 0) & (array < bound)).all())


def _freeze(tables: RewardTables, name: str, dtype: type[np.generic], shape: tuple[int, ...]) -> None:
    array = np.array(getattr(tables, name), dtype=dtype)
    _check(array.shape == shape, f"{name} has shape {array.shape}, expected {shape}")
    array.flags.writeable = False
    object.__setattr__(tables, name, array)
