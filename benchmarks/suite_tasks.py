"""The tasks of the suite as values: reads `suite_worlds.toml` and `suite_tasks.toml` and builds exact models.

The two files say what their entries mean. What is wrong with an entry is reported with its name.
"""

from __future__ import annotations

import itertools
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.mdp import LabelledMDP
from ltlc.mdp.model import Label

UP, RIGHT, DOWN, LEFT, STAY = (-1, 0), (0, 1), (1, 0), (0, -1), (0, 0)
MOVES = {"up": UP, "right": RIGHT, "down": DOWN, "left": LEFT, "stay": STAY}
Cell = tuple[int, int]
Outcomes = Mapping[Cell, float]
"""move -> probability"""

FOLDER = Path(__file__).parent
_KINDS = {
    "map": {"map", "walled", "labels", "start", "motion", "actions", "absorbing", "firm", "forced"},
    "size": {"size", "regions", "start", "motion", "actions", "absorbing"},
    "steps": {"steps", "labels"},
    "env": {"env", "arguments", "labels"},
}
_OVERRIDES = {"motion", "absorbing", "start"}
_ROW = {"world", "formula", "pmax", "published", "steps"}


@dataclass(frozen=True)
class SuiteTask:
    """A world with a formula, and what is known of it."""

    name: str
    group: str
    formula: str
    pmax: float
    """the maximum satisfaction probability, as published or as computed by independent means."""
    published: bool
    steps: int | None
    """fewest steps until the formula is satisfied whatever follows; None where nothing is known of that."""
    source: str
    world: Mapping[str, Any] = field(repr=False)
    """its entry, with the changes of the task."""

    @cached_property
    def model(self) -> LabelledMDP:
        """The exact model of the world; every state offers every action."""
        return build(self.world, f"task {self.name!r}")


def load_suite(
    worlds: Path = FOLDER / "suite_worlds.toml", tasks: Path = FOLDER / "suite_tasks.toml"
) -> dict[str, SuiteTask]:
    """All tasks by name, in the order of the file.

    Raises:
        InvalidArgumentError: a file is no TOML, or an entry is not as the file says entries are.
        UnknownNameError: an entry speaks of a world or has a key that does not exist.
    """
    known = load_worlds(worlds)
    suite: dict[str, SuiteTask] = {}
    for group, rows in _read(tasks).items():
        for name, row in rows.items():
            if name in suite:
                raise InvalidArgumentError(f"{tasks.name}: there are two tasks {name!r}")
            suite[name] = _task(name, group, row, known)
    return suite


def load_worlds(path: Path = FOLDER / "suite_worlds.toml") -> dict[str, Any]:
    """The entries of `suite_worlds.toml` by name, to change and to `build`.

    Raises:
        InvalidArgumentError: the file is no TOML, or an entry is not as the file says entries are.
        UnknownNameError: an entry has a key that does not exist.
    """
    worlds = _read(path)
    for name, world in worlds.items():
        _check_world(world, f"world {name!r}")
    return worlds


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise InvalidArgumentError(f"{path.name} is no TOML: {error}") from error


def _task(name: str, group: str, row: Any, worlds: Mapping[str, Any]) -> SuiteTask:
    where = f"task {name!r}"
    _require(isinstance(row, dict), where, "is not a table")
    _check_keys(row, _ROW | _OVERRIDES, {"world", "formula", "pmax"}, where)
    if row["world"] not in worlds:
        raise UnknownNameError(f"{where}: world", str(row["world"]), worlds)
    _require(isinstance(row["pmax"], int | float) and 0 <= row["pmax"] <= 1, where, "pmax is no probability")
    world = worlds[row["world"]] | {key: row[key] for key in _OVERRIDES & row.keys()}
    _check_world(world, where)
    return SuiteTask(
        name=name,
        group=group,
        formula=row["formula"],
        pmax=float(row["pmax"]),
        published=row.get("published", False),
        steps=row.get("steps"),
        source=world["source"],
        world=world,
    )


def _check_world(world: Any, where: str) -> None:
    _require(isinstance(world, dict), where, "is not a table")
    kinds = [kind for kind in _KINDS if kind in world]
    _require(len(kinds) == 1, where, f"has {' and '.join(kinds) or 'none'} of {', '.join(_KINDS)}; it needs one")
    required = {"source"} | ({"motion"} if kinds[0] in ("map", "size") else set())
    _check_keys(world, _KINDS[kinds[0]] | required, required, where)


def _check_keys(entry: Mapping[str, Any], allowed: Iterable[str], required: Iterable[str], where: str) -> None:
    for key in entry:
        if key not in allowed:
            raise UnknownNameError(f"key of {where}:", key, sorted(allowed))
    missing = sorted(set(required) - entry.keys())
    _require(not missing, where, f"has no {', '.join(missing)}")


