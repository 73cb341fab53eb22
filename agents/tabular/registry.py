"""Tabular learners by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .config import LearnerConfig
from .fu_topcu import FuTopcuConfig, train_fu_topcu
from .learned import Learned
from .q_learning import QLearningConfig, train_q_learning
from .sadigh import SadighConfig, train_sadigh
from .wang import WangConfig, train_wang


@dataclass(frozen=True)
class Learner:
    """One way to learn a policy with tables."""

    name: str
    citation: str
    description: str
    """one sentence."""
    config: LearnerConfig
    """default hyperparameters."""
    train: Callable[..., Learned]
    """called as train(env, config, callback=...)."""
    uses_rewards: bool = False
    """whether it learns from the rewards of the task, and its policy is over their states; others go by the automaton
    alone."""


_ALL = (
    Learner(
        "q-learning",
        "C. Watkins, P. Dayan, Machine Learning 8, 1992, doi 10.1007/BF00992698",
        "Values of the rewards of the task, taught to every automaton state at each step.",
        QLearningConfig(),
        train_q_learning,
        uses_rewards=True,
    ),
    Learner(
        "double-q-learning",
        "H. van Hasselt, Double Q-learning, NeurIPS 2010",
        "Q-learning with two tables, one to choose the next action and the other to value it.",
        QLearningConfig(double=True),
        train_q_learning,
        uses_rewards=True,
    ),
    Learner(
        "fu-topcu",
        "J. Fu, U. Topcu, RSS 2014, doi 10.15607/RSS.2014.X.039",
        "Transition probabilities with known states, and the way to accepting end components of the learned product.",
        FuTopcuConfig(),
        train_fu_topcu,
    ),
    Learner(
        "sadigh",
        "D. Sadigh et al., CDC 2014, doi 10.1109/CDC.2014.7039527",
        "Rewards from the sets of a Rabin pair, and temporal differences on a learned model.",
        SadighConfig(),
        train_sadigh,
    ),
    Learner(
        "wang",
        "J. Wang et al., IJRR 34(10), 2015, doi 10.1177/0278364915581505",
        "A randomised policy towards accepting end components of the learned product, by actor and critic.",
        WangConfig(),
        train_wang,
    ),
)
LEARNERS: Mapping[str, Learner] = MappingProxyType({learner.name: learner for learner in _ALL})
"""every tabular learner, by the name that the command line knows."""
