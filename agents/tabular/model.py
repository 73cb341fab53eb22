"""Transition and label probabilities learned from counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from scipy import sparse, special

from ltlc.mdp import LabelledMDP

from ..training.contents import Content
from .experience import Batch, BoolArray, Experience, IntArray

FloatArray = npt.NDArray[np.float64]
_MOST = 2**40
"""counts in a file are below; their sums are exact in float64."""


class EmpiricalModel:
    """Counts of what has been seen of an environment, and the maximum-likelihood model they make.

    Attributes:
        visits: (n_states, n_actions), how often an action was taken in a state.
        terminal: (n_states,), the states that the environment was seen to end an episode in.
    """

    def __init__(self, experience: Experience) -> None:
        automaton, tables = experience.automaton, experience.tables
        self._aps = automaton.aps
        _, first = np.unique(automaton.letter_class, return_index=True)
        self._letters = automaton.letter_numbers.masks(first)
        self.n_states, self.n_actions = experience.n_states, experience.n_actions
        self.visits = np.zeros((self.n_states, self.n_actions), dtype=np.int64)
        self.terminal = np.zeros(self.n_states, dtype=np.bool_)
        self._label_counts = np.zeros((self.n_states, automaton.n_classes), dtype=np.int64)
        self._keys, self._counts = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
        self._pending: list[IntArray] = []
        self.start = np.bincount(experience.state, minlength=self.n_states) / experience.n_envs
        # A class that explains the table state after the first letter; it matters only if the start is never entered.
        explains = tables.next_state[tables.initial_state] == experience.table_state[:, None]
        self._first_class = np.zeros(self.n_states, dtype=np.int64)
        self._first_class[experience.state] = explains.argmax(axis=1)

    def add(self, batch: Batch) -> None:
        """Count environment steps."""
        pair = batch.state * self.n_actions + batch.action
        self._pending.append(pair * self.n_states + batch.next_state)
        np.add.at(self.visits.ravel(), pair, 1)
        np.add.at(self._label_counts, (batch.next_state, batch.letter_class), 1)
        self.terminal[batch.next_state[batch.terminated]] = True

    def transition_counts(self) -> tuple[IntArray, IntArray, IntArray]:
        """Pairs state * n_actions + action, next states, and how often each was seen; ordered."""
        if self._pending:
            keys, counts = np.unique(np.concatenate(self._pending), return_counts=True)
            merged, where = np.unique(np.concatenate((self._keys, keys)), return_inverse=True)
            self._counts = np.bincount(where, np.concatenate((self._counts, counts))).astype(np.int64)
            self._keys, self._pending = merged, []
        pair, target = np.divmod(self._keys, self.n_states)
        return pair, target, self._counts

    def labelled_mdp(self) -> LabelledMDP:
        """The maximum-likelihood model.

        An action that was never tried in a state is not available there; terminal states, and those in which none was,
        stay where they are under every action.
        """
        pair, target, count = self.transition_counts()
        state, action = np.divmod(pair, self.n_actions)
        probability = count / self.visits[state, action]
        stays = self.terminal | ~self.visits.any(axis=1)
        resting = np.flatnonzero(stays)
        transitions = []
        for a in range(self.n_actions):
            used = (action == a) & ~stays[state]
            rows = np.concatenate((state[used], resting))
            columns = np.concatenate((target[used], resting))
            data = np.concatenate((probability[used], np.ones(len(resting))))
            transitions.append(sparse.csr_array((data, (rows, columns)), shape=(self.n_states, self.n_states)))
        return LabelledMDP(
            aps=self._aps,
            transitions=tuple(transitions),
            letters=self._letters,
            label_probability=sparse.csr_array(self._label_probability()),
            initial_state=int(self.start.argmax()),
            initial_distribution=self.start,
            terminal=self.terminal,
        )

    def known(self, accuracy: float, delta: float) -> BoolArray:
        """The states whose transition probabilities are all known to within `accuracy` with confidence 1 - delta.

        The error of each probability is k standard deviations of its Beta posterior (uniform prior, so that a single
        visit proves nothing), where k is the two-sided normal quantile of 1 - delta.

        Returns:
            shape (n_states,), bool; states that were never left are unknown, terminal ones are known.

        References:
            J. Fu, U. Topcu, RSS 2014, doi 10.15607/RSS.2014.X.039, section III; with their prior, a transition seen
            once and alone would count as known.
        """
        pair, _, count = self.transition_counts()
        n = self.visits.ravel()[pair]
        variance = (count + 1.0) * (n - count + 1.0) / ((n + 2.0) ** 2 * (n + 3.0))
        deviation = np.full(self.visits.size, np.inf)
        deviation[np.unique(pair)] = 0.0
        np.maximum.at(deviation, pair, np.sqrt(variance))
        error = float(special.ndtri(1 - delta / 2)) * deviation.reshape(self.visits.shape)
        return np.asarray((error <= accuracy).all(axis=1) | self.terminal)

    def state_dict(self) -> dict[str, Any]:
        """Return all counts as tensors."""
        self.transition_counts()  # which takes in what is pending
        arrays = {"keys": self._keys, "counts": self._counts, "labels": self._label_counts, "terminal": self.terminal}
        return {name: torch.from_numpy(array) for name, array in arrays.items()}

    def load_state(self, content: Content) -> None:
        """Check what `state_dict` gave, read from a file, and go back to it.

        Raises:
            FileFormatError: it is of another model.
        """
        keys = content["keys"].indices(torch.int64, None, self.visits.size * self.n_states)
        content["keys"].check(keys.ndim == 1 and bool((keys[1:] > keys[:-1]).all()), "is not in order")
        counts = content["counts"].indices(torch.int64, (len(keys),), _MOST)
        content["counts"].check(bool((counts > 0).all()), "has a count of 0")
        shape = self._label_counts.shape
        self._label_counts = content["labels"].indices(torch.int64, shape, _MOST).numpy()
        self.terminal = content["terminal"].tensor(torch.bool, self.terminal.shape).numpy()
        self._keys, self._counts, self._pending = keys.numpy(), counts.numpy(), []
        visits = np.bincount(self._keys // self.n_states, self._counts, self.visits.size)
        self.visits = visits.astype(np.int64).reshape(self.visits.shape)

    def _label_probability(self) -> FloatArray:
        counts = self._label_counts.copy()
        unseen = np.flatnonzero(~counts.any(axis=1))
        counts[unseen, self._first_class[unseen]] = 1
        return np.asarray(counts / counts.sum(axis=1, keepdims=True))
