"""Systematic exploration: balanced wandering where little is known, and the way there where much is."""

from __future__ import annotations

from typing import Any

import numpy as np

from ltlc.mdp import max_reachability, policy_iteration

from ..training.contents import Content
from .config import ExplorerConfig
from .experience import BoolArray, Experience, IntArray
from .learner import TabularLearner
from .model import EmpiricalModel
from .planning import NOTHING_TO_REACH, Components, accepting_components, cut

DISCOUNT = 0.99
"""how soon to arrive at unknown states."""


class Explorer(TabularLearner):
    """Explores until every state that can be reached is known.

    In an unknown state, the action that was tried least; in a known one, the quickest way to an unknown one that the
    model has.

    Args:
        experience: the environment.
        config: hyperparameters.

    Attributes:
        model: what has been counted.
        known: (n_states,), bool; as of the last `refresh`.
        finished: whether exploration is over.

    References:
        M. Kearns, S. Singh, Near-optimal reinforcement learning in polynomial time, Machine Learning 49, 2002,
        doi 10.1023/A:1017984413808 (balanced wandering, known states).
    """

    def __init__(self, experience: Experience, config: ExplorerConfig) -> None:
        super().__init__(experience, config)
        self.model = EmpiricalModel(experience)
        self.known: BoolArray = np.zeros(experience.n_states, dtype=np.bool_)
        self._way: IntArray = np.zeros(experience.n_states, dtype=np.int64)
        self.finished = False

    @property
    def accuracy(self) -> float:
        """Error of a transition probability at which it counts as known."""
        return float(self.config.accuracy)

    @property
    def neglect(self) -> float:
        """Exploration is over where unknown states can be reached with less than this probability, in [0, 1)."""
        return 0.0

    @property
    def done(self) -> bool:
        """Whether exploration is over, or the steps are."""
        return self.finished or super().done

    @property
    def progress(self) -> str:
        """How much is known, as a sentence."""
        return f"{int(self.known.sum())} of {self.model.n_states} states are known"

    @property
    def failure(self) -> str:
        """Why there is no policy, where the learned product has no accepting end component."""
        if self.finished:
            return f"{self.progress}; {NOTHING_TO_REACH}"
        return f"{self.progress} to within {self.accuracy:g}, too few; allow more steps, or a larger accuracy"

    def step(self) -> None:
        """Make `refresh_every` steps in each sub-environment, then see what has become known."""
        for _ in range(self.config.refresh_every):
            state = self.experience.state
            tried = self.model.visits[state] + self.generator.random((len(state), self.model.n_actions))
            actions = np.where(self.known[state], self._way[state], tried.argmin(axis=1))
            self.model.add(self.experience.step(actions))
        self.refresh()

    def refresh(self) -> None:
        """See what has become known, and plan the ways to what has not."""
        model = self.model
        self.known = model.known(self.accuracy, self.config.delta)
        learned = model.labelled_mdp().explicit
        process = cut(learned, self.known[learned.choice_state])
        target = ~self.known
        chance = float(process.initial @ max_reachability(process, target).value)
        self.finished = chance <= self.neglect
        entering = np.asarray(process.matrix @ target.astype(np.float64))
        self._way = np.asarray(policy_iteration(process, entering, discount=DISCOUNT).policy, dtype=np.int64)

    def components(self) -> Components:
        """Find the accepting end components of the learned product, among the known states."""
        product = self.experience.product(self.model.labelled_mdp())
        return accepting_components(product, self.known, self.config.discount)

    def state_dict(self) -> dict[str, Any]:
        """Return the counts; what is known follows from them."""
        return self.model.state_dict()

    def load_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file, and go back to it."""
        self.model.load_state(content)
        self.refresh()
