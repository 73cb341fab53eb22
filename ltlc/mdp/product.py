"""The product of a labelled MDP with a Rabin automaton: does the run satisfy?"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.automata.rabin import DRA
from ltlc.errors import InvalidArgumentError
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray, Support
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.product_exploration import InitialLabel, ProductExploration, TransitionTable, input_probability


class LabelledProduct(ExplicitMDP):
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


class Product(LabelledProduct):
    """The product of a labelled MDP with a Rabin automaton, on its reachable states.

    P((s, q), a, (s', q')) = P(s, a, s') * Pr(a letter l of s' has delta(q, l) = q'). With `initial_label="read"` the
    automaton reads the label of the first state; with "skip" it starts in its raw initial state. In a terminal state of
    the MDP the letter drawn on entering is read for ever.

    Marks are kept per *choice*: a choice has a mark iff one of its branches has it. That loses nothing, since a choice
    taken infinitely often takes each of its branches infinitely often with probability 1; so letters that lead to the
    same state with different marks need no states of their own.

    With the choices of a `Refinement` (`select_pair`, from `limit_deterministic`), the product is that of its
    automaton, and the best policies reach the same satisfaction probability as those on the product with the original
    automaton.

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
        automaton: DRA,
        *,
        select_pair: IntArray | None = None,
        initial_label: InitialLabel = "read",
    ) -> None:
        stabilized, origin = mdp.with_final_letters
        table = TransitionTable(
            next_state=automaton.delta.astype(np.int64),
            goes_on=np.ones(automaton.delta.shape, dtype=np.bool_),
            initial_state=automaton.initial_state,
            input_probability=input_probability(stabilized, automaton.aps, automaton.letter_class, automaton.possible),
            ends=np.zeros(stabilized.n_states, dtype=np.bool_),
            select_pair=select_pair,
        )
        exploration = ProductExploration(stabilized, table, initial_label)
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
