"""A run folder: what was to be learned, how far it has come, what came out, and pictures.

config.json       the task, the environment, the hyperparameters, and the identity of the run, which its files share
dra.json          the automaton
metrics.csv       a row every now and then
times.csv         seconds of training at these rows
checkpoint.ltlc   to go on from
policy.ltlc       what has been learned
result.json       the verdict
policy.png        the policy on the map, one panel per automaton state (environments with a map)
curve.png         return over the steps
trajectories.png  episodes of the policy (environments that can be drawn)
dra.svg           the automaton (where Graphviz or graphviz-pure is installed)
report.html       a page about all of it (on request)
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping
from contextlib import ExitStack, closing, suppress
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ltlc import formats
from ltlc.atomic import atomic_write, atomic_write_all
from ltlc.automata import DFA, DRA
from ltlc.envs import LTLVectorWrapper
from ltlc.errors import FileFormatError, InvalidArgumentError, LtlcError, MissingProgramError
from ltlc.faithful import Shortfall, shortfall
from ltlc.mdp import Judge
from ltlc.task import Task

from ..agent import Agent
from ..registry import AGENTS, AgentEntry
from .folder_lock import locked_folder
from .metrics import METRICS_FILE, TIMES_FILE, read_rows
from .progress import Callback, TrainingResult
from .run_config import RunConfig, identity
from .storage import CHECKPOINT_FILE, POLICY_FILE, run_of

CONFIG_FILE = "config.json"
AUTOMATON_FILE = "dra.json"
AUTOMATON_PICTURE = "dra.svg"
RESULT_FILE = "result.json"
POLICY_PICTURE, CURVE_PICTURE, TRAJECTORIES_PICTURE = "policy.png", "curve.png", "trajectories.png"
REPORT_FILE = "report.html"
_RESULTS = (POLICY_FILE, RESULT_FILE, POLICY_PICTURE, CURVE_PICTURE, TRAJECTORIES_PICTURE, AUTOMATON_PICTURE,
            REPORT_FILE, METRICS_FILE, TIMES_FILE, CHECKPOINT_FILE)  # fmt: skip
"""what a run writes after its beginning, in the order of removal: what is left is a run at any moment."""
_EVENTS = "events.out.tfevents.*"
"""files of TensorBoard."""


class RunFolder:
    """A training run on disk; see the head of this module for its files."""

    def __init__(self, path: str | os.PathLike[str], config: RunConfig, automaton: DRA) -> None:
        self.path = Path(path)
        self.config = config
        self.automaton = automaton
        self.task = config.task(automaton)
        self.id = identity(config.to_dict(), automaton)
        self._lock: ExitStack | None = None

    @classmethod
    def create(
        cls, path: str | os.PathLike[str], config: RunConfig, automaton: DRA, *, force: bool = False
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
        automaton = automaton.reached() if isinstance(automaton, DFA) else automaton
        try:
            run = cls(folder, config, automaton)
        except InvalidArgumentError as error:
            raise FileFormatError(f"{file} is not the configuration of a run: {error}") from error
        run.id = identity(values, automaton)
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

    def differs(self, config: RunConfig, automaton: DRA) -> list[str]:
        """What another configuration or automaton has different; device and threads do not count."""
        same = formats.to_json(self.automaton) == formats.to_json(automaton)
        return [*([] if same else ["formula"]), *self.config.differences(config)]

    def move_to(self, device: str) -> None:
        """Train on another device from now on.

        Raises:
            InvalidArgumentError: the agent has no device.
        """
        self.config = self.config.on_device(device)

    @cached_property
    def learned_task(self) -> Task:
        """The task with the rewards that the agent learns from, which may be fitted to it."""
        with closing(self.vector_env()) as env:
            task: Task = self.entry.agent_class.learned_task(env, self.config.hyperparameters)
            return task

    @cached_property
    def judge(self) -> Judge | None:
        """Of the task, or None where the dynamics of the environment are not known."""
        env_spec = self.config.env_spec
        if env_spec.model is None:
            return None
        return Judge(env_spec.model, self.learned_task, initial_label=env_spec.initial_label)

    @cached_property
    def shortfall(self) -> Shortfall | None:
        """What the optimum of the rewards misses of the maximum satisfaction probability.

        None: nothing much, or the dynamics are not known, or the agent learns without the rewards.
        """
        return shortfall(self.judge, self.learned_task) if self.entry.uses_rewards and self.judge is not None else None

    @property
    def entry(self) -> AgentEntry:
        """What is known of the agent."""
        return AGENTS[self.config.agent]

    def vector_env(self) -> LTLVectorWrapper:
        """The environments of the run."""
        return self.config.env_spec.vector(self.task, self.config.num_envs, self.config.workers)

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
            resume: whether to go on from the checkpoint.
            callback: called with each row of metrics; stops the training by returning True.
        """
        config = self.config
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
                judge=self.judge,
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
        names = ("letter_class", "next_state", "select_pair", "initial_state")
        if theirs.aps != ours.aps or not all(np.array_equal(getattr(theirs, n), getattr(ours, n)) for n in names):
            raise FileFormatError(f"{self.path / POLICY_FILE} is of another task than {self.path / AUTOMATON_FILE}")
        with closing(self.config.env_spec.vector(self.task, 1)) as env:
            self._check_fits(env, agent)
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


def _json(values: Mapping[str, Any]) -> str:
    return json.dumps(values, ensure_ascii=False, indent=2) + "\n"


def _run_of_result(path: Path) -> Any:
    """The identity of the run whose verdict is in the file.

    Raises:
        FileFormatError: the file is damaged.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8")).get("run")
    except (ValueError, AttributeError) as error:
        raise FileFormatError(f"{path} is not the verdict of a run: {error}") from error
