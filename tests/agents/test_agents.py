"""Every agent of the registry: it learns a tiny world, is kept in a file, acts alike, and goes on where it was."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ltlc.agents import AGENTS, Agent, Progress, register_agent, train
from ltlc.agents.training.report import tabular_policy
from ltlc.cli.app import run
from ltlc.envs import GridWorld, LTLVectorWrapper, VectorGridWorld, labelled_mdp
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import Judge
from ltlc.task import Task

MAP = "S.A"
MINE = """
    from ltlc.agents import FittedQ

    class Patient(FittedQ):
        "Fitted Q iteration from a user's module."

        name = "patient"
"""


def a_task() -> Task:
    return Task("F A", "thesis")


def an_env(task: Task) -> LTLVectorWrapper:
    return LTLVectorWrapper(VectorGridWorld(MAP, 4, max_episode_steps=20), task, observation="none")


def settings(name: str) -> Any:
    """The defaults of an agent, but for a few steps and a small network."""
    defaults = AGENTS[name].defaults
    small = {"total_steps": 2_000, "log_every": 500, "checkpoint_every": 500, "hidden": [8], "batch_size": 32,
             "learning_starts": 64, "accuracy": 0.02, "averaging_steps": 500}  # fmt: skip
    return type(defaults).from_dict(
        defaults.to_dict() | {key: value for key, value in small.items() if key in defaults.to_dict()}
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", AGENTS)
def test_learns_and_is_kept_in_a_file(name: str, tmp_path: Path) -> None:
    task, config = a_task(), settings(name)
    seen: list[Progress] = []
    result = train(an_env(task), config, agent=name, folder=tmp_path / "run", callback=seen.append)
    agent: Agent = result.agent
    assert seen and result.total_steps == 2_000 and seen[-1].row.steps == result.steps
    policy = agent.policy_table()
    assert Judge(labelled_mdp(GridWorld(MAP)), task).satisfaction(policy) == pytest.approx(1)
    again = AGENTS[name].agent_class.load(tmp_path / "run" / "policy.ltlc")
    assert (again.policy_table() == policy).all()
    packed, states = agent.encoder.pack(np.arange(3)), np.full(3, task.tables.initial_state)
    assert (again.packed_policy(packed, states) == agent.packed_policy(packed, states)).all()
    assert (tabular_policy(again, labelled_mdp(GridWorld(MAP))) == policy).all()
    header = (tmp_path / "run" / "metrics.csv").read_text().partition("\n")[0]
    assert header.startswith("steps,updates,episodes,episode_return")  # one schema for all


class Killed(BaseException):
    """Stands for a kill."""


@pytest.mark.slow
@pytest.mark.parametrize("name", AGENTS)
def test_goes_on_where_it_was(name: str, tmp_path: Path) -> None:
    """Killed half through, and again at the last row: policy, checkpoint and metrics are those of a whole run."""
    task, config = a_task(), settings(name)
    seen: list[Progress] = []
    train(an_env(task), config, agent=name, folder=tmp_path / "whole", callback=seen.append)
    resume = False
    for row in (seen[len(seen) // 2].row, seen[-1].row):

        def kill(progress: Progress, last: int = row.steps, message: str = row.message) -> None:
            if progress.row.steps >= last and progress.row.message == message:
                raise Killed

        with pytest.raises(Killed):
            given = {} if resume else {"config": config, "agent": name}
            train(an_env(task), **given, folder=tmp_path / "parts", resume=resume, callback=kill)
        resume = True
    for _ in range(2):  # the second time, nothing is left to do
        result = train(an_env(task), folder=tmp_path / "parts", resume=True)
        assert result.steps == seen[-1].row.steps and not result.interrupted
        for file in ("policy.ltlc", "checkpoint.ltlc", "metrics.csv"):
            assert (tmp_path / "whole" / file).read_bytes() == (tmp_path / "parts" / file).read_bytes()


@pytest.mark.slow
def test_an_agent_of_a_users_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(textwrap.dedent(MINE))
    place = ["--env", "ltlc/Grid-v0", "--steps", "400", "--num-envs", "2"]
    assert run(["train", "F goal", *place, "--agent", "mine.py:Patient", "--out", "here", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["agent"] == "mine.py:Patient" and told["agent_reason"] is None
    assert run(["evaluate", "here", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["learned"] == told["learned"]
    register_agent("patient", "mine.py:Patient")
    try:
        assert run(["agents", "--json"]) == 0
        listed = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)}
        assert listed["patient"]["description"] == "Fitted Q iteration from a user's module."
        with pytest.raises(InvalidArgumentError, match="agent 'patient': the name is taken"):
            register_agent("patient", "mine.py:Patient")
    finally:
        AGENTS.remove("patient")


@pytest.mark.parametrize("part", [3, dict, "json:loads"])
def test_what_is_no_agent(part: Any) -> None:
    with pytest.raises(InvalidArgumentError, match="'nothing' is no agent"):
        register_agent("nothing", part)
        try:
            AGENTS["nothing"]
        finally:
            AGENTS.remove("nothing")


@pytest.mark.slow
def test_auto_says_what_it_chose(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    place = ["F goal", "--env", "ltlc/Grid-v0", "--steps", "200", "--num-envs", "2", "--out", "here"]
    assert run(["train", *place]) == 0
    assert "Agent: fitted-q, since the " in capsys.readouterr().out
    config, result = (json.loads(Path("here", name).read_text()) for name in ("config.json", "result.json"))
    assert config["agent"] == result["agent"] == "fitted-q"
    assert config["agent_reason"] == result["agent_reason"] and config["agent_reason"].endswith("can be numbered")
    assert run(["train", *place, "--agent", "fitted-q", "--resume"]) == 0  # the same run, whoever chose the agent
