"""Agents that learn a task: fitted Q iteration, double DQN and tabular learners on a product with an automaton.

`train` trains any of them; `register_agent` adds one. The names below are imported on first use, so that listing agents
and drawing policies need no PyTorch.

Examples: docs/examples.md.
"""

from typing import TYPE_CHECKING

from ltlc.lazy import on_first_use

if TYPE_CHECKING:
    from .agent import Agent
    from .choice import Choice, choose_agent
    from .config import AgentConfig, OffPolicyConfig
    from .double_dqn.agent import DoubleDQN
    from .double_dqn.config import DQNConfig
    from .fitted_q.agent import FittedQ
    from .fitted_q.config import FittedQConfig
    from .registry import AGENTS, AgentEntry, register_agent
    from .training.evaluate import Evaluation, EvaluationCallback, Rollouts, greedy_policy, rollout
    from .training.loop import train
    from .training.progress import Callback, Progress, TrainingResult
    from .training.storage import CHECKPOINT_FILE, POLICY_FILE
    from .value_agent import ValueAgent

__all__ = [
    "AGENTS",
    "CHECKPOINT_FILE",
    "POLICY_FILE",
    "Agent",
    "AgentConfig",
    "AgentEntry",
    "Callback",
    "Choice",
    "DQNConfig",
    "DoubleDQN",
    "Evaluation",
    "EvaluationCallback",
    "FittedQ",
    "FittedQConfig",
    "OffPolicyConfig",
    "Progress",
    "Rollouts",
    "TrainingResult",
    "ValueAgent",
    "choose_agent",
    "greedy_policy",
    "register_agent",
    "rollout",
    "train",
]

_HOME = {
    "agent": ("Agent",),
    "choice": ("Choice", "choose_agent"),
    "config": ("AgentConfig", "OffPolicyConfig"),
    "double_dqn.agent": ("DoubleDQN",),
    "double_dqn.config": ("DQNConfig",),
    "fitted_q.agent": ("FittedQ",),
    "fitted_q.config": ("FittedQConfig",),
    "registry": ("AGENTS", "AgentEntry", "register_agent"),
    "training.evaluate": ("Evaluation", "EvaluationCallback", "Rollouts", "greedy_policy", "rollout"),
    "training.loop": ("train",),
    "training.progress": ("Callback", "Progress", "TrainingResult"),
    "training.storage": ("CHECKPOINT_FILE", "POLICY_FILE"),
    "value_agent": ("ValueAgent",),
}
"""public names by the module that they are in."""


if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = on_first_use(__name__, {name: f".{home}" for home, names in _HOME.items() for name in names})


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
