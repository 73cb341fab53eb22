"""The benchmark suite: its numbers, its data, its simulator, and what the agent learns in two of its tasks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import suite
from suite_tasks import FOLDER, build, load_suite, load_worlds
from suite_world import ModelWorld

from ltlc.errors import InvalidArgumentError, LtlcError, UnknownNameError
from ltlc.mdp import LabelledMDP
from ltlc.mdp.verdict import TOLERANCE

TASKS = load_suite()


@pytest.mark.parametrize("name", TASKS)
def test_exact_values_are_the_known_ones_and_bounded(name: str) -> None:
    found = suite.exact(TASKS[name])
    assert found.pmax == pytest.approx(TASKS[name].pmax, abs=1e-6)
    assert found.lower <= found.pmax <= found.upper
    assert found.upper - found.lower <= 1e-6
    assert found.optimum >= found.pmax - TOLERANCE


@pytest.mark.parametrize("name", [task.name for task in TASKS.values() if task.steps is not None])
def test_fewest_steps(name: str) -> None:
    assert suite.fewest_steps(TASKS[name]) == TASKS[name].steps


@pytest.mark.peer
def test_storm_agrees() -> None:
    pytest.importorskip("stormpy")
    for name in ("safe-absorbing", "gate", "until", "devious", "frozen-4x4-goal1-goal2"):
        found = suite.exact(TASKS[name], storm=True)
        assert found.storm == pytest.approx(found.pmax, abs=1e-5), name


@pytest.mark.slow
@pytest.mark.parametrize("name", ["devious", "gate"])
def test_what_the_default_agent_learns_is_optimal(name: str) -> None:
    found = suite.learn(TASKS[name], 0, TASKS[name].pmax, total_steps=60_000)
    assert found.shortfall == pytest.approx(0.0, abs=1e-6)
    assert found.steps >= 60_000


@pytest.mark.slow
def test_the_command_prints_and_writes_its_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    suite.main(["--exact", "theory", "gate", "--json", str(tmp_path / "suite.json")])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 1 + 8 + 2
    assert lines[-2].split()[:3] == ["gate", "22", "0.80000000"]
    assert (tmp_path / "suite.json").stat().st_size > 1000
    with pytest.raises(SystemExit):
        suite.main(["gat"])
    assert "Did you mean gate" in capsys.readouterr().err


@pytest.mark.slow
def test_every_world_offers_every_action_and_is_used() -> None:
    used = {id(task.world) for task in TASKS.values()}
    assert len(used) == len(TASKS)
    sources = {task.source for task in TASKS.values()}
    assert {world["source"] for world in load_worlds().values()} == sources
    for task in TASKS.values():
        assert task.model.available.all(), task.name


def test_office_is_icartes() -> None:
    office = build(load_worlds()["office"])
    shown = {
        (int(cell) % 12, 8 - int(cell) // 12): office.aps[int(letter).bit_length() - 1]
        for cell, letter in enumerate(office.letters[office.label_probability.argmax(axis=1)])
        if letter
    }
    assert {place for place, name in shown.items() if name == "plant"} == {
        (4, 1), (7, 1), (4, 7), (7, 7), (1, 4), (10, 4),
    }  # fmt: skip
    assert shown[1, 1], shown[10, 7] == ("a", "c")
    assert [place for place, name in sorted(shown.items()) if name == "coffee"] == [(3, 6), (8, 2)]
    assert divmod(office.initial_state, 12) == (7, 2)


MAP = {"source": "", "map": "S.\n.g", "motion": {"intended": 1.0}}


@pytest.mark.parametrize(
    ("world", "words"),
    [
        ({"map": "S.\n."}, "rows of the map have different widths"),
        ({"map": "..\n.g"}, "not one S on the map, and no start"),
        ({"labels": {"x": "goal"}}, r"labels speaks of \['x'\], which is not on the map"),
        ({"absorbing": "z"}, "absorbing speaks of"),
        ({"motion": {"intended": 0.5, "slip": 0.1}}, "is not of a kind the file describes"),
        ({"actions": 6}, "has 6 actions"),
    ],
)
def test_maps_that_cannot_be_read(world: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=f"here: .*{words}"):
        build(MAP | world, "here")


@pytest.mark.parametrize(
    ("steps", "labels", "words"),
    [
        ({"a": {"go": "b"}}, {}, "action go of a leads to b, which is no state"),
        ({"a": {"go": "a"}}, {"x": ["b"]}, r"labels speaks of \['b'\]"),
        ({"a": {"go": {"a": 0.5}}}, {}, "sum to 0.5"),
    ],
)
def test_steps_that_cannot_be_read(steps: dict[str, Any], labels: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=words):
        build({"steps": steps, "labels": labels}, "here")


@pytest.mark.parametrize(
    ("tasks", "worlds", "error", "words"),
    [
        ("[g]\nt = { world = 'two-pairs', formula = 'F a' }", "", InvalidArgumentError, "task 't': has no pmax"),
        ("[g]\nt = { world = 'two-pairs', formula = 'F a', pmax = 2 }", "", InvalidArgumentError, "no probability"),
        ("[g]\nt = { world = 'gat', formula = 'F a', pmax = 1 }", "", UnknownNameError, "Did you mean gate"),
        ("[g]\nt = { world = 'gate', formula = 'F a', pmax = 1, step = 2 }", "", UnknownNameError, "key of task 't': "),
        ("[g]\nt = 3", "", InvalidArgumentError, "task 't': is not a table"),
        ("[g", "", InvalidArgumentError, "tasks.toml is no TOML"),
        ("", "[w]\nsource = ''", InvalidArgumentError, "world 'w': has none of map, size, steps, env"),
        ("", "[w]\nmap = 'S'\nsource = ''", InvalidArgumentError, "world 'w': has no motion"),
        ("", "[w]\nmap = 'S'\nmoton = 1\nsource = ''", UnknownNameError, "Did you mean motion"),
    ],
)
def test_files_that_cannot_be_read(tmp_path: Path, tasks: str, worlds: str, error: type[LtlcError], words: str) -> None:
    (tmp_path / "tasks.toml").write_text(tasks)
    (tmp_path / "worlds.toml").write_text(worlds or (FOLDER / "suite_worlds.toml").read_text())
    with pytest.raises(error, match=words):
        load_suite(tmp_path / "worlds.toml", tmp_path / "tasks.toml")


def test_the_simulator_makes_the_steps_of_the_model() -> None:
    p = np.array([[[0.2, 0.8, 0], [0, 0.5, 0.5], [0, 0, 1]], [[0, 0, 1], [1, 0, 0], [0.1, 0, 0.9]]])
    mdp = LabelledMDP.from_arrays(p, aps="ab", labels={0: {"a": 0.3}, 1: "b"})
    world = ModelWorld(mdp, 4_000, 10)
    state, _ = world.reset(seed=0)
    counts, seen = np.zeros((2, 3, 3)), np.zeros((3, 4))
    for step in range(1, 31):
        actions = (np.arange(4_000) // 3 + step) % 2 if step % 3 else np.arange(4_000) % 2
        following, _, terminated, truncated, infos = world.step(actions)
        assert truncated.all() == truncated.any() == (step % 11 == 10) and not terminated.any()
        if step % 11:
            np.add.at(counts, (actions, state, following), 1)
        else:
            assert (following == 0).all()
        np.add.at(seen, (following, infos["labels"]), 1)
        state = following
    tried = counts.sum(axis=2)
    assert np.abs(counts / tried[..., None] - p).max() < 0.02
    assert np.allclose(
        seen / seen.sum(axis=1, keepdims=True), [[0.7, 0.3, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0]], atol=0.02
    )
    world.begin_episode(np.arange(4_000) < 10)
    assert (world.step(actions)[0][:10] == 0).all()
