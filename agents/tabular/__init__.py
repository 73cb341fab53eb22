"""Tabular learners: Q-learning, and the systems that the thesis compares itself with."""

from .experience import Experience
from .fu_topcu import FuTopcuConfig, train_fu_topcu
from .learned import Callback, Learned
from .model import EmpiricalModel
from .q_learning import QLearningConfig, train_q_learning
from .registry import LEARNERS, Learner
from .sadigh import SadighConfig, train_sadigh
from .wang import WangConfig, train_wang

__all__ = [
    "LEARNERS",
    "Callback",
    "EmpiricalModel",
    "Experience",
    "FuTopcuConfig",
    "Learned",
    "Learner",
    "QLearningConfig",
    "SadighConfig",
    "WangConfig",
    "train_fu_topcu",
    "train_q_learning",
    "train_sadigh",
    "train_wang",
]
