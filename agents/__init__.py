"""The bundled reinforcement-learning agent: Q-learning, deep or tabular, on a product of environment and automaton."""

from .config import DQNConfig
from .dqn import DoubleDQN
from .evaluate import ExactJudge, Regret, Rollouts, greedy_policy, rollout
from .train import CHECKPOINT_FILE, POLICY_FILE, Progress, TrainingResult, train

__all__ = [
    "CHECKPOINT_FILE",
    "POLICY_FILE",
    "DQNConfig",
    "DoubleDQN",
    "ExactJudge",
    "Progress",
    "Regret",
    "Rollouts",
    "TrainingResult",
    "greedy_policy",
    "rollout",
    "train",
]
