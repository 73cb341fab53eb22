"""The largest probability of reaching a set of states, with bounds that are proved and not only believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.end_components import maximal_end_components
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray
from ltlc.mdp.policy_iteration import improve
from ltlc.mdp.quotient import collapse
from ltlc.mdp.reachability import almost_sure_region, attractor, distance_to

Method = Literal["auto", "policy", "interval"]
LINEAR_SOLVE_LIMIT = 100_000
"""`auto` solves linear systems up to this many states in question, and iterates beyond."""


@dataclass(frozen=True, eq=False)
class Reachability:
    """Maximal probabilities, between two bounds, and a policy that attains the lower one."""

    lower: FloatArray
    """shape (n_states,); no larger than the true value."""
    upper: FloatArray
    """shape (n_states,); no smaller than the true value; equal to `lower` where the graph alone decides 0 or 1."""
    value: FloatArray
    """shape (n_states,); the best estimate in between."""
    choice: IntArray
    """shape (n_states,); an optimal choice per state, on the target the first one."""


def max_reachability(
    mdp: ExplicitMDP,
    target: BoolArray,
    *,
    method: Method = "auto",
    precision: float = 1e-9,
    max_iterations: int = 10_000_000,
) -> Reachability:
    """The largest probability of ever entering `target` (n_states,), from each state.

    1. Where the graph alone decides, the answer is exactly 0 or 1.
    2. In what is left, end components are collapsed, which makes the solution of the Bellman equation unique.
    3. `method="policy"`: policy iteration with sparse LU; its result is turned into two bounds that the Bellman operator
       moves inwards everywhere, by more than rounding can explain, which proves them. `method="interval"`: iteration
       from below and from above until the two meet within `precision`. "auto" does the first where the problem is small
       enough for LU, and the second otherwise or where no proof came out.

    Raises:
        InvalidArgumentError: an unknown method, or a precision that is not positive.
        LimitExceeded: the bounds are still apart after `max_iterations`.

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
    possible = distance_to(mdp, target) >= 0
    sure, safe = almost_sure_region(mdp, target)
    approach = attractor(mdp, target, safe)
    choice = np.where(sure & ~target, approach, mdp.choice_start[:-1])
    lower = sure.astype(np.float64)
    value, upper = lower.copy(), lower.copy()
    open_states = possible & ~sure
    if open_states.any():
        within = open_states[mdp.choice_state] & ~mdp.enters(~open_states)
        components = maximal_end_components(mdp, within)
        quotient = collapse(mdp, components, open_states)
        gain = np.asarray(mdp.matrix @ sure.astype(np.float64))[quotient.original]
        bounds = _solve(quotient.mdp, gain, method, precision, max_iterations)
        block = quotient.block[open_states]
        lower[open_states], upper[open_states], value[open_states] = (b[block] for b in bounds[:3])
        choice = np.where(open_states, quotient.expand(bounds[3], mdp, components), choice)
    return Reachability(lower, upper, value, choice)


def _solve(
    mdp: ExplicitMDP, gain: FloatArray, method: Method, precision: float, max_iterations: int
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Lower bound, upper bound, estimate and choices for v = max over choices of gain + matrix v."""
    if method == "policy" or (method == "auto" and mdp.n_states <= LINEAR_SOLVE_LIMIT):
        value, chosen, _ = improve(mdp, gain, mdp.greedy(gain))
        bounds = _inductive_bounds(mdp, gain, value, chosen)
        if bounds is not None and (method == "policy" or (bounds[1] - bounds[0]).max() <= precision):
            return *bounds, np.clip(value, *bounds), chosen
        if method == "policy":
            raise LimitExceeded('policy iteration gave values that could not be proved; use method="interval"')
    lower, upper = interval_iteration(mdp, gain, precision, max_iterations)
    return lower, upper, (lower + upper) / 2, mdp.greedy(gain + mdp.matrix @ lower)


def interval_iteration(
    mdp: ExplicitMDP, gain: FloatArray, precision: float, max_iterations: int
) -> tuple[FloatArray, FloatArray]:
    """Bounds at most `precision` apart on the solution of v = max over choices of gain + matrix v, in [0, 1].

    The MDP must have no end component, so that the solution is unique.
    """
    bounds = np.stack((np.zeros(mdp.n_states), np.ones(mdp.n_states)), axis=1)
    for _ in range(max_iterations):
        step = np.maximum.reduceat(gain[:, None] + mdp.matrix @ bounds, mdp.choice_start[:-1], axis=0)
        bounds[:, 0] = np.maximum(bounds[:, 0], step[:, 0])
        bounds[:, 1] = np.minimum(bounds[:, 1], step[:, 1])
        gap = (bounds[:, 1] - bounds[:, 0]).max()
        if gap <= precision:
            return bounds[:, 0], bounds[:, 1]
    raise LimitExceeded(
        f"interval iteration: bounds are still {gap:.3g} apart after {max_iterations} iterations; allow more, ask for less "
        'precision, or use method="policy"'
    )


def _inductive_bounds(
    mdp: ExplicitMDP, gain: FloatArray, value: FloatArray, chosen: IntArray
) -> tuple[FloatArray, FloatArray] | None:
    """Bounds around `value` that one Bellman step provably moves inwards, or None.

    With h(s) expected steps, value + c h is lowered by c in each step of a policy whose steps h counts. From above this
    must hold for every choice: h counts those of the slowest among the nearly optimal policies, and the other choices
    are worse by more than c h can make up for. Rounding is far below c / 2, the margin that is checked.
    """
    ones = np.ones(mdp.n_choices)
    nearly_best = gain + mdp.matrix @ value >= value[mdp.choice_state] - _NEARLY
    rows = np.flatnonzero(nearly_best)
    counts = np.bincount(mdp.choice_state[rows], minlength=mdp.n_states)
    if (counts == 0).any() or not nearly_best[chosen].all():
        return None
    part = ExplicitMDP(
        mdp.matrix[rows],
        np.concatenate(([0], np.cumsum(counts))),
        mdp.choice_action[rows],
        mdp.initial,
        leak=mdp.leak[rows],
    )
    slowest, _, _ = improve(part, ones[rows], np.searchsorted(rows, chosen))
    own = MarkovChain(mdp, mdp.choice_matrix(chosen)).total(np.ones(mdp.n_states))
    c = min(_NEARLY / (2 * slowest.max()), _NEARLY / (2 * own.max()), 1e-12)
    upper, lower = value + c * slowest, value - c * own
    falls = mdp.best(gain + mdp.matrix @ upper) <= upper - c / 2
    rises = (gain + mdp.matrix @ lower)[chosen] >= lower + c / 2
    if c < _ROUNDING or not (falls.all() and rises.all()):
        return None
    return np.clip(lower, 0.0, 1.0), np.clip(upper, 0.0, 1.0)


_NEARLY = 1e-8
_ROUNDING = 1e-14
"""Values are in [0, 1] and rows short: one Bellman step rounds by a few 1e-16."""
