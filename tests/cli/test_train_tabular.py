"""`ltlc train` with tabular learners: what they print, what a run folder holds, and how a run goes on."""

from __future__ import annotations

import json
import signal
import textwrap
from pathlib import Path

import pytest
from cli_process import process

from ltlc.cli.app import run

ROOT = Path(__file__).parents[2]
SMALL_WORLD = ("--env", "ltlc/Thesis5x5-v0")
HIDDEN = """
    import gymnasium

    class Hidden(gymnasium.Env):
        observation_space = gymnasium.spaces.Discrete(3)
        action_space = gymnasium.spaces.Discrete(2)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            self.place = 0
            return 0, {}

        def step(self, action):
            self.place = min(self.place + 1, 2) if action == (self.np_random.random() < 0.9) else 0
            return self.place, 0.0, False, False, {}

    def labels(observation, info):
        return {"up"} if observation == 2 else set()

    gymnasium.register("Hidden-v0", entry_point=Hidden)
"""


@pytest.mark.slow
@pytest.mark.parametrize("agent", ["q-learning", "double-q-learning", "fu-topcu", "sadigh", "wang"])
def test_a_run_and_its_folder(agent: str, capsys: pytest.CaptureFixture[str]) -> None:
    coarse = ["--hyper", "accuracy=0.2"] if agent in ("fu-topcu", "wang") else []
    assert run(["train", "F(A & F B)", *SMALL_WORLD, "--agent", agent, "--steps", "40000", *coarse]) == 0
    out = capsys.readouterr().out
    assert " steps  P(satisfied) " in out and "optimal for the rewards" in out
    place = Path(f"runs/f-a-f-b-thesis5x5-v0-{agent}-0")
    files = {path.name for path in place.iterdir()} - {"dra.svg"}
    assert files == {
        "config.json", "dra.json", "metrics.csv", "times.csv", "checkpoint.ltlc", "policy.ltlc", "result.json",
        "policy.png", "curve.png",
    }  # fmt: skip
    result = json.loads((place / "result.json").read_text())
    assert result["exact"] and result["learned"]["satisfaction"] == pytest.approx(1)
    assert 0 <= result["regret"] < 0.2
    assert run(["evaluate", str(place), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["learned"] == result["learned"]
    before = (place / "policy.ltlc").read_bytes()
    assert run(["train", "--resume", "--out", str(place), "--json"]) == 0  # nothing is left to do
    assert json.loads(capsys.readouterr().out)["learned"] == result["learned"]
    assert (place / "policy.ltlc").read_bytes() == before


@pytest.mark.slow
def test_ctrl_c_and_resume_give_the_same_as_no_interruption() -> None:
    options = ("--agent", "q-learning", "--hyper", "log_every=250", "--num-envs", "2", "--steps", "10000")
    running = process("train", "F A", *SMALL_WORLD, *options, "--out", "cut")
    assert running.stdout is not None
    for line in running.stdout:
        if " steps  P(satisfied)" in line and int(line.split()[0]) > 4_500:
            running.send_signal(signal.SIGINT)
            break
    _, error = running.communicate(timeout=60)
    assert running.returncode == 130
    assert "Go on with: ltlc train --resume --out cut" in error
    assert "Traceback" not in error
    files = {path.name for path in Path("cut").iterdir()}
    assert files == {"config.json", "dra.json", "metrics.csv", "times.csv", "checkpoint.ltlc"}
    assert run(["evaluate", "cut"]) == 2
    assert run(["train", "--resume", "--out", "cut", "--quiet"]) == 0
    assert run(["train", "F A", *SMALL_WORLD, *options, "--out", "whole", "--quiet"]) == 0
    for name in ("policy.ltlc", "metrics.csv", "result.json"):
        assert Path("cut", name).read_bytes() == Path("whole", name).read_bytes()


@pytest.mark.slow
def test_damaged_folders_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    train = ["train", "F A", *SMALL_WORLD, "--agent", "q-learning", "--steps", "2000", "--out", "done", "--quiet"]
    assert run(train) == 0
    Path("done/metrics.csv").write_text("")
    assert run(["train", "--resume", "--out", "done"]) == 2
    assert "metrics.csv: line 1 is not the header" in capsys.readouterr().err
    config = json.loads(Path("done/config.json").read_text())
    for key, wrong in (("num_envs", "a"), ("parameters", []), ("reward", 3)):
        Path("done/config.json").write_text(json.dumps(config | {key: wrong}))
        assert run(["evaluate", "done"]) == 2
        assert f"{key} is {wrong!r}" in capsys.readouterr().err


def test_no_policy(capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--agent", "wang", "--hyper", "accuracy=0.2", "--out", "none"]
    assert run(["train", "G !A & F A", *SMALL_WORLD, *options]) == 1
    assert "the learned product has no accepting end component" in capsys.readouterr().err
    assert json.loads(Path("none/result.json").read_text())["learned"] is None
    assert run(["train", "G !A & F A", *SMALL_WORLD, *options, "--force", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["learned"] is None
    assert run(["evaluate", "none"]) == 2
    assert "holds no policy" in capsys.readouterr().err


@pytest.mark.slow
def test_unknown_dynamics_are_sampled(capsys: pytest.CaptureFixture[str]) -> None:
    hidden = ["--env", "hidden:Hidden-v0", "--labels", "hidden:labels", "--hyper", "accuracy=0.1"]
    Path("hidden.py").write_text(textwrap.dedent(HIDDEN))
    options = ["--agent", "wang", "--num-envs", "4", "--out", "coins", "--episode-steps", "40", "--json"]
    assert run(["train", "F up", *hidden, *options]) == 0
    result = json.loads(capsys.readouterr().out)
    assert not result["exact"] and result["learned"]["accepted_without_violation"]["value"] == 1
    assert not Path("coins/curve.png").exists()


@pytest.mark.slow
def test_the_label_of_the_first_observation_can_be_skipped(capsys: pytest.CaptureFixture[str]) -> None:
    start = ["--env", "ltlc/Grid-v0", "--hyper", "accuracy=0.2", "--json", "--agent", "fu-topcu"]
    for reading, formula in (("read", "!goal & F goal"), ("skip", "X F goal")):
        assert run(["train", formula, *start, "--initial-label", reading, "--out", reading]) == 0
        assert json.loads(capsys.readouterr().out)["learned"]["satisfaction"] == pytest.approx(1)