def build(world: Mapping[str, Any], where: str = "world") -> LabelledMDP:
    """The model of an entry of `suite_worlds.toml`.

    Raises:
        InvalidArgumentError: the entry is not as the file says entries are.
    """
    if "steps" in world:
        return _of_steps(world, where)
    if "env" in world:
        return _of_env(world)
    return _of_map(world, where) if "map" in world else _of_regions(world, where)


def _of_map(world: Mapping[str, Any], where: str) -> LabelledMDP:
    lines = world["map"].strip("\n").splitlines()
    width = max(map(len, lines), default=0)
    _require(all(len(line) == width for line in lines), where, "the rows of the map have different widths")
    walls: set[frozenset[Cell]] = set()
    if world.get("walled", False):
        lines, walls = _without_walls(lines)
    cells = {(r, c): character for r, line in enumerate(lines) for c, character in enumerate(line)}
    found: dict[str, list[Cell]] = {}
    for cell, character in cells.items():
        found.setdefault(character, []).append(cell)
    meaning = {c: c for c in found if c not in ".#S"} | world.get("labels", {})
    for key in ("labels", "firm", "forced"):
        odd = [character for character in world.get(key, ()) if character not in found]
        _require(not odd, where, f"{key} speaks of {odd}, which is not on the map")
    start = world.get("start") or (found["S"][0] if len(found.get("S", ())) == 1 else None)
    _require(start is not None, where, "has not one S on the map, and no start")
    directions = _directions(world, where)
    special = {cell: intended(directions, 1.0) for character in world.get("firm", "") for cell in found[character]}
    for character, outcomes in world.get("forced", {}).items():
        same = [{MOVES[direction]: p for direction, p in outcomes.items()}] * len(directions)
        special |= dict.fromkeys(found[character], same)
    return grid(
        len(lines),
        len(lines[0]),
        _motion(world, directions, where),
        {cell: meaning[character] for cell, character in cells.items() if meaning.get(character)},
        start=tuple(start),
        blocked=found.get("#", []),
        absorbing=_absorbing(world, found, where),
        special=special,
        walls=walls,
    )


def _without_walls(lines: Sequence[str]) -> tuple[list[str], set[frozenset[Cell]]]:
    """The cells of a map with drawn walls, and the pairs of neighbours that a wall is between."""
    cells = [line[1::2] for line in lines[1::2]]
    walls = set()
    for row, column in np.ndindex(len(cells), len(cells[0])):
        for down, right in (RIGHT, DOWN):
            if lines[2 * row + 1 + down][2 * column + 1 + right] != " ":
                walls.add(frozenset({(row, column), (row + down, column + right)}))
    return cells, walls


def _of_regions(world: Mapping[str, Any], where: str) -> LabelledMDP:
    _require("start" in world, where, "has no start")
    labels: dict[Cell, str] = {}
    for name, boxes in world.get("regions", {}).items():
        for top, bottom, left, right in boxes:
            for cell in itertools.product(range(top, bottom), range(left, right)):
                _require(cell not in labels, where, f"cell {cell} is in {labels.get(cell)} and in {name}")
                labels[cell] = name
    height, width = world["size"]
    moves = _motion(world, _directions(world, where), where)
    return grid(height, width, moves, labels, start=tuple(world["start"]), absorbing=_absorbing(world, {}, where))


def _directions(world: Mapping[str, Any], where: str) -> list[Cell]:
    n_actions = world.get("actions", 4)
    _require(n_actions in (4, 5), where, f"has {n_actions} actions; a grid has 4, or 5 with staying")
    return list(MOVES.values())[:n_actions]


def _motion(world: Mapping[str, Any], directions: Sequence[Cell], where: str) -> list[Outcomes]:
    motion = world["motion"]
    if motion.keys() == {"intended", "turned"}:
        return sideways(motion["intended"], motion["turned"])
    if motion.keys() == {"intended"}:
        return intended(directions, motion["intended"])
    _require(motion.keys() == {"uniform"}, where, f"motion {dict(motion)} is not of a kind the file describes")
    return uniform_slip(motion["uniform"], directions)


def _absorbing(world: Mapping[str, Any], found: Mapping[str, list[Cell]], where: str) -> list[Cell]:
    given = world.get("absorbing", "")
    if not isinstance(given, str):
        return [tuple(cell) for cell in given]
    odd = [character for character in given if character not in found]
    _require(not odd, where, f"absorbing speaks of {odd}, which is not on the map")
    return [cell for character in given for cell in found[character]]


