"""The product of a labelled MDP with reward tables: what is paid?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.automata.possible import LetterNumbers
from ltlc.errors import InvalidArgumentError
from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.explicit import ExplicitMDP, FloatArray, IntArray
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.product import LabelledProduct
from ltlc.mdp.product_exploration import InitialLabel, ProductExploration, TransitionTable, input_probability

Miss = Literal["empty", "hold"]


class RewardColumns(Protocol):
    """What a reward product reads of a compiled reward scheme; arrays have shape (n_states, n_letter_classes).

    There may also be `select_pair`, shape (n_states, n_choices): the state after choosing a pair, -1 where that cannot
    be; and `closing`, of the same shape as the others: what it is worth to read a letter for ever from a state, paid
    where the environment terminates. Without it, nothing follows there.
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


class RewardProduct(LabelledProduct):
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
        stabilized, origin = mdp.with_final_letters
        possible = getattr(tables, "possible", None)
        inputs = input_probability(stabilized, tuple(tables.aps), np.asarray(tables.letter_class), possible)
        columns = {name: np.asarray(getattr(tables, name)) for name in _COLUMNS}
        columns["closing"] = np.asarray(getattr(tables, "closing", np.zeros_like(columns["reward"])))
        if miss == "hold":
            empty_class = int(tables.letter_class[LetterNumbers(tuple(tables.aps), possible).number(0)])
            inputs = _with_held_input(
                mdp,
                stabilized,
                origin,
                inputs,
                empty_class,
            )
            columns = _with_held_column(columns, tables.initial_state)
        elif miss != "empty":
            raise InvalidArgumentError(f'miss is {miss!r}, expected "empty" or "hold"')
        stop = columns["stop"].astype(np.float64)
        table = TransitionTable(
            next_state=columns["next_state"].astype(np.int64),
            goes_on=stop < 1,
            initial_state=int(tables.initial_state),
            input_probability=inputs,
            ends=np.zeros(stabilized.n_states, dtype=np.bool_) if stabilized.terminal is None else stabilized.terminal,
            select_pair=getattr(tables, "select_pair", None),
        )
        self._exploration = ProductExploration(stabilized, table, initial_label)
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


def _with_held_input(mdp: LabelledMDP, stabilized: LabelledMDP, origin: IntArray, inputs: Any, empty_class: int) -> Any:
    """Moves the empty letter of states that may show another letter to a new input, the last column."""
    shown = np.asarray((mdp.label_probability @ (mdp.letters != 0).astype(np.float64)) > 0)[origin]
    missed = np.asarray(stabilized.label_probability @ (mdp.letters == 0).astype(np.float64)) * shown
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
