"""Hyperparameters: presets, schedules, and errors that say what is wrong."""

import pytest

from ltlc.agents import DQNConfig, FittedQConfig
from ltlc.agents.tabular.config import QLearningConfig
from ltlc.agents.training.run_config import num_envs_for
from ltlc.errors import InvalidArgumentError, UnknownNameError


def test_thesis_preset_is_algorithm_1() -> None:
    config = DQNConfig.thesis()
    assert (config.double, config.counterfactual, config.batch_norm) == (False, False, True)
    assert config.hidden == (400, 300)
    assert (config.observation_input, config.state_input, config.initialization) == ("raw", "raw", "thesis")
    assert (config.tau, config.averaging, config.l2 > 0) == (0.001, 1.0, True)
    assert DQNConfig.thesis(seed=7).seed == 7


def test_defaults_are_double_and_counterfactual() -> None:
    config = DQNConfig()
    assert config.double and config.counterfactual and config.state_input == "heads"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gamma": 1.5}, r"gamma is 1\.5; it must be a number in \[0, 1\]"),
        ({"tau": 0.0}, r"tau is 0\.0; it must be a number in \(0, 1\]"),
        ({"learning_rate": float("nan")}, "learning_rate is nan"),
        ({"learning_rate": "fast"}, "learning_rate is 'fast'"),
        ({"batch_size": 0}, "batch_size is 0; it must be a whole number, at least 1"),
        ({"batch_size": 64.0}, r"batch_size is 64\.0"),
        ({"batch_size": 300, "buffer_size": 200}, r"less than batch_size \(300\)"),
        ({"hidden": (64, 0)}, "each entry of hidden is 0"),
        ({"hidden": 5}, "hidden is 5; it must be a list"),
        ({"hidden": "abc"}, "hidden is 'abc'; it must be a list"),
        ({"reward_scale": 0.0}, "reward_scale is 0"),
        ({"threads": 0}, "threads is 0"),
        ({"batch_norm": True, "batch_size": 1}, "at least 2"),
        ({"batch_norm": "off"}, "batch_norm is 'off'; it must be true or false"),
        ({"double": 1}, "double is 1; it must be true or false"),
        ({"epsilon_steps": -1}, "epsilon_steps is -1; it must be a whole number, at least 0"),
        ({"max_memory": 0}, "max_memory is 0; it must be a number in"),
    ],
)
def test_values_out_of_range_are_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=words):
        DQNConfig(**changes)  # type: ignore[arg-type]


def test_unknown_choices_and_names_get_a_suggestion() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean heads"):
        DQNConfig(state_input="head")  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match="Did you mean learning_rate"):
        DQNConfig.from_dict({"learning_rat": 0.1})


def test_schedules_are_lines_with_flat_ends() -> None:
    config = DQNConfig(
        epsilon_start=1.0,
        epsilon_final=0.2,
        epsilon_steps=100,
        learning_rate=0.4,
        final_learning_rate=0.2,
        total_steps=50,
    )
    assert [config.epsilon_at(steps) for steps in (0, 50, 100, 1000)] == pytest.approx([1.0, 0.6, 0.2, 0.2])
    assert [config.learning_rate_at(steps) for steps in (0, 25, 50, 99)] == pytest.approx([0.4, 0.3, 0.2, 0.2])
    assert DQNConfig(epsilon_steps=0, epsilon_start=0.5, epsilon_final=0.5).epsilon_at(0) == 0.5


def test_dictionaries_give_the_configuration_back() -> None:
    config = DQNConfig.thesis(seed=3)
    assert DQNConfig.from_dict(config.to_dict()) == config


def test_exploration_follows_the_steps_asked_for_unless_it_is_given() -> None:
    for total in (300, 21_000, 3_000_000):
        config = DQNConfig(total_steps=total)
        assert config.epsilon_at(0) == 1.0
        assert config.epsilon_at(total // 6) == pytest.approx(0.65, abs=1e-4)
        assert config.epsilon_at(total // 3) == config.epsilon_at(total) == pytest.approx(0.3)
    assert DQNConfig(total_steps=300, epsilon_steps=600).epsilon_at(300) == pytest.approx(0.65)


def test_environments_follow_the_steps_asked_for() -> None:
    assert num_envs_for(300_000, 200) == 64
    assert num_envs_for(8_000, 200) == 10  # 64 would take 125 steps each, and no episode would end
    assert num_envs_for(100, 200) == 1
    for total in (1, 1_000, 5_000, 50_000):
        for episode in (1, 30, 500):
            n = num_envs_for(total, episode)
            assert 1 <= n <= 64 and (n == 1 or total // n >= 4 * episode)


def test_what_is_without_effect_names_its_reason() -> None:
    for config in (DQNConfig(), FittedQConfig()):
        assert config.without_effect(rewarded=False) == {}
        assert "discounts" in config.without_effect(rewarded=True)["gamma"]
    assert QLearningConfig().without_effect(rewarded=True) == {}
