"""The largest probability of reaching a set of states, with bounds that are proved and not only believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp.chain import MarkovChain, solve
from ltlc.mdp.end_components import maximal_end_components
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray, ranges
from ltlc.mdp.induction import Race
from ltlc.mdp.parts import parts
from ltlc.mdp.policy_iteration import improve
from ltlc.mdp.quotient import collapse
from ltlc.mdp.reachability import almost_sure_region, approach, attractor, distance_to
from ltlc.mdp.sweeps import GaussSeidel

Method = Literal["auto", "policy", "interval"]
LINEAR_SOLVE_LIMIT = 10_000
"""`auto` and `policy` evaluate policies by sparse LU up to this many states in question, and by sweeps beyond."""


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
    precision: float = 1e-6,
    max_iterations: int = 1_000_000,
) -> Reachability:
    """The largest probability of ever entering `target` (n_states,), from each state.

    1. Where the graph alone decides, the answer is exactly 0 or 1.
    2. In what is left, end components are collapsed, which makes the solution of the Bellman equation unique.
    3. `method="policy"`: policy iteration, whose result is turned into two bounds that the Bellman operator moves
       inwards everywhere, by more than rounding can explain, which proves them. Policies are evaluated by sparse LU,
       or by sweeps (modified policy iteration) where the problem is too large for that. `method="interval"`: iteration
       from below and from above until the two meet within `precision`. "auto" does the first, and some rounds of the
       second if the bounds are further apart than `precision`.

    Bounds are sound in each case. They can be wide with "policy" and "auto", where the MDP has policies that dawdle
    almost for ever; the value is then still that of policy iteration.

    Raises:
        InvalidArgumentError: an unknown method, or a precision that is not positive.
        LimitExceeded: the bounds of interval iteration are still apart after `max_iterations`.

    References:
        S. Haddad, B. Monmege, Interval iteration algorithm for MDPs and IMDPs, TCS 735, 2018,
        DOI 10.1016/j.tcs.2016.12.003. C. Baier, J. Klein, L. Leuschner, D. Parker, S. Wunderlich, Ensuring the
        reliability of your model checker, CAV 2017, DOI 10.1007/978-3-319-63387-9_8. A. Hartmanns, B. Kaminski,
        Optimistic value iteration, CAV 2020, DOI 10.1007/978-3-030-53291-8_26 (bounds proved by being inductive).
        M. L. Puterman, M. C. Shin, Modified policy iteration algorithms for discounted Markov decision problems,
        Management Science 24(11), 1978, DOI 10.1287/mnsc.24.11.1127 (sweeps).
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
        lose = (mdp.leak + mdp.expect((~possible).astype(np.float64)))[quotient.original]
        race = Race(quotient.mdp, gain, lose).without_loops()
        bounds = _solve(race, method, precision, max_iterations)
        block = quotient.block[open_states]
        lower[open_states], upper[open_states], value[open_states] = (b[block] for b in bounds[:3])
        choice = np.where(open_states, quotient.expand(bounds[3], mdp, components), choice)
    return Reachability(lower, upper, value, choice)


