"""The probability that a Markov chain ends up in some of its bottom components."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ltlc.mdp.certified import best_policy
from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray
from ltlc.mdp.induction import ReachAvoid


@dataclass(frozen=True, eq=False)
class Absorption:
    """Probabilities between two bounds that are proved; all three are exact where the graph alone decides 0 or 1."""

    lower: FloatArray
    """shape (n_states,)."""
    value: FloatArray
    """shape (n_states,)."""
    upper: FloatArray
    """shape (n_states,)."""


def absorption(chain: MarkovChain, target: BoolArray) -> Absorption:
    """The probability of ever entering `target` (n_states,), a union of bottom components, from each state.

    The bounds are those of `ltlc.mdp.induction`: they hold for every chain that the floating-point one stands for.
    """
    others = (chain.bottom_component >= 0) & ~target
    can_win, can_lose = chain.reaches(target), chain.reaches(others | (chain.exit_probability > 0))
    sure = np.where(can_win & ~can_lose, 1.0, 0.0)
    lower, value, upper = sure.copy(), sure.copy(), sure.copy()
    undecided = np.flatnonzero(can_win & can_lose)
    if undecided.size:
        rows = chain.matrix[undecided]
        gain = np.asarray(rows @ sure)
        lose = chain.exit_probability[undecided] + np.asarray(rows @ (~can_win).astype(np.float64))
        n = len(undecided)
        action, start = np.zeros(n, dtype=np.int32), chain.initial[undecided]
        part = ExplicitMDP(rows[:, undecided], np.arange(n + 1), action, start, exit_probability=gain + lose)
        found = best_policy(ReachAvoid(part, gain, lose).without_loops())
        lower[undecided], upper[undecided] = found.lower, found.upper
        value[undecided] = np.clip(found.value, found.lower, found.upper)
    return Absorption(lower, value, upper)
