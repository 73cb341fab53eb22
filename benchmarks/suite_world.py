"""Any labelled Markov decision process as an environment: many copies, stepped together."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ltlc.mdp import LabelledMDP

IntArray = npt.NDArray[np.int64]


class ModelWorld(VectorEnv[Any, Any, Any]):
    """Copies of a process whose every state offers every action; observations are state numbers, rewards are 0.

    `infos["labels"]` holds letters, bit i = `propositions[i]`. Episodes are cut after so many steps and begin anew at
    the next one.

    Args:
        mdp: the process.
        num_envs: number of copies.
        max_episode_steps: where episodes are cut.
    """

    def __init__(self, mdp: LabelledMDP, num_envs: int, max_episode_steps: int) -> None:
        self.num_envs, self.max_episode_steps = num_envs, max_episode_steps
        self.propositions = mdp.aps
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.single_observation_space = spaces.Discrete(mdp.n_states)
        self.single_action_space = spaces.Discrete(mdp.n_actions)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._start = mdp.initial_state
        self._steps = [_Draw(matrix) for matrix in mdp.transitions]
        self._labels, self._letters = _Draw(mdp.label_probability), mdp.letters
        self._state = np.full(num_envs, self._start)
        self._elapsed = np.zeros(num_envs, dtype=np.int64)
        self._finished = np.zeros(num_envs, dtype=np.bool_)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin episodes everywhere."""
        if seed is not None:
            self._np_random = np.random.default_rng(seed)
        self._state[:], self._elapsed[:], self._finished[:] = self._start, 0, False
        return self._state.copy(), {"labels": self._label()}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Move all copies; those whose episode is over begin a new one instead."""
        following, u = self._state.copy(), self.np_random.random(self.num_envs)
        for action, draw in enumerate(self._steps):
            chosen = np.flatnonzero(np.asarray(actions) == action)
            following[chosen] = draw(self._state[chosen], u[chosen])
        self._state = np.where(self._finished, self._start, following)
        self._elapsed = np.where(self._finished, 0, self._elapsed + 1)
        truncated = self._elapsed >= self.max_episode_steps
        self._finished = truncated.copy()
        zero = np.zeros(self.num_envs)
        return self._state.copy(), zero, zero > 0, truncated, {"labels": self._label()}

    def begin_episode(self, mask: npt.NDArray[np.bool_]) -> None:
        """End the episodes of the masked copies from outside; the next step begins new ones."""
        self._finished = self._finished | mask

    def _label(self) -> IntArray:
        return np.asarray(self._letters[self._labels(self._state, self.np_random.random(self.num_envs))])


class _Draw:
    """Draws a column of a row of a sparse stochastic matrix, given a number in [0, 1)."""

    def __init__(self, matrix: Any) -> None:
        self._column = matrix.indices
        row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
        before = np.concatenate(([0.0], np.cumsum(matrix.data)))
        self._bound = row + np.minimum(before[1:] - before[matrix.indptr[row]], 1.0)
        self._bound[matrix.indptr[1:] - 1] = np.arange(1, matrix.shape[0] + 1)

    def __call__(self, row: IntArray, u: npt.NDArray[np.float64]) -> IntArray:
        return np.asarray(self._column[np.searchsorted(self._bound, row + u, side="right")])
