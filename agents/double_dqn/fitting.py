"""What hyperparameters leave open, fitted to an environment."""

from __future__ import annotations

import dataclasses

import numpy as np

from ltlc.graph import strong_components
from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from ..training.collect import Collector, Interface
from .config import DQNConfig
from .robustness import with_robustness

_ALERT, _MOST_HELD = 250, 4
"""steps of an episode for each step that an action is held, and how many it is held at most."""


def fitted(config: DQNConfig, interface: Interface) -> tuple[DQNConfig, RewardTables | None]:
    """Fill in what depends on the environment, and say which reward tables to learn from.

    Args:
        config: the hyperparameters.
        interface: of the environment.
    """
    counted, wrapper = _counted(config, interface), interface.wrapper
    if wrapper is None or wrapper.adds_base_reward:
        config = dataclasses.replace(config, output="linear", horizon=0)
        return with_robustness(config.filled(numbered=counted), interface), interface.tables
    if config.action_repeat is None:
        single = counted or config.curiosity or not config.traced or wrapper.masks.shown_by(wrapper.env)
        config = dataclasses.replace(config, action_repeat=1 if single else fitted_repeat(interface, config))
    config = dataclasses.replace(config, horizon=fitted_horizon(config, interface))
    config = with_robustness(config.filled(numbered=counted), interface)
    return config, wrapper.task.for_horizon(config.horizon or 0).tables


def fitted_horizon(config: DQNConfig, interface: Interface) -> int:
    """Steps to look ahead, fitted to the environment where nobody says how many; see `DQNConfig.horizon`."""
    if config.horizon is not None:
        return config.horizon
    if interface.wrapper is None or interface.wrapper.adds_base_reward:
        return 0
    if _counted(config, interface):
        return 2000
    limit, fifths = interface.episode_steps, 2 if _recurs(interface.wrapper.task.tables) else 1
    return 100 if limit is None else min(max(fifths * limit // 5, 20), 200)


def fitted_repeat(interface: Interface, config: DQNConfig) -> int:
    """Steps to hold an action for where nobody says how many; see `DQNConfig.action_repeat`.

    Where episodes are long enough, random actions are tried: a world that ends soon under these, as one in which
    something is to be balanced, is none in which a step does little. The steps for that are no part of the training,
    and a tenth of it at most.

    Args:
        interface: of the environment, which is reset.
        config: `seed` and `total_steps` are used.
    """
    n, limit = interface.env.num_envs, interface.episode_steps
    rounds = min(limit or 0, _MOST_HELD * _ALERT, config.total_steps // (10 * n))
    if rounds < 2 * _ALERT:
        return 1
    collector, tables = Collector(interface, ObservationEncoder(interface.space)), interface.tables
    collector.reset(config.seed)
    random, over = np.random.default_rng(config.seed), np.zeros(n, dtype=np.bool_)
    for done in range(1, rounds + 1):
        steps = collector.step(random.integers(interface.n_actions, size=n))
        over[steps.copy] |= steps.terminated
        if tables is not None:
            over[steps.copy] |= tables.violated[steps.state, steps.letter_class]
        if 2 * over.sum() > n:
            return max(done // _ALERT, 1)
    return rounds // _ALERT


def _recurs(tables: RewardTables) -> bool:
    """Whether a run may accept again and again, with steps between: then it pays to be there the next time, too.

    A horizon much nearer than the next acceptance makes little of it that nothing comes after this one.
    """
    component = np.array(strong_components(tables.next_state))
    inside = (component[tables.next_state] == component[:, None]) & ~tables.terminal
    accepting, between = ({*component[(inside & which).any(axis=1)]} for which in (tables.accepted, ~tables.accepted))
    return not accepting.isdisjoint(between)


def _counted(config: DQNConfig, interface: Interface) -> bool:
    """Whether observations are numbered."""
    return ObservationEncoder(interface.space, config.observation_input).n_observations > 0
