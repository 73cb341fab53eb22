"""A sweep through Ray Tune: its runs as a search space, and what trains one of them.

    from ray import tune
    space = search_space(grid) | {"hyper": {"epsilon_final": tune.uniform(0.01, 0.3)}}
    tuner = tune.Tuner(trainable(grid), param_space=space, tune_config=tune.TuneConfig(num_samples=20))
    best = tuner.fit().get_best_result("satisfaction", "max")

With the search space alone, Tune trains the runs of the grid into their folders, and `write_table(grid)` gives the same
table as `run_grid`. Parameters that are searched beside them make runs of their own.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ltlc.errors import InvalidArgumentError, MissingProgramError, UnknownNameError
from ltlc.sweeps.engine import train_cell
from ltlc.sweeps.grid import Cell, Grid
from ltlc.sweeps.running import write_plan
from ltlc.sweeps.table import outcome

try:
    from ray import tune
except ImportError as error:
    raise MissingProgramError.of_library("ray[tune]", "ray", error) from error

AXES = ("formula", "environment", "reward", "agent", "seed")
"""keys of a configuration that name a run of the grid."""
_OPTIONS = {"hyper": "--hyper", "set": "--set"}
"""keys of a configuration that hold further hyperparameters of the agent and parameters of the reward scheme."""


def search_space(grid: Grid) -> dict[str, Any]:
    """The runs of a sweep as a search space of Ray Tune: a grid search over each axis.

    Any axis may be replaced, as in `search_space(grid) | {"seed": tune.choice([0, 1])}`.
    """
    values = {axis: list(dict.fromkeys(getattr(cell, axis) for cell in grid.cells)) for axis in AXES}
    return {axis: tune.grid_search(found) for axis, found in values.items()}


def trainable(grid: Grid) -> Callable[[dict[str, Any]], None]:
    """What Ray Tune calls with each configuration: it trains that run and reports what it has learned.

    A configuration names a run by its axes. It may have tables `hyper` and `set` of further hyperparameters and
    parameters of the reward scheme, which are added to those of the grid. Runs that have their verdict are not trained
    again; those that were cut go on from their checkpoints.

    Returns:
        A function that reports `satisfaction`, `exact` and the `folder` of the run.

    Raises:
        InvalidArgumentError: the folder of the grid holds another sweep.
        FileFormatError: its plan is damaged.
        OSError: the folder cannot be written.
    """
    write_plan(grid)
    cwd = os.getcwd()

    def train(config: dict[str, Any]) -> None:
        cell = _cell(grid, config)
        said = train_cell(grid.folder, cell, cwd=cwd)
        found = outcome(Path(cwd) / grid.folder, cell)
        if said or found is None:
            raise RuntimeError(f"{cell.name}: {said or 'nothing was learned'}")
        value, exact = found
        tune.report({"satisfaction": value, "exact": exact, "folder": str(Path(cwd) / grid.folder / cell.name)})

    return train


def _cell(grid: Grid, config: Mapping[str, Any]) -> Cell:
    """The run of a configuration.

    Raises:
        UnknownNameError: it has another key.
        InvalidArgumentError: the sweep has no such run.
    """
    for key in config:
        if key not in (*AXES, *_OPTIONS):
            raise UnknownNameError("key of a configuration", key, (*AXES, *_OPTIONS))
    wanted = tuple(config.get(axis) for axis in AXES)
    found = next((cell for cell in grid.cells if tuple(getattr(cell, axis) for axis in AXES) == wanted), None)
    if found is None:
        raise InvalidArgumentError(f"the sweep has no run {dict(zip(AXES, wanted, strict=True))}")
    searched = {
        (option, name): value if isinstance(value, str) else json.dumps(value)
        for key, option in _OPTIONS.items()
        for name, value in sorted(config.get(key, {}).items())
    }
    if not searched:
        return found
    pairs = list(zip(found.arguments, (*found.arguments[1:], ""), strict=True))
    replaced = {
        index + offset
        for index, (option, text) in enumerate(pairs)
        if (option, text.partition("=")[0]) in searched
        for offset in (0, 1)
    }
    kept = [word for index, word in enumerate(found.arguments) if index not in replaced]
    words = [word for (option, name), text in searched.items() for word in (option, f"{name}={text}")]
    mark = hashlib.sha256("\0".join(words).encode()).hexdigest()[:12]
    return replace(found, arguments=(*kept, *words), variant=mark)
