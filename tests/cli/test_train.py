"""The commands that learn: what they print, what a run folder holds, and what becomes of wrong input."""

from __future__ import annotations

import json
import re
import signal
import textwrap
from pathlib import Path

import numpy as np
import pytest
from cli_process import process
from cli_worlds import GRID, LAKE, POLE, SENSORS, SMALL

from ltlc.agents import DoubleDQN
from ltlc.agents.training.run_config import RunConfig, default_folder
from ltlc.agents.training.run_folder import RunFolder
from ltlc.cli.app import run
from ltlc.compiler import compile
from ltlc.envs.spec import EnvSpec
from ltlc.errors import UnknownNameError
from ltlc.task import Task

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Every test runs in a folder of its own, which holds the labels."""
    Path("sensors.py").write_text(textwrap.dedent(SENSORS))
    return folder


def q_values(path: str) -> np.ndarray:
    agent = DoubleDQN.load(Path(path) / "policy.ltlc")
    return agent.q_values(agent.encoder.all_observations())


class TestTrain:
    @pytest.mark.slow
    def test_a_run_and_its_folder(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["train", *LAKE, "--steps", "600", "--num-envs", "4", *SMALL]) == 0
        out = capsys.readouterr().out
        assert "largest probability of satisfying the formula here is 0.823529" in out
        assert "return" in out and "violations" in out and "left" in out and "optimal for the rewards" in out
        assert re.search(r"steps  P\(satisfied\) 0\.?\d*  return", out)
        place = Path("runs/f-goal-g-hole-frozenlake-v1-0")
        files = {path.name for path in place.iterdir()}
        assert {"config.json", "dra.json", "metrics.csv", "checkpoint.ltlc", "policy.ltlc", "result.json"} <= files
        assert (place / "policy.png").read_bytes().startswith(b"\x89PNG")
        assert (place / "curve.png").read_bytes().startswith(b"\x89PNG")
        result = json.loads((place / "result.json").read_text())
        assert result["exact"] and result["optimal"]["satisfaction"] == pytest.approx(14 / 17)
        assert run(["evaluate", str(place), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["learned"] == result["learned"]
        assert run(["evaluate", str(place)]) == 0
        assert "Lost against the optimum" in capsys.readouterr().out

    @pytest.mark.slow
    def test_a_callback_gets_each_row_and_can_end_the_training(self, capsys: pytest.CaptureFixture[str]) -> None:
        Path("mine.py").write_text(
            "rows = []\n"
            "def log(progress):\n"
            "    print('logged', sorted(progress.row.to_dict())[:3])\n"
            "    return progress.row.steps >= 200\n"
            "wrong = 3\n"
        )
        options = ["--steps", "600", "--episode-steps", "10", "--out", "pole", *SMALL]
        assert run(["train", *POLE, *options, "--callback", "mine:log"]) == 0
        out = capsys.readouterr().out
        assert "logged ['acceptances', 'episode_length', 'episode_return']" in out
        assert re.search(r"steps  P\(satisfied\) about [01]\.\d\d  return", out)
        assert 200 <= json.loads(Path("pole/result.json").read_text())["steps"] < 400
        assert run(["train", *POLE, *options, "--force", "--callback", "mine:wrong"]) == 2
        assert "must be a function" in capsys.readouterr().err

    @pytest.mark.slow
    def test_an_unknown_environment_is_sampled(self, capsys: pytest.CaptureFixture[str]) -> None:
        options = ["--steps", "300", "--episode-steps", "30", "--out", "pole", "--json", *SMALL]
        assert run(["train", *POLE, *options]) == 0
        result = json.loads(capsys.readouterr().out)
        assert not result["exact"] and result["episodes"] == 100
        assert run(["evaluate", "pole", "--episodes", "20", "--json"]) == 0
        learned = json.loads(capsys.readouterr().out)["learned"]
        assert learned["steps"]["low"] <= learned["steps"]["value"] <= learned["steps"]["high"]
        assert run(["evaluate", "pole", "--episodes", "20"]) == 0
        assert "95 % interval" in capsys.readouterr().out
        assert not Path("pole/policy.png").exists()

    @pytest.mark.slow
    @pytest.mark.parametrize(("formula", "word"), [("goal & !goal", "unsatisfiable"), ("goal | !goal", "valid")])
    def test_foregone_conclusions(self, formula: str, word: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["train", formula, *GRID[1:], "--steps", "50", "--num-envs", "2", "--quiet", *SMALL]) == 0
        assert f"is {word}" in capsys.readouterr().err
        assert run(["solve", formula, *GRID[1:]]) == 0
        assert f"is {word}" in capsys.readouterr().err

    @pytest.mark.slow
    def test_quiet(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["train", *GRID, "--steps", "100", "--num-envs", "2", "--quiet", *SMALL]) == 0
        assert capsys.readouterr().out == ""

    @pytest.mark.slow
    def test_an_automaton_file_and_the_preset_of_the_thesis(self) -> None:
        assert run(["compile", "F goal", "-o", "task.json"]) == 0
        preset = ["--config", "thesis", "--hyper", "hidden=[8]", "--out", "here", "-q"]
        assert run(["train", "task.json", "--env", "ltlc/Grid-v0", "--steps", "80", *preset]) == 0
        config = RunFolder.open("here").config
        assert config.num_envs == 1 and config.hyperparameters.hidden == (8,)
        assert config.agent == "double-dqn" and not config.hyperparameters.double

    @pytest.mark.slow
    def test_a_run_is_not_overwritten(self, capsys: pytest.CaptureFixture[str]) -> None:
        small = ["--steps", "60", "--num-envs", "2", "--quiet", "--out", "here", *SMALL]
        assert run(["train", *GRID, *small]) == 0
        assert run(["train", *GRID, *small]) == 2
        assert "--resume" in capsys.readouterr().err
        assert run(["train", *GRID, *small, "--force"]) == 0
        assert run(["train", *GRID, *small, "--resume", "--device", "cpu"]) == 0  # nothing is left to do
        assert run(["train", "F(goal & X goal)", *GRID[1:], *small, "--resume"]) == 2
        assert "differs in formula" in capsys.readouterr().err
        assert run(["train", *GRID, *small, "--resume", "--seed", "1"]) == 2
        assert "differs in hyperparameters" in capsys.readouterr().err

    @pytest.mark.slow
    def test_ctrl_c_and_resume_give_the_same_as_no_interruption(self) -> None:
        options = ("--steps", "2400", "--num-envs", "2", "--hyper", "train_frequency=8", *SMALL)
        running = process("train", *GRID, *options, "--out", "cut")
        assert running.stdout is not None
        for line in running.stdout:
            if (row := re.match(r" *(\d+) steps  ", line)) and int(row[1]) > 1_300:
                running.send_signal(signal.SIGINT)
                break
        _, error = running.communicate(timeout=60)
        assert running.returncode == 130
        assert "Go on with: ltlc train --resume --out cut" in error
        assert run(["train", "--resume", "--out", "cut", "--quiet"]) == 0
        assert run(["train", *GRID, *options, "--out", "whole", "--quiet"]) == 0
        assert np.array_equal(q_values("cut"), q_values("whole"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["F goal", "--env", "FrozenLak-v1"], "unknown environment 'FrozenLak-v1'. Did you mean FrozenLake-v1"),
        (["F goal", "--env", "FrozenLake-v1"], "give labels, the text module:function"),
        (["F gaol", *LAKE[1:]], "'gaol'. Did you mean goal"),
        (["F A & F D", "--env", "ltlc/Thesis5x5-v0"], "(no label produces it): 'D'"),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "labels"], "expected module:name"),
        (
            ["F goal", "--env", "FrozenLake-v1", "--labels", "no_such_module:labels"],
            "there is no module no_such_module",
        ),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:label"], "'label'. Did you mean labels"),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:nothing"], "'sensors.py:nothing' is 3"),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:fails"], "on the observation 0 with KeyError"),
        (
            ["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:quits"],
            "sensors.py:17 on the observation 0",
        ),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:quits"], "SystemExit: 0"),
        (["F hole", "--env", "FrozenLake-v1", "--labels", "sensors.py:either"], "SystemExit: 0"),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:four"], "takes (observation, info, env, reward)"),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:number"], "a label is nan (float)"),
        (["F goal", "--env", "FrozenLake-v1", "--labels", "sensors.py:wrong_type"], "a label contains 3.5 (float)"),
        (["G !fallen", "--env", "CartPole-v1", "--labels", "sensors.py:broken"], "'fallen' is nan (float)"),
        ([*LAKE[:-1], "zeta-discont"], "unknown reward scheme 'zeta-discont'. Did you mean zeta-discount"),
        ([*LAKE, "--set", "zetta=0.9"], "Did you mean zeta"),
        ([*LAKE, "--set", "zeta"], "expected KEY=VALUE"),
        ([*LAKE, "--hyper", "batchsize=3"], "unknown hyperparameter 'batchsize'. Did you mean batch_size"),
        ([*LAKE, "--hyper", "gamma"], "expected KEY=VALUE"),
        ([*LAKE, "--agent", "q-lerning"], "unknown agent 'q-lerning'. Did you mean q-learning"),
        ([*LAKE, "--agent", "sadigh", "--hyper", "hidden=[16]"], "unknown hyperparameter 'hidden'. Known: total_steps"),
        ([*LAKE, "--agent", "wang", "--hyper", "delta=2"], "delta is 2; it must lie strictly between 0 and 1"),
        ([*LAKE, "--agent", "wang", "--hyper", "iterations=many"], "iterations is 'many'; it must be a whole number"),
        ([*LAKE, "--agent", "fu-topcu", "--config", "thesis"], "--config thesis is for the agent 'double-dqn'"),
        ([*LAKE, "--agent", "fu-topcu", "--device", "cpu"], "tables stay in main memory"),
        ([*POLE, "--agent", "q-learning"], "tabular learning needs observations that are discrete"),
        (
            ["FG A | FG B", "--env", "ltlc/Thesis5x5-v0", "--reward", "zeta-discount", "--agent", "fu-topcu"],
            "leave the choice of a Rabin pair to the policy",
        ),
        ([*LAKE, "--hyper", "gamma=2"], "gamma is 2; it must be a number in [0, 1]"),
        ([*LAKE, "--env-set", "colour=3"], "FrozenLake-v1 cannot be made"),
        ([*LAKE, "--device", "gpu7"], "PyTorch cannot use the device 'gpu7'"),
        ([*LAKE, "--out", "sensors.py"], "sensors.py is a file"),
        ([*LAKE, "--out", "sensors.py/run"], "Not a directory"),
        ([*LAKE, "--num-envs", "0"], "'--num-envs': 0 is not in the range x>=1"),
        ([*LAKE, "--steps", "0"], "'--steps'"),
        ([*LAKE, "--seed", "-1"], "'--seed'"),
        ([*LAKE, "--episode-steps", "0"], "'--episode-steps': 0 is not in the range x>=1"),
        ([*LAKE, "--hyper", "total_steps=60"], "--steps is 50, and total_steps is 60; give one of them"),
        ([*LAKE, "--hyper", "gamma=0.5"], "gamma is without effect here: the reward scheme brings its own discounts"),
        ([*LAKE, "--agent", "fitted-q", "--hyper", "learning_rate=0.1"], "unknown hyperparameter 'learning_rate'"),
        ([*POLE, "--agent", "fitted-q"], "cannot be numbered; take the agent 'double-dqn'"),
        ([*LAKE, "--hyper", "hidden=8", "--hyper", "batch_norm=maybe"], "batch_norm is 'maybe'; it must be on or off"),
        ([*LAKE, "--env-set", "is_slippery=maybe"], "is_slippery is 'maybe'; it must be on or off"),
        ([*LAKE, "--set", "zeta=high"], "zeta is 'high'; it must be a number"),
        (["F goal", *LAKE[1:5], "--reward", "thesis", "--set", "terminate_on_accept=maybe"], "it must be on or off"),
        (["G !fallen", "--env", "Pendulum-v1", "--labels", "sensors.py:standing"], "are continuous; the agents choose"),
        (["F goal"], "give a FORMULA and an environment"),
        (["--resume", "--out", "nowhere"], "nowhere is no run folder"),
        (["F goal &", *LAKE[1:]], "line 1, column 8"),
    ],
)
def test_wrong_input(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    assert run(["train", "--steps", "50", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error
    assert not Path("runs").exists()


@pytest.mark.slow
def test_damaged_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["train", *GRID, "--steps", "60", "--num-envs", "2", "--quiet", "--out", "here", *SMALL]) == 0
    here = Path("here")
    content = {
        name: (here / name).read_bytes() for name in ("policy.ltlc", "config.json", "dra.json", "checkpoint.ltlc")
    }
    damages = [
        ("policy.ltlc", content["policy.ltlc"][:-100], "policy is damaged"),
        ("policy.ltlc", None, "holds no policy"),
        ("dra.json", content["dra.json"][:50], "dra.json"),
        ("dra.json", None, "dra.json is missing"),
        ("config.json", b"{", "config.json is not the configuration of a run"),
        ("config.json", b'{"format": 4}', "is missing"),
        ("config.json", content["config.json"].replace(b'"format": 4', b'"format": 9'), "this version reads format 4"),
        ("config.json", None, "no run folder"),
    ]
    for name, damaged, message in damages:
        if damaged is None:
            (here / name).unlink()
        else:
            (here / name).write_bytes(damaged)
        assert run(["evaluate", "here"]) == 2
        error = capsys.readouterr().err
        assert message in error and "Traceback" not in error
        (here / name).write_bytes(content[name])
    (here / "checkpoint.ltlc").write_bytes(content["checkpoint.ltlc"][:-9])
    assert run(["train", "--resume", "--out", "here"]) == 2
    assert "checkpoint is damaged" in capsys.readouterr().err
    assert run(["evaluate", "here", "--episodes", "1"]) == 2


ENDING = """
    import gymnasium, sys

    def labels(observation):
        return set()

    class Ending(gymnasium.Env):
        observation_space = gymnasium.spaces.Discrete(3)
        action_space = gymnasium.spaces.Discrete(2)

        def __init__(self, early=False):
            if early:
                sys.exit(0)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return 0, {}

        def step(self, action):
            sys.exit(0)

    gymnasium.register("Ending-v0", entry_point=Ending)
