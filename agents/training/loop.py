"""The training loop of algorithm 1, for many environments at once, interruptible at any moment."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import torch
from gymnasium.vector import VectorEnv

from ltlc.mdp.verdict import Judge
from ltlc.rewards import RewardTables

from ..choice import choose_agent
from ..config import AgentConfig, OffPolicyConfig
from ..registry import AGENTS, agent_of
from ..value_agent import ValueAgent
from .checkpoint import Checkpoint, agent_of_checkpoint, agreed_run, stream_seed
from .collect import Collector, Interface
from .contents import Content
from .folder_lock import locked_folder
from .interrupt import InterruptFlag
from .metrics import Metrics, Row
from .progress import Callback, Progress, Stopwatch, TrainingResult
from .shortcomings import EARLY, shortcomings
from .storage import POLICY_FILE


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
            agent = agent_of_checkpoint(where) if resume else choose_agent(env).agent
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
    interface, fitted = Interface.of(env), AGENTS[agent].agent_class.fitted
    saved, agreed, run_id = agreed_run(agent, config, folder, run_id, resume, lambda one: fitted(one, interface)[0])
    tables: RewardTables | None
    config, tables = fitted(agreed, interface)
    assert isinstance(config, OffPolicyConfig)
    with _threads(config.threads), InterruptFlag() as interrupt:
        run = _Run(interface, agent, config, tables, folder, run_id, saved)
        stopped = False
        while run.steps < config.total_steps and not stopped and not interrupt.raised:
            epsilon, learning_rate = config.epsilon_at(run.steps), run.agent.learning_rate_at(run.steps)
            actions = run.agent.explore(run.collector.packed, run.collector.states, epsilon, run.generator)
            steps = run.collector.step(actions)
            run.memory.add(steps)
            losses = run.learn() if len(steps.action) else []
            row = run.advance(len(steps.action), losses, epsilon, learning_rate)
            if row is not None and callback is not None:
                with run.watch.paused():
                    stopped = bool(callback(Progress(run.agent, row, config.total_steps, run.early_shortcomings())))
            if run.leg_is_over() and run.steps < config.total_steps:
                run.begin_leg()
        message = run.finish(lambda: interrupt.raised)
        return TrainingResult(
            run.agent, run.steps, config.total_steps, run.watch.seconds, interrupt.raised, folder, run.saved_steps,
            run.shortcomings(), message,
        )  # fmt: skip


class _Run:
    """The state of a training run: everything a checkpoint holds."""

    def __init__(
        self,
        interface: Interface,
        agent: str,
        config: OffPolicyConfig,
        tables: RewardTables | None,
        folder: Path | None,
        run_id: str,
        saved: Content | None,
    ) -> None:
        env = interface.env
        agent_class: type[ValueAgent] = AGENTS[agent].agent_class
        self.config, self.folder, self.id, self.interface = config, folder, run_id, interface
        if saved is not None:
            n_states = 1 if tables is None else tables.n_states
            weights = saved["agent"]["policy_network"]
            agent_class.check_size(weights, config, interface.space, n_states, interface.n_actions)
        self.agent = agent_class(interface.space, interface.n_actions, tables, config)
        self.agent.learn_in(interface)
        encoder, tables = self.agent.encoder, self.agent.tables
        self.checkpoint = Checkpoint(folder, run_id, agent, config, tables, encoder.space, env.num_envs)
        self.agent.check_memory(env.num_envs, copied=folder is not None)
        self.memory = self.agent.new_memory(env.num_envs)
        self.collector = Collector(interface, encoder)
        self.generator = torch.Generator().manual_seed(stream_seed(config, 0))
        self.steps = self.rounds = self.leg = 0
        self._told = False
        if saved is not None:
            self.checkpoint.check(saved)
            self._restore(saved)
        self.metrics = Metrics(folder, self.steps)
        self.watch = Stopwatch(self.metrics.seconds)
        if saved is None:
            self._write()
        else:
            self.metrics.load_state_dict(saved["metrics"].value)
        self.saved_steps = self.steps
        self._reset()

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
        return self.metrics.row(self.steps, self.agent.updates, epsilon, learning_rate, round(self.watch.seconds, 3))

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

    def finish(self, stop: Callable[[], bool]) -> str:
        """Write the last checkpoint, unless the leg was cut short or nothing happened since, and the policy.

        Args:
            stop: whether the training was interrupted, which it may be meanwhile.

        Returns:
            What is to be told of the policy.
        """
        if self.steps > self.saved_steps:
            self.agent.finish(self.memory)
            if not stop():
                self.save()
        message = "" if stop() else self.agent.settle(self.interface, stream_seed(self.config, self.leg + 1), stop)
        self.metrics.close()
        if self.folder is not None:
            self.agent.save(self.folder / POLICY_FILE, run=self.id)
        return message

    def save(self) -> None:
        """End the leg with a checkpoint: the old one, or the new one, is there at any moment."""
        self.leg += 1
        self._write()

    def _write(self) -> None:
        self.saved_steps = self.steps
        self.checkpoint.write({
            "steps": self.steps,
            "rounds": self.rounds,
            "leg": self.leg,
            "seen": self.collector.seen_state(),
            "generator": self.generator.get_state(),
            "agent": self.agent.state_dict(),
            "memory": self.memory.state_dict(),
            "metrics": self.metrics.state_dict(),
        })  # fmt: skip

    def _reset(self) -> None:
        every = self.config.checkpoint_every
        self._leg_end = (self.steps // every + 1) * every
        self.collector.reset(stream_seed(self.config, self.leg + 1))
        self.agent.begin()
        self.memory.cut()

    def _restore(self, saved: Content) -> None:
        """Go back to where a checkpoint was written; all of it is checked before any file is touched."""
        self.agent.check_state(saved["agent"])
        Metrics.check_state(saved["metrics"])
        self.memory.check_state(saved["memory"])
        self.steps, self.rounds, self.leg = (saved[name].count() for name in ("steps", "rounds", "leg"))
        self.collector.load_seen_state(saved["seen"], self.agent.tables.n_classes)
        try:
            self.generator.set_state(saved["generator"].tensor(torch.uint8))
        except RuntimeError as error:
            saved["generator"].fail(f"is no state of a random generator ({error})")
        self.agent.load_state_dict(saved["agent"].value)
        self.memory.load_state_dict(saved["memory"].value)


@contextlib.contextmanager
def _threads(count: int | None) -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(before if count is None else count)
    try:
        yield
    finally:
        torch.set_num_threads(before)
