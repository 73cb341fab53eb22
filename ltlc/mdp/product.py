"""Products of a labelled MDP with a Rabin automaton (does the run satisfy?) and with reward tables (what is paid?)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.automata.rabin import RabinAutomaton
from ltlc.errors import InvalidArgumentError
from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray, Support
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.product_exploration import InitialLabel, ProductExploration, TransitionTable, input_probability

Miss = Literal["empty", "hold"]


class RewardColumns(Protocol):
    """What a reward product reads of a compiled reward scheme; arrays have shape (n_states, n_letter_classes).

    There may also be `commit`, shape (n_states, n_choices): the state after choosing a pair, -1 where that cannot be;
    and `closing`, of the same shape as the others: what it is worth to read a letter for ever from a state, paid where
    the environment terminates. Without it, nothing follows there.
    """

    @property
    def aps(self) -> Sequence[str]:
        """The propositions that the tables read."""
        ...

    @property
    def letter_class(self) -> npt.NDArray[Any]:
        """Shape (2**n_aps,): the class of each letter."""
        ...

    @property
    def initial_state(self) -> int:
        """The state before any letter is read."""
        ...

    @property
    def next_state(self) -> npt.NDArray[Any]:
        """After whatever the scheme does on a deadlock."""
        ...

    @property
    def reward(self) -> npt.NDArray[Any]:
        """Paid on the step."""
        ...

    @property
    def discount(self) -> npt.NDArray[Any]:
        """Weight of what follows, in [0, 1]."""
        ...

    @property
    def stop(self) -> npt.NDArray[Any]:
        """Probability that the step ends the episode."""
        ...

    @property
    def stop_reward(self) -> npt.NDArray[Any]:
        """Paid in addition when it does."""
        ...

    @property
    def violated(self) -> npt.NDArray[Any]:
        """Whether the step enters a deadlock."""
        ...

    @property
    def accepted(self) -> npt.NDArray[Any]:
        """Whether the step is accepting."""
        ...


class _LabelledProduct(ExplicitMDP):
    """What both products share: pairs (MDP state, machine state), reachable ones only, ordered by the first.

    A terminal state of the MDP that may show several letters keeps the one drawn on entering it: then there is a pair
    for each.

    Where the machine leaves choices to the policy, action a + n * (1 + i) of an MDP with n actions is choice i together
    with action a.

    Attributes:
        mdp: the MDP.
        mdp_state, machine_state: (n_states,), the two halves of a product state.
    """

    def __init__(
        self,
        mdp: LabelledMDP,
        origin: IntArray,
        exploration: ProductExploration,
        matrix: Any,
        exit_probability: FloatArray | None,
    ) -> None:
        super().__init__(
            matrix,
            exploration.choice_start,
            exploration.choice_action,
            exploration.initial,
            exit_probability=exit_probability,
            n_actions=exploration.n_actions,
        )
        self.mdp = mdp
        self.mdp_state = origin[exploration.mdp_state].astype(np.int32)
        self.machine_state = exploration.machine_state

    def lift(self, policy: npt.ArrayLike) -> npt.NDArray[Any]:
        """A policy on MDP states, or on (MDP state, machine state), as one on product states.

        Takes int (n_mdp_states,) or (n_mdp_states, n_machine_states), or float with a last axis (n_actions,).

        Raises:
            InvalidArgumentError: another shape.
        """
        given = np.asarray(policy)
        shape = given.shape if np.issubdtype(given.dtype, np.integer) else given.shape[:-1]
        if len(shape) == 1 and shape[0] == self.mdp.n_states:
            return np.asarray(given[self.mdp_state])
        if len(shape) == 2 and shape[0] == self.mdp.n_states and shape[1] > int(self.machine_state.max()):
            return np.asarray(given[self.mdp_state, self.machine_state])
        raise InvalidArgumentError(
            f"a policy of shape {given.shape} and type {given.dtype} is neither one on {self.mdp.n_states} MDP states "
            "nor one on pairs of MDP and automaton states"
        )

    def state_index(self, mdp_state: int, machine_state: int) -> int:
        """The number of a product state (the first, of a terminal state with several letters), or -1: not reachable."""
        found = np.flatnonzero((self.mdp_state == mdp_state) & (self.machine_state == machine_state))
        return int(found[0]) if found.size else -1

    def describe(self, state: int | np.integer[Any]) -> str:
        """The product state for a message."""
        return f"{state} (MDP state {self.mdp.state_name(self.mdp_state[state])}, q{self.machine_state[state]})"


class Product(_LabelledProduct):
    """The product of a labelled MDP with a Rabin automaton, on its reachable states.

    P((s, q), a, (s', q')) = P(s, a, s') * Pr(a letter l of s' has delta(q, l) = q'). With `initial_label="read"` the
    automaton reads the label of the first state; with "skip" it starts in its raw initial state. In a terminal state of
    the MDP the letter drawn on entering is read for ever.

    Marks are kept per *choice*: a choice has a mark iff one of its branches has it. That loses nothing, since a choice
    taken infinitely often takes each of its branches infinitely often with probability 1; so letters that lead to the
    same state with different marks need no states of their own.

    With the choices of a `Refinement` (`commit`, from `limit_deterministic`), the product is that of its automaton, and
    the best policies reach the same satisfaction probability as those on the product with the original automaton.

    Attributes:
        automaton: the automaton; its states are `automaton_state` (n_states,).

    Raises:
        UnknownNameError: the automaton has a proposition that the MDP does not label.

    References:
        C. Baier, J.-P. Katoen, Principles of Model Checking, MIT Press 2008, section 10.6.4.
    """

    def __init__(
        self,
        mdp: LabelledMDP,
        automaton: RabinAutomaton,
        *,
        commit: IntArray | None = None,
        initial_label: InitialLabel = "read",
    ) -> None:
        settled, origin = mdp.with_final_letters
        table = TransitionTable(
            next_state=automaton.delta.astype(np.int64),
            goes_on=np.ones(automaton.delta.shape, dtype=np.bool_),
            initial_state=automaton.initial_state,
            input_probability=input_probability(settled, automaton.aps, automaton.letter_class),
            ends=np.zeros(settled.n_states, dtype=np.bool_),
            commit=_choices(commit),
        )
        exploration = ProductExploration(settled, table, initial_label)
        super().__init__(mdp, origin, exploration, exploration.transitions, None)
        self.automaton = automaton
        self._exploration = exploration

    @property
    def automaton_state(self) -> IntArray:
        """The automaton's half of each product state, shape (n_states,)."""
        return self.machine_state

    @cached_property
    def support(self) -> Support:
        """See `ExplicitMDP.support`; made without the transition matrix."""
        return self._graph[0]

    @cached_property
    def choice_fin(self) -> BoolArray:
        """Which choices have a Fin mark of each pair, shape (n_pairs, n_choices)."""
        return self._graph[1][:, self.support.of_choice]

    @cached_property
    def choice_inf(self) -> BoolArray:
        """Which choices have an Inf mark of each pair, shape (n_pairs, n_choices)."""
        return self._graph[2][:, self.support.of_choice]

    def expect(self, value: FloatArray) -> FloatArray:
        """See `ExplicitMDP.expect`; takes no transition matrix."""
        return self._exploration.after_step(value)

    @cached_property
    def _graph(self) -> tuple[Support, BoolArray, BoolArray]:
        """The graph, and the marks of its choices."""
        dra = self.automaton
        support, marks = self._exploration.support([*dra.edge_fin, *dra.edge_inf])
        table = np.array(marks, dtype=np.bool_).reshape(2, dra.n_pairs, support.graph.n_choices)
        return support, table[0], table[1]


class RewardProduct(_LabelledProduct):
    """The product of a labelled MDP with reward tables: what an agent in the wrapped environment experiences.

    `matrix` holds the undiscounted steps that go on; episodes end where the tables stop and in terminal states of the
    MDP (`exit_probability`), where the step is paid what reading its letter for ever is worth, besides. The automaton
    follows the tables, whatever they do on a deadlock.

    `miss="hold"` reproduces the thesis' code: where the empty letter is drawn in a state that could have shown another
    one, the automaton stays in q, and the step is paid as one that enters q.

    Attributes:
        tables: the reward tables.
        reward: (n_choices,), expected reward of a step, rewards for stopping and closing values included.
        violation, acceptance: (n_choices,), probability that the step violates / accepts.
        unaccepted_end: (n_choices,), probability that the step ends the episode without accepting.

    Raises:
        UnknownNameError: the tables have a proposition that the MDP does not label.
        InvalidArgumentError: `miss="hold"` with tables whose reward does not depend on the entered state alone.
    """

    def __init__(
        self,
        mdp: LabelledMDP,
        tables: RewardColumns,
        *,
        initial_label: InitialLabel = "read",
        miss: Miss = "empty",
    ) -> None:
        settled, origin = mdp.with_final_letters
        inputs = input_probability(settled, tuple(tables.aps), np.asarray(tables.letter_class))
        columns = {name: np.asarray(getattr(tables, name)) for name in _COLUMNS}
        columns["closing"] = np.asarray(getattr(tables, "closing", np.zeros_like(columns["reward"])))
        if miss == "hold":
            inputs = _with_held_input(mdp, settled, origin, inputs, int(tables.letter_class[0]))
            columns = _with_held_column(columns, tables.initial_state)
        elif miss != "empty":
            raise InvalidArgumentError(f'miss is {miss!r}, expected "empty" or "hold"')
        stop = columns["stop"].astype(np.float64)
        table = TransitionTable(
            next_state=columns["next_state"].astype(np.int64),
            goes_on=stop < 1,
            initial_state=int(tables.initial_state),
            input_probability=inputs,
            ends=np.zeros(settled.n_states, dtype=np.bool_) if settled.terminal is None else settled.terminal,
            commit=_choices(getattr(tables, "commit", None)),
        )
        self._exploration = ProductExploration(settled, table, initial_label)
        self._columns = columns
        matrix, exit_probability = self._exploration.transitions(1 - stop), self._exploration.ending(stop)
        super().__init__(mdp, origin, self._exploration, matrix, exit_probability)
        self.tables = tables
        final = np.take_along_axis(columns["closing"], table.next_state, axis=0)
        self.reward = self._exploration.expected(
            columns["reward"] + stop * columns["stop_reward"], (1 - stop) * columns["discount"] * final
        )
        self.violation = self.expected(columns["violated"])
        self.acceptance = self.expected(columns["accepted"])
        rejected = ~columns["accepted"].astype(np.bool_)
        self.unaccepted_end = self._exploration.ending(stop, rejected)

    def expected(self, column: npt.ArrayLike) -> FloatArray:
        """The mean of a table (n_table_states, n_letter_classes) over the outcomes of each choice, (n_choices,)."""
        return self._exploration.expected(np.asarray(column, dtype=np.float64))

    def discounted(self, discount: float | None = None) -> ExplicitMDP:
        """The process for discounted returns: with the tables' own discounts (None), or with one number instead."""
        if discount is not None:
            return self.reweighted(discount)
        weight = (1 - self._columns["stop"]) * self._columns["discount"]
        return ExplicitMDP(
            self._exploration.transitions(weight),
            self.choice_start,
            self.choice_action,
            self.initial,
            exit_probability=self._exploration.ending(1 - weight),
            n_actions=self.n_actions,
        )

    def under(self, policy: npt.ArrayLike) -> EpisodeChain:
        """The episodes under a policy on product states: int (n_states,) or float (n_states, n_actions).

        Raises:
            InvalidArgumentError: the policy does not fit the product.
        """
        return EpisodeChain(self, self.policy_matrix(policy))


class EpisodeChain(MarkovChain):
    """The Markov chain that a policy induces on a reward product, and its variants, made from the same moves.

    Args:
        product: the reward product.
        weights: the policy, as `ExplicitMDP.policy_matrix` gives it.
    """

    def __init__(self, product: RewardProduct, weights: Any) -> None:
        self._exploration, self._columns = product._exploration, product._columns
        self._goes_on = 1 - self._columns["stop"].astype(np.float64)
        self._moves = weights @ self._exploration.moves()
        self._moves.sort_indices()  # as those of the choices are, so that sums come out the same to the last bit
        steps = self._exploration.transitions(self._goes_on, self._moves)
        super().__init__(steps, product.initial, np.asarray(weights @ product.exit_probability), weights)

    def discounted(self, discount: float | None = None) -> MarkovChain:
        """See `RewardProduct.discounted`."""
        if discount is None:
            return self._variant(self._goes_on * self._columns["discount"])
        if discount == 1:
            return self
        if not 0 <= discount < 1:
            raise InvalidArgumentError(f"discount {discount} is not in [0, 1]")
        lost = self.exit_probability + (1 - discount) * np.asarray(self.matrix.sum(axis=1)).ravel()
        return MarkovChain(self.matrix * discount, self.initial, lost, self.weights)

    def until_acceptance(self) -> MarkovChain:
        """The episodes that end with their first accepting step."""
        return self._variant(self._goes_on * ~self._columns["accepted"].astype(np.bool_))

    def _variant(self, weight: FloatArray) -> MarkovChain:
        lost = self.of_choices(self._exploration.ending(1 - weight))
        return MarkovChain(self._exploration.transitions(weight, self._moves), self.initial, lost, self.weights)


_COLUMNS = ("next_state", "reward", "discount", "stop", "stop_reward", "violated", "accepted")


def _choices(commit: IntArray | None) -> IntArray | None:
    return commit if commit is not None and commit.shape[1] else None


def _with_held_input(mdp: LabelledMDP, settled: LabelledMDP, origin: IntArray, inputs: Any, empty_class: int) -> Any:
    """Moves the empty letter of states that may show another letter to a new input, the last column."""
    shown = np.asarray((mdp.label_probability @ (mdp.letters != 0).astype(np.float64)) > 0)[origin]
    missed = np.asarray(settled.label_probability @ (mdp.letters == 0).astype(np.float64)) * shown
    states = np.flatnonzero(missed)
    shape = (inputs.shape[0], inputs.shape[1] + 1)
    rows = np.repeat(np.arange(shape[0]), np.diff(inputs.indptr))
    data = np.concatenate((inputs.data, -missed[states], missed[states]))
    row = np.concatenate((rows, states, states))
    column = np.concatenate((inputs.indices, np.full(len(states), empty_class), np.full(len(states), shape[1] - 1)))
    held = sparse.csr_array((data, (row, column)), shape=shape)
    held.data[np.abs(held.data) < 1e-15] = 0
    held.eliminate_zeros()
    return held


def _with_held_column(columns: dict[str, npt.NDArray[Any]], initial_state: int) -> dict[str, npt.NDArray[Any]]:
    """The tables with one more column: stay in q, paid as a step that enters q; and for ever, where it is the last."""
    next_state = columns["next_state"]
    n_states = len(next_state)
    kept = ~columns["violated"].astype(np.bool_).ravel()  # such a step may have been turned back from the deadlock
    edge = np.flatnonzero(kept)
    edge = edge[np.argsort(next_state.ravel()[edge], kind="stable")]
    entered, first = np.unique(next_state.ravel()[edge], return_index=True)
    representative = np.zeros(n_states, dtype=np.int64)
    representative[entered] = edge[first]
    held = {}
    for name in _COLUMNS:
        table = columns[name]
        flat = table.ravel()
        column = flat[representative]
        if name == "next_state":
            column = np.arange(n_states, dtype=table.dtype)
        elif (flat[edge] != column[next_state.ravel()[edge]]).any():
            raise InvalidArgumentError(f'miss="hold" needs tables whose {name} depends on the entered state alone')
        held[name] = np.concatenate((table, column[:, None]), axis=1)
    if initial_state not in entered:
        raise InvalidArgumentError('miss="hold": no step enters the initial state, so holding it has no reward')
    reward, discount, stop, stop_reward = (held[name][:, -1] for name in ("reward", "discount", "stop", "stop_reward"))
    closing, goes_on = columns["closing"], (1 - stop) * discount
    for_ever = np.divide(reward + stop * stop_reward, 1 - goes_on, out=np.zeros(n_states), where=goes_on < 1)
    held["closing"] = np.column_stack((closing, for_ever if closing.any() else closing[:, 0]))
    return held
