"""Tabular learners: Q-learning, and the systems that the thesis compares itself with.

Each learns in a module of its own, which is imported when `Learner.train` is called; listing them needs no PyTorch.
"""

from .config import FuTopcuConfig, QLearningConfig, SadighConfig, WangConfig
from .learned import Callback, Learned
from .registry import LEARNERS, Learner

__all__ = [
    "LEARNERS",
    "Callback",
    "FuTopcuConfig",
    "Learned",
    "Learner",
    "QLearningConfig",
    "SadighConfig",
    "WangConfig",
]
