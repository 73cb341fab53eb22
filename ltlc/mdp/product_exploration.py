"""The part of (MDP states) x (automaton states) that can be reached, built frontier by frontier.

A step of a product has two halves. The *move* is the environment's: choice (s, q, a) leads to the *arrival* (s', q),
where the automaton has not read anything yet. The *reading* is the automaton's: a letter is drawn from the label of s'
and leads to (s', q'). Everything that depends on letters (next automaton state, rewards, marks) lives on the few
arrivals, not on the many branches of the moves, and a transition matrix is the product of two sparse ones. It need not
be made at all for what only takes the mean of something over the successors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import sparse

from ltlc.automata.finite import END, end_letter, spoken_letters
from ltlc.automata.possible import LetterNumbers, Possible, mask_type
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray, Support, ranges, row_any
from ltlc.mdp.model import LabelledMDP

InitialLabel = Literal["read", "skip"]


@dataclass(frozen=True, eq=False)
class TransitionTable:
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

    select_pair: IntArray | None = None
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
        if self.select_pair is None or not self.select_pair.size:
            return np.arange(len(machine)), np.zeros(len(machine), dtype=np.int64), machine
        then = np.column_stack((machine, self.select_pair[machine]))
        owner, option = np.nonzero(then >= 0)
        return owner, option, then[owner, option]


class ProductExploration:
    """Reachable product states, moves between them and arrivals, and readings of the arrivals.

    Moves are kept in factors: those of the MDP, and which machine states occur with which of its states.

    Attributes:
        mdp_state, machine_state: (n_states,), ordered by MDP state, then machine state.
        initial: (n_states,), distribution of the first product state.
        choice_start, choice_action: the choices, as an `ExplicitMDP` has them.
        n_arrivals: number of arrivals.
        reading_arrival, reading_machine_state, reading_input: (n_readings,), sorted by arrival.
        reading_probability: (n_readings,).
        reading_target: (n_readings,), product state, or -1 where the episode surely ends.
    """

    def __init__(self, mdp: LabelledMDP, table: TransitionTable, initial_label: InitialLabel) -> None:
        if initial_label not in ("read", "skip"):
            raise InvalidArgumentError(f'initial_label is {initial_label!r}, expected "read" or "skip"')
        start_keys, start_weight = _start(mdp, table, initial_label)
        seen, arrived = _reach(mdp, table, start_keys)
        keys, arrivals = np.flatnonzero(seen), np.flatnonzero(arrived)
        self.mdp_state, self.machine_state = (half.astype(np.int32) for half in np.divmod(keys, table.size))
        self.initial: FloatArray = np.zeros(len(keys))
        np.add.at(self.initial, np.searchsorted(keys, start_keys), start_weight)

        self._base, self._size = mdp.explicit, table.size
        # an act is a product state with one of its options, after which the machine is in a state and the MDP moves
        self._owner, option, self._act_machine = table.options(self.machine_state)
        self._act_state = self.mdp_state[self._owner]
        self._first_action = mdp.n_actions * option
        self.n_actions = mdp.n_actions * (1 if table.select_pair is None else 1 + table.select_pair.shape[1])
        self._act_start, self.choice_start, self.choice_action, _ = self._choices_of(self._base)
        self.n_arrivals = len(arrivals)
        self._arrivals = arrivals
        self._arrival_number = np.cumsum(arrived, dtype=np.int32) - np.int32(1)

        entered, machine = np.divmod(arrivals, table.size)
        inputs = table.input_probability
        length = np.diff(inputs.indptr)[entered]
        entry = ranges(inputs.indptr[entered], length)
        self.reading_arrival = np.repeat(np.arange(len(arrivals), dtype=np.int32), length)
        self.reading_machine_state = machine[self.reading_arrival]
        self.reading_input = inputs.indices[entry]
        self.reading_probability = inputs.data[entry]
        self.reading_ends = table.ends[entered[self.reading_arrival]]
        here = self.reading_machine_state, self.reading_input
        target = entered[self.reading_arrival] * table.size + table.next_state[here]
        live = table.goes_on[here] & ~self.reading_ends
        number = np.cumsum(seen, dtype=np.int32) - np.int32(1)
        self.reading_target = np.where(live, number[target], np.int32(-1))

    @property
    def n_states(self) -> int:
        """Number of reachable product states."""
        return len(self.mdp_state)

    @property
    def n_choices(self) -> int:
        """Number of choices of product states."""
        return len(self.choice_action)

    def after_move(self, per_arrival: FloatArray) -> FloatArray:
        """The mean of a quantity (n_arrivals,) over the arrivals of each choice, shape (n_choices,).

        One machine state at a time, which takes a matrix of the size of the MDP, and none of the size of the product.
        """
        base, result = self._base, np.empty(self.n_choices)
        entered, machine = np.divmod(self._arrivals, self._size)
        for state in np.unique(self._act_machine):
            there, here = np.flatnonzero(machine == state), np.flatnonzero(self._act_machine == state)
            value = np.zeros(base.n_states)
            value[entered[there]] = per_arrival[there]
            start, rows = _rows(base, self._act_state[here])
            few = 2 * len(rows) < base.n_choices
            mean = base.matrix[rows] @ value if few else (base.matrix @ value)[rows]
            result[ranges(self._act_start[here], np.diff(start))] = mean
        return result

    def after_step(self, value: FloatArray) -> FloatArray:
        """The mean of a quantity (n_states,) over where each choice leads, shape (n_choices,); 0 where it ends."""
        paid = self.reading_probability * np.where(self.reading_target >= 0, value[self.reading_target], 0.0)
        return self.after_move(self._per_arrival(paid))

    def expected(self, column: FloatArray | BoolArray, at_end: FloatArray | None = None) -> FloatArray:
        """What a table (n_machine_states, n_inputs) pays on average for each choice, shape (n_choices,).

        With `at_end`, another such table, paid on top where the environment ends the episode.
        """
        here = self.reading_machine_state, self.reading_input
        paid = column[here]
        if at_end is not None:
            paid = paid + np.where(self.reading_ends, at_end[here], 0.0)
        return self.after_move(self._per_arrival(self.reading_probability * paid))

    def ending(self, stop: FloatArray, counted: BoolArray | None = None) -> FloatArray:
        """The probability that the episode ends with a choice, by `stop` or by the environment, shape (n_choices,).

        Only steps for which `counted` holds, if given; both tables have shape (n_machine_states, n_inputs).
        """
        here = self.reading_machine_state, self.reading_input
        chance = np.where(self.reading_ends, 1.0, stop[here])
        if counted is not None:
            chance = chance * counted[here]
        return self.after_move(self._per_arrival(self.reading_probability * chance))

    def moves(self) -> Any:
        """The environment's half of every choice, csr_array (n_choices, n_arrivals)."""
        return self._moves(self._base)

    def transitions(self, weight: FloatArray | None = None, moves: Any = None) -> Any:
        """The steps that go on, csr_array (n_choices, n_states).

        Args:
            weight: scales them, shape (n_machine_states, n_inputs).
            moves: instead of all `moves`, some combinations of them, one per row.
        """
        factor = self.reading_probability
        if weight is not None:
            factor = factor * weight[self.reading_machine_state, self.reading_input]
        return self._read(self.moves() if moves is None else moves, factor)

    def support(self, marks: Sequence[BoolArray]) -> tuple[Support, list[BoolArray]]:
        """The graph of the product, and which of its choices have a mark with a branch.

        Each mark is a table (n_machine_states, n_inputs). The graph of the MDP is unfolded, not that of the product
        searched for equal rows.
        """
        base = self._base.support
        moves = self._moves(base.graph)
        marked = []
        for table in marks:
            hit = self._per_arrival(table[self.reading_machine_state, self.reading_input].astype(np.float64)) > 0
            marked.append(row_any(moves, hit))
        matrix = self._read(moves, None)
        act_start, start, action, _ = self._choices_of(base.graph)
        merged = ExplicitMDP(matrix, start, action, self.initial, n_actions=self.n_actions)
        _, original = _rows(self._base, self._act_state)
        offset = act_start[:-1] - base.graph.choice_start[self._act_state]
        of_choice = base.of_choice[original] + np.repeat(offset, np.diff(self._act_start)).astype(np.int32)
        return Support(merged, of_choice), marked

    def _choices_of(self, base: ExplicitMDP) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """Where the choices of each act and of each product state begin, their actions, and their choices in `base`."""
        act_start, rows = _rows(base, self._act_state)
        first = np.searchsorted(self._owner, np.arange(self.n_states + 1))
        action = base.choice_action[rows]
        if self._first_action.any():
            action = action + np.repeat(self._first_action, np.diff(act_start))
        return act_start, act_start[first], action, rows

    def _per_arrival(self, per_reading: FloatArray) -> FloatArray:
        if len(self.reading_arrival) == self.n_arrivals:
            return per_reading
        return np.bincount(self.reading_arrival, per_reading, minlength=self.n_arrivals).astype(np.float64, copy=False)

    def _moves(self, base: ExplicitMDP) -> Any:
        """The environment's half of a step: choice (s, q, a) -> arrival (s', q), csr_array (n_choices, n_arrivals)."""
        matrix = base.matrix
        act_start, _, _, rows = self._choices_of(base)
        length = np.diff(matrix.indptr)[rows]
        entry = ranges(matrix.indptr[rows], length)
        key = matrix.indices[entry].astype(np.int64) * self._size
        key += np.repeat(np.repeat(self._act_machine, np.diff(act_start)), length)
        indptr = _pointers(length)
        shape = (len(rows), self.n_arrivals)
        return sparse.csr_array((matrix.data[entry], self._arrival_number[key], indptr), shape=shape)

    def _read(self, moves: Any, factor: FloatArray | None) -> Any:
        """Moves followed by readings, csr_array (n_choices, n_states); without a factor it is a matrix of bool."""
        shape = (moves.shape[0], self.n_states)
        keep = self.reading_target >= 0
        if factor is not None:
            keep = keep & (factor > 0)
        if keep.all() and len(keep) == self.n_arrivals:  # one sure reading per arrival: a renaming of columns
            scaled = factor is not None and not (factor == 1).all()
            data = moves.data * factor[moves.indices] if scaled and factor is not None else moves.data
            return sparse.csr_array((data, self.reading_target[moves.indices], moves.indptr), shape=shape)
        chance = np.ones(int(keep.sum()), dtype=np.bool_) if factor is None else factor[keep]
        read = (self.reading_arrival[keep], self.reading_target[keep])
        product = moves @ sparse.csr_array((chance, read), shape=(self.n_arrivals, self.n_states))
        product.sort_indices()
        return product


