"""The bundled reinforcement-learning agent: Q-learning, deep or tabular, on a product of environment and automaton.

The names below are imported on first use, so that listing agents and drawing policies need no PyTorch.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .double_dqn.agent import DoubleDQN
    from .double_dqn.config import DQNConfig
    from .training.evaluate import ExactJudge, Regret, Rollouts, greedy_policy, rollout
    from .training.loop import CHECKPOINT_FILE, POLICY_FILE, Progress, TrainingResult, train

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
    "CHECKPOINT_FILE": "training.loop",
    "POLICY_FILE": "training.loop",
    "DQNConfig": "double_dqn.config",
    "DoubleDQN": "double_dqn.agent",
    "ExactJudge": "training.evaluate",
    "Progress": "training.loop",
    "Regret": "training.evaluate",
    "Rollouts": "training.evaluate",
    "TrainingResult": "training.loop",
    "greedy_policy": "training.evaluate",
    "rollout": "training.evaluate",
    "train": "training.loop",
}


if not TYPE_CHECKING:  # a type checker would take every name for an attribute

    def __getattr__(name: str) -> object:
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = globals()[name] = getattr(_import_module(f".{_HOME[name]}", __name__), name)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
