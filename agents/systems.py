"""Every way to learn a task, by the name that the command line knows: checked, trained, kept and loaded alike.

What is known of the agents is at hand without PyTorch; it is loaded where one learns or acts.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from ltlc.errors import InvalidArgumentError, UnknownNameError

from .double_dqn.config import DQNConfig
from .tabular.config import LearnerConfig
from .tabular.registry import LEARNERS

if TYPE_CHECKING:
    from ltlc.envs import LTLVectorWrapper
    from ltlc.mdp import Judge

    from .double_dqn.agent import DoubleDQN
    from .double_dqn.replay import ReplaySize
    from .tabular.policy import TablePolicy
    from .tabular.run import TableProgress
    from .training.loop import Progress

Agent: TypeAlias = "DoubleDQN | TablePolicy"
Hyperparameters = DQNConfig | LearnerConfig
Callback: TypeAlias = "Callable[[Progress | TableProgress], None]"


@dataclass(frozen=True)
class Entry:
    """What there is to say of an agent."""

    description: str
    """one sentence."""
    citation: str
    defaults: Hyperparameters


DOUBLE_DQN = "double-dqn"
AGENTS: Mapping[str, Entry] = MappingProxyType({
    DOUBLE_DQN: Entry(
        "A network or, of few observations, a table of values, from replayed steps that teach every automaton state.",
        "H. van Hasselt, A. Guez, D. Silver, AAAI 2016, doi 10.1609/aaai.v30i1.10295",
        DQNConfig(),
    ),
    **{name: Entry(learner.description, learner.citation, learner.config) for name, learner in LEARNERS.items()},
})  # fmt: skip
"""all agents by name."""


@dataclass(frozen=True)
class Trained:
    """What a training run came to."""

    agent: Agent | None
    """None: it was interrupted before anything was learned, or there is no policy; `message` says so."""
    steps: int
    """environment steps since the start of training."""
    seconds: float
    """of training, interruptions not counted."""
    interrupted: bool = False
    """whether it stopped on Ctrl-C."""
    saved_steps: int = 0
    """environment steps that the checkpoint holds."""
    message: str = ""
    """how training ended, where there is more to say than that its steps were made."""
    shortcomings: tuple[str, ...] = ()
    """what it lacked, and what to try."""


def hyperparameters(agent: str, values: Mapping[str, Any]) -> Hyperparameters:
    """The hyperparameters of an agent; those not given have their default.

    Raises:
        UnknownNameError: there is no such agent or hyperparameter.
        InvalidArgumentError: a value is out of range.
    """
    if agent not in AGENTS:
        raise UnknownNameError("agent", agent, AGENTS)
    defaults = AGENTS[agent].defaults
    return type(defaults).from_dict(defaults.to_dict() | dict(values))


def check(env: LTLVectorWrapper, config: Hyperparameters, given: Collection[str] = ()) -> ReplaySize | None:
    """Make everything once but for the replay buffer, so that wrong input is found before anything is written.

    Args:
        env: the environment.
        config: hyperparameters.
        given: names of those that somebody asked for.

    Returns:
        The size of the replay buffer of networks; None where there is none.

    Raises:
        InvalidArgumentError: a hyperparameter that was asked for is without effect here.
        MemoryLimitExceeded: the networks or the replay do not fit into memory.
        LtlcError: the environment, its labels, the task and the hyperparameters do not go together.
    """
    if not isinstance(config, DQNConfig):
        from .tabular.run import check_learner

        check_learner(env, config)
        return None
    from .double_dqn.agent import DoubleDQN
    from .double_dqn.replay import ReplaySize
    from .training.collect import Interface

    interface = Interface.of(env)
    agent = DoubleDQN(interface.space, interface.n_actions, interface.tables, config)
    unused = config.without_effect(tabular=agent.tabular, rewarded=interface.tables is not None)
    for name in given:
        if name in unused:
            raise InvalidArgumentError(f"{name} is without effect here: {unused[name]}")
    env.reset(seed=config.seed)
    if agent.tabular:
        return None
    size = ReplaySize.of(config, agent.encoder, env.num_envs)
    size.check(config.device, config.max_memory, copied=True)
    return size


def train_agent(
    env: LTLVectorWrapper,
    agent: str,
    config: Hyperparameters,
    folder: Path,
    *,
    run_id: str = "",
    resume: bool = False,
    judge: Judge | None = None,
    callback: Callback | None = None,
) -> Trained:
    """Train an agent to the end, or until Ctrl-C; metrics and the policy go into the folder.

    Args:
        env: the environment; it is not closed.
        agent: its name.
        config: its hyperparameters.
        folder: of the run; the caller has its lock.
        run_id: identity of the run, which its files carry.
        resume: whether to go on from a checkpoint. Tabular learners keep none; they begin anew.
        judge: of the task, where its dynamics are known, for the metrics of tabular learners.
        callback: called with each row of metrics.
    """
    from .tabular.run import train_learner
    from .training.loop import CHECKPOINT_FILE, POLICY_FILE, train_in

    if isinstance(config, DQNConfig):
        go_on = resume and (folder / CHECKPOINT_FILE).exists()  # else killed before the first checkpoint
        result = train_in(folder, env, config, run_id=run_id, resume=go_on, callback=callback)
        return Trained(
            result.agent, result.steps, result.seconds, result.interrupted, result.saved_steps,
            shortcomings=result.shortcomings,
        )  # fmt: skip
    last: list[TableProgress] = []

    def look(progress: TableProgress) -> None:
        last[:] = [progress]
        if callback is not None:
            callback(progress)

    try:
        learned = train_learner(env, LEARNERS[agent], config, folder=folder, judge=judge, callback=look)
    except KeyboardInterrupt:
        steps, seconds = (last[0].row.steps, last[0].row.seconds) if last else (0, 0.0)
        return Trained(None, steps, seconds, interrupted=True)
    if learned.agent is not None:
        learned.agent.save(folder / POLICY_FILE, run=run_id)
    return Trained(
        learned.agent, learned.steps, learned.seconds, message=learned.message, shortcomings=learned.shortcomings
    )


def load_agent(agent: str, path: str | os.PathLike[str]) -> Agent:
    """The agent whose policy was saved.

    Raises:
        FileFormatError: the file is damaged, or of another kind.
        OSError: it is missing or not readable.
    """
    from .double_dqn.agent import DoubleDQN
    from .tabular.policy import TablePolicy

    return DoubleDQN.load(path) if agent == DOUBLE_DQN else TablePolicy.load(path)


def on_device(config: Hyperparameters, device: str) -> DQNConfig:
    """The same hyperparameters for another device.

    Raises:
        InvalidArgumentError: the agent is no network.
    """
    if not isinstance(config, DQNConfig):
        raise InvalidArgumentError(f"tables stay in main memory; a device ({device}) is for the agent {DOUBLE_DQN!r}")
    return dataclasses.replace(config, device=device)