def _rows(base: ExplicitMDP, states: IntArray) -> tuple[IntArray, IntArray]:
    """The choices of each of the given states, one after the other, and where those of each begin."""
    counts = np.asarray(np.diff(base.choice_start)[states], dtype=np.int32)
    return _pointers(counts), ranges(base.choice_start[states], counts)


def _pointers(counts: IntArray) -> IntArray:
    """Where each of some consecutive ranges begins, and where the last one ends; in 32 bits where that is enough."""
    total = int(counts.sum(dtype=np.int64))
    result: IntArray = np.zeros(len(counts) + 1, dtype=np.int32 if total < 2**31 else np.int64)
    np.cumsum(counts, out=result[1:])
    return result


def input_probability(
    mdp: LabelledMDP, aps: tuple[str, ...], letter_class: IntArray, possible: Possible | None = None
) -> Any:
    """The label distributions of an MDP in terms of the letter classes of a machine, csr_array (n_states, n_classes).

    Where an episode ends (`ltlc.automata.finite.END`) is known from the terminal states, unless it is a label.

    Raises:
        UnknownNameError: the machine reads a proposition that the MDP does not label.
        ImpossibleLetterError: a letter of the MDP was declared impossible.
    """
    end = 0 if END in mdp.aps else end_letter(aps, letter_class)
    numbers = spoken_letters(aps, possible) if end else LetterNumbers(aps, possible)
    masks = np.zeros(len(mdp.letters), dtype=mask_type(len(numbers.aps)))
    for bit, name in enumerate(numbers.aps):
        if name not in mdp.aps:
            raise UnknownNameError("proposition", name, mdp.aps)
        masks |= ((mdp.letters >> mdp.aps.index(name)) & 1).astype(masks.dtype) << bit
    letters = numbers.numbers(masks)
    n_classes = int(letter_class.max()) + 1

    def grouped(classes: IntArray) -> Any:
        each = np.arange(len(classes))
        return sparse.csr_array((np.ones(len(classes)), (each, classes)), shape=(len(classes), n_classes))

    inputs = mdp.label_probability @ grouped(letter_class[letters])
    if end and mdp.terminal is not None:
        goes_on = sparse.diags_array((~mdp.terminal).astype(np.float64)).tocsr()
        ends = sparse.diags_array(mdp.terminal.astype(np.float64)).tocsr()
        inputs = goes_on @ inputs + ends @ (mdp.label_probability @ grouped(letter_class[letters + end]))
        inputs.eliminate_zeros()
    inputs.sort_indices()
    return inputs