def _solve(
    race: Race, method: Method, precision: float, max_iterations: int
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Lower bound, upper bound, estimate and choices."""
    mdp, gain = race.mdp, race.gain
    lower, upper = np.zeros(mdp.n_states), np.ones(mdp.n_states)
    if method != "interval":
        lower, upper, value, chosen = _by_policies(race)
        if method == "auto" and (upper - lower).max() > precision:
            rounds = min(max_iterations, _CLOSING_ROUNDS)
            lower, upper = interval_iteration(mdp, gain, lower, upper, precision, rounds)
        return lower, upper, np.clip(value, lower, upper), chosen
    lower, upper = interval_iteration(mdp, gain, lower, upper, precision, max_iterations)
    gap = (upper - lower).max()
    if gap > precision:
        raise LimitExceeded(
            f"interval iteration: bounds are still {gap:.3g} apart after {max_iterations} iterations; allow more, "
            'ask for less precision, or use method="policy"'
        )
    return lower, upper, (lower + upper) / 2, mdp.greedy(gain + mdp.matrix @ lower)


def interval_iteration(
    mdp: ExplicitMDP, gain: FloatArray, lower: FloatArray, upper: FloatArray, precision: float, max_iterations: int
) -> tuple[FloatArray, FloatArray]:
    """Moves bounds on the solution of v = max over choices of gain + matrix v, until at most `precision` apart.

    The MDP must have no end component, so that the solution is unique. Gives up after `max_iterations`.
    """
    bounds = np.stack((lower, upper), axis=1)
    for _ in range(max_iterations):
        step = np.maximum.reduceat(gain[:, None] + mdp.matrix @ bounds, mdp.choice_start[:-1], axis=0)
        bounds[:, 0] = np.maximum(bounds[:, 0], step[:, 0])
        bounds[:, 1] = np.minimum(bounds[:, 1], step[:, 1])
        if (bounds[:, 1] - bounds[:, 0]).max() <= precision:
            break
    return bounds[:, 0], bounds[:, 1]


def _by_policies(race: Race) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Lower bound, upper bound, estimate and choices, one part of the process after the other.

    Policy iteration with a gain that is smaller by a margin in every choice does not dawdle for ever for the sake of
    rounding errors. Its value rises in a step of the true process, so it is a lower bound. The value of its policy is
    where the search for an upper bound begins.
    """
    mdp, gain = race.mdp, race.gain
    lower, value, upper = np.zeros(mdp.n_states), np.zeros(mdp.n_states), np.zeros(mdp.n_states)
    chosen = np.zeros(mdp.n_states, dtype=np.int32)
    for states in parts(mdp):
        part, rows = mdp, np.arange(mdp.n_choices)
        if len(states) < mdp.n_states:
            part, rows = _part(mdp, states)
        entering = mdp.matrix[rows] if part is not mdp else mdp.matrix
        local_gain = gain[rows] + entering @ value
        by = _by_policy_iteration if part.n_states <= LINEAR_SOLVE_LIMIT else _by_sweeps
        slacked, picked, exact = by(part, local_gain)
        above = float((upper - value).max())
        below = float((value - lower).max())
        chosen[states] = rows[picked]
        value[states] = exact
        lower[states] = np.clip(slacked - below, 0.0, 1.0)
        if not race.sinks_nowhere(lower, chosen[states]):
            lower[states] = 0.0
        for quantum in _QUANTA:  # by linearity this is the value of the policy when each step gains 4 quanta
            upper[states] = exact + above + (exact - slacked) * (4 * quantum / _MARGIN)
            if race.raised(upper, states, quantum, _MOST_RAISES):
                break
        else:
            upper[states] = 1.0
    return lower, upper, value, chosen


def _part(mdp: ExplicitMDP, states: IntArray) -> tuple[ExplicitMDP, IntArray]:
    """The process on some of its states, left by entering another one, and which choices it has."""
    count = np.diff(mdp.choice_start)[states]
    rows = ranges(mdp.choice_start[states], count)
    matrix = mdp.matrix[rows][:, states]
    leak = np.clip(1 - np.asarray(matrix.sum(axis=1)).ravel(), 0.0, 1.0)
    start = np.concatenate(([0], np.cumsum(count)))
    return ExplicitMDP(matrix, start, mdp.choice_action[rows], mdp.initial[states], leak=leak), rows


def _by_policy_iteration(mdp: ExplicitMDP, gain: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Values that rise in a step, choices, and the values of those choices."""
    start, _ = _swept(mdp, gain - 4 * _ROUGH, _first_policy(mdp, gain), _ROUGH)
    slacked, chosen, _ = improve(mdp, gain - _MARGIN, start)
    return slacked, chosen, MarkovChain.under(mdp, mdp.choice_matrix(chosen)).total(gain[chosen])


def _by_sweeps(mdp: ExplicitMDP, gain: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """The same by modified policy iteration, which need not settle which of the nearly best choices is best."""
    slack_gain = gain - _MARGIN
    door = mdp.best(gain) > 0
    order = np.argsort(distance_to(mdp, door), kind="stable")
    chosen, slacked = _first_policy(mdp, gain), np.zeros(mdp.n_states)
    for _ in range(_MOST_ROUNDS):
        chain = GaussSeidel(mdp.matrix[chosen], order)
        slacked, _ = chain.run(slack_gain[chosen], slacked, _MARGIN / 8, _SWEEPS)
        choice_value = slack_gain + mdp.matrix @ slacked
        best, own = mdp.best(choice_value), choice_value[chosen]
        if (best - np.minimum(own, slacked)).max() <= _NEAR:
            break
        chosen = np.where(best > own + _MARGIN, mdp.greedy(choice_value), chosen)
    slacked, settled = chain.run(slack_gain[chosen], slacked, _MARGIN / 8, _MOST_SWEEPS)
    if not settled:
        slacked = solve(mdp.matrix[chosen], slack_gain[chosen])
    value, settled = chain.run(gain[chosen], slacked, _MARGIN / 8, _MOST_SWEEPS)
    return slacked, chosen, value if settled else solve(mdp.matrix[chosen], gain[chosen])


def _swept(
    mdp: ExplicitMDP,
    gain: FloatArray,
    chosen: IntArray,
    tolerance: float,
    value: FloatArray | None = None,
    rounds: int = 10_000,
) -> tuple[IntArray, FloatArray]:
    """Choices and values after modified policy iteration, until a Bellman step changes no value by more."""
    sweeps = _MOST_SWEEPS if value is None else _SWEEPS
    value = np.zeros(mdp.n_states) if value is None else value
    for _ in range(rounds):
        value = _evaluated(mdp, gain[chosen], chosen, value, tolerance / 4, sweeps)
        sweeps = _SWEEPS
        choice_value = gain + mdp.matrix @ value
        best = mdp.best(choice_value)
        better = best > choice_value[chosen] + tolerance / 2
        chosen = np.where(better, mdp.greedy(choice_value), chosen)
        change = np.abs(best - value).max()
        value = best
        if change <= tolerance:
            break
    return chosen, value


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


_ROUGH = 1e-6
_NEAR = 1e-11
_SWEEPS = 40
_MOST_SWEEPS = 5_000
_MOST_ROUNDS = 200
_MARGIN = 2.0**-44
_QUANTA = (2.0**-46, 2.0**-40, 2.0**-34)
_MOST_RAISES = 400
_CLOSING_ROUNDS = 300
