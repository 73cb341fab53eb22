"""Systematic exploration: balanced wandering where little is known, and the way there where much is."""

from __future__ import annotations

import numpy as np

from ltlc.mdp import max_reachability, policy_iteration

from .experience import BoolArray, Experience, IntArray
from .model import EmpiricalModel
from .planning import NOTHING_TO_REACH, cut

DISCOUNT = 0.99
"""how soon to arrive at unknown states."""


class Explorer:
    """Explores until every state that can be reached is known.

    In an unknown state, the action that was tried least; in a known one, the quickest way to an unknown one that the
    model has.

    Args:
        experience: the environment.
        accuracy: see `EmpiricalModel.known`.
        delta: see `EmpiricalModel.known`.
        neglect: exploration is over where unknown states can be reached with less than this probability, in [0, 1).
        generator: breaks ties.

    Attributes:
        model: what has been counted.
        known: (n_states,), bool; as of the last `refresh`.
        finished: whether exploration is over.

    References:
        M. Kearns, S. Singh, Near-optimal reinforcement learning in polynomial time, Machine Learning 49, 2002,
        doi 10.1023/A:1017984413808 (balanced wandering, known states).
    """

    def __init__(
        self, experience: Experience, accuracy: float, delta: float, neglect: float, generator: np.random.Generator
    ) -> None:
        self.model = EmpiricalModel(experience)
        self._experience, self._generator = experience, generator
        self._accuracy, self._delta, self._neglect = accuracy, delta, neglect
        self.known: BoolArray = np.zeros(experience.n_states, dtype=np.bool_)
        self._way: IntArray = np.zeros(experience.n_states, dtype=np.int64)
        self.finished = False

    @property
    def progress(self) -> str:
        """How much is known, as a sentence."""
        return f"{int(self.known.sum())} of {self.model.n_states} states are known"

    @property
    def failure(self) -> str:
        """Why there is no policy, where the learned product has no accepting end component."""
        if self.finished:
            return f"{self.progress}; {NOTHING_TO_REACH}"
        return f"{self.progress} to within {self._accuracy:g}, too few; allow more steps, or a larger accuracy"

    def step(self) -> None:
        """One step in each sub-environment."""
        state = self._experience.state
        tried = self.model.visits[state] + self._generator.random((len(state), self.model.n_actions))
        actions = np.where(self.known[state], self._way[state], tried.argmin(axis=1))
        self.model.add(self._experience.step(actions))

    def refresh(self) -> None:
        """See what has become known, and plan the ways to what has not."""
        model = self.model
        self.known = model.known(self._accuracy, self._delta)
        learned = model.labelled_mdp().explicit
        process = cut(learned, self.known[learned.choice_state])
        target = ~self.known
        chance = float(process.initial @ max_reachability(process, target).value)
        self.finished = chance <= self._neglect
        entering = np.asarray(process.matrix @ target.astype(np.float64))
        self._way = np.asarray(policy_iteration(process, entering, discount=DISCOUNT).policy, dtype=np.int64)
