"""The accepting frontier: each acceptance set pays once, until all have been visited."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.automata import DRA, Refinement
from ltlc.errors import InvalidArgumentError
from ltlc.rewards.buchi_scheme import BuchiScheme, discounted_acceptances
from ltlc.rewards.closing import closed
from ltlc.rewards.forms import buchi, buchi_form, with_buchi_marks
from ltlc.rewards.scheme import (
    OnDeadlock,
    StepRewards,
    check_on_deadlock,
    tables_of,
)
from ltlc.rewards.tables import BoolArray, OnTermination, RewardTables


@dataclass(frozen=True)
class Frontier(BuchiScheme):
    """Entering a set that is still in the frontier pays 1 and removes it; an empty frontier is filled again.

    Table states are (automaton state, frontier). The sets are those of a generalized Büchi condition on the states of
    the automaton, given as `sets`; without them, the one set of the Büchi form is used.

    Attributes:
        eta: discount of rewarded steps, in (0, 1).
        sets: sets of automaton states, each to be visited infinitely often.

    References:
        M. Hasanbeig, D. Kroening, A. Abate, LCRL: certified policy synthesis via logically-constrained reinforcement
        learning, QEST 2022, doi 10.1007/978-3-031-16336-4_11. Unlike its code, the episode does not end when the
        frontier empties, since that would teach to visit each set once.
    """

    name: ClassVar[str] = "frontier"
    citation: ClassVar[str] = "M. Hasanbeig et al., QEST 2022, doi 10.1007/978-3-031-16336-4_11"
    guarantee: ClassVar[str] = (
        "The paper claims policies of maximum probability of satisfaction for eta near enough to 1 on a finite MDP."
    )
    limit_parameter: ClassVar[str] = "eta"
    requires: ClassVar[str] = "generalized Büchi form: Büchi form, or acceptance sets given as `sets`"

    eta: float = 0.99
    sets: tuple[frozenset[int], ...] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sets is not None and not 0 < len(self.sets) <= 16:
            raise InvalidArgumentError(f"reward scheme frontier: {len(self.sets)} sets; give 1 to 16")

    def payments(self, accepted: BoolArray) -> StepRewards:
        """The value of accepting for ever is 1 / (1 - eta)."""
        return discounted_acceptances(accepted, self.eta)

    def steps(self, dra: DRA) -> StepRewards:
        """Steps on an automaton whose Inf marks are the rewarded edges."""
        return self.payments(dra.edge_inf[0])

    def refinement(self, dra: DRA) -> Refinement:
        """The Büchi form, with its accepting edges as Inf marks."""
        form = buchi_form(dra)
        marked = with_buchi_marks(form.automaton, buchi(self, form.automaton))
        return dataclasses.replace(form, automaton=marked)

    def compile(
        self,
        dra: DRA,
        on_deadlock: OnDeadlock | None = None,
        on_termination: OnTermination = "repeat",
    ) -> RewardTables:
        """The tables, over (automaton state, frontier) where sets are given; see `RewardScheme.compile`."""
        if self.sets is None:
            return super().compile(dra, on_deadlock, on_termination)
        mode = check_on_deadlock(self.on_deadlock if on_deadlock is None else on_deadlock)
        refined, automaton_state = _with_frontier(dra, self._edges(dra, self.sets))
        tables = tables_of(refined, Refinement.trivial(refined), self.steps(refined), mode)
        return closed(dataclasses.replace(tables, automaton_state=automaton_state), on_termination)

    def _edges(self, dra: DRA, sets: Iterable[frozenset[int]]) -> list[BoolArray]:
        for states in sets:
            if not all(0 <= q < dra.n_states for q in states):
                raise InvalidArgumentError(
                    f"reward scheme frontier: set {sorted(states)} names a state outside 0..{dra.n_states - 1}"
                )
        return [np.isin(dra.delta, sorted(states)) for states in sets]


def _with_frontier(dra: DRA, edges: Sequence[BoolArray]) -> tuple[DRA, np.ndarray]:
    """The reachable (state, frontier) automaton with Inf marks on rewarded edges, and the state behind each of its."""
    entered = np.tensordot(1 << np.arange(len(edges)), np.array(edges, dtype=np.int64), axes=1)
    full = (1 << len(edges)) - 1
    number = {(dra.initial_state, full): 0}
    todo = [(dra.initial_state, full)]
    rows, rewarded = [], []
    for state, frontier in todo:  # grows while it is read
        hit = entered[state] & frontier
        left = np.where(hit == frontier, full, frontier & ~hit)
        row = []
        for target in zip(dra.delta[state].tolist(), left.tolist(), strict=True):
            if target not in number:
                number[target] = len(todo)
                todo.append(target)
            row.append(number[target])
        rows.append(row)
        rewarded.append(hit != 0)
    inf = np.array([rewarded])
    refined = dataclasses.replace(
        dra,
        delta=np.array(rows),
        fin=np.zeros_like(inf),
        inf=inf,
        initial_state=0,
        acceptance="transition",
        state_names=None,
    )
    return refined, np.array([state for state, _ in todo], dtype=np.int32)
