"""Gymnasium's toy-text worlds, which have a transition table `P`, as environments with a model and a board."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.envs.toy_text.cliffwalking import CliffWalkingEnv
from gymnasium.envs.toy_text.frozen_lake import FrozenLakeEnv

from ltlc.board import TINTS, Board
from ltlc.mdp import LabelledMDP

_GOAL, _DANGER = TINTS[1], TINTS[3]


class TableEnv:
    """The model of an environment with a table `P[state][action] = [(probability, state, reward, terminated), ...]`.

    Those of Gymnasium are FrozenLake, CliffWalking and Taxi. Terminal states become absorbing.

    Args:
        env: the environment, unwrapped.
    """

    def __init__(self, env: Any) -> None:
        self._env = env

    def labelled_mdp(self) -> LabelledMDP:
        """The model, without propositions."""
        start = getattr(self._env, "initial_state_distrib", None)
        first: dict[str, Any] = {}
        if start is not None:
            first = {"initial_state": int(np.argmax(start)), "initial_distribution": np.asarray(start, np.float64)}
        return LabelledMDP.from_table(self._env.P, **first)


class _FrozenLake(TableEnv):
    def board(self) -> Board:
        """The lake."""
        rows = tuple("".join(cell.decode() for cell in row) for row in self._env.desc)
        flat = "".join(rows)
        return Board(
            tuple(row.replace("F", ".").replace("S", ".") for row in rows),
            flat.index("S"),
            ("LEFT", "DOWN", "RIGHT", "UP"),
            {"H": "hole", "G": "goal"},
            frozenset(cell for cell, character in enumerate(flat) if character in "HG"),
            {"H": _DANGER, "G": _GOAL},
        )


class _CliffWalking(TableEnv):
    def board(self) -> Board:
        """The shore above the cliff."""
        rows, columns = self._env.shape
        cliff, last = self._env._cliff.ravel(), rows * columns - 1
        flat = "".join("G" if cell == last else "C" if fatal else "." for cell, fatal in enumerate(cliff))
        return Board(
            tuple(flat[i : i + columns] for i in range(0, len(flat), columns)),
            int(self._env.start_state_index),
            ("UP", "RIGHT", "DOWN", "LEFT"),
            {"C": "cliff", "G": "goal"},
            frozenset({last}),
            {"C": _DANGER, "G": _GOAL},
        )


def adapted(env: Any) -> Any:
    """An environment with a transition table as one with the methods of `ltlc.envs.protocol`; any other as it is.

    One with a method `labelled_mdp` of its own stays as it is, whatever it calls `P`.
    """
    if not isinstance(getattr(env, "P", None), Mapping) or hasattr(env, "labelled_mdp"):
        return env
    if isinstance(env, FrozenLakeEnv):
        return _FrozenLake(env)
    return _CliffWalking(env) if isinstance(env, CliffWalkingEnv) else TableEnv(env)
