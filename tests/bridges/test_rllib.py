"""RLlib's DQN weighs by the discount of each step, and its results say what it has learned.

RLlib pins Gymnasium, so it is seldom there: `make test-rllib` runs these tests in an environment of its own.
"""

from __future__ import annotations

import importlib
import runpy
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ltlc
from ltlc.envs import GridWorld
from ltlc.errors import InvalidArgumentError, MissingProgramError, RewardWarning

try:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        bridge = importlib.import_module("ltlc.bridges.rllib")
except MissingProgramError:
    pytest.skip("RLlib is not installed; make test-rllib", allow_module_level=True)

pytestmark = [pytest.mark.peer, pytest.mark.filterwarnings("ignore")]
EXAMPLE = Path(__file__).parents[2] / "examples" / "train_rllib.py"


def env() -> Any:
    world = GridWorld(("S..k", "...."), labels={"k": "key"}, slip=0.2, actions=4)
    return ltlc.LTLWrapper(world, ltlc.Task("G F key", "two-discount"), observation="flat", warn_discount=False)


def filled(steps: int = 200) -> tuple[Any, dict[tuple[float, ...], float]]:
    """A buffer with an episode, and the discount of each of its steps by what is seen, done and seen then."""
    single = importlib.import_module("ray.rllib.env.single_agent_episode")
    made, random, known = env(), np.random.default_rng(0), {}
    buffer = bridge.TaskEpisodeReplayBuffer(capacity=1000)
    seen, info = made.reset(seed=0)
    episode = single.SingleAgentEpisode(observation_space=made.observation_space, action_space=made.action_space)
    episode.add_env_reset(observation=seen, infos=info)
    for _ in range(steps):
        action = int(random.integers(4))
        after, reward, terminated, truncated, info = made.step(action)
        episode.add_env_step(
            observation=after, action=action, reward=reward, infos=info, terminated=terminated, truncated=truncated
        )
        known[(*seen, action, *after)] = info["ltl"]["discount"]
        seen = after
    buffer.add(episode)
    return buffer, known


@pytest.mark.parametrize("gamma", [0.5, 0.99])
def test_the_power_of_gamma_is_the_discount_of_the_step(gamma: float) -> None:
    buffer, known = filled()
    found = set()
    for one in buffer.sample(num_items=100, batch_length_T=None, n_step=1, gamma=gamma, sample_episodes=True):
        before, after = one.get_observations(0), one.get_observations(-1)
        power = float(np.asarray(one.get_extra_model_outputs("n_step")).reshape(-1)[-1])
        expected = known[(*before, int(one.get_actions(0)), *after)]
        assert gamma**power == pytest.approx(expected, rel=1e-5)
        found.add(round(expected, 6))
    assert len(found) > 1


def test_what_it_cannot_honour_is_told() -> None:
    buffer, _ = filled(10)
    with pytest.raises(InvalidArgumentError, match="gamma is 1"):
        buffer.sample(num_items=1, gamma=1)
    with pytest.raises(InvalidArgumentError, match="need n_step=1"):
        buffer.sample(num_items=1, n_step=3)
    with pytest.raises(InvalidArgumentError, match="not wrapped"):
        bridge._wrapper(gym.make("CartPole-v1"))


def test_an_agent_with_one_discount_is_warned_of() -> None:
    dqn = importlib.import_module("ray.rllib.algorithms.dqn").DQNConfig
    ppo = importlib.import_module("ray.rllib.algorithms.ppo").PPOConfig
    for config in (ppo(), dqn(), dqn().training(replay_buffer_config={"type": "EpisodeReplayBuffer"})):
        with pytest.warns(RewardWarning, match=r"say warn_discount=False, or take.*'zeta-reach'.*gamma = 1"):
            bridge.warn_of_one_discount(config, env())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bridge.warn_of_one_discount(dqn().training(replay_buffer_config=bridge.replay()), env())


@pytest.mark.slow
def test_the_example_reports_what_it_has_learned(capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), "1500"])
    runpy.run_path(str(EXAMPLE), run_name="__main__")
    assert float(capsys.readouterr().out.split("P(sat) ")[-1].split()[0]) > 0.2