"""


@pytest.mark.parametrize(("arguments", "message"), [
    (["--env", "ending:Ending-v0"], "ending.py:20 calls sys.exit while the command runs"),
    (["--env", "ending:Ending-v0", "--env-set", "early=true"], "Ending-v0 cannot be made (SystemExit: 0)"),
    (["--env", "at_once:Ending-v0"], "importing at_once fails (SystemExit: 0)"),
])  # fmt: skip
def test_what_calls_exit_is_named(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Such a command did nothing and said so to nobody, with exit code 0."""
    Path("ending.py").write_text(textwrap.dedent(ENDING))
    Path("at_once.py").write_text("raise SystemExit(0)")
    assert run(["train", "F x", *arguments, "--labels", "ending.py:labels", "--steps", "50"]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_an_agent_learns_with_labels_that_look_at_the_environment(capsys: pytest.CaptureFixture[str]) -> None:
    looks = ["--env", "FrozenLake-v1", "--labels", "sensors.py:looks"]
    assert run(["train", "F goal", *looks, "--steps", "200", "--out", "looking"]) == 0
    assert "P(accepting step, no violation)" in capsys.readouterr().out


def test_labels_of_the_user_on_a_grid_world() -> None:
    Path("corners.py").write_text("corner = {'corner': lambda cell: bool(cell == 0)}\n")
    env_spec = EnvSpec(env="ltlc/Thesis5x5-v0", labels="corners.py:corner")
    assert env_spec.model is not None and env_spec.model.aps == ("corner",)
    assert env_spec.model.letters[env_spec.model.label_probability.indices].tolist() == [1] + [0] * 24
    _, infos = env_spec.vector(Task("F corner"), 2).reset(seed=0)
    assert infos["ltl"]["label"].tolist() == [0, 0]


def test_default_folder() -> None:
    assert default_folder("F(A & F B) & G !C", "ltlc/Thesis10x10-v0", 3) == Path("runs/f-a-f-b-g-c-thesis10x10-v0-3")
    assert len(default_folder("F x & " * 50 + "G y", "FrozenLake-v1", 0).name) < 70


class TestTermination:
    @pytest.mark.slow
    def test_a_run_keeps_and_compares_what_follows_the_end(self, capsys: pytest.CaptureFixture[str]) -> None:
        small = ["--steps", "60", "--num-envs", "2", "--quiet", "--out", "here", *SMALL]
        assert run(["train", *LAKE, *small, "--on-termination", "cut"]) == 0
        run_folder = RunFolder.open("here")
        assert run_folder.config.on_termination == run_folder.task.tables.on_termination == "cut"
        assert not run_folder.load().tables.closing.any()
        assert run(["train", *LAKE, *small, "--resume", "--on-termination", "cut"]) == 0
        assert run(["train", *LAKE, *small, "--resume"]) == 2
        assert "differs in on_termination" in capsys.readouterr().err
        assert run(["train", *LAKE, *small, "--force"]) == 0
        assert RunFolder.open("here").load().tables.closing.any()

    def test_what_follows_must_be_one_of_two(self, capsys: pytest.CaptureFixture[str]) -> None:
        with pytest.raises(UnknownNameError, match="unknown termination mode 'sometimes'"):
            RunConfig(env_spec=EnvSpec(env="ltlc/Grid-v0"), on_termination="sometimes").task(compile("F goal"))
        assert run(["train", *GRID, "--on-termination", "sometimes"]) == 2
        assert "repeat" in capsys.readouterr().err

    @pytest.mark.slow
    def test_the_lake_ends_at_its_goal(self, capsys: pytest.CaptureFixture[str]) -> None:
        options = ["--env", "FrozenLake-v1", "--labels", "sensors.py:labels", "--json"]
        found = {}
        for mode in ("repeat", "cut"):
            assert run(["solve", "G F goal", *options, "--on-termination", mode]) == 0
            found[mode] = json.loads(capsys.readouterr().out)["optimal"]
        assert found["repeat"]["satisfaction"] == pytest.approx(14 / 17, abs=1e-3)
        assert found["repeat"]["discounted_return"] > 0.8
        assert found["cut"]["discounted_return"] < 0.1
        for mode, shown in (("repeat", "two-discount"), ("cut", "two-discount termination=cut")):
            assert run(["faithful", "G F goal", *options, "--on-termination", mode]) == 0
            rows = json.loads(capsys.readouterr().out)["rows"]
            (row,) = (row for row in rows if row["name"] == shown)
            assert row["objective"] == pytest.approx(found[mode]["discounted_return"])