def _start(mdp: LabelledMDP, table: TransitionTable, initial_label: InitialLabel) -> tuple[IntArray, FloatArray]:
    """Keys (MDP state * machine size + machine state) of the first product states, and their probabilities."""
    states = np.flatnonzero(mdp.start)
    weight = mdp.start[states]
    if initial_label == "skip":
        return states * table.size + table.initial_state, weight
    inputs = table.input_probability
    length = np.diff(inputs.indptr)[states]
    entry = ranges(inputs.indptr[states], length)
    machine = table.next_state[table.initial_state, inputs.indices[entry]]
    return np.repeat(states, length) * table.size + machine, np.repeat(weight, length) * inputs.data[entry]


def _reach(mdp: LabelledMDP, table: TransitionTable, start: IntArray) -> tuple[BoolArray, BoolArray]:
    """Which keys are reachable as product states, and which as arrivals."""
    edges, inputs, size = mdp.explicit.adjacency, table.input_probability, table.size
    degree, n_inputs = np.diff(edges.indptr), np.diff(inputs.indptr)
    seen = np.zeros(mdp.n_states * size, dtype=np.bool_)
    arrived = np.zeros_like(seen)
    ticket = np.zeros(len(seen), dtype=np.int32)
    frontier = np.unique(start)
    seen[frontier] = True
    while frontier.size:
        state, machine = np.divmod(frontier, size)
        owner, _, machine = table.options(machine)
        state = state[owner]
        length = degree[state]
        entered = edges.indices[ranges(edges.indptr[state], length)].astype(np.int64)
        arrival = _fresh(entered * size + np.repeat(machine, length), arrived, ticket)
        state, machine = np.divmod(arrival, size)
        length = n_inputs[state]
        column = inputs.indices[ranges(inputs.indptr[state], length)]
        state, machine = np.repeat(state, length), np.repeat(machine, length)
        live = table.goes_on[machine, column] & ~table.ends[state]
        frontier = _fresh((state * size + table.next_state[machine, column])[live], seen, ticket)
    return seen, arrived


def _fresh(keys: IntArray, seen: BoolArray, ticket: IntArray) -> IntArray:
    """The keys not seen before, each once; marks them as seen. `ticket` is scratch space."""
    keys = keys[~seen[keys]]
    number = np.arange(len(keys), dtype=np.int32)
    ticket[keys] = number  # of equal keys one wins
    keys = keys[ticket[keys] == number]
    seen[keys] = True
    return keys
