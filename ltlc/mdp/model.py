"""The labelled Markov decision process: what is known of a task before any automaton is added."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.automata.possible import mask_type
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray, ranges

Label = Iterable[str] | Mapping[str, float]
"""The names that hold, or a name -> probability table of names that hold independently of each other."""

TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class LabelledMDP:
    """A finite Markov decision process whose states carry a distribution over letters.

    Rows and label distributions are rescaled to sum to 1 exactly, once they were checked to do so within 1e-9.

    Attributes:
        aps: the propositions that states show.
        transitions: one scipy.sparse.csr_array of shape (n_states, n_states) per action; rows sum to 1, or are empty
            where the action is not available.
        letters: shape (n_letters,), `mask_type(len(aps))`; bitmasks over `aps`: the letters that occur at all.
        label_probability: scipy.sparse.csr_array of shape (n_states, n_letters): the letter drawn on *entering* the
            state.
        initial_state: the first state.
        initial_distribution: shape (n_states,); None means always `initial_state`.
        terminal: shape (n_states,): entering such a state ends the episode of the environment; None means never. For
            words the state goes on for ever, and so does the letter that was drawn on entering it; so it must be
            absorbing.
        state_names, action_names: one each, or None; for readers only.

    Raises:
        InvalidArgumentError: shapes disagree, a probability is negative or not a number, a row does not sum to 1, or a
            state has no available action; the message names the state and the action.
    """

    aps: tuple[str, ...]
    transitions: tuple[Any, ...]
    letters: IntArray
    label_probability: Any
    initial_state: int = 0
    initial_distribution: FloatArray | None = None
    terminal: BoolArray | None = None
    state_names: tuple[str, ...] | None = None
    action_names: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if not self.transitions:
            raise InvalidArgumentError("an MDP needs at least one action; `transitions` is empty")
        n = sparse.csr_array(self.transitions[0]).shape[0]
        _require(n > 0, "an MDP needs at least one state")
        _require(self.state_names is None or len(self.state_names) == n, f"not one name for each of {n} states")
        n_actions = len(self.transitions)
        _require(self.action_names is None or len(self.action_names) == n_actions, "not one name for each action")
        _require(len(set(self.aps)) == len(self.aps), "an atomic proposition is listed twice")
        _require(0 <= self.initial_state < n, f"initial state {self.initial_state} of {n} states")
        rows = tuple(
            _stochastic(matrix, (n, n), f"action {self.action_name(a)}", self.state_name, may_be_empty=True)
            for a, matrix in enumerate(self.transitions)
        )
        letters = np.asarray(self.letters, dtype=mask_type(len(self.aps)))
        _require(letters.ndim == 1 and len(np.unique(letters)) == len(letters), "`letters` is not a list of letters")
        _require(bool(((letters >= 0) & (letters < 1 << len(self.aps))).all()), "a letter is outside the propositions")
        labels = _stochastic(self.label_probability, (n, len(letters)), "label distribution", self.state_name)
        _set(self, aps=tuple(self.aps), transitions=rows, letters=letters, label_probability=labels)
        self._check_initial(n)
        blocked = np.flatnonzero(~self.available.any(axis=1))
        if blocked.size:
            name = self.state_name(blocked[0])
            raise InvalidArgumentError(f"state {name} has no available action; let one lead back to the state itself")
        self._check_terminal(n)

    def _check_initial(self, n: int) -> None:
        if self.initial_distribution is None:
            return
        start = np.asarray(self.initial_distribution, dtype=np.float64)
        proper = start.shape == (n,) and bool((start >= 0).all()) and abs(start.sum() - 1) <= TOLERANCE
        _require(proper, f"`initial_distribution` is not a probability distribution over {n} states")
        _set(self, initial_distribution=start / start.sum())

    def _check_terminal(self, n: int) -> None:
        if self.terminal is None:
            return
        terminal = np.asarray(self.terminal, dtype=np.bool_)
        _require(terminal.shape == (n,), f"`terminal` has shape {terminal.shape}, expected ({n},)")
        for a, matrix in enumerate(self.transitions):
            leaves = terminal & ((matrix.diagonal() < 1) & self.available[:, a])
            if leaves.any():
                state = self.state_name(np.flatnonzero(leaves)[0])
                raise InvalidArgumentError(f"terminal state {state}: action {self.action_name(a)} leaves it")
        _set(self, terminal=terminal)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return int(self.label_probability.shape[0])

    @property
    def n_actions(self) -> int:
        """Number of actions, available or not."""
        return len(self.transitions)

    @cached_property
    def available(self) -> BoolArray:
        """Which actions a state offers, shape (n_states, n_actions)."""
        return np.stack([np.diff(matrix.indptr) > 0 for matrix in self.transitions], axis=1)

    @cached_property
    def start(self) -> FloatArray:
        """The distribution of the first state, shape (n_states,)."""
        if self.initial_distribution is not None:
            return self.initial_distribution
        start: FloatArray = np.eye(1, self.n_states, self.initial_state)[0]
        return start

    @cached_property
    def explicit(self) -> ExplicitMDP:
        """The same process as rows of choices, without its labels; choices are ordered by state, then action."""
        n, available = self.n_states, self.available
        start = np.concatenate(([0], np.cumsum(available.sum(axis=1)))).astype(np.int32)
        action = np.nonzero(available)[1].astype(np.int32)
        # where each choice begins is known beforehand, so that every action can be put in place by itself
        length: IntArray = np.stack([np.diff(matrix.indptr) for matrix in self.transitions], axis=1)[available]
        total = int(length.sum(dtype=np.int64))
        pointers = np.concatenate(([0], np.cumsum(length))).astype(np.int32 if total < 2**31 else np.int64)
        indices, data = np.empty(total, dtype=np.int32), np.empty(total)
        for a, matrix in enumerate(self.transitions):
            rows = np.flatnonzero(action == a)
            place = ranges(np.asarray(pointers[rows], dtype=np.int64), length[rows])
            indices[place], data[place] = matrix.indices, matrix.data
        choices = sparse.csr_array((data, indices, pointers), shape=(len(action), n))
        return ExplicitMDP(choices, start, action, self.start, n_actions=self.n_actions)

    @cached_property
    def with_final_letters(self) -> tuple[LabelledMDP, IntArray]:
        """The same process with a terminal state for each letter that one may show, and the state behind each."""
        ended = np.zeros(self.n_states, dtype=np.bool_) if self.terminal is None else self.terminal
        return split_by_letter(self, ended)

    def state_name(self, state: int | np.integer[Any]) -> str:
        """The state for a message: its number, and its name where it has one."""
        return f"{state}" if self.state_names is None else f"{state} ({self.state_names[int(state)]})"

    def action_name(self, action: int | np.integer[Any]) -> str:
        """The action for a message: its number, and its name where it has one."""
        return f"{action}" if self.action_names is None else f"{action} ({self.action_names[int(action)]})"

    def with_labels(self, aps: Sequence[str], labels: Mapping[int, Label] | Sequence[Label]) -> LabelledMDP:
        """The same process with other labels; a state that the mapping leaves out has the empty label.

        A label is a collection of names, or a name -> probability mapping (drawn independently on each entry).

        Raises:
            UnknownNameError: a label uses a name that is not in `aps`.
            InvalidArgumentError: a probability is outside [0, 1], or a state does not exist.
        """
        letters, probability = _label_matrix(tuple(aps), labels, self.n_states)
        return replace(self, aps=tuple(aps), letters=letters, label_probability=probability)

    @classmethod
    def from_arrays(
        cls,
        transitions: npt.ArrayLike | Sequence[Any],
        *,
        aps: Sequence[str] = (),
        labels: Mapping[int, Label] | Sequence[Label] = (),
        **fields: Any,
    ) -> LabelledMDP:
        """From `transitions[action][state, next state]`, dense or sparse; `fields` are further fields of the class."""
        matrices = tuple(sparse.csr_array(matrix, dtype=np.float64) for matrix in transitions)  # type: ignore[union-attr]
        _require(bool(matrices), "an MDP needs at least one action; `transitions` is empty")
        n = matrices[0].shape[0]
        letters, probability = _label_matrix(tuple(aps), labels or {}, n)
        return cls(tuple(aps), matrices, letters, probability, **fields)

    @classmethod
    def from_table(
        cls,
        table: Mapping[int, Mapping[int, Sequence[tuple[float, int, float, bool]]]],
        *,
        aps: Sequence[str] = (),
        labels: Mapping[int, Label] | Sequence[Label] = (),
        **fields: Any,
    ) -> LabelledMDP:
        """From Gymnasium's `P[state][action] = [(probability, next state, reward, terminated), ...]`.

        Rewards are dropped. A state that is entered with `terminated` is terminal, hence made absorbing.

        Raises:
            InvalidArgumentError: a state that can be reached is entered both with and without `terminated`.
        """
        quads = [
            (s, a, p, t, done)
            for s, actions in table.items()
            for a, branches in actions.items()
            for p, t, _, done in branches
        ]
        source, action, probability, target, done = (np.array(column) for column in zip(*quads, strict=True))
        n, n_actions = int(source.max()) + 1, int(action.max()) + 1
        _require(int(target.max()) < n, f"the table leads to state {target.max()}, but describes only {n} states")
        terminal = np.zeros(n, dtype=np.bool_)
        terminal[target[(probability > 0) & done.astype(bool)]] = True
        transitions = []
        for a in range(n_actions):
            used = (action == a) & ~terminal[source]
            rows = np.concatenate((source[used], np.flatnonzero(terminal)))
            columns = np.concatenate((target[used], np.flatnonzero(terminal)))
            data = np.concatenate((probability[used], np.ones(int(terminal.sum()))))
            transitions.append(sparse.csr_array((data, (rows, columns)), shape=(n, n)))
        mdp = cls.from_arrays(transitions, aps=aps, labels=labels, terminal=terminal, **fields)
        reached = mdp.explicit.reachable
        odd = reached[source] & ~terminal[source] & (probability > 0) & terminal[target] & ~done.astype(bool)
        if odd.any():
            name = mdp.state_name(target[odd][0])
            raise InvalidArgumentError(f"state {name} is entered both with and without `terminated`")
        return mdp


def split_by_letter(mdp: LabelledMDP, states: BoolArray) -> tuple[LabelledMDP, IntArray]:
    """The same process with states (state, letter) instead of those given, (n_states,); and the state behind each.

    The letter is drawn on entering, as before; a terminal state keeps it. Where the states have names, it becomes a
    part of them, as a bitmask. A process in which the labels of these states are sure is given back as it is.
    """
    probability, n = mdp.label_probability, mdp.n_states
    row = np.repeat(np.arange(n), np.diff(probability.indptr))
    split = states[row]
    new = split | (np.diff(row, prepend=-1) > 0)  # the entries of the label distributions that get a state of their own
    origin = row[new]
    size = len(origin)
    if size == n:
        return mdp, np.arange(n)
    # old state -> new states, weighted by its letters; and new state -> the old one behind it
    drawn = sparse.csr_array(
        (np.where(split, probability.data, 1.0)[new], np.arange(size), np.searchsorted(origin, np.arange(n + 1))),
        shape=(n, size),
    )
    kept = np.zeros(size, dtype=np.bool_) if mdp.terminal is None else mdp.terminal[origin]
    behind = sparse.csr_array((np.ones(size), origin, np.arange(size + 1)), shape=(size, n))
    leaving = sparse.diags_array((~kept).astype(np.float64)) @ behind
    start, names = np.asarray(mdp.start @ drawn), mdp.state_names
    letter = mdp.letters[probability.indices][new]
    return replace(
        mdp,
        transitions=tuple(
            leaving @ matrix @ drawn + sparse.diags_array((kept & mdp.available[origin, a]).astype(np.float64))
            for a, matrix in enumerate(mdp.transitions)
        ),
        label_probability=sparse.csr_array(
            (np.where(split, 1.0, probability.data), (np.cumsum(new) - 1, probability.indices)),
            shape=(size, len(mdp.letters)),
        ),
        initial_state=int(np.argmax(start)),
        initial_distribution=start,
        terminal=None if mdp.terminal is None else kept,
        state_names=None
        if names is None
        else tuple(
            f"{names[state]}, letter {shown}" if states[state] else names[state]
            for state, shown in zip(origin.tolist(), letter.tolist(), strict=True)
        ),
    ), origin


def _label_matrix(
    aps: tuple[str, ...], labels: Mapping[int, Label] | Sequence[Label], n_states: int
) -> tuple[IntArray, Any]:
    """The letters that occur, ascending, and the csr_array (n_states, n_letters) of their probabilities."""
    if not isinstance(labels, Mapping):
        _require(len(labels) == n_states, f"{len(labels)} labels for {n_states} states")
        labels = dict(enumerate(labels))
    bit = {name: 1 << i for i, name in enumerate(aps)}
    entries: list[tuple[int, int, float]] = []
    for state, label in labels.items():
        _require(0 <= state < n_states, f"a label is given for state {state}, but there are {n_states} states")
        entries += [(state, letter, p) for letter, p in _distribution(label, bit, state).items()]
    unlabelled = np.setdiff1d(np.arange(n_states), np.fromiter(labels, dtype=np.int64, count=len(labels)))
    states = np.concatenate((np.array([e[0] for e in entries], dtype=np.int64), unlabelled))
    drawn = np.array([e[1] for e in entries] + [0] * len(unlabelled), dtype=mask_type(len(aps)))
    probability = np.array([e[2] for e in entries] + [1.0] * len(unlabelled))
    letters, column = np.unique(drawn, return_inverse=True)
    return letters, sparse.csr_array((probability, (states, column)), shape=(n_states, len(letters)))


def _distribution(label: Label, bit: Mapping[str, int], state: int) -> dict[int, float]:
    """Letter -> probability of one label."""
    if isinstance(label, str):
        label = (label,)
    chance = dict(label) if isinstance(label, Mapping) else dict.fromkeys(label, 1.0)
    distribution = {0: 1.0}
    for name, p in chance.items():
        if name not in bit:
            raise UnknownNameError("proposition", name, bit)
        _require(0 <= p <= 1, f"state {state}: proposition {name} has probability {p}, not in [0, 1]")
        distribution = {
            letter | (bit[name] if holds else 0): weight * (p if holds else 1 - p)
            for letter, weight in distribution.items()
            for holds in (False, True)
            if (p if holds else 1 - p) > 0
        }
    return distribution


def _stochastic(matrix: Any, shape: tuple[int, int], what: str, state_name: Any, *, may_be_empty: bool = False) -> Any:
    """A checked copy in canonical form; rows sum to 1 (or are empty, where that is allowed)."""
    rows = sparse.csr_array(matrix, dtype=np.float64, copy=True)
    _require(rows.shape == shape, f"{what}: shape {rows.shape}, expected {shape}")
    rows.sum_duplicates()
    wrong = np.flatnonzero(~((rows.data >= 0) & (rows.data <= 1 + TOLERANCE)))  # NaN compares false
    if wrong.size:
        state = int(np.searchsorted(rows.indptr, wrong[0], side="right")) - 1
        raise InvalidArgumentError(
            f"state {state_name(state)}, {what}: {rows.data[wrong[0]]} is not a probability "
            f"(column {rows.indices[wrong[0]]})"
        )
    rows.eliminate_zeros()
    total = np.asarray(rows.sum(axis=1)).ravel()
    off = np.abs(total - 1) > TOLERANCE
    if may_be_empty:
        off &= np.diff(rows.indptr) > 0
    if off.any():
        state = int(np.flatnonzero(off)[0])
        allowed = ", and not 0 as where the action is not available" if may_be_empty else ""
        raise InvalidArgumentError(
            f"state {state_name(state)}, {what}: probabilities sum to {total[state]:.12g}, not to 1{allowed}"
        )
    rows.data /= np.repeat(total, np.diff(rows.indptr))
    return rows


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise InvalidArgumentError(message)


def _set(mdp: LabelledMDP, **fields: Any) -> None:
    for name, value in fields.items():
        object.__setattr__(mdp, name, value)
