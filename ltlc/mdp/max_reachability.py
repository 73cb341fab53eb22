"""The largest probability of reaching a set of states, with bounds that are proved and not only believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp.certified import best_policy
from ltlc.mdp.end_components import maximal_end_components
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray
from ltlc.mdp.induction import ReachAvoid
from ltlc.mdp.quotient import collapse
from ltlc.mdp.reachability import almost_sure_region, approach

Method = Literal["auto", "policy", "interval"]


@dataclass(frozen=True, eq=False)
class Reachability:
    """Maximal probabilities, between two bounds, and a policy that attains the lower one.

    Attributes:
        lower: shape (n_states,); no larger than the true value.
        upper: shape (n_states,); no smaller than the true value; equal to `lower` where the graph alone decides 0 or 1.
        value: shape (n_states,); the best estimate in between.
        choice: shape (n_states,); an optimal choice per state, on the target the first one.
    """

    lower: FloatArray
    upper: FloatArray
    value: FloatArray
    choice: IntArray


def max_reachability(
    mdp: ExplicitMDP,
    target: BoolArray,
    *,
    method: Method = "auto",
    precision: float = 1e-6,
    max_iterations: int = 1_000_000,
) -> Reachability:
    """The largest probability of ever entering `target` (n_states,), from each state.

    1. Where the graph alone decides, the answer is exactly 0 or 1.
    2. In what is left, end components are collapsed, which makes the solution of the Bellman equation unique.
    3. `method="policy"`: policy iteration, whose result is turned into two bounds that a Bellman step provably moves
       inwards. `method="interval"`: iteration from below and from above until the two meet within `precision`. "auto"
       does the first, and some rounds of the second if the bounds are further apart than `precision`.

    Bounds are sound in each case, rounding included (see `ltlc.mdp.induction`): they hold for every MDP that the
    floating-point one may stand for. With "policy" and "auto" they can be wide where a best policy takes some 1e8 steps
    or more to get anywhere; the value is then still that of policy iteration.

    Raises:
        InvalidArgumentError: an unknown method, or a precision that is not positive.
        LimitExceeded: the bounds of interval iteration are still apart after `max_iterations`.

    References:
        S. Haddad, B. Monmege, Interval iteration algorithm for MDPs and IMDPs, TCS 735, 2018,
        DOI 10.1016/j.tcs.2016.12.003. C. Baier, J. Klein, L. Leuschner, D. Parker, S. Wunderlich, Ensuring the
        reliability of your model checker, CAV 2017, DOI 10.1007/978-3-319-63387-9_8. A. Hartmanns, B. Kaminski,
        Optimistic value iteration, CAV 2020, DOI 10.1007/978-3-030-53291-8_26 (bounds proved by being inductive).
    """
    if method not in ("auto", "policy", "interval"):
        raise InvalidArgumentError(f'method is {method!r}, expected "auto", "policy" or "interval"')
    if not precision > 0:
        raise InvalidArgumentError(f"precision is {precision}, expected a positive number")
    sure, safe, distance, possible = almost_sure_region(mdp, target)
    choice = np.where(sure & ~target, approach(mdp, distance, safe), mdp.choice_start[:-1])
    lower = sure.astype(np.float64)
    value, upper = lower.copy(), lower.copy()
    open_states = possible & ~sure
    if open_states.any():
        within = open_states[mdp.choice_state] & ~mdp.enters(~open_states)
        components = maximal_end_components(mdp, within)
        quotient = collapse(mdp, components, open_states)
        gain = mdp.expect(sure.astype(np.float64))[quotient.original]
        lose = (mdp.exit_probability + mdp.expect((~possible).astype(np.float64)))[quotient.original]
        problem = ReachAvoid(quotient.mdp, gain, lose).without_loops()
        bounds = _solve(problem, method, precision, max_iterations)
        block = quotient.block[open_states]
        lower[open_states], upper[open_states], value[open_states] = (b[block] for b in bounds[:3])
        choice = np.where(open_states, quotient.expand(bounds[3], mdp, components), choice)
    return Reachability(lower, upper, value, choice)


def _solve(
    problem: ReachAvoid, method: Method, precision: float, max_iterations: int
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Lower bound, upper bound, estimate and choices."""
    n = problem.mdp.n_states
    if method != "interval":
        best = best_policy(problem)
        lower, upper = best.lower, best.upper
        if method == "auto" and (upper - lower).max() > precision:
            lower, upper = interval_iteration(problem, lower, upper, precision, min(max_iterations, _CLOSING_ROUNDS))
        return lower, upper, np.clip(best.value, lower, upper), best.chosen
    lower, upper = interval_iteration(problem, np.zeros(n), np.ones(n), precision, max_iterations)
    gap = (upper - lower).max()
    if gap > precision:
        raise LimitExceeded(
            f"interval iteration: bounds are still {gap:.3g} apart after {max_iterations} iterations; allow more, "
            'ask for less precision, or use method="policy"'
        )
    return lower, upper, (lower + upper) / 2, problem.mdp.greedy(problem.gain + problem.mdp.matrix @ lower)


def interval_iteration(
    problem: ReachAvoid, lower: FloatArray, upper: FloatArray, precision: float, max_iterations: int
) -> tuple[FloatArray, FloatArray]:
    """Moves bounds on the probability of winning a problem, until at most `precision` apart.

    Each step is rounded outwards. Gives up after `max_iterations`, or when rounding allows no more progress.
    """
    mdp, gain = problem.mdp, problem.gain
    bounds = np.stack((lower, upper), axis=1)
    for _ in range(max_iterations):
        step = np.maximum.reduceat(gain[:, None] + mdp.matrix @ bounds, mdp.choice_start[:-1], axis=0)
        better = np.stack(
            (
                np.maximum(bounds[:, 0], step[:, 0] - problem.slack),
                np.minimum(bounds[:, 1], step[:, 1] + problem.slack),
            ),
            axis=1,
        )
        stuck = np.array_equal(better, bounds)
        bounds = better
        if stuck or (bounds[:, 1] - bounds[:, 0]).max() <= precision:
            break
    return bounds[:, 0], bounds[:, 1]


_CLOSING_ROUNDS = 300