def _of_steps(world: Mapping[str, Any], where: str) -> LabelledMDP:
    steps = world["steps"]
    states = list(steps)
    actions = list(dict.fromkeys(action for offered in steps.values() for action in offered))
    p = np.zeros((len(actions), len(states), len(states)))
    for state, offered in steps.items():
        for action in actions:
            outcomes = offered[action] if action in offered else next(iter(offered.values()))
            for target, chance in ({outcomes: 1.0} if isinstance(outcomes, str) else outcomes).items():
                _require(target in steps, where, f"action {action} of {state} leads to {target}, which is no state")
                p[actions.index(action), states.index(state), states.index(target)] += chance
    names = world.get("labels", {})
    odd = [state for shown in names.values() for state in shown if state not in steps]
    _require(not odd, where, f"labels speaks of {odd}, which is no state")
    labels = {i: [name for name, shown in names.items() if state in shown] for i, state in enumerate(states)}
    return LabelledMDP.from_arrays(
        p, aps=sorted(names), labels=labels, state_names=tuple(states), action_names=tuple(actions)
    )


def _of_env(world: Mapping[str, Any]) -> LabelledMDP:
    import gymnasium

    env: Any = gymnasium.make(world["env"], **world.get("arguments", {})).unwrapped
    names = world.get("labels", {})
    labels = {state: [name for name, shown in names.items() if state in shown] for state in range(len(env.P))}
    start = int(np.argmax(env.initial_state_distrib))
    return replace(LabelledMDP.from_table(env.P, aps=sorted(names), labels=labels, initial_state=start), terminal=None)


def _require(condition: object, where: str, problem: str) -> None:
    if not condition:
        raise InvalidArgumentError(f"{where}: {problem}")


def grid(
    height: int,
    width: int,
    actions: Sequence[Outcomes],
    labels: Mapping[Cell, Label],
    *,
    start: Cell = (0, 0),
    blocked: Sequence[Cell] = (),
    absorbing: Sequence[Cell] = (),
    special: Mapping[Cell, Sequence[Outcomes]] | None = None,
    walls: Iterable[frozenset[Cell]] = (),
    aps: Sequence[str] | None = None,
) -> LabelledMDP:
    """A grid world; a move over the edge, through a wall or into a blocked cell stays.

    Args:
        height: rows.
        width: columns.
        actions: of each action, where it leads with what probability.
        labels: of the cells that have one; see `LabelledMDP.with_labels`.
        start: first cell.
        blocked: cells that cannot be entered.
        absorbing: cells that are never left.
        special: other outcomes of the actions in some cells.
        walls: pairs of neighbouring cells with a wall between.
        aps: propositions; those that occur, ordered, by default.
    """
    closed, stuck, between = set(blocked), {*absorbing, *blocked}, set(walls)
    entries: list[list[tuple[int, int, float]]] = [[] for _ in actions]
    for cell in np.ndindex(height, width):
        outcomes = (special or {}).get(cell, actions)
        for a, chances in enumerate(outcomes):
            for (down, right), p in chances.items():
                to = (cell[0] + down, cell[1] + right)
                inside = 0 <= to[0] < height and 0 <= to[1] < width and to not in closed
                if not inside or cell in stuck or (between and frozenset({cell, to}) in between):
                    to = cell
                entries[a].append((cell[0] * width + cell[1], to[0] * width + to[1], p))
    n = height * width
    matrices = []
    for found in entries:
        source, target, p = (np.array(column) for column in zip(*found, strict=True))
        matrices.append(sparse.csr_array((p, (source, target)), shape=(n, n)))
    if aps is None:
        aps = sorted({name for label in labels.values() for name in ([label] if isinstance(label, str) else label)})
    flat = {row * width + column: label for (row, column), label in labels.items()}
    return LabelledMDP.from_arrays(matrices, aps=aps, labels=flat, initial_state=start[0] * width + start[1])


def intended(moves: Sequence[Cell], chance: float) -> list[Outcomes]:
    """Each action succeeds with probability `chance`; the rest is shared by the other moves."""
    other = (1 - chance) / (len(moves) - 1)
    return [{move: chance if move == chosen else other for move in moves} for chosen in moves]


def sideways(intended: float, side: float) -> list[Outcomes]:
    """Up, right, down, left; slips to both perpendicular directions."""
    turn = [UP, RIGHT, DOWN, LEFT]
    return [{turn[i]: intended, turn[(i + 1) % 4]: side, turn[i - 1]: side} for i in range(4)]


def uniform_slip(slip: float, moves: Sequence[Cell] = (UP, RIGHT, DOWN, LEFT)) -> list[Outcomes]:
    """With probability `slip` a uniformly random one of the moves, the intended one included."""
    return [{move: slip / len(moves) + (1 - slip) * (move == chosen) for move in moves} for chosen in moves]
