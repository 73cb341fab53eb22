"""Environments that are stepped in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import pairwise
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

from ltlc.envs.batch import joined, joined_infos
from ltlc.errors import WorkerLost

BoolArray = npt.NDArray[np.bool_]

_PATIENCE = 1.0
"""seconds between two looks for the process that began this one, and that a worker has to close its environments."""


class WorkerVectorEnv(VectorEnv[Any, Any, Any]):
    """Sub-environments in several processes, each of which steps its share one by one.

    It is equal to a `SyncVectorEnv` of them all, in autoreset mode NEXT_STEP, to the last bit: seeds, order and
    restarts are the same. Processes end with `close`, with the one that began them, and not by Ctrl-C.

    Args:
        make: makes a number of sub-environments; called once here and in each process.
        num_envs: sub-environments in all.
        workers: processes, at most one for each sub-environment.

    Attributes:
        propositions: names that the sub-environments declare for their labels, or None.

    Raises:
        Exception: what `make` raises.
    """

    def __init__(self, make: Callable[[int], SyncVectorEnv], num_envs: int, workers: int) -> None:
        one = make(1)
        try:
            single: Any = one.envs[0]
            self.num_envs = num_envs
            self.spec, self.render_mode = one.spec, None
            self.metadata = {**one.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
            self.single_observation_space, self.single_action_space = single.observation_space, single.action_space
            declared = single.has_wrapper_attr("propositions")
            self.propositions = single.get_wrapper_attr("propositions") if declared else None
        finally:
            one.close()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        parts = np.array_split(np.arange(num_envs), min(workers, num_envs))
        self._slices = [slice(a, b) for a, b in pairwise([0, *np.cumsum([len(part) for part in parts]).tolist()])]
        self._late = np.zeros(num_envs, dtype=np.bool_)
        self._seen: list[Any] = [None] * len(parts)
        context: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else None)
        self._pipes: list[Connection] = []
        self.processes: list[Any] = []
        for part in parts:
            ours, theirs = context.Pipe()
            process = context.Process(target=_work, args=(theirs, os.getpid(), make, len(part)), daemon=True)
            with warnings.catch_warnings():  # workers do not use the threads that there are here
                warnings.simplefilter("ignore", DeprecationWarning)
                process.start()
            theirs.close()
            self._pipes.append(ours)
            self.processes.append(process)

    def begin_episode(self, mask: BoolArray) -> None:
        """Begin a new episode in these sub-environments at the next step, whatever the action."""
        self._late |= mask

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin episodes in all sub-environments, or in those of the boolean array `options["reset_mask"]`.

        Raises:
            Exception: what a sub-environment raises.
            WorkerLost: a process has ended.
        """
        n = self.num_envs
        seeds = [seed + i for i in range(n)] if isinstance(seed, int) else [None] * n if seed is None else list(seed)
        mask = (options or {}).get("reset_mask", np.ones(n, dtype=np.bool_))
        self._late &= ~mask
        asked = [i for i, part in enumerate(self._slices) if mask[part].any()]
        for i in asked:
            part = self._slices[i]
            masked = {"reset_mask": mask[part]} if "reset_mask" in (options or {}) else {}
            own = None if options is None else {**options, **masked}
            self._send(i, ("reset", {"seed": seeds[part], "options": own}))
        infos: list[dict[str, Any]] = [{} for _ in self._slices]
        for i, (observations, info) in zip(asked, self._receive(asked), strict=True):
            self._seen[i], infos[i] = observations, info
        return joined(self.single_observation_space, self._seen), joined_infos(infos, self._sizes)

    def step(self, actions: Any) -> tuple[Any, Any, BoolArray, BoolArray, dict[str, Any]]:
        """Step all sub-environments.

        Raises:
            Exception: what a sub-environment raises.
            WorkerLost: a process has ended.
        """
        for i, part in enumerate(self._slices):
            self._send(i, ("step", {"actions": actions[part], "late": self._late[part]}))
        self._late = np.zeros_like(self._late)
        steps = self._receive(range(len(self._slices)))
        self._seen = [step[0] for step in steps]
        rewards, terminated, truncated = (np.concatenate([step[k] for step in steps]) for k in (1, 2, 3))
        infos = joined_infos([step[4] for step in steps], self._sizes)
        return joined(self.single_observation_space, self._seen), rewards, terminated, truncated, infos

    def close_extras(self, **arguments: Any) -> None:
        """End the processes."""
        for pipe in self._pipes:
            with suppress(OSError):  # it has ended
                pipe.send(None)
        for process, pipe in zip(self.processes, self._pipes, strict=True):
            process.join(_PATIENCE)
            process.kill()
            process.join()
            pipe.close()

    @property
    def _sizes(self) -> list[int]:
        return [part.stop - part.start for part in self._slices]

    def _send(self, worker: int, message: tuple[str, dict[str, Any]]) -> None:
        try:
            self._pipes[worker].send(message)
        except OSError as error:
            raise self._lost(worker) from error

    def _receive(self, workers: Sequence[int]) -> list[Any]:
        """What the workers answer; the first failure is raised when all have."""
        results, failures = [], []
        for i in workers:
            try:
                good, result = self._pipes[i].recv()
            except (EOFError, OSError) as error:
                raise self._lost(i) from error
            results.append(result)
            failures += [] if good else [result]
        if failures:
            raise failures[0]
        return results

    def _lost(self, worker: int) -> WorkerLost:
        process = self.processes[worker]
        process.join(_PATIENCE)
        return WorkerLost(
            f"the process {process.pid}, which stepped environments, has ended with exit code {process.exitcode}; "
            "look for what ended it (memory?), and go on from the last checkpoint, or step without processes"
        )


def _work(pipe: Connection, parent: int, make: Callable[[int], SyncVectorEnv], n: int) -> None:
    """Do what comes through the pipe, until it says to end or the other process has."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the other process, which ends this one
    envs: SyncVectorEnv | None = None
    while True:
        while not pipe.poll(_PATIENCE):
            if os.getppid() != parent:
                return
        try:
            message = pipe.recv()
        except EOFError:
            return
        if message is None:
            break
        try:
            envs = envs or make(n)
            pipe.send((True, _done(envs, *message)))
        except BaseException as error:  # SystemExit, too, is for the other process
            error.add_note(f"in a process that steps environments:\n{traceback.format_exc()}")
            pipe.send((False, _sendable(error)))
    if envs is not None:
        envs.close()


def _done(envs: SyncVectorEnv, what: str, arguments: dict[str, Any]) -> Any:
    if what == "reset":
        return envs.reset(**arguments)
    envs._autoreset_envs |= arguments["late"]  # the only door there is to a reset at the next step
    return envs.step(arguments["actions"])


def _sendable(error: BaseException) -> BaseException:
    """The exception if it comes through a pipe whole, else one that says the same."""
    from multiprocessing.reduction import ForkingPickler

    try:
        ForkingPickler.loads(ForkingPickler.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__} in a process that steps environments: {error}")
    return error
