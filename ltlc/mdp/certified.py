"""The best policy of a problem, and what it is worth between two bounds that are proved and not only believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ltlc.mdp.chain import MarkovChain, solve
from ltlc.mdp.explicit import ExplicitMDP, FloatArray, IntArray, ranges
from ltlc.mdp.gauss_seidel import GaussSeidel
from ltlc.mdp.induction import ReachAvoid
from ltlc.mdp.policy_iteration import improve
from ltlc.mdp.reachability import attractor, distance_to
from ltlc.mdp.topological_blocks import topological_blocks

LINEAR_SOLVE_LIMIT = 10_000
"""Policies are evaluated by sparse LU in parts of up to this many states, and by sweeps in larger ones."""


@dataclass(frozen=True, eq=False)
class Certified:
    """Probabilities of winning a problem, and a policy that has the lower ones at least."""

    lower: FloatArray
    """shape (n_states,), proved for the policy."""
    value: FloatArray
    """shape (n_states,), of the policy as computed."""
    upper: FloatArray
    """shape (n_states,), proved for all policies."""
    chosen: IntArray
    """shape (n_states,), a choice per state."""


def best_policy(problem: ReachAvoid) -> Certified:
    """The best policy, found in one part of the process after the other, and its value.

    Policy iteration with a gain that is smaller by a margin in every choice does not dawdle for ever for the sake of
    rounding errors. Its value rises in a step of the true process, so it is a lower bound. As far above the true value
    of that policy, the search for an upper bound begins. A bound that cannot be proved is 0 or 1: so it is where runs
    take more than about 1e12 steps, many states are visited on the way, and the value differs between them.

    References:
        A. Hartmanns, B. Kaminski, Optimistic value iteration, CAV 2020, DOI 10.1007/978-3-030-53291-8_26 (guesses an
        upper bound and proves it by being inductive). M. L. Puterman, M. C. Shin, Modified policy iteration algorithms
        for discounted Markov decision problems, Management Science 24(11), 1978, DOI 10.1287/mnsc.24.11.1127.
    """
    mdp = problem.mdp
    lower, value, upper = np.zeros(mdp.n_states), np.zeros(mdp.n_states), np.zeros(mdp.n_states)
    chosen = mdp.choice_start[:-1].astype(np.int64)
    for states in topological_blocks(mdp):
        part, rows, steps = _part(mdp, states)
        gain = problem.gain[rows] + steps @ value
        by = _by_policy_iteration if part.n_states <= LINEAR_SOLVE_LIMIT else _by_sweeps
        slacked, picked, exact = by(part, gain)
        below, above = float((value - lower).max()), float((upper - value).max())
        chosen[states], value[states] = rows[picked], exact
        _prove_lower(problem, chosen, states, lower, slacked - below, exact)
        _prove_upper(problem, states, upper, exact + above, exact - slacked)
    return Certified(lower, value, upper, chosen)


def _prove_lower(
    problem: ReachAvoid, chosen: IntArray, states: IntArray, lower: FloatArray, guess: FloatArray, value: FloatArray
) -> None:
    """Sets a lower bound of the policy in some states, given those of the states that they lead to."""
    lower[states] = np.clip(guess, 0.0, 1.0)
    if problem.sinks_nowhere(lower, chosen[states]):
        return
    losing, above = problem.mirrored(chosen), 1 - lower
    for quantum in _QUANTA:
        above[states] = 1 - value
        if losing.improved(above, states, quantum, _MOST_RAISES):
            lower[states] = 1 - above[states]
            return
    lower[states] = 0.0


def _prove_upper(
    problem: ReachAvoid, states: IntArray, upper: FloatArray, guess: FloatArray, margin: FloatArray
) -> None:
    """Sets an upper bound in some states, given those of the states that they lead to."""
    for quantum in _QUANTA:  # by linearity, the first guess is the value of the policy when each step gains 4 quanta
        upper[states] = guess + margin * (4 * quantum / _MARGIN)
        if problem.improved(upper, states, quantum, _MOST_RAISES):
            return
    upper[states] = 1.0


def _part(mdp: ExplicitMDP, states: IntArray) -> tuple[ExplicitMDP, IntArray, Any]:
    """The process on some of its states, left by entering another one; its choices, and where those lead at all."""
    if len(states) == mdp.n_states:
        return mdp, np.arange(mdp.n_choices), mdp.matrix
    count = np.diff(mdp.choice_start)[states]
    rows = ranges(mdp.choice_start[states], count)
    outside = np.ones(mdp.n_states)
    outside[states] = 0.0
    steps = mdp.matrix[rows]
    exit_probability = mdp.exit_probability[rows] + np.asarray(steps @ outside)
    start = np.concatenate(([0], np.cumsum(count)))
    part = ExplicitMDP(
        steps[:, states], start, mdp.choice_action[rows], mdp.initial[states], exit_probability=exit_probability
    )
    return part, rows, steps


def _by_policy_iteration(mdp: ExplicitMDP, gain: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Values that rise in a step, choices, and the values of those choices."""
    start = _roughly_best(mdp, gain) if mdp.n_choices > mdp.n_states else mdp.choice_start[:-1]
    slacked, chosen, _ = improve(mdp, gain - _MARGIN, start)
    return slacked, chosen, MarkovChain.under(mdp, mdp.choice_matrix(chosen)).total(gain[chosen])


