"""A run that ends no episode, or never sees an accepting step, says so while it runs and with the verdict."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ltlc.agents import DQNConfig, Progress, train
from ltlc.agents.encoder import ObservationEncoder
from ltlc.agents.training.collect import Collector, Interface
from ltlc.agents.training.shortcomings import Seen, shortcomings
from ltlc.cli.app import run
from ltlc.envs import LTLVectorWrapper, VectorGridWorld
from ltlc.task import Task

WORLD = ("--env", "ltlc/Thesis5x5-v0")
NETWORK = ("--hyper", "hidden=8", "--hyper", "batch_size=16", "--hyper", "learning_starts=16")


def test_nothing_is_said_where_all_is_well() -> None:
    assert shortcomings(Seen(4, 3, True, True), 100) == []
    assert shortcomings(Seen(4, 3, False, True), 100, counterfactual=True, updates=7) == []
    assert len(shortcomings(Seen(4, 3, False, True), 100, updates=7)) == 1


def test_what_is_missing_and_what_to_try() -> None:
    episodes, accepting, updates = shortcomings(Seen(64, 0, False, False, ("goal",)), 8_000, updates=0, wait=9_000)
    assert "No episode has ended in 8000 steps, 125 in each of 64 environments" in episodes
    assert "fewer environments" in episodes and "shorter episodes" in episodes
    assert "No step has been accepting in 8000 steps; never true so far: goal" in accepting
    assert "labels" in accepting and "shaping" in accepting and "epsilon_final" in accepting
    assert "the first update waits for 9000" in updates


@pytest.mark.slow
@pytest.mark.parametrize("agent", ["double-dqn", "q-learning"])
def test_the_command_says_so_while_it_runs_and_in_the_verdict(
    agent: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    pace = [] if agent == "double-dqn" else ["--hyper", "log_every=500"]
    few = ["--num-envs", "64", "--steps", "6000", "--agent", agent, *pace]
    assert run(["train", "F(A & B)", *WORLD, *few, "--json", "--out", "one"]) == 0
    out, err = capsys.readouterr()
    assert err.count("warning: No episode has ended") == err.count("warning: No step has been accepting") == 1
    told = json.loads(out)["shortcomings"]
    assert [text[:10] for text in told] == ["No episode", "No step ha"] and "in 60" in told[0]
    assert json.loads(Path("one/result.json").read_text())["shortcomings"] == told
    assert run(["train", "F(A & B)", *WORLD, *few, "--out", "two"]) == 0
    out, err = capsys.readouterr()
    assert "Note: No episode has ended in 60" in out and err.count("No episode has ended") == 1


def test_labels_in_another_order_count_where_each_step_teaches_every_state() -> None:
    """In this corridor B comes before A, and the episode ends there."""
    for formula, reachable in (("F(A & F B)", True), ("F(A & B)", False), ("F B", True), ("F(A & F C)", False)):
        env = LTLVectorWrapper(
            VectorGridWorld("SBA\n..C", 2, max_episode_steps=3), Task(formula), extra_labels="ignore"
        )
        collector = Collector(Interface.of(env), ObservationEncoder(Interface.of(env).space))
        collector.reset(0)
        for _ in range(2):
            collector.step(np.array([1, 1]))  # to the right
        seen = collector.seen
        assert (seen.accepting, seen.accepting_elsewhere) == (formula == "F B", reachable), formula


@pytest.mark.slow
def test_with_the_default_number_of_environments_episodes_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["train", "F A", *WORLD, "--steps", "6000", "--json", "--out", "one"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["shortcomings"] == [] and "No episode" not in err


@pytest.mark.slow
def test_a_network_that_was_never_updated_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["train", "F A", *WORLD, "--steps", "600", "--hyper", "hidden=8", "--json", "--out", "one"]) == 0
    assert any("first update waits for 1000" in text for text in json.loads(capsys.readouterr().out)["shortcomings"])


@pytest.mark.slow
def test_it_is_told_once_and_survives_a_checkpoint(tmp_path: Path) -> None:
    def env() -> LTLVectorWrapper:
        return LTLVectorWrapper(VectorGridWorld("S.A\n..B", 4, max_episode_steps=50), Task("F(A & B)"))

    told: list[tuple[int, tuple[str, ...]]] = []

    def look(progress: Progress) -> bool:
        told.append((progress.row.steps, progress.shortcomings))
        return progress.row.steps >= 600

    config = DQNConfig(
        hidden=(4,), batch_size=8, total_steps=1_200, log_every=100, checkpoint_every=300, buffer_size=99
    )
    first = train(env(), config, folder=tmp_path / "run", callback=look)
    assert [steps for steps, texts in told if texts] == [300]
    assert [text.split(" has ")[0] for text in first.shortcomings] == ["No step", "The network"]  # episodes of 50 ended
    resumed = train(env(), folder=tmp_path / "run", resume=True)
    assert resumed.shortcomings[0].startswith("No step has been accepting in 1200 steps")
    assert train(env(), config).shortcomings == resumed.shortcomings
