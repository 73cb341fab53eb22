"""The bundled reinforcement-learning agent: deep Q-learning on the product of an environment and an automaton."""

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