def _by_sweeps(mdp: ExplicitMDP, gain: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """The same by modified policy iteration, which need not settle which of the nearly best choices is best."""
    slack_gain = gain - _MARGIN
    door = mdp.best(gain) > 0
    order = np.argsort(distance_to(mdp, door), kind="stable")
    chosen, slacked = _first_policy(mdp, gain), np.zeros(mdp.n_states)
    for left in reversed(range(_MOST_ROUNDS)):
        chain = GaussSeidel(mdp.matrix[chosen], order)
        slacked, _ = chain.run(slack_gain[chosen], slacked, _MARGIN / 8, _SWEEPS)
        choice_value = slack_gain + mdp.matrix @ slacked
        best, own = mdp.best(choice_value), choice_value[chosen]
        if not left or (best - np.minimum(own, slacked)).max() <= _NEAR:
            break
        chosen = np.where(best > own + _MARGIN, mdp.greedy(choice_value), chosen)
    slacked, converged = chain.run(slack_gain[chosen], slacked, _MARGIN / 8, _MOST_SWEEPS)
    if not converged:
        slacked = solve(mdp.matrix[chosen], slack_gain[chosen])
    value, converged = chain.run(gain[chosen], slacked, _MARGIN / 8, _MOST_SWEEPS)
    return slacked, chosen, value if converged else solve(mdp.matrix[chosen], gain[chosen])


def _roughly_best(mdp: ExplicitMDP, gain: FloatArray) -> IntArray:
    """Choices after modified policy iteration, until a Bellman step changes no value by more than a millionth."""
    gain = gain - 4 * _ROUGH
    chosen, value, sweeps = _first_policy(mdp, gain), np.zeros(mdp.n_states), _MOST_SWEEPS
    for _ in range(10_000):
        value = _evaluated(mdp, gain[chosen], chosen, value, _ROUGH / 4, sweeps)
        sweeps = _SWEEPS
        choice_value = gain + mdp.matrix @ value
        best = mdp.best(choice_value)
        chosen = np.where(best > choice_value[chosen] + _ROUGH / 2, mdp.greedy(choice_value), chosen)
        change = np.abs(best - value).max()
        value = best
        if change <= _ROUGH:
            break
    return chosen


def _evaluated(
    mdp: ExplicitMDP, gain: FloatArray, chosen: IntArray, value: FloatArray, tolerance: float, sweeps: int
) -> FloatArray:
    """The value of a policy, approached by sweeps until the last one changes nothing by more than `tolerance`."""
    matrix = mdp.matrix[chosen]
    for sweep in range(1, sweeps + 1):
        before, value = value, gain + matrix @ value
        if sweep % _SWEEPS == 0 and np.abs(value - before).max() <= tolerance:
            break
    return value


def _first_policy(mdp: ExplicitMDP, gain: FloatArray) -> IntArray:
    """The best gain where there is one at hand, and the way to the nearest one elsewhere."""
    first = mdp.greedy(gain)
    door = gain[first] > 0
    way = attractor(mdp, door)
    return np.where(door | (way < 0), first, way)


_ROUGH = 1e-6  # change in a Bellman step at which the search for a first policy ends: the exact one is short from there
_NEAR = 1e-11  # what choices may still gain when sweeps end: less than bounds are apart where runs take 1e5 steps
_SWEEPS = 40  # between two looks at the choices: a look costs as much as some sweeps
_MOST_SWEEPS = 5_000  # more than these take as long as a sparse LU
_MOST_ROUNDS = 200  # of sweeps and a look; then the choices stay as they are
_MARGIN = 2.0**-44  # by which a choice must be better to be taken: the rounding errors of a step are below 2**-50
_QUANTA = (2.0**-46, 2.0**-40, 2.0**-34)  # a bound is a multiple of the finest by which it is proved
_MOST_RAISES = 400  # sweeps that raise a bound, before a coarser grid is tried
