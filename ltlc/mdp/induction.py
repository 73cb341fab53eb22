"""Bounds on reachability probabilities that are proved by one step: if it moves them inwards everywhere, they hold.

The question is the largest probability of winning in a process without end components whose every choice c of state s
wins with probability `gain[c]`, loses with `lose[c]`, and otherwise goes on. For any function u of states, the *drift*
of a choice is what a step adds to u on average:

    sum over s' of P(c, s') (u(s') - u(s)) + gain(c) (1 - u(s)) - lose(c) u(s)

If u >= 0 drifts upwards nowhere, it is an upper bound (Knaster and Tarski); if a policy drifts downwards nowhere, a
lower one. Written as differences, the drift is computed with a small *relative* error: it is exactly 0 where u is flat.
That is what makes the proof possible where some policies can dawdle for more steps than a double can count.

A drift counts as bad unless it stays good when each of its terms is wrong by `slack`, which is several times what its
evaluation can round by. So the bounds hold for every process with the same graph whose probabilities agree with the
stored ones within a relative 2**-49, the one with the decimal fractions that the user meant among them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray, ranges


@dataclass(frozen=True, eq=False)
class ReachAvoid:
    """A process without end components in which every run wins or loses in the end."""

    mdp: ExplicitMDP
    """what is missing to 1 in a row of its matrix wins or loses."""
    gain: FloatArray
    """shape (n_choices,), the probability of winning with this step."""
    lose: FloatArray
    """shape (n_choices,), the probability of losing with this step."""

    @cached_property
    def slack(self) -> float:
        """How wrong each term of a drift may be, relatively."""
        longest = int(np.diff(self.mdp.matrix.indptr).max(initial=0))
        return float(4 * (longest + 16) * np.finfo(np.float64).eps)

    def without_loops(self) -> ReachAvoid:
        """The same problem with every choice that may stay replaced by what happens when at last it does not.

        Overwrites the transition matrix.
        """
        mdp, matrix = self.mdp, self.mdp.matrix
        row = np.repeat(np.arange(mdp.n_choices, dtype=np.int32), np.diff(matrix.indptr))
        loop = matrix.indices == mdp.choice_state[row]
        stays = np.zeros(mdp.n_choices, dtype=np.bool_)
        stays[row[loop]] = True
        if not stays.any():
            return self
        matrix.data[loop] = 0
        moves = np.asarray(matrix.sum(axis=1)).ravel() + self.gain + self.lose
        scale = np.where(stays, 1 / moves, 1.0)
        matrix.data *= scale[row]
        matrix.eliminate_zeros()
        gain, lose = self.gain * scale, self.lose * scale
        loopless = ExplicitMDP(
            matrix,
            mdp.choice_start,
            mdp.choice_action,
            mdp.initial,
            exit_probability=gain + lose,
            n_actions=mdp.n_actions,
        )
        return ReachAvoid(loopless, gain, lose)

    def mirrored(self, chosen: IntArray) -> ReachAvoid:
        """The problem under one policy (a choice per state) for the one who wins where it loses."""
        mdp = self.mdp
        start = np.arange(mdp.n_states + 1)
        under = ExplicitMDP(
            mdp.matrix[chosen],
            start,
            mdp.choice_action[chosen],
            mdp.initial,
            exit_probability=mdp.exit_probability[chosen],
        )
        return ReachAvoid(under, self.lose[chosen], self.gain[chosen])

    def drift(self, value: FloatArray, choices: IntArray, sign: int) -> FloatArray:
        """The drift of some choices, made larger (`sign` 1) or smaller (-1) by the slack of each term."""
        mdp = self.mdp
        result = np.empty(len(choices))
        length = np.diff(mdp.matrix.indptr)[choices]
        chunks = np.searchsorted(np.cumsum(length), np.arange(_CHUNK, int(length.sum()) + _CHUNK, _CHUNK))
        begin = 0
        for end in (*np.minimum(chunks[:-1] + 1, len(choices)), len(choices)):
            if begin < end:
                result[begin:end] = self._drift(value, choices[begin:end], sign * self.slack)
            begin = end
        return result

    def _drift(self, value: FloatArray, choices: IntArray, slack: float) -> FloatArray:
        matrix = self.mdp.matrix
        here = value[self.mdp.choice_state[choices]]
        start = matrix.indptr[choices]
        length = matrix.indptr[choices + 1] - start
        entry = ranges(start, length)
        step = value[matrix.indices[entry]]
        step -= np.repeat(here, length)
        step *= matrix.data[entry]
        step += slack * np.abs(step)
        total = self.gain[choices] * (1 - here) * (1 + slack) - self.lose[choices] * here * (1 - slack)
        filled = np.flatnonzero(length)
        total[filled] += np.add.reduceat(step, (np.cumsum(length) - length)[filled]) if filled.size else 0.0
        return total

    def sinks_nowhere(self, value: FloatArray, chosen: IntArray) -> bool:
        """Whether `value` (n_states,) is proved to be no larger than the probability of winning under a policy."""
        return bool((self.drift(value, chosen, -1) >= 0).all())

    def improved(self, value: FloatArray, states: IntArray, quantum: float, most_sweeps: float) -> bool:
        """Raises `value` in some states, in place, until it drifts upwards in none of them; False if it gave up.

        The values there become multiples of `quantum`. They end little above the least function that does not drift
        upwards, if they begin near it, unless it has slopes that a quantum cannot resolve.
        """
        mdp = self.mdp
        value[states] = np.clip(np.ceil(value[states] / quantum) * quantum, 0.0, 1.0)
        inside = np.zeros(mdp.n_states, dtype=np.bool_)
        inside[states] = True
        active, budget = states, most_sweeps * len(states)
        while active.size:
            budget -= len(active)
            if budget < 0:
                return False
            count = (mdp.choice_start[active + 1] - mdp.choice_start[active]).astype(np.int64)
            drift = self.drift(value, ranges(mdp.choice_start[active].astype(np.int64), count), 1)
            drift = np.maximum.reduceat(drift, np.cumsum(count) - count)
            rising = drift > 0
            low, need = active[rising], drift[rising]
            height = value[low] / quantum
            value[low] = np.minimum(np.maximum(np.ceil(height + need / quantum), height + 1) * quantum, 1.0)
            active = np.flatnonzero(self._predecessors(low) & inside)
        return True

    def _predecessors(self, states: IntArray) -> BoolArray:
        """The given states and those that may be followed by one of them, shape (n_states,)."""
        graph = self.mdp.support.graph
        columns = graph.columns
        start = columns.indptr[states].astype(np.int64)
        rows = columns.indices[ranges(start, columns.indptr[states + 1] - start)]
        found = np.zeros(self.mdp.n_states, dtype=np.bool_)
        found[graph.choice_state[rows]] = True
        found[states] = True
        return found


_CHUNK = 4_000_000
