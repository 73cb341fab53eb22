"""The training loop of algorithm 1, for many environments at once, interruptible at any moment."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import torch
from gymnasium.vector import VectorEnv

from ltlc.errors import InvalidArgumentError

from ..double_dqn.agent import DoubleDQN, check_size
from ..double_dqn.config import DQNConfig
from ..double_dqn.replay import ReplayBuffer, ReplaySize
from ..fitted_q.table import GROWTH, Tally
from .collect import Collector, Interface
from .contents import Content, config_of, tables_of
from .folder_lock import locked_folder
from .metrics import Metrics, Row
from .shortcomings import EARLY, shortcomings
from .storage import read_file, run_of, same_tables, tables_to_tensors, write_file

CHECKPOINT_FILE = "checkpoint.ltlc"
POLICY_FILE = "policy.ltlc"
_FILE_KIND = "checkpoint"
_FREE_TO_CHANGE = ("device", "threads")
"""hyperparameters that a resumed run may have different."""


@dataclass(frozen=True)
class Progress:
    """Where a training run stands; callbacks get it with each row of metrics."""

    agent: DoubleDQN
    row: Row
    total_steps: int
    shortcomings: tuple[str, ...] = ()
    """what the training lacks so far, see `shortcomings`; told once, after a quarter of the steps."""

    @property
    def seconds_left(self) -> float:
        """Estimated seconds to go, at the speed so far."""
        return self.row.seconds * (self.total_steps / max(self.row.steps, 1) - 1)


@dataclass(frozen=True)
class TrainingResult:
    """What a training run came to."""

    agent: DoubleDQN
    steps: int
    """environment steps since the start of training."""
    seconds: float
    """of training, interruptions not counted."""
    interrupted: bool
    """whether it stopped on Ctrl-C."""
    folder: Path | None
    saved_steps: int = 0
    """environment steps that the checkpoint in the folder holds."""
    shortcomings: tuple[str, ...] = ()
    """what the training lacked, and what to try; see `shortcomings`."""

    def __str__(self) -> str:
        total = self.agent.config.total_steps
        text = f"{self.steps} of {total} steps in {self.seconds:.1f} s"
        if not self.interrupted:
            return text
        if self.folder is None:
            return f"{text}, interrupted; nothing was written, since no folder was given"
        return f"{text}, interrupted; {self.saved_steps} are in {self.folder}. Go on with train(..., resume=True)"


Callback = Callable[[Progress], bool | None]


def train(
    env: VectorEnv[Any, Any, Any],
    config: DQNConfig | None = None,
    *,
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
    if folder is None:
        return train_in(None, env, config, resume=resume, callback=callback)
    with locked_folder(Path(folder)):
        return train_in(Path(folder), env, config, resume=resume, callback=callback)


def train_in(
    folder: Path | None,
    env: VectorEnv[Any, Any, Any],
    config: DQNConfig | None,
    *,
    run_id: str = "",
    resume: bool = False,
    callback: Callback | None = None,
) -> TrainingResult:
    """Train as `train` does, in a folder that is there and locked.

    Args:
        folder: of the run, or None.
        env: see `train`.
        config: see `train`.
        run_id: what the files of the run carry as its identity; a resumed run goes on with its own.
        resume: see `train`.
        callback: see `train`.

    Raises:
        LtlcError, OSError: see `train`.
    """
    saved = _find_checkpoint(folder, resume)
    config = _agreed_config(config, saved)
    if saved is not None and folder is not None:
        run_id = run_of(folder / CHECKPOINT_FILE)
    with _threads(config.threads), _InterruptFlag() as interrupt:
        run = _Run(env, config, folder, run_id, saved)
        stopped = False
        while run.steps < config.total_steps and not stopped and not interrupt.raised:
            epsilon, learning_rate = config.epsilon_at(run.steps), config.learning_rate_at(run.steps)
            actions = run.agent.explore(run.collector.packed, run.collector.states, epsilon, run.generator)
            steps = run.collector.step(actions)
            run.buffer.add(steps)
            losses = run.learn(learning_rate) if len(steps.action) else []
            row = run.advance(len(steps.action), losses, epsilon, learning_rate)
            if row is not None and callback is not None:
                stopped = bool(callback(Progress(run.agent, row, config.total_steps, run.early_shortcomings())))
            if run.leg_is_over() and run.steps < config.total_steps:
                run.begin_leg()
        run.finish(complete=not interrupt.raised)
        return TrainingResult(
            run.agent, run.steps, run.seconds, interrupt.raised, folder, run.saved_steps, run.shortcomings()
        )


class _Run:
    """The state of a training run: everything a checkpoint holds."""

    def __init__(
        self,
        env: VectorEnv[Any, Any, Any],
        config: DQNConfig,
        folder: Path | None,
        run_id: str,
        saved: Content | None,
    ) -> None:
        interface = Interface.of(env)
        self.config, self.folder, self.id = config, folder, run_id
        if saved is not None:
            n_states = 1 if interface.tables is None else interface.tables.n_states
            weights = saved["agent"]["policy_network"]
            check_size(weights, config, interface.space, n_states, interface.n_actions)
        self.agent = DoubleDQN(interface.space, interface.n_actions, interface.tables, config)
        encoder = self.agent.encoder
        self.buffer: ReplayBuffer | Tally
        if self.agent.tabular:
            self.buffer = Tally(encoder, interface.n_actions, self.agent.tables.n_classes)
        else:
            size = ReplaySize.of(config, encoder, env.num_envs)
            size.check(config.device, config.max_memory, copied=folder is not None)
            self.buffer = ReplayBuffer(size.rows, encoder.width, encoder.dtype, config.device)
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

    def learn(self, learning_rate: float) -> list[float]:
        """Make the updates that are due; returns their losses."""
        config = self.config
        if len(self.buffer) < max(config.learning_starts, config.batch_size):
            return []
        if isinstance(self.buffer, Tally):
            return [self.agent.fit(self.buffer)] if len(self.buffer) >= GROWTH * self.buffer.fitted else []
        if self.rounds % config.train_frequency:
            return []
        batches = (self.buffer.sample(config.batch_size, self.generator) for _ in range(config.gradient_steps))
        return [self.agent.update(batch, learning_rate) for batch in batches]

    def advance(self, n_steps: int, losses: list[float], epsilon: float, learning_rate: float) -> Row | None:
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
        updates = None if self.agent.tabular else self.agent.updates
        wait = max(self.config.learning_starts, self.config.batch_size)
        everywhere = self.config.counterfactual
        return tuple(
            shortcomings(self.collector.seen, self.steps, counterfactual=everywhere, updates=updates, wait=wait)
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
            if isinstance(self.buffer, Tally) and len(self.buffer):
                self.agent.fit(self.buffer, to_the_end=True)
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
            "buffer": self.buffer.state_dict(),
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
        if isinstance(self.buffer, Tally):
            self.buffer.check_state(saved["buffer"])
        else:
            tables = self.agent.tables
            limits = {"state": tables.n_states, "action": self.agent.n_actions, "letter_class": tables.n_classes}
            self.buffer.check_state(saved["buffer"], limits)
        self.steps, self.rounds, self.leg = (saved[name].count() for name in ("steps", "rounds", "leg"))
        *counts, classes = saved["seen"].entries(4)
        read = [entry.count(most=self.agent.tables.n_classes - 1) for entry in classes.entries()]
        self.collector.load_seen_state([*(entry.count() for entry in counts), read])
        try:
            self.generator.set_state(saved["generator"].tensor(torch.uint8))
        except RuntimeError as error:
            saved["generator"].fail(f"is no state of a random generator ({error})")
        self.agent.load_state_dict(saved["agent"].value)
        self.buffer.load_state_dict(saved["buffer"].value)

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


def _agreed_config(config: DQNConfig | None, saved: Content | None) -> DQNConfig:
    """The configuration of the run; a resumed one goes on with its own."""
    if saved is None:
        return config or DQNConfig()
    before = config_of(saved["config"])
    if config is None:
        return before
    names = [field.name for field in dataclasses.fields(DQNConfig) if field.name not in _FREE_TO_CHANGE]
    changed = [name for name in names if getattr(config, name) != getattr(before, name)]
    if changed:
        pairs = ", ".join(f"{name} {getattr(before, name)!r}, not {getattr(config, name)!r}" for name in changed)
        raise InvalidArgumentError(f"the run to resume has {pairs}; resume with config=None")
    return config


def _seed(config: DQNConfig, stream: int) -> int:
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
