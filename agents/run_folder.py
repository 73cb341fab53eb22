"""A run folder: what was to be learned, how far it has come, what came out, and pictures.

config.json       the task, the environment and the hyperparameters
dra.json          the automaton
metrics.csv       a row every now and then
checkpoint.ltlc   to go on from (double DQN)
policy.ltlc       what has been learned
result.json       the verdict
policy.png        the policy on the map, one panel per automaton state (environments with a map)
curve.png         return over the steps
dra.svg           the automaton (where Graphviz or graphviz-pure is installed)
"""

from __future__ import annotations

import csv
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ltlc import formats
from ltlc.atomic import atomic_write
from ltlc.automata import RabinAutomaton
from ltlc.envs import LTLVectorWrapper
from ltlc.envs.setting import Setting
from ltlc.errors import FileFormatError, InvalidArgumentError, LtlcError, MissingProgramError
from ltlc.mdp.verdict import Judge
from ltlc.rewards import RECOMMENDED, OnDeadlock, OnTermination, get_scheme
from ltlc.task import Task
from ltlc.version import __version__

from . import systems
from .config import DQNConfig
from .metrics import METRICS_FILE
from .systems import DOUBLE_DQN, Agent, Callback, Hyperparameters, Trained
from .training import CHECKPOINT_FILE, POLICY_FILE

CONFIG_FILE = "config.json"
AUTOMATON_FILE = "dra.json"
AUTOMATON_PICTURE = "dra.svg"
RESULT_FILE = "result.json"
POLICY_PICTURE = "policy.png"
CURVE_PICTURE = "curve.png"
_FILES = (CONFIG_FILE, AUTOMATON_FILE, METRICS_FILE, CHECKPOINT_FILE, POLICY_FILE, RESULT_FILE, POLICY_PICTURE,
          CURVE_PICTURE, AUTOMATON_PICTURE)  # fmt: skip
