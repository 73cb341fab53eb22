"""What a training run depends on: its configuration, the identity that follows from it, and what nobody says."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ltlc import formats
from ltlc.automata import DRA
from ltlc.envs.spec import EnvSpec
from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.rewards import RECOMMENDED, OnDeadlock, OnTermination, get_scheme
from ltlc.task import Task
from ltlc.version import __version__

from ..config import AgentConfig
from ..fitted_q.config import FittedQConfig
from ..registry import DOUBLE_DQN, FITTED_Q, hyperparameters

_FORMAT = 4
MOST_ENVS = 64
"""environments stepped together where nobody says how many."""
EPISODES_EACH = 4
"""episodes that at least end in each of them, if there are enough steps for one."""
_NOT_LEARNED = ("ltlc", "run", "agent_reason", "workers")


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """Everything that a training run depends on, but for the automaton."""

    env_spec: EnvSpec
    reward: str = RECOMMENDED
    """name of the reward scheme."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """of the reward scheme, `shaping` included; the others have their defaults."""
    on_deadlock: OnDeadlock | None = None
    on_termination: OnTermination = "repeat"
    num_envs: int = MOST_ENVS
    """environments stepped together."""
    agent: str = FITTED_Q
    """name of what learns."""
    hyperparameters: AgentConfig = field(default_factory=FittedQConfig)
    """of the agent."""
    agent_reason: str | None = None
    """why this agent was chosen; None: somebody named it."""
    workers: int = 0
    """processes that step the environments; 0: none. What is learned does not depend on them."""

    def task(self, automaton: DRA) -> Task:
        """The task of an automaton with these rewards.

        Raises:
            UnknownNameError: there is no such scheme or parameter.
            InvalidArgumentError: a parameter is out of range, or does not fit the automaton.
        """
        scheme = get_scheme(self.reward, **self.parameters)
        return Task(automaton, scheme, on_deadlock=self.on_deadlock, on_termination=self.on_termination)

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        return {
            "format": _FORMAT,
            "ltlc": __version__,
            "env_spec": self.env_spec.to_dict(),
            "reward": self.reward,
            "parameters": dict(self.parameters),
            "on_deadlock": self.on_deadlock,
            "on_termination": self.on_termination,
            "num_envs": self.num_envs,
            "agent": self.agent,
            "agent_reason": self.agent_reason,
            "workers": self.workers,
            "hyperparameters": self.hyperparameters.to_dict(),
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> RunConfig:
        """The inverse of `to_dict`.

        Raises:
            FileFormatError: it is of a later version.
            LtlcError, KeyError, TypeError: it is something else.
        """
        if values["format"] != _FORMAT:
            raise FileFormatError(f"format {values['format']!r}; this version reads format {_FORMAT}")
        fields = _of_kinds({"workers": 0} | dict(values), {"reward": str, "parameters": dict, "on_deadlock": str | None,
                                    "on_termination": str, "num_envs": int, "agent": str, "env_spec": dict,
                                    "hyperparameters": dict, "agent_reason": str | None,
                                    "workers": int})  # fmt: skip
        config = hyperparameters(fields["agent"], fields["hyperparameters"])
        kinds: dict[str, Any] = {"env": str, "arguments": dict, "labels": str | None, "max_episode_steps": int | None,
                                 "initial_label": str, "discretise": int | None}  # fmt: skip
        _of_kinds({"discretise": None} | fields["env_spec"], kinds)
        return cls(**fields | {"env_spec": EnvSpec(**fields["env_spec"]), "hyperparameters": config})

    def differences(self, other: RunConfig) -> list[str]:
        """Name the fields in which another run would learn something else."""
        before, now = _what_is_learned(self.to_dict()), _what_is_learned(other.to_dict())
        return [key for key in now if now[key] != before[key]]

    def on_device(self, device: str) -> RunConfig:
        """Return the same run on another device.

        Raises:
            InvalidArgumentError: the agent has no device.
        """
        if not hasattr(self.hyperparameters, "device"):
            raise InvalidArgumentError(
                f"tables stay in main memory; a device ({device}) is for the agent {DOUBLE_DQN!r}"
            )
        changed: Any = replace(self.hyperparameters, device=device)  # type: ignore[call-arg]
        return replace(self, hyperparameters=changed)


def _of_kinds(values: Mapping[str, Any], kinds: Mapping[str, Any]) -> dict[str, Any]:
    """The values with these names, each of which must be of its kind."""
    for key, kind in kinds.items():
        if not isinstance(values[key], kind) or (isinstance(values[key], bool) and kind is not bool):
            raise FileFormatError(f"{key} is {values[key]!r}")
    return {key: values[key] for key in kinds}


def _what_is_learned(config: Mapping[str, Any]) -> dict[str, Any]:
    """What a configuration says about what is learned: all but the version, the reason, device, threads, identity."""
    values: dict[str, Any] = json.loads(json.dumps({key: config[key] for key in config if key not in _NOT_LEARNED}))
    for name in ("device", "threads"):
        values["hyperparameters"].pop(name, None)
    return values


def identity(config: Mapping[str, Any], automaton: DRA) -> str:
    """The identity of a run, which all its files carry."""
    text = json.dumps(_what_is_learned(config), sort_keys=True) + formats.to_json(automaton)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


def num_envs_for(total_steps: int, episode_steps: int) -> int:
    """How many environments to step together, so that several episodes end in each.

    Args:
        total_steps: environment steps of the training.
        episode_steps: where episodes are cut.
    """
    return max(1, min(MOST_ENVS, total_steps // (EPISODES_EACH * episode_steps)))


def default_folder(name: str, env: str, seed: int, agent: str = FITTED_Q) -> Path:
    """`runs/<task>-<environment>-<agent>-<seed>`, in characters that every file system takes.

    Without the agent, if it is one that is chosen where nobody names one.
    """
    parts = (name, env.rpartition("/")[2], "" if agent in (FITTED_Q, DOUBLE_DQN) else agent)
    task, env_part, who = (re.sub(r"[^a-z0-9]+", "-", part.lower()).strip("-") for part in parts)
    return Path("runs") / "-".join(filter(None, (task[:40].strip("-"), env_part, who, str(seed))))
