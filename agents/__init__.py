"""The bundled reinforcement-learning agent: Q-learning, deep or tabular, on a product of environment and automaton.

The names below are imported on first use, so that listing agents and drawing policies need no PyTorch.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .config import DQNConfig
    from .dqn import DoubleDQN
    from .evaluate import ExactJudge, Regret, Rollouts, greedy_policy, rollout
    from .training import CHECKPOINT_FILE, POLICY_FILE, Progress, TrainingResult, train

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

_HOME = {
    "CHECKPOINT_FILE": "training",
    "POLICY_FILE": "training",
    "DQNConfig": "config",
    "DoubleDQN": "dqn",
    "ExactJudge": "evaluate",
    "Progress": "training",
    "Regret": "evaluate",
    "Rollouts": "evaluate",
    "TrainingResult": "training",
    "greedy_policy": "evaluate",
    "rollout": "evaluate",
    "train": "training",
}


if not TYPE_CHECKING:  # a type checker would take every name for an attribute

    def __getattr__(name: str) -> object:
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = globals()[name] = getattr(_import_module(f".{_HOME[name]}", __name__), name)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
