"""The checkpoint of a run: what it is of, where it is, and whether another run may go on from it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces

from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables

from ..config import AgentConfig
from ..registry import AGENTS
from .contents import Content, config_of, tables_of
from .storage import CHECKPOINT_FILE, read_file, run_of, same_tables, tables_to_tensors, write_file

_FILE_KIND = "checkpoint"
_FREE_TO_CHANGE = ("device", "threads")
"""hyperparameters that a resumed run may have different."""


@dataclass(frozen=True)
class Checkpoint:
    """The checkpoint file of a run, and what it is of.

    Attributes:
        folder: of the run; None: nothing is written.
        run: identity of the run.
        agent: its name in the registry.
        config: hyperparameters.
        tables: reward tables of the task.
        space: of a single observation, without the automaton.
        num_envs: sub-environments.
    """

    folder: Path | None
    run: str
    agent: str
    config: AgentConfig
    tables: RewardTables
    space: spaces.Space[Any]
    num_envs: int

    def write(self, content: dict[str, Any]) -> None:
        """Replace the checkpoint: the old one, or the new one, is there at any moment.

        Args:
            content: what `write_file` takes.

        Raises:
            OSError: the folder cannot be written; an older checkpoint is as it was.
        """
        if self.folder is None:
            return
        head = {
            "name": self.agent,
            "config": self.config.to_dict(),
            "tables": tables_to_tensors(self.tables),
            "space": repr(self.space),
            "num_envs": self.num_envs,
        }
        write_file(self.folder / CHECKPOINT_FILE, _FILE_KIND, head | content, self.run)

    def check(self, saved: Content) -> None:
        """Check that a checkpoint is of this task and environment.

        Raises:
            InvalidArgumentError: it is of another.
            FileFormatError: a value in it is wrong.
        """
        if not same_tables(tables_of(saved["tables"]), self.tables):
            raise InvalidArgumentError(
                "the checkpoint is of a task with other reward tables; resume with the same task"
            )
        here = (repr(self.space), self.num_envs)
        space, num_envs = saved["space"].text(), saved["num_envs"].count(1)
        if here != (space, num_envs):
            raise InvalidArgumentError(
                f"the checkpoint is of {num_envs} environments that show {space}, "
                f"this is {here[1]} that show {here[0]}; resume with the same environment"
            )


def find_checkpoint(folder: Path | None, resume: bool) -> Content | None:
    """Read the checkpoint to resume from, or None to start afresh.

    Raises:
        InvalidArgumentError: there is none to resume from, or one that is not to be resumed.
        FileFormatError: it is damaged.
    """
    path = None if folder is None else folder / CHECKPOINT_FILE
    exists = path is not None and path.exists()
    if resume and not exists:
        raise InvalidArgumentError(f"there is no checkpoint to resume from in {folder}; train with resume=False first")
    if exists and not resume:
        raise InvalidArgumentError(f"{folder} holds a training run; pass resume=True to go on, or another folder")
    return read_file(path, _FILE_KIND) if resume and path is not None else None


def agent_of_checkpoint(folder: Path | None) -> str:
    """Say whose checkpoint is in a folder; raises as `find_checkpoint` does."""
    saved = find_checkpoint(folder, resume=True)
    assert saved is not None
    return saved["name"].text()


def agreed_run(
    agent: str,
    config: Any,
    folder: Path | None,
    run: str,
    resume: bool,
    fit: Callable[[Any], Any] = lambda open_: open_,
) -> tuple[Content | None, Any, str]:
    """Agree on what is trained; a resumed run goes on with its own hyperparameters and identity.

    Args:
        agent: name of the agent.
        config: its hyperparameters; None: those of the run to resume, or the defaults. What it leaves open is as in the
            run to resume.
        folder: of the run, or None.
        run: identity of a run that begins.
        resume: whether to go on from the checkpoint in the folder.
        fit: fills in what hyperparameters leave open.

    Returns:
        The checkpoint to resume from, if any; the hyperparameters; the identity of the run.

    Raises:
        InvalidArgumentError: as `find_checkpoint`; or the run to resume is of another agent or configuration.
        FileFormatError: the checkpoint is damaged.
    """
    saved, defaults = find_checkpoint(folder, resume), AGENTS[agent].defaults
    if saved is None or folder is None:
        return None, fit(config or defaults), run
    name = saved["name"].text()
    if name != agent:
        raise InvalidArgumentError(f"the run to resume is of the agent {name!r}, not {agent!r}")
    before = config_of(saved["config"], type(defaults))
    if config is None:
        return saved, before, run_of(folder / CHECKPOINT_FILE)
    names = [field.name for field in dataclasses.fields(before) if field.name not in _FREE_TO_CHANGE]
    left_open = {name: getattr(before, name) for name in names if getattr(config, name, 0) is None}
    config = fit(dataclasses.replace(config, **left_open))
    changed = [name for name in names if getattr(config, name) != getattr(before, name)]
    if changed:
        pairs = ", ".join(f"{name} {getattr(before, name)!r}, not {getattr(config, name)!r}" for name in changed)
        raise InvalidArgumentError(f"the run to resume has {pairs}; resume with config=None")
    return saved, config, run_of(folder / CHECKPOINT_FILE)


def stream_seed(config: AgentConfig, stream: int) -> int:
    """Derive independent seeds: 0 of the agent's random numbers, 1, 2, ... of the environment in each leg."""
    return int(np.random.SeedSequence([config.seed, stream]).generate_state(1)[0] >> 1)
