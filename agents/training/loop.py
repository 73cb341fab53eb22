"""The training loop of algorithm 1, for many environments at once, interruptible at any moment."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import torch
from gymnasium.vector import VectorEnv

from ltlc.errors import InvalidArgumentError
from ltlc.mdp.verdict import Judge

from ..choice import choose_agent
from ..config import AgentConfig, OffPolicyConfig
from ..registry import AGENTS, agent_of
from ..value_agent import ValueAgent
from .collect import Collector, Interface
from .contents import Content, config_of, tables_of
from .folder_lock import locked_folder
from .metrics import Metrics, Row
from .progress import Callback, Progress, TrainingResult
from .shortcomings import EARLY, shortcomings
from .storage import (
    CHECKPOINT_FILE,
    POLICY_FILE,
    read_file,
    run_of,
    same_tables,
    tables_to_tensors,
    write_file,
)

_FILE_KIND = "checkpoint"
_FREE_TO_CHANGE = ("device", "threads")
"""hyperparameters that a resumed run may have different."""


def train(
    env: VectorEnv[Any, Any, Any],
    config: AgentConfig | None = None,
    *,
    agent: str | None = None,
    folder: str | os.PathLike[str] | None = None,
    resume: bool = False,
    callback: Callback | None = None,
) -> TrainingResult:
    """Train an agent in a vector environment, usually an `LTLVectorWrapper`.

    Training is cut into legs of `checkpoint_every` steps. Each begins with an environment reset from a seed of its own
    and ends with a checkpoint. So the result depends on the configuration alone, not on whether the run was killed and
    resumed from a checkpoint, as long as the environment is deterministic given its seed. For the same reason Ctrl-C
    gives up what the leg under way has done.

    Args:
        env: the environment; it is not closed.
        config: hyperparameters; None: those of the run to resume, or the defaults.
        agent: name of the agent; None: the one whose hyperparameters these are, that of the run to resume, or the one
            that fits the environment (see `choose_agent`).
        folder: where metrics, checkpoints and in the end the policy are written; None: nothing is.
        resume: whether to go on from the checkpoint in the folder.
        callback: called with each row of metrics; stops the training by returning True.

    Raises:
        InvalidArgumentError: the agent cannot take the environment; the folder holds a run and `resume` is False; the
            checkpoint is of another configuration, task or environment; or something else trains in the folder.
        FileFormatError: the checkpoint is damaged.
        TrainingDiverged: the loss is no longer finite; the last checkpoint is intact.
        OSError: the folder cannot be written, for instance because the disk is full; the last checkpoint is intact.

    References:
        Q. Gao, Deep Reinforcement Learning with Temporal Logic Specifications, Duke University, 2018, algorithm 1.
    """
    with contextlib.nullcontext() if folder is None else locked_folder(Path(folder)):
        where = None if folder is None else Path(folder)
        if agent is None and config is not None:
            agent = agent_of(config)
        elif agent is None:
            agent = _agent_of_checkpoint(where) if resume else choose_agent(env).agent
        result: TrainingResult = AGENTS[agent].train(env, agent, config, folder=where, resume=resume, callback=callback)
        return result


def train_in(
    env: VectorEnv[Any, Any, Any],
    agent: str,
    config: OffPolicyConfig | None,
    *,
    folder: Path | None = None,
    run_id: str = "",
    resume: bool = False,
    judge: Judge | None = None,
    callback: Callback | None = None,
) -> TrainingResult:
    """Train as `train` does, in a folder that is there and locked.

    Args:
        env: see `train`.
        agent: its name.
        config: see `train`.
        folder: of the run, or None.
        run_id: what the files of the run carry as its identity; a resumed run goes on with its own.
        resume: see `train`.
        judge: of the task; its metrics are not judged.
        callback: see `train`.

    Raises:
        LtlcError, OSError: see `train`.
    """
    agent_class = AGENTS[agent].agent_class
    saved = _find_checkpoint(folder, resume)
    config = _agreed_config(agent, config, saved)
    if saved is not None and folder is not None:
        run_id = run_of(folder / CHECKPOINT_FILE)
    with _threads(config.threads), _InterruptFlag() as interrupt:
        run = _Run(env, agent_class, config, folder, run_id, saved)
        stopped = False
        while run.steps < config.total_steps and not stopped and not interrupt.raised:
            epsilon, learning_rate = config.epsilon_at(run.steps), run.agent.learning_rate_at(run.steps)
            actions = run.agent.explore(run.collector.packed, run.collector.states, epsilon, run.generator)
            steps = run.collector.step(actions)
            run.memory.add(steps)
            losses = run.learn() if len(steps.action) else []
            row = run.advance(len(steps.action), losses, epsilon, learning_rate)
            if row is not None and callback is not None:
                stopped = bool(callback(Progress(run.agent, row, config.total_steps, run.early_shortcomings())))
            if run.leg_is_over() and run.steps < config.total_steps:
                run.begin_leg()
        run.finish(complete=not interrupt.raised)
        return TrainingResult(
            run.agent, run.steps, config.total_steps, run.seconds, interrupt.raised, folder, run.saved_steps,
            run.shortcomings(),
        )  # fmt: skip


class _Run:
    """The state of a training run: everything a checkpoint holds."""

    def __init__(
        self,
        env: VectorEnv[Any, Any, Any],
        agent_class: type[ValueAgent],
        config: OffPolicyConfig,
        folder: Path | None,
        run_id: str,
        saved: Content | None,
    ) -> None:
        interface = Interface.of(env)
        self.config, self.folder, self.id = config, folder, run_id
        if saved is not None:
            n_states = 1 if interface.tables is None else interface.tables.n_states
            weights = saved["agent"]["policy_network"]
            agent_class.check_size(weights, config, interface.space, n_states, interface.n_actions)
        self.agent = agent_class(interface.space, interface.n_actions, interface.tables, config)
        encoder = self.agent.encoder
        self.agent.check_memory(env.num_envs, copied=folder is not None)
        self.memory = self.agent.new_memory(env.num_envs)
        self.collector = Collector(interface, encoder)
        self.generator = torch.Generator().manual_seed(_seed(config, 0))
        self.steps = self.rounds = self.leg = 0
        self._told = False
        self._seconds, self._since = 0.0, time.perf_counter()
        if saved is not None:
            self._check_same_task(saved)
            self._restore(saved)
        self.metrics = Metrics(folder, self.steps)
        self._seconds = self.metrics.seconds
        if saved is None:
            self._write()
        else:
            self.metrics.load_state_dict(saved["metrics"].value)
        self.saved_steps = self.steps
        self._reset()

    @property
    def seconds(self) -> float:
        """Seconds of training so far."""
        return self._seconds + time.perf_counter() - self._since

    def learn(self) -> list[float]:
        """Make the updates that are due; returns their losses."""
        return self.agent.learn(self.memory, self.steps, self.rounds, self.generator)

    def advance(self, n_steps: int, losses: list[float], epsilon: float, learning_rate: float | None) -> Row | None:
        """Count a round of environment steps; a row of metrics if one is due."""
        before = self.steps
        self.steps += n_steps
        self.rounds += 1
        self.metrics.add([episode for _, episode in self.collector.take_episodes()], losses)
        every = self.config.log_every
        if before // every == self.steps // every and self.steps < self.config.total_steps:
            return None
        return self.metrics.row(self.steps, self.agent.updates, epsilon, learning_rate, round(self.seconds, 3))

    def shortcomings(self) -> tuple[str, ...]:
        """What the training has lacked so far."""
        agent, wait = self.agent, self.agent.first_update
        updates = None if wait is None else agent.updates
        return tuple(
            shortcomings(
                self.collector.seen, self.steps, counterfactual=agent.counterfactual, updates=updates, wait=wait or 0
            )
        )

    def early_shortcomings(self) -> tuple[str, ...]:
        """The same, once: with the first row after a part of the steps."""
        if self._told or self.steps < EARLY * self.config.total_steps:
            return ()
        self._told = True
        return self.shortcomings()

    def leg_is_over(self) -> bool:
        """Whether a checkpoint is due."""
        return self.steps >= self._leg_end

    def begin_leg(self) -> None:
        """Write a checkpoint, and begin new episodes from the seed of the next leg."""
        self.save()
        self._reset()

    def finish(self, *, complete: bool) -> None:
        """Write the last checkpoint, unless the leg was cut short or nothing happened since, and the policy."""
        if self.steps > self.saved_steps:
            self.agent.finish(self.memory)
            if complete:
                self.save()
        self.metrics.close()
        if self.folder is not None:
            self.agent.save(self.folder / POLICY_FILE, run=self.id)

    def save(self) -> None:
        """End the leg with a checkpoint: the old one, or the new one, is there at any moment."""
        self.leg += 1
        self._write()

    def _write(self) -> None:
        self.saved_steps = self.steps
        if self.folder is None:
            return
        content = {
            "name": self.agent.name,
            "config": self.config.to_dict(),
            "tables": tables_to_tensors(self.agent.tables),
            "space": repr(self.agent.encoder.space),
            "num_envs": len(self.collector.packed),
            "steps": self.steps,
            "rounds": self.rounds,
            "leg": self.leg,
            "seen": self.collector.seen_state(),
            "generator": self.generator.get_state(),
            "agent": self.agent.state_dict(),
            "memory": self.memory.state_dict(),
            "metrics": self.metrics.state_dict(),
        }
        write_file(self.folder / CHECKPOINT_FILE, _FILE_KIND, content, self.id)

    def _reset(self) -> None:
        every = self.config.checkpoint_every
        self._leg_end = (self.steps // every + 1) * every
        self.collector.reset(_seed(self.config, self.leg + 1))

    def _restore(self, saved: Content) -> None:
        """Go back to where a checkpoint was written; all of it is checked before any file is touched."""
        self.agent.check_state(saved["agent"])
        Metrics.check_state(saved["metrics"])
        self.memory.check_state(saved["memory"])
        self.steps, self.rounds, self.leg = (saved[name].count() for name in ("steps", "rounds", "leg"))
        *counts, classes = saved["seen"].entries(4)
        read = [entry.count(most=self.agent.tables.n_classes - 1) for entry in classes.entries()]
        self.collector.load_seen_state([*(entry.count() for entry in counts), read])
        try:
            self.generator.set_state(saved["generator"].tensor(torch.uint8))
        except RuntimeError as error:
            saved["generator"].fail(f"is no state of a random generator ({error})")
        self.agent.load_state_dict(saved["agent"].value)
        self.memory.load_state_dict(saved["memory"].value)

    def _check_same_task(self, saved: Content) -> None:
        if not same_tables(tables_of(saved["tables"]), self.agent.tables):
            raise InvalidArgumentError(
                "the checkpoint is of a task with other reward tables; resume with the same task"
            )
        here = (repr(self.agent.encoder.space), len(self.collector.packed))
        space, num_envs = saved["space"].text(), saved["num_envs"].count(1)
        if here != (space, num_envs):
            raise InvalidArgumentError(
                f"the checkpoint is of {num_envs} environments that show {space}, "
                f"this is {here[1]} that show {here[0]}; resume with the same environment"
            )


def _find_checkpoint(folder: Path | None, resume: bool) -> Content | None:
    """The content of the checkpoint to resume from, or None to start afresh."""
    path = None if folder is None else folder / CHECKPOINT_FILE
    exists = path is not None and path.exists()
    if resume and not exists:
        raise InvalidArgumentError(f"there is no checkpoint to resume from in {folder}; train with resume=False first")
    if exists and not resume:
        raise InvalidArgumentError(f"{folder} holds a training run; pass resume=True to go on, or another folder")
    return read_file(path, _FILE_KIND) if resume and path is not None else None


def _agent_of_checkpoint(folder: Path | None) -> str:
    """Say whose checkpoint is in a folder."""
    saved = _find_checkpoint(folder, resume=True)
    assert saved is not None
    return saved["name"].text()


def _agreed_config(agent: str, config: OffPolicyConfig | None, saved: Content | None) -> OffPolicyConfig:
    """The configuration of the run; a resumed one goes on with its own."""
    entry = AGENTS[agent]
    if saved is None:
        wanted = config or entry.defaults
        assert isinstance(wanted, OffPolicyConfig)
        return wanted
    name, ours = saved["name"].text(), entry.agent_class.name
    if name != ours:
        raise InvalidArgumentError(f"the run to resume is of the agent {name!r}, not {ours!r}")
    before: OffPolicyConfig = config_of(saved["config"], entry.agent_class.config_type)
    if config is None:
        return before
    names = [field.name for field in dataclasses.fields(before) if field.name not in _FREE_TO_CHANGE]
    changed = [name for name in names if getattr(config, name) != getattr(before, name)]
    if changed:
        pairs = ", ".join(f"{name} {getattr(before, name)!r}, not {getattr(config, name)!r}" for name in changed)
        raise InvalidArgumentError(f"the run to resume has {pairs}; resume with config=None")
    return config


def _seed(config: OffPolicyConfig, stream: int) -> int:
    """Independent seeds: 0 of the agent's random numbers, 1, 2, ... of the environment in each leg."""
    return int(np.random.SeedSequence([config.seed, stream]).generate_state(1)[0] >> 1)


@contextlib.contextmanager
def _threads(count: int | None) -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(before if count is None else count)
    try:
        yield
    finally:
        torch.set_num_threads(before)


class _InterruptFlag:
    """While active, the first Ctrl-C only raises a flag; a second one is as usual."""

    def __init__(self) -> None:
        self.raised = False

    def __enter__(self) -> _InterruptFlag:
        self._active = threading.current_thread() is threading.main_thread()
        if self._active:
            self._before = signal.signal(signal.SIGINT, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        if self._active:
            signal.signal(signal.SIGINT, self._before)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.raised:
            raise KeyboardInterrupt
        self.raised = True
