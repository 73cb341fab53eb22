"""The part of (MDP states) x (automaton states) that can be reached, built frontier by frontier.

A step of a product has two halves. The *move* is the environment's: choice (s, q, a) leads to the *arrival* (s', q),
where the automaton has not read anything yet. The *reading* is the automaton's: a letter is drawn from the label of s'
and leads to (s', q'). Everything that depends on letters (next automaton state, rewards, marks) lives on the few
arrivals, not on the many branches of the moves, and a transition matrix is the product of two sparse ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import sparse

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp.explicit import BoolArray, FloatArray, IntArray, ranges
from ltlc.mdp.model import LabelledMDP

InitialLabel = Literal["read", "skip"]


@dataclass(frozen=True, eq=False)
class Reader:
    """A deterministic machine that reads one input per step: what automata and reward tables have in common."""

    next_state: IntArray
    """shape (n_machine_states, n_inputs)."""
    goes_on: BoolArray
    """same shape; False where the step surely ends the episode, so that nothing behind it is explored."""
    initial_state: int
    input_probability: Any
    """csr_array (n_mdp_states, n_inputs): the input that is drawn on entering a state."""
    ends: BoolArray
    """(n_mdp_states,), entering the state ends the episode."""
    commit: IntArray | None = None
    """shape (n_machine_states, n_choices): where a policy may move the machine, along with an action; -1 = it may not;
    None = there are no choices."""

    @property
    def size(self) -> int:
        """Number of machine states."""
        return int(self.next_state.shape[0])

    def options(self, machine: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """What a policy can do about machine states before a step: stay in one, or go where a choice leads.

        Returns:
            the index in `machine`, 0 for staying or 1 + the number of the choice, and the machine state then; sorted
            by the first two.
        """
        if self.commit is None:
            return np.arange(len(machine)), np.zeros(len(machine), dtype=np.int64), machine
        then = np.column_stack((machine, self.commit[machine]))
        owner, option = np.nonzero(then >= 0)
        return owner, option, then[owner, option]


class Unfolding:
    """Reachable product states, moves between them and arrivals, and readings of the arrivals.

    Attributes:
        mdp_state, machine_state: (n_states,), ordered by MDP state, then machine state.
        initial: (n_states,), distribution of the first product state.
        moves: csr_array (n_choices, n_arrivals).
        reading_arrival, reading_machine_state, reading_input: (n_readings,), sorted by arrival.
        reading_probability: (n_readings,).
        reading_target: (n_readings,), product state, or -1 where the episode surely ends.
    """

    def __init__(self, mdp: LabelledMDP, reader: Reader, initial_label: InitialLabel) -> None:
        if initial_label not in ("read", "skip"):
            raise InvalidArgumentError(f'initial_label is {initial_label!r}, expected "read" or "skip"')
        start_keys, start_weight = _start(mdp, reader, initial_label)
        seen, arrived = _reach(mdp, reader, start_keys)
        keys, arrivals = np.flatnonzero(seen), np.flatnonzero(arrived)
        self.mdp_state, self.machine_state = np.divmod(keys, reader.size)
        self.initial: FloatArray = np.zeros(len(keys))
        np.add.at(self.initial, np.searchsorted(keys, start_keys), start_weight)

        base = mdp.explicit
        owner, option, machine = reader.options(self.machine_state)
        acting = self.mdp_state[owner]
        length = np.diff(base.choice_start)[acting]
        rows = ranges(base.choice_start[acting], length)
        per_state = np.bincount(owner, length, minlength=len(keys)).astype(np.int64)
        self.choice_start = np.concatenate(([0], np.cumsum(per_state)))
        self.choice_action = base.choice_action[rows] + mdp.n_actions * np.repeat(option, length)
        self.moves = _moves(base.matrix, rows, np.repeat(machine, length), arrived, reader.size)

        entered, machine = np.divmod(arrivals, reader.size)
        inputs = reader.input_probability
        length = np.diff(inputs.indptr)[entered]
        entry = ranges(inputs.indptr[entered], length)
        self.reading_arrival = np.repeat(np.arange(len(arrivals)), length)
        self.reading_machine_state = machine[self.reading_arrival]
        self.reading_input = inputs.indices[entry]
        self.reading_probability = inputs.data[entry]
        self.reading_ends = reader.ends[entered[self.reading_arrival]]
        here = self.reading_machine_state, self.reading_input
        target = entered[self.reading_arrival] * reader.size + reader.next_state[here]
        live = reader.goes_on[here] & ~self.reading_ends
        self.reading_target = np.where(live, np.searchsorted(keys, target), -1)

    @property
    def n_states(self) -> int:
        """Number of reachable product states."""
        return len(self.mdp_state)

    def expected(self, column: FloatArray | BoolArray) -> FloatArray:
        """What a table (n_machine_states, n_inputs) pays on average for each choice, shape (n_choices,)."""
        paid = self.reading_probability * column[self.reading_machine_state, self.reading_input]
        per_arrival = np.bincount(self.reading_arrival, paid, minlength=self.moves.shape[1])
        return np.asarray(self.moves @ per_arrival)

    def ending(self, stop: FloatArray, counted: BoolArray | None = None) -> FloatArray:
        """The probability that the episode ends with a choice, by `stop` or by the environment, shape (n_choices,).

        Only steps for which `counted` holds, if given; both tables have shape (n_machine_states, n_inputs).
        """
        here = self.reading_machine_state, self.reading_input
        chance = np.where(self.reading_ends, 1.0, stop[here])
        if counted is not None:
            chance = chance * counted[here]
        per_arrival = np.bincount(
            self.reading_arrival, self.reading_probability * chance, minlength=self.moves.shape[1]
        )
        return np.asarray(self.moves @ per_arrival)

    def transitions(self, weight: FloatArray | None = None) -> Any:
        """The steps that go on, csr_array (n_choices, n_states), scaled by `weight` (n_machine_states, n_inputs)."""
        factor = self.reading_probability
        if weight is not None:
            factor = factor * weight[self.reading_machine_state, self.reading_input]
        keep = (self.reading_target >= 0) & (factor > 0)
        if keep.all() and len(keep) == self.moves.shape[1]:  # one sure reading per arrival: a renaming of columns
            data = self.moves.data if (factor == 1).all() else self.moves.data * factor[self.moves.indices]
            columns = self.reading_target.astype(self.moves.indices.dtype)[self.moves.indices]
            return sparse.csr_array((data, columns, self.moves.indptr), shape=(self.moves.shape[0], self.n_states))
        arrival, target = self.reading_arrival[keep], self.reading_target[keep]
        readings = sparse.csr_array((factor[keep], (arrival, target)), shape=(self.moves.shape[1], self.n_states))
        product = self.moves @ readings
        product.sort_indices()
        return product


def input_probability(mdp: LabelledMDP, aps: tuple[str, ...], letter_class: IntArray) -> Any:
    """The label distributions of an MDP in terms of the letter classes of a machine, csr_array (n_states, n_classes).

    Raises:
        UnknownNameError: the machine reads a proposition that the MDP does not label.
    """
    letters = np.zeros(len(mdp.letters), dtype=np.int64)
    for bit, name in enumerate(aps):
        if name not in mdp.aps:
            raise UnknownNameError("proposition", name, mdp.aps)
        letters |= ((mdp.letters >> mdp.aps.index(name)) & 1) << bit
    classes = letter_class[letters]
    n_classes = int(letter_class.max()) + 1
    group = sparse.csr_array(
        (np.ones(len(classes)), (np.arange(len(classes)), classes)), shape=(len(classes), n_classes)
    )
    inputs = mdp.label_probability @ group
    inputs.sort_indices()
    return inputs


def _start(mdp: LabelledMDP, reader: Reader, initial_label: InitialLabel) -> tuple[IntArray, FloatArray]:
    """Keys (MDP state * machine size + machine state) of the first product states, and their probabilities."""
    states = np.flatnonzero(mdp.start)
    weight = mdp.start[states]
    if initial_label == "skip":
        return states * reader.size + reader.initial_state, weight
    inputs = reader.input_probability
    length = np.diff(inputs.indptr)[states]
    entry = ranges(inputs.indptr[states], length)
    machine = reader.next_state[reader.initial_state, inputs.indices[entry]]
    return np.repeat(states, length) * reader.size + machine, np.repeat(weight, length) * inputs.data[entry]


def _reach(mdp: LabelledMDP, reader: Reader, start: IntArray) -> tuple[BoolArray, BoolArray]:
    """Which keys are reachable as product states, and which as arrivals."""
    base, inputs, size = mdp.explicit, reader.input_probability, reader.size
    first = base.matrix.indptr[base.choice_start]  # a state's rows are adjacent: its successors are one range
    seen = np.zeros(mdp.n_states * size, dtype=np.bool_)
    arrived = np.zeros_like(seen)
    frontier = np.unique(start)
    seen[frontier] = True
    while frontier.size:
        state, machine = np.divmod(frontier, size)
        owner, _, machine = reader.options(machine)
        state = state[owner]
        length = first[state + 1] - first[state]
        entered = base.matrix.indices[ranges(first[state], length)].astype(np.int64)
        arrival = _fresh(entered * size + np.repeat(machine, length), arrived)
        state, machine = np.divmod(arrival, size)
        length = np.diff(inputs.indptr)[state]
        column = inputs.indices[ranges(inputs.indptr[state], length)]
        state, machine = np.repeat(state, length), np.repeat(machine, length)
        live = reader.goes_on[machine, column] & ~reader.ends[state]
        frontier = _fresh((state * size + reader.next_state[machine, column])[live], seen)
    return seen, arrived


def _fresh(keys: IntArray, seen: BoolArray) -> IntArray:
    """The keys not seen before, each once, ascending; marks them as seen."""
    keys = np.unique(keys[~seen[keys]])
    seen[keys] = True
    return keys


def _moves(matrix: Any, rows: IntArray, machine: IntArray, arrived: BoolArray, size: int) -> Any:
    """The environment's half of a step: choice (s, q, a) -> arrival (s', q)."""
    number = np.cumsum(arrived, dtype=np.int64) - 1
    picked = matrix[rows]
    keys = picked.indices.astype(np.int64) * size
    keys += np.repeat(machine, np.diff(picked.indptr))
    columns = number[keys].astype(picked.indices.dtype)
    return sparse.csr_array((picked.data, columns, picked.indptr), shape=(len(rows), int(number[-1]) + 1))
