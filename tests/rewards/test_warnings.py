"""What is said where rewards may teach something else than the formula, and how schemes go towards their limits."""

from __future__ import annotations

import itertools
import json
import warnings

import gymnasium as gym
import numpy as np
import pytest

from ltlc.agents import DQNConfig, train
from ltlc.agents.training.run_folder import RunFolder
from ltlc.cli.app import run
from ltlc.envs import GridWorld, LTLVectorWrapper, LTLWrapper, VectorGridWorld
from ltlc.errors import RewardWarning
from ltlc.rewards import RECOMMENDED, SCHEMES, RewardScheme, get_scheme
from ltlc.rewards.scheme import SMALLEST_DISTANCE
from ltlc.task import Task

NO_GUARANTEE = {"thesis", "thesis-code", "sadigh", "accept"}
LABELS = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}


@pytest.mark.parametrize("name", SCHEMES)
def test_a_scheme_without_a_guarantee_warns_once_in_each_task(name: str) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Task("G F a", name)
        Task("G F a", name, shaping=1.0)
    assert len(caught) == (2 if name in NO_GUARANTEE else 0)
    for warning in caught:
        assert warning.category is RewardWarning
        assert warning.filename == __file__
        assert repr(RECOMMENDED) in str(warning.message)


def test_the_default_is_the_recommended_scheme_and_has_a_guarantee() -> None:
    assert Task("F a").scheme == get_scheme(RECOMMENDED)
    assert get_scheme(RECOMMENDED).has_guarantee


@pytest.mark.parametrize("name", sorted(SCHEMES.keys() - NO_GUARANTEE))
@pytest.mark.parametrize("shaping", [0.0, 2.0])
def test_schemes_with_a_guarantee_go_towards_their_limit(name: str, shaping: float) -> None:
    scheme = get_scheme(name, shaping=shaping)
    distances = [to_limit(scheme.towards_limit(k)) for k in range(4)]
    assert scheme.towards_limit(0) == scheme
    for before, after in itertools.pairwise(distances):
        assert (after <= before + 1e-15).all()
        assert after.min() <= before.min() / 9
    far = scheme.towards_limit(40)  # where double precision ends
    assert far is not None
    assert (to_limit(far) > 0).all()


def to_limit(scheme: RewardScheme | None) -> np.ndarray:
    """How far each number among the parameters is from its limit, which is 0 for epsilon and 1 for discounts."""
    assert scheme is not None
    values = getattr(scheme, "scheme", scheme).parameters
    return np.array([v if k == "epsilon" else 1 - v for k, v in values.items() if isinstance(v, float)])


def test_the_two_discounts_part_on_the_way() -> None:
    ratios = []
    for k in range(5):
        scheme = get_scheme("two-discount").towards_limit(k)
        assert scheme is not None
        slow, fast = (1 - scheme.parameters[name] for name in ("gamma_accept", "gamma"))
        ratios.append(fast / slow)
        assert fast >= SMALLEST_DISTANCE / 2
    assert all(b < a for a, b in itertools.pairwise(ratios))


def wrapped(reward: str, **options: bool) -> LTLWrapper:
    return LTLWrapper(gym.make("FrozenLake-v1"), Task("F goal & G !hole", reward), LABELS, **options)


def test_a_discount_that_varies_is_told_at_the_first_reset_alone() -> None:
    env = wrapped("two-discount")
    with pytest.warns(RewardWarning, match="zeta-reach"):
        env.reset(seed=0)
    vector = LTLVectorWrapper(VectorGridWorld("S.A", 2), "G F A")
    with pytest.warns(RewardWarning, match="warn_discount=False"):
        vector.reset(seed=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.reset()
        vector.reset()
        wrapped("zeta-reach").reset()
        wrapped("two-discount", warn_discount=False).reset()
        wrapped("two-discount")  # not before it is used


def test_the_bundled_agent_uses_discounts_and_nothing_is_said() -> None:
    env = LTLVectorWrapper(VectorGridWorld("S.A", 4, max_episode_steps=20), "F A")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        train(env, DQNConfig(total_steps=200))


def test_the_option_survives_a_spec() -> None:
    world = LTLWrapper(GridWorld(("Sa",), actions=4), "F a", warn_discount=False)
    assert world._saved_kwargs["warn_discount"] is False


class TestCommands:
    @pytest.fixture(autouse=True)
    def _here(self, tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(str(tmp_path))

    @pytest.mark.parametrize("command", [["solve"], ["train", "--steps", "300", "--num-envs", "2", "--out", "run"]])
    @pytest.mark.slow
    def test_one_line_on_stderr(self, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
        arguments = [*command, "F A", "-e", "ltlc/Thesis5x5-v0", "--reward", "accept", "--json"]
        assert run(arguments) == 0
        captured = capsys.readouterr()
        json.loads(captured.out)
        lines = [line for line in captured.err.splitlines() if "'accept' do not guarantee" in line]
        assert len(lines) == 1
        assert lines[0].startswith("ltlc: warning: ")

    @pytest.mark.slow
    @pytest.mark.parametrize(("options", "reward"), [
        ([], RECOMMENDED),
        (["--config", "thesis"], "thesis"),
        (["--config", "thesis", "--reward", "eventual"], "eventual"),
    ])  # fmt: skip
    def test_the_preset_brings_its_rewards(self, options: list[str], reward: str) -> None:
        where = ["F A", "-e", "ltlc/Thesis5x5-v0", "--steps", "100", "--hyper", "hidden=[4]", "-q"]
        assert run(["train", *where, *options, "--out", "run"]) == 0
        assert RunFolder.open("run").config.reward == reward

    @pytest.mark.slow
    def test_an_older_run_keeps_its_rewards(self) -> None:
        run(["train", "F A", "-e", "ltlc/Thesis5x5-v0", "--steps", "100", "-q", "--reward", "thesis", "--out", "run"])
        with pytest.warns(RewardWarning, match="'thesis'"):
            assert RunFolder.open("run").task.scheme == get_scheme("thesis")
