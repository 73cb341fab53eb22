"""Tabular learners by name; how each learns is imported when it does, since that loads PyTorch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from .config import FuTopcuConfig, LearnerConfig, QLearningConfig, SadighConfig, WangConfig
from .learned import Learned


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


def _q_learning(*args: Any, **options: Any) -> Learned:
    from .q_learning import train_q_learning

    return train_q_learning(*args, **options)


def _fu_topcu(*args: Any, **options: Any) -> Learned:
    from .fu_topcu import train_fu_topcu

    return train_fu_topcu(*args, **options)


def _sadigh(*args: Any, **options: Any) -> Learned:
    from .sadigh import train_sadigh

    return train_sadigh(*args, **options)


def _wang(*args: Any, **options: Any) -> Learned:
    from .wang import train_wang

    return train_wang(*args, **options)


_ALL = (
    Learner(
        "q-learning",
        "C. Watkins, P. Dayan, Machine Learning 8, 1992, doi 10.1007/BF00992698",
        "Values of the rewards of the task, taught to every automaton state at each step.",
        QLearningConfig(),
        _q_learning,
        uses_rewards=True,
    ),
    Learner(
        "double-q-learning",
        "H. van Hasselt, Double Q-learning, NeurIPS 2010",
        "Q-learning with two tables, one to choose the next action and the other to value it.",
        QLearningConfig(double=True),
        _q_learning,
        uses_rewards=True,
    ),
    Learner(
        "fu-topcu",
        "J. Fu, U. Topcu, RSS 2014, doi 10.15607/RSS.2014.X.039",
        "Transition probabilities with known states, and the way to accepting end components of the learned product.",
        FuTopcuConfig(),
        _fu_topcu,
    ),
    Learner(
        "sadigh",
        "D. Sadigh et al., CDC 2014, doi 10.1109/CDC.2014.7039527",
        "Rewards from the sets of a Rabin pair, and temporal differences on a learned model.",
        SadighConfig(),
        _sadigh,
    ),
    Learner(
        "wang",
        "J. Wang et al., IJRR 34(10), 2015, doi 10.1177/0278364915581505",
        "A randomised policy towards accepting end components of the learned product, by actor and critic.",
        WangConfig(),
        _wang,
    ),
)
LEARNERS: Mapping[str, Learner] = MappingProxyType({learner.name: learner for learner in _ALL})
"""every tabular learner, by the name that the command line knows."""
