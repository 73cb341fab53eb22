"""Learning with known states and accepting maximal end components, after Fu and Topcu."""

from __future__ import annotations

from functools import partial

from ..training.metrics import Row
from .config import FuTopcuConfig
from .explore import Explorer
from .learner import Found
from .planning import as_table, reach_and_stay
from .run import train_learner


class FuTopcu(Explorer):
    """Learns the transition probabilities, then reaches accepting components of the learned product and stays there.

    1. Unknown states are explored by balanced wandering, known ones are crossed on the quickest way to unknown ones.
    2. The product of the known part with the automaton, its accepting maximal end components, and value iteration give
       the policy that is most likely to reach them.
    3. It ends when unknown states can be reached with probability at most epsilon only, or steps run out.

    Rewards are not used; a task with any reward scheme will do. Where the learned product has no accepting component,
    every policy satisfies the formula with probability 0 in it, and none is returned.

    References:
        See `FuTopcuConfig`. Unlike there, the probabilities of labels are learned too, sub-environments explore in
        parallel, and policies are compared without a horizon T, ties by discount.
    """

    config: FuTopcuConfig

    @property
    def accuracy(self) -> float:
        """Error of a transition probability at which it counts as known."""
        return self.config.accuracy_for(self.experience.n_states)

    @property
    def neglect(self) -> float:
        """Probability of satisfaction that may be lost."""
        return self.config.epsilon

    def plan(self) -> Found:
        """Find the policy that is most likely to satisfy the formula in the learned product."""
        components = self.components()
        table, probability, message = None, 0.0, self.failure
        if components.n_components:
            best = reach_and_stay(components, self.known, self.config.discount)
            table, probability, message = as_table(components.product, best.policy), best.probability, self.progress
        return table, Row(
            steps=self.experience.steps,
            value=probability,
            product_states=components.product.n_states,
            accepting_components=components.n_components,
            message=message,
        )


train = partial(train_learner, FuTopcu)
"""the trainer of the registry."""