_FORMAT = 2


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """Everything that a training run depends on, but for the automaton."""

    setting: Setting
    reward: str = RECOMMENDED
    """name of the reward scheme."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """of the reward scheme, `shaping` included; the others have their defaults."""
    on_deadlock: OnDeadlock | None = None
    on_termination: OnTermination = "repeat"
    num_envs: int = 64
    """environments stepped together."""
    agent: str = DOUBLE_DQN
    """name of what learns."""
    hyperparameters: Hyperparameters = field(default_factory=DQNConfig)
    """of the agent."""

    def task(self, automaton: RabinAutomaton) -> Task:
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
            "setting": self.setting.to_dict(),
            "reward": self.reward,
            "parameters": dict(self.parameters),
            "on_deadlock": self.on_deadlock,
            "on_termination": self.on_termination,
            "num_envs": self.num_envs,
            "agent": self.agent,
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
        kinds = {"reward": str, "parameters": dict, "on_deadlock": str | None, "on_termination": str, "num_envs": int,
                 "agent": str}  # fmt: skip
        values = {"on_termination": "cut", **values}  # what runs did that do not say
        fields = {key: values[key] for key in kinds}
        for key, kind in kinds.items():
            if not isinstance(fields[key], kind):
                raise FileFormatError(f"{key} is {fields[key]!r}")
        config = systems.hyperparameters(values["agent"], values["hyperparameters"])
        return cls(setting=Setting(**values["setting"]), hyperparameters=config, **fields)


class RunFolder:
    """A training run on disk; see the head of this module for its files."""

    def __init__(self, path: str | os.PathLike[str], config: RunConfig, automaton: RabinAutomaton) -> None:
        self.path = Path(path)
        self.config = config
        self.automaton = automaton
        self.task = config.task(automaton)

    @classmethod
    def create(
        cls, path: str | os.PathLike[str], config: RunConfig, automaton: RabinAutomaton, *, force: bool = False
    ) -> RunFolder:
        """Begin a run; `force` removes the files of an older one.

        Raises:
            InvalidArgumentError: the folder holds a run already, or is a file.
            OSError: it cannot be written.
        """
        run = cls(path, config, automaton)
        if run.path.exists() and not run.path.is_dir():
            raise InvalidArgumentError(f"{run.path} is a file; give a folder for the run")
        if (run.path / CONFIG_FILE).exists() and not force:
            raise InvalidArgumentError(
                f"{run.path} holds a training run; go on with it by --resume, replace it by --force, or give another "
                "folder with --out"
            )
        run.path.mkdir(parents=True, exist_ok=True)
        for name in _FILES:
            (run.path / name).unlink(missing_ok=True)
        formats.write(automaton, run.path / AUTOMATON_FILE)
        run._write_json(CONFIG_FILE, config.to_dict())
        return run

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> RunFolder:
        """A run that has been begun.

        Raises:
            InvalidArgumentError: there is no run in the folder.
            FileFormatError: one of its files is damaged; says which.
        """
        folder = Path(path)
        file = folder / CONFIG_FILE
        if not file.is_file():
            raise InvalidArgumentError(f"{folder} is no run folder: there is no {CONFIG_FILE} in it")
        try:
            config = RunConfig.from_dict(json.loads(file.read_text(encoding="utf-8")))
        except (LtlcError, ValueError, KeyError, TypeError) as error:
            detail = f"{error} is missing" if isinstance(error, KeyError) else error
            raise FileFormatError(f"{file} is not the configuration of a run: {detail}") from error
        try:
            automaton = formats.read(folder / AUTOMATON_FILE)
        except FileNotFoundError as error:
            raise FileFormatError(f"{folder / AUTOMATON_FILE} is missing; the run cannot be used without it") from error
        return cls(folder, config, automaton)

    def differs(self, config: RunConfig, automaton: RabinAutomaton) -> list[str]:
        """What another configuration or automaton has different; device and threads do not count."""
        before, now = self.config.to_dict(), json.loads(json.dumps(config.to_dict()))
        for values in (before, now):
            del values["ltlc"]
            for name in ("device", "threads"):
                values["hyperparameters"].pop(name, None)
        same = formats.to_json(self.automaton) == formats.to_json(automaton)
        return [*([] if same else ["formula"]), *(key for key in now if now[key] != before[key])]

    def move_to(self, device: str) -> None:
        """Train on another device from now on.

        Raises:
            InvalidArgumentError: the agent is no network.
        """
        self.config = replace(self.config, hyperparameters=systems.on_device(self.config.hyperparameters, device))

    @cached_property
    def judge(self) -> Judge | None:
        """Of the task, or None where the dynamics of the environment are not known."""
        place = self.config.setting
        if place.model is None:
            return None
        return Judge(place.model, self.automaton, self.task.tables, initial_label=place.initial_label)

    def vector_env(self) -> LTLVectorWrapper:
        """The environments of the run."""
        return self.config.setting.vector(self.task, self.config.num_envs)

    def check(self) -> None:
        """Make everything once, so that wrong input is found before anything is written.

        Raises:
            LtlcError: the environment, its labels, the task and the hyperparameters do not go together.
        """
        env = self.vector_env()
        try:
            systems.check(env, self.config.hyperparameters)
        finally:
            env.close()

    def train(self, *, resume: bool = False, callback: Callback | None = None) -> Trained:
        """Train to the end, or go on; see `ltlc.agents.systems.train_agent`."""
        config = self.config
        if resume and not self.keeps_checkpoints and (self.path / POLICY_FILE).exists():
            rows = self.metrics()
            if not rows:
                raise FileFormatError(f"{self.path / METRICS_FILE} has no rows; begin anew with --force")
            return Trained(self.load(), int(rows[-1]["steps"] or 0), rows[-1]["seconds"] or 0.0)
        env = self.vector_env()
        try:
            return systems.train_agent(
                env,
                config.agent,
                config.hyperparameters,
                self.path,
                resume=resume,
                judge=None if self.keeps_checkpoints else self.judge,
                callback=callback,
            )
        finally:
            env.close()

    @property
    def keeps_checkpoints(self) -> bool:
        """Whether training that was cut short can go on where it was; else it begins anew."""
        return self.config.agent == DOUBLE_DQN

    def load(self) -> Agent:
        """What has been learned.

        Raises:
            InvalidArgumentError: nothing has been learned yet.
            FileFormatError: the file is damaged, or of another task.
        """
        if not (self.path / POLICY_FILE).exists():
            raise InvalidArgumentError(
                f"{self.path} holds no policy, since its training was cut short or found none; go on with it first: "
                f"ltlc train --resume --out {self.path}"
            )
        agent = systems.load_agent(self.config.agent, self.path / POLICY_FILE)
        if agent.tables.next_state.shape != self.task.tables.next_state.shape:
            raise FileFormatError(f"{self.path / POLICY_FILE} is of another task than {self.path / AUTOMATON_FILE}")
        return agent

    def metrics(self) -> list[dict[str, float | None]]:
        """The rows of metrics.csv; None where a row has no value.

        Raises:
            FileFormatError: the file is damaged.
        """
        path = self.path / METRICS_FILE
        try:
            with path.open(encoding="utf-8", newline="") as stream:
                return [
                    {key: float(value) if value else None for key, value in row.items()}
                    for row in csv.DictReader(stream)
                ]
        except (ValueError, AttributeError) as error:
            raise FileFormatError(f"{path}: {error}") from error

    def write_result(self, result: Mapping[str, Any]) -> Path:
        """Write result.json."""
        return self._write_json(RESULT_FILE, result)

    def draw_automaton(self) -> Path | None:
        """Write dra.svg, or nothing where nothing that draws is installed."""
        try:
            return formats.render(self.automaton, self.path / AUTOMATON_PICTURE)
        except MissingProgramError:
            return None

    def _write_json(self, name: str, values: Mapping[str, Any]) -> Path:
        return atomic_write(self.path / name, json.dumps(values, ensure_ascii=False, indent=2) + "\n")


def default_folder(name: str, env: str, seed: int, agent: str = DOUBLE_DQN) -> Path:
    """`runs/<task>-<environment>-<seed>`, in characters that every file system takes; with the agent, if tabular."""
    task, place = (re.sub(r"[^a-z0-9]+", "-", part.lower()).strip("-") for part in (name, env.rpartition("/")[2]))
    who = "" if agent == DOUBLE_DQN else agent
    return Path("runs") / "-".join(filter(None, (task[:40].strip("-"), place, who, str(seed))))
