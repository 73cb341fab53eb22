"""What hyperparameters leave open, fitted to an environment."""

from __future__ import annotations

import dataclasses

from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..training.collect import Interface
from .config import DQNConfig
from .robustness import with_robustness


def fitted(config: DQNConfig, interface: Interface) -> tuple[DQNConfig, RewardTables | None]:
    """Fill in what depends on the environment, and say which reward tables to learn from.

    Args:
        config: the hyperparameters.
        interface: of the environment.
    """
    counted = ObservationEncoder(interface.space, config.observation_input).n_observations > 0
    wrapper = interface.wrapper
    if wrapper is None or wrapper.adds_base_reward:
        config = dataclasses.replace(config, output="linear", horizon=0)
        return with_robustness(config.filled(numbered=counted), interface), interface.tables
    if config.action_repeat is None:
        limit = None if counted or config.curiosity else interface.episode_steps
        config = dataclasses.replace(config, action_repeat=fitted_repeat(limit))
    if config.horizon is None:
        config = dataclasses.replace(config, horizon=fitted_horizon(interface.episode_steps, counted=counted))
    config = with_robustness(config.filled(numbered=counted), interface)
    return config, wrapper.task.for_horizon(config.horizon or 0).tables


def fitted_horizon(episode_steps: int | None, *, counted: bool) -> int:
    """Steps to look ahead where nobody says how many; see `DQNConfig.horizon`.

    Args:
        episode_steps: where episodes are cut; None: unknown.
        counted: whether observations are numbered.
    """
    if counted:
        return 2000
    return 100 if episode_steps is None else min(max(episode_steps // 5, 20), 200)


def fitted_repeat(episode_steps: int | None) -> int:
    """Steps to hold an action for where nobody says how many; see `DQNConfig.action_repeat`.

    Args:
        episode_steps: where episodes are cut; None: unknown.
    """
    return 1 if episode_steps is None else min(max(episode_steps // 250, 1), 4)
