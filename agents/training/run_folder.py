"""A run folder: what was to be learned, how far it has come, what came out, and pictures.

config.json       the task, the environment, the hyperparameters, and the identity of the run, which its files share
dra.json          the automaton
metrics.csv       a row every now and then
times.csv         seconds of training at these rows
checkpoint.ltlc   to go on from (double DQN)
policy.ltlc       what has been learned
result.json       the verdict
policy.png        the policy on the map, one panel per automaton state (environments with a map)
curve.png         return over the steps
dra.svg           the automaton (where Graphviz or graphviz-pure is installed)
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Collection, Mapping
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ltlc import formats
from ltlc.atomic import atomic_write, atomic_write_all
from ltlc.automata import RabinAutomaton
from ltlc.envs import LTLVectorWrapper
from ltlc.envs.spec import EnvSpec
from ltlc.errors import FileFormatError, InvalidArgumentError, LtlcError, MissingProgramError
from ltlc.faithful import Shortfall, shortfall
from ltlc.mdp import Judge
from ltlc.rewards import RECOMMENDED, OnDeadlock, OnTermination, get_scheme
from ltlc.task import Task
from ltlc.version import __version__

from ..agent import Agent
from ..config import AgentConfig
from ..fitted_q.config import FittedQConfig
from ..registry import AGENTS, DOUBLE_DQN, FITTED_Q, AgentEntry, hyperparameters
from .folder_lock import locked_folder
from .metrics import METRICS_FILE, TIMES_FILE, read_rows
from .progress import Callback, TrainingResult
from .storage import CHECKPOINT_FILE, POLICY_FILE, run_of

CONFIG_FILE = "config.json"
AUTOMATON_FILE = "dra.json"
AUTOMATON_PICTURE = "dra.svg"
RESULT_FILE = "result.json"
POLICY_PICTURE = "policy.png"
CURVE_PICTURE = "curve.png"
_RESULTS = (POLICY_FILE, RESULT_FILE, POLICY_PICTURE, CURVE_PICTURE, AUTOMATON_PICTURE, METRICS_FILE, TIMES_FILE,
            CHECKPOINT_FILE)  # fmt: skip
"""what a run writes after its beginning, in the order of removal: what is left is a run at any moment."""
_EVENTS = "events.out.tfevents.*"
"""files of TensorBoard."""
_FORMAT = 4
MOST_ENVS = 64
"""environments stepped together where nobody says how many."""
EPISODES_EACH = 4
"""episodes that at least end in each of them, if there are enough steps for one."""


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
            "env_spec": self.env_spec.to_dict(),
            "reward": self.reward,
            "parameters": dict(self.parameters),
            "on_deadlock": self.on_deadlock,
            "on_termination": self.on_termination,
            "num_envs": self.num_envs,
            "agent": self.agent,
            "agent_reason": self.agent_reason,
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
        fields = _of_kinds(values, {"reward": str, "parameters": dict, "on_deadlock": str | None,
                                    "on_termination": str, "num_envs": int, "agent": str, "env_spec": dict,
                                    "hyperparameters": dict, "agent_reason": str | None})  # fmt: skip
        config = hyperparameters(fields["agent"], fields["hyperparameters"])
        kinds: dict[str, Any] = {"env": str, "arguments": dict, "labels": str | None, "max_episode_steps": int | None,
                                 "initial_label": str, "discretise": int | None}  # fmt: skip
        _of_kinds({"discretise": None} | fields["env_spec"], kinds)
        return cls(**fields | {"env_spec": EnvSpec(**fields["env_spec"]), "hyperparameters": config})


def _of_kinds(values: Mapping[str, Any], kinds: Mapping[str, Any]) -> dict[str, Any]:
    """The values with these names, each of which must be of its kind."""
    for key, kind in kinds.items():
        if not isinstance(values[key], kind) or (isinstance(values[key], bool) and kind is not bool):
            raise FileFormatError(f"{key} is {values[key]!r}")
    return {key: values[key] for key in kinds}


class RunFolder:
    """A training run on disk; see the head of this module for its files."""

    def __init__(self, path: str | os.PathLike[str], config: RunConfig, automaton: RabinAutomaton) -> None:
        self.path = Path(path)
        self.config = config
        self.automaton = automaton
        self.task = config.task(automaton)
        self.id = _digest(config.to_dict(), automaton)
        self._lock: ExitStack | None = None

    @classmethod
    def create(
        cls, path: str | os.PathLike[str], config: RunConfig, automaton: RabinAutomaton, *, force: bool = False
    ) -> RunFolder:
        """Begin a run, and keep others from training in its folder until `close`.

        Args:
            path: of the folder, which is made if it is not there.
            config: of the run.
            automaton: of the task.
            force: replace what the folder holds of an older run: all of it, once the new beginning is on the disk.

        Raises:
            InvalidArgumentError: the folder is a file, or holds a run or files that a run would replace; or something
                else trains in it.
            OSError: it cannot be written.
        """
        run = cls(path, config, automaton)
        with ExitStack() as lock:
            lock.enter_context(locked_folder(run.path))
            if not force:
                run._check_free()
            old = [*(run.path / name for name in _RESULTS), *run.path.glob(_EVENTS), run.path / CONFIG_FILE]
            new = {AUTOMATON_FILE: formats.to_json(automaton), CONFIG_FILE: _json(config.to_dict() | {"run": run.id})}
            atomic_write_all({run.path / name: text for name, text in new.items()}, instead_of=old)
            run._lock = lock.pop_all()
        return run

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, lock: bool = False) -> RunFolder:
        """A run that has been begun.

        Args:
            path: of the folder.
            lock: keep others from training in it until `close`.

        Raises:
            InvalidArgumentError: there is no run in the folder, or something else trains in it.
            FileFormatError: one of its files is damaged, or of another run; says which.
        """
        folder = Path(path)
        if not (folder / CONFIG_FILE).is_file():
            raise InvalidArgumentError(f"{folder} is no run folder: there is no {CONFIG_FILE} in it")
        if not lock:
            return cls._read(folder)
        with ExitStack() as held:
            held.enter_context(locked_folder(folder))
            run = cls._read(folder)
            run._lock = held.pop_all()
        return run

    @classmethod
    def _read(cls, folder: Path) -> RunFolder:
        file = folder / CONFIG_FILE
        try:
            values = json.loads(file.read_text(encoding="utf-8"))
            config = RunConfig.from_dict(values)
        except (LtlcError, ValueError, KeyError, TypeError, RecursionError) as error:
            detail = f"{error} is missing" if isinstance(error, KeyError) else error
            raise FileFormatError(f"{file} is not the configuration of a run: {detail}") from error
        try:
            automaton = formats.read(folder / AUTOMATON_FILE)
        except FileNotFoundError as error:
            raise FileFormatError(f"{folder / AUTOMATON_FILE} is missing; the run cannot be used without it") from error
        try:
            run = cls(folder, config, automaton)
        except InvalidArgumentError as error:
            raise FileFormatError(f"{file} is not the configuration of a run: {error}") from error
        run.id = _digest(values, automaton)
        run._check_parts(values)
        return run

    def _check_free(self) -> None:
        if (self.path / CONFIG_FILE).exists():
            raise InvalidArgumentError(
                f"{self.path} holds a training run; go on with it (resume), replace it (force), or give another folder"
            )
        strange = [name for name in _RESULTS if (self.path / name).exists()]
        automaton = self.path / AUTOMATON_FILE
        if automaton.exists() and automaton.read_bytes() != formats.to_json(self.automaton).encode("utf-8"):
            strange.append(AUTOMATON_FILE)
        if strange:
            raise InvalidArgumentError(
                f"{self.path} holds no training run, but {', '.join(strange)}, which one would replace; give another "
                "folder, or replace them (force)"
            )

    def _check_parts(self, config: Mapping[str, Any]) -> None:
        """Check that the files of the run carry its identity.

        Raises:
            FileFormatError: one does not, or its first line is damaged.
        """
        kept: dict[str, Any] = {CONFIG_FILE: config.get("run")}
        for name in (CHECKPOINT_FILE, POLICY_FILE):
            with suppress(FileNotFoundError):
                kept[name] = run_of(self.path / name)
        with suppress(FileNotFoundError):
            kept[RESULT_FILE] = _run_of_result(self.path / RESULT_FILE)
        strange = [name for name, run in kept.items() if run != self.id]
        if CONFIG_FILE in strange:
            raise FileFormatError(
                f"{self.path}: {CONFIG_FILE} and {AUTOMATON_FILE} do not belong together, or one was changed after "
                "the run had begun; bring the old ones back, or begin a new run"
            )
        if strange:
            raise FileFormatError(
                f"{self.path}: {', '.join(strange)} and {CONFIG_FILE} do not belong together, they are of two runs; "
                "bring the old ones back, or begin a new run"
            )

    def close(self) -> None:
        """Let others train in the folder again."""
        if self._lock is not None:
            self._lock.close()
        self._lock = None

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def differs(self, config: RunConfig, automaton: RabinAutomaton) -> list[str]:
        """What another configuration or automaton has different; device and threads do not count."""
        before, now = _identity(self.config.to_dict()), _identity(config.to_dict())
        same = formats.to_json(self.automaton) == formats.to_json(automaton)
        return [*([] if same else ["formula"]), *(key for key in now if now[key] != before[key])]

    def move_to(self, device: str) -> None:
        """Train on another device from now on.

        Raises:
            InvalidArgumentError: the agent has no device.
        """
        self.config = replace(self.config, hyperparameters=on_device(self.config.hyperparameters, device))

    @cached_property
    def judge(self) -> Judge | None:
        """Of the task, or None where the dynamics of the environment are not known."""
        env_spec = self.config.env_spec
        if env_spec.model is None:
            return None
        return Judge(env_spec.model, self.task, initial_label=env_spec.initial_label)

    @cached_property
    def shortfall(self) -> Shortfall | None:
        """What the optimum of the rewards misses of the maximum satisfaction probability.

        None: nothing much, or the dynamics are not known, or the agent learns without the rewards.
        """
        return shortfall(self.judge, self.task) if self.entry.uses_rewards and self.judge is not None else None

    @property
    def entry(self) -> AgentEntry:
        """What is known of the agent."""
        return AGENTS[self.config.agent]

    def vector_env(self) -> LTLVectorWrapper:
        """The environments of the run."""
        return self.config.env_spec.vector(self.task, self.config.num_envs)

    def check(self, given: Collection[str] = ()) -> Any:
        """Make everything once, so that wrong input is found before anything is written.

        Args:
            given: names of the hyperparameters that somebody asked for.

        Returns:
            The size of the agent's memory, with `rows` and `size_text`; None where it is small.

        Raises:
            InvalidArgumentError: a hyperparameter that was asked for is without effect here.
            MemoryLimitExceeded: the agent does not fit into memory.
            LtlcError: the environment, its labels, the task and the hyperparameters do not go together.
        """
        config = self.config.hyperparameters
        with closing(self.vector_env()) as env:
            size = self.entry.agent_class.check(env, config)
        unused = config.without_effect(rewarded=True)
        for name in given:
            if name in unused:
                raise InvalidArgumentError(f"{name} is without effect here: {unused[name]}")
        return size

    def train(self, *, resume: bool = False, callback: Callback | None = None) -> TrainingResult:
        """Train to the end, or go on; until Ctrl-C.

        Others are kept from training in the folder meanwhile, unless `create` or `open` has seen to it.

        Args:
            resume: whether to go on from a checkpoint. Agents that keep none begin anew.
            callback: called with each row of metrics; stops the training by returning True.
        """
        config, again = self.config, self.entry.keeps_checkpoints
        if resume and not again and (self.path / POLICY_FILE).exists():
            rows = self.metrics()
            if not rows:
                raise FileFormatError(f"{self.path / METRICS_FILE} has no rows; begin anew")
            steps = int(rows[-1]["steps"] or 0)
            total = config.hyperparameters.total_steps
            return TrainingResult(self.load(), steps, total, rows[-1]["seconds"] or 0.0, folder=self.path)
        with ExitStack() as stack:
            if self._lock is None:
                stack.enter_context(locked_folder(self.path))
            result: TrainingResult = self.entry.train(
                stack.enter_context(closing(self.vector_env())),
                config.agent,
                config.hyperparameters,
                folder=self.path,
                run_id=self.id,
                resume=resume and (self.path / CHECKPOINT_FILE).exists(),  # else killed before the first checkpoint
                judge=None if again else self.judge,
                callback=callback,
            )
            return result

    def load(self) -> Agent:
        """What has been learned.

        Raises:
            InvalidArgumentError: nothing has been learned yet.
            FileFormatError: the file is damaged, or of another task.
        """
        if not (self.path / POLICY_FILE).exists():
            raise InvalidArgumentError(
                f"{self.path} holds no policy, since its training was cut short or found none; resume it first"
            )
        agent: Agent = self.entry.agent_class.load(self.path / POLICY_FILE)
        theirs, ours = agent.tables, self.task.tables
        names = ("letter_class", "next_state", "commit", "initial_state")
        if theirs.aps != ours.aps or not all(np.array_equal(getattr(theirs, n), getattr(ours, n)) for n in names):
            raise FileFormatError(f"{self.path / POLICY_FILE} is of another task than {self.path / AUTOMATON_FILE}")
        env = self.config.env_spec.vector(self.task, 1)
        try:
            self._check_fits(env, agent)
        finally:
            env.close()
        return agent

    def _check_fits(self, env: LTLVectorWrapper, agent: Agent) -> None:
        from .collect import Interface

        interface = Interface.of(env)
        if interface.space != agent.encoder.space or interface.n_actions != agent.n_actions:
            raise FileFormatError(
                f"{self.path / POLICY_FILE} is for {agent.encoder.space} and {agent.n_actions} actions; "
                f"the environment of the run has {interface.space} and {interface.n_actions}"
            )

    def metrics(self) -> list[dict[str, float | None]]:
        """The rows of metrics.csv, with the seconds of times.csv; None where a row has no value.

        Raises:
            FileFormatError: a file is damaged.
        """
        return read_rows(self.path)

    def write_result(self, result: Mapping[str, Any]) -> Path:
        """Write result.json; to hold no times, so that equal runs have equal verdicts."""
        return atomic_write(self.path / RESULT_FILE, _json({"run": self.id, **result}))

    def draw_automaton(self) -> Path | None:
        """Write dra.svg, or nothing where nothing that draws is installed."""
        try:
            return formats.render(self.automaton, self.path / AUTOMATON_PICTURE)
        except MissingProgramError:
            return None


_NOT_LEARNED = ("ltlc", "run", "agent_reason")


def _json(values: Mapping[str, Any]) -> str:
    return json.dumps(values, ensure_ascii=False, indent=2) + "\n"


def _identity(config: Mapping[str, Any]) -> dict[str, Any]:
    """What a configuration says about what is learned: all but the version, the reason, device, threads, identity."""
    values: dict[str, Any] = json.loads(json.dumps({key: config[key] for key in config if key not in _NOT_LEARNED}))
    for name in ("device", "threads"):
        values["hyperparameters"].pop(name, None)
    return values


def _digest(config: Mapping[str, Any], automaton: RabinAutomaton) -> str:
    """The identity of a run, which all its files carry."""
    text = json.dumps(_identity(config), sort_keys=True) + formats.to_json(automaton)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


def _run_of_result(path: Path) -> Any:
    """The identity of the run whose verdict is in the file.

    Raises:
        FileFormatError: the file is damaged.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8")).get("run")
    except (ValueError, AttributeError) as error:
        raise FileFormatError(f"{path} is not the verdict of a run: {error}") from error


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
    task, env_spec, who = (re.sub(r"[^a-z0-9]+", "-", part.lower()).strip("-") for part in parts)
    return Path("runs") / "-".join(filter(None, (task[:40].strip("-"), env_spec, who, str(seed))))


def on_device(config: AgentConfig, device: str) -> AgentConfig:
    """The same hyperparameters for another device.

    Raises:
        InvalidArgumentError: the agent has no device.
    """
    if not hasattr(config, "device"):
        raise InvalidArgumentError(f"tables stay in main memory; a device ({device}) is for the agent {DOUBLE_DQN!r}")
    return replace(config, device=device)  # type: ignore[call-arg]
