"""Reward tables small enough to follow by hand."""

from __future__ import annotations

import numpy as np

from ltlc.rewards import RewardTables


def small_tables() -> RewardTables:
    """Three states, of which 2 is entered only where the episode surely stops; two letter classes."""
    return RewardTables(
        aps=("a",),
        letter_class=np.array([0, 1]),
        initial_state=0,
        next_state=np.array([[0, 1], [1, 2], [2, 2]]),
        reward=np.array([[-1.0, -2.0], [3.0, 4.0], [7.0, 7.0]]),
        discount=np.array([[0.9, 0.8], [1.0, 0.7], [0.5, 0.5]]),
        stop=np.array([[0.0, 0.25], [0.0, 1.0], [0.0, 0.0]]),
        stop_reward=np.array([[0.0, 8.0], [0.0, -5.0], [0.0, 0.0]]),
        violated=np.zeros((3, 2), dtype=bool),
        accepted=np.zeros((3, 2), dtype=bool),
        automaton_state=np.arange(3),
        progress=np.zeros(3),
        closing=np.array([[6.0, -6.0], [10.0, 20.0], [0.0, 1.0]]),
        on_termination="repeat",
    )
