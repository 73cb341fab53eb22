"""Scenes: what can hold together, and pictures of trajectories."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ltlc.compiler import compile
from ltlc.envs import VectorFlatWorld, VectorLetterWorld
from ltlc.pictures.trajectories import Trajectory, _unwrapped, draw_trajectories
from ltlc.scene import Region, Scene


@pytest.mark.slow
def test_what_can_hold_together() -> None:
    regions = (Region("a", 0, 0, 1), Region("b", 1, 0, 0.5, square=True), Region("c", -1.5, -1.5, 0.3))
    scene = Scene((-2, -2, 2, 2), regions, (0, 0))
    assert scene.labels == {frozenset(), frozenset("a"), frozenset("ab"), frozenset("b"), frozenset("c")}
    assert len(VectorFlatWorld().scene().labels) == 13
    letters = VectorLetterWorld()
    letters.reset(seed=0)
    assert letters.scene().labels == {frozenset(), *map(frozenset, "abcdefghijkl")}


def test_steps_round_a_torus_are_two_lines() -> None:
    scene = Scene((-0.5, -0.5, 6.5, 6.5), (), (0, 0), wraps=True)
    first, last = np.array([[0.0, 0.0], [3.0, 3.0]]), np.array([[6.0, 0.0], [3.0, 4.0]])
    begins, ends, colours = _unwrapped(scene, first, last, ["x", "y"])
    assert begins.tolist() == [[0, 0], [3, 3], [7, 0]]
    assert ends.tolist() == [[-1, 0], [3, 4], [6, 0]]
    assert colours == ["x", "y", "x"]


@pytest.mark.slow
def test_pictures_of_trajectories(tmp_path: Path) -> None:
    world = VectorLetterWorld()
    world.reset(seed=0)
    automaton = compile("F a")
    places = np.array([[0.0, 6.0], [6.0, 6.0], [6.0, 5.0]])
    one = Trajectory(world.scene(), places, np.array([0, 0, 1]), "2 steps")
    paths = [draw_trajectories(tmp_path / f"{i}.png", [one] * 4, automaton, title="F a") for i in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    few = draw_trajectories(tmp_path / "few.svg", [one], automaton, title="F a", subtitle="one")
    again = draw_trajectories(tmp_path / "again.svg", [one], automaton, title="F a", subtitle="one")
    assert b"q1  accepting" in few.read_bytes() == again.read_bytes()
