"""The reward function of the thesis: one number each for the terminal state, deadlocks, G, B, and the rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ltlc.automata import DRA
from ltlc.rewards.scheme import OnDeadlock, RewardScheme, StepRewards, check_probability, is_accepting_sink, is_deadlock


@dataclass(frozen=True)
class Thesis(RewardScheme):
    """Equation 4.3: the state entered decides; terminal before deadlock before G before B before the rest.

    With several pairs, G and B are the unions over the pairs. Automata for one language may be paid differently, since
    the marks decide. Those translated here have no Fin marks outside the components where the pair accepts; ltl2dstar,
    which the thesis used, puts them on every transient state.

    Attributes:
        accepting: reward on entering G when the episode goes on.
        rejecting: reward on entering B.
        deadlock: reward on entering a deadlock.
        other: reward of any other step.
        terminal: reward of the step that ends the episode.
        terminate_on_accept: whether entering G ends the episode; if not, only an accepting sink does.
        gamma: discount of every step, in (0, 1].

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, equation 4.3,
        https://hdl.handle.net/10161/17056. The deadlock reward is paid on entering, before the state is reset; as
        algorithm 2 prints it, it could never be paid.
    """

    name: ClassVar[str] = "thesis"
    citation: ClassVar[str] = (
        "Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, thesis, Duke University, 2018, "
        "eq. 4.3, https://hdl.handle.net/10161/17056"
    )
    guarantee: ClassVar[str] = "None: the optimal policy depends on the automaton and need not satisfy the formula."
    requires: ClassVar[str] = "any Rabin automaton"
    on_deadlock: ClassVar[OnDeadlock] = "stay"

    accepting: float = -1.0
    rejecting: float = -10.0
    deadlock: float = -100.0
    other: float = -1.0
    terminal: float = -1.0
    terminate_on_accept: bool = True
    gamma: float = 0.99

    def __post_init__(self) -> None:
        check_probability(self, "gamma", one=True)

    def steps(self, dra: DRA) -> StepRewards:
        """Rewards by the mark of the state entered."""
        fin = dra.edge_fin.any(axis=0)
        accepted = dra.edge_inf.any(axis=0) & ~is_deadlock(dra)[dra.delta]
        ends = accepted if self.terminate_on_accept else is_accepting_sink(dra)[dra.delta]
        return StepRewards(
            accepted=accepted,
            reward=np.select([ends, accepted, fin], [self.terminal, self.accepting, self.rejecting], self.other),
            discount=self.gamma,
            stop=ends.astype(np.float64),
            violation=self.deadlock,
            satisfaction=self.terminal,
        )


@dataclass(frozen=True)
class ThesisCode(Thesis):
    """+100 for the step that ends the episode, +10 for G; a deadlock sends the automaton back to its initial state.

    References:
        Q. Gao, code of 2018 beside the thesis, https://github.com/gaoqitong/LTL_RL. The code also asks for a goal cell
        before it ends the episode; here, as in its successor of 2019, entering G is enough.
    """

    name: ClassVar[str] = "thesis-code"
    citation: ClassVar[str] = "Q. Gao, code beside the thesis, 2018, https://github.com/gaoqitong/LTL_RL"
    on_deadlock: ClassVar[OnDeadlock] = "initial"

    accepting: float = 10.0
    terminal: float = 100.0
