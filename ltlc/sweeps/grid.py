"""What a sweep runs, read from a file."""

from __future__ import annotations

import itertools
import json
import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ltlc.errors import FileFormatError, InvalidArgumentError, UnknownNameError

_TABLES = ("formulas", "environments", "rewards", "agents")
_KEYS = ("out", "seeds", "steps", "num_envs", *_TABLES)
_ENVIRONMENT = ("env", "labels", "variables", "arguments", "episode_steps", "discretise", "initial_label")


@dataclass(frozen=True)
class Cell:
    """One run of a sweep.

    Attributes:
        formula, environment, reward, agent: names in the file.
        seed: of everything random.
        arguments: of the command that trains it, without the folder.
        variant: what sets it apart from the run of the same names in the file; empty: it is that.

    Example:
        >>> Cell("reach", "lake", "default", "auto", 3, ("F goal",)).name
        'reach-lake-default-auto-3'
    """

    formula: str
    environment: str
    reward: str
    agent: str
    seed: int
    arguments: tuple[str, ...]
    variant: str = ""

    @property
    def group(self) -> tuple[str, str, str, str]:
        """What runs that differ in the seed alone have in common."""
        return self.formula, self.environment, self.reward, self.agent

    @property
    def name(self) -> str:
        """Name of its folder."""
        return "-".join([*self.group, str(self.seed), *filter(None, [self.variant])])


@dataclass(frozen=True)
class Grid:
    """A sweep.

    Attributes:
        folder: of all its runs.
        cells: in the order of the file, seeds last.
    """

    folder: Path
    cells: tuple[Cell, ...]


def read_grid(path: str | os.PathLike[str]) -> Grid:
    """A sweep from a TOML file; docs/runs.md says what stands in one.

    Raises:
        FileFormatError: it is no TOML, or has no formula or environment, or two that make the same folder.
        UnknownNameError: it has a key that means nothing.
        InvalidArgumentError: a value is of another kind.
        OSError: it cannot be read.
    """
    file = Path(path)
    try:
        values = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{file} is no TOML: {error}") from error
    _check_keys(values, _KEYS, str(file))
    named = {kind: _table(values.get(kind, {}), f"{file}: {kind}") for kind in _TABLES}
    for kind in ("formulas", "environments"):
        if not named[kind]:
            raise FileFormatError(f'{file} has no {kind}; it needs a table [{kind}], such as reach = "F goal"')
    rewards, agents = named["rewards"] or {"default": {}}, named["agents"] or {"auto": {}}
    common = [
        word
        for key, option in (("steps", "--steps"), ("num_envs", "--num-envs"))
        if key in values
        for word in (option, str(_whole(values[key], f"{file}: {key}", least=1)))
    ]
    cells = tuple(
        Cell(
            formula,
            environment,
            reward,
            agent,
            seed,
            (
                _text(named["formulas"][formula], f"{file}: formula {formula}"),
                *_environment(named["environments"][environment], f"{file}: environment {environment}"),
                *_reward(reward, rewards[reward], bool(named["rewards"]), f"{file}: rewards {reward}"),
                *_agent(agent, agents[agent], f"{file}: agent {agent}"),
                *common,
                "--seed",
                str(seed),
            ),
        )
        for formula, environment, reward, agent, seed in itertools.product(
            named["formulas"], named["environments"], rewards, agents, _seeds(values.get("seeds", 1), f"{file}: seeds")
        )
    )
    names = [cell.name for cell in cells]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise FileFormatError(f"{file}: two runs would be in the folder {twice}; rename one of the parts")
    folder = _text(values.get("out", str(Path("sweeps") / file.stem)), f"{file}: out")
    return Grid(Path(folder), cells)


def _check_keys(values: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in values:
        if key not in known:
            raise UnknownNameError(f"entry of {where}", key, known)


def _table(values: Any, where: str) -> dict[str, Any]:
    if not isinstance(values, Mapping):
        raise InvalidArgumentError(f"{where} is {values!r:.60}; it must be a table of names")
    for name in values:
        if not re.fullmatch(r"\w[\w.-]*", name):
            raise InvalidArgumentError(
                f"{where}: the name {name!r} must be of letters, digits, _ and -, as in a folder"
            )
    return dict(values)


def _seeds(value: Any, where: str) -> list[int]:
    if isinstance(value, list):
        return [_whole(seed, where) for seed in value]
    return list(range(_whole(value, where, least=1)))


def _whole(value: Any, where: str, least: int = 0) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise InvalidArgumentError(f"{where} is {value!r}; it must be a whole number, at least {least}")
    return value


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise InvalidArgumentError(f"{where} is {value!r}; it must be a text")
    return value


def _environment(values: Any, where: str) -> list[str]:
    given = {"env": values} if isinstance(values, str) else _table(values, where)
    _check_keys(given, _ENVIRONMENT, where)
    words = ["--env", _text(given.get("env"), f"{where}: env")]
    for key in ("labels", "initial_label"):
        if key in given:
            words += [f"--{key.replace('_', '-')}", _text(given[key], f"{where}: {key}")]
    for key in ("episode_steps", "discretise"):
        if key in given:
            words += [f"--{key.replace('_', '-')}", str(_whole(given[key], f"{where}: {key}", least=1))]
    for name, place in _table(given.get("variables", {}), f"{where}: variables").items():
        words += ["--variables", f"{name}={place}"]
    return words + _assignments("--env-set", _table(given.get("arguments", {}), f"{where}: arguments"))


def _reward(name: str, values: Any, named: bool, where: str) -> list[str]:
    given = _table(values, where)
    scheme = given.pop("reward", name if named else None)
    words = [] if scheme is None else ["--reward", _text(scheme, f"{where}: reward")]
    for key in ("on_deadlock", "on_termination"):
        if key in given:
            words += [f"--{key.replace('_', '-')}", _text(given.pop(key), f"{where}: {key}")]
    return words + _assignments("--set", given)


def _agent(name: str, values: Any, where: str) -> list[str]:
    given = _table(values, where)
    return ["--agent", _text(given.pop("agent", name), f"{where}: agent"), *_assignments("--hyper", given)]


def _assignments(option: str, values: Mapping[str, Any]) -> list[str]:
    """Parameters as the command takes them: words as they are, everything else as JSON."""
    texts = ((name, value if isinstance(value, str) else json.dumps(value)) for name, value in values.items())
    return [word for name, text in texts for word in (option, f"{name}={text}")]
