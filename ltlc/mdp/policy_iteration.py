"""Policy iteration (thesis 2.3.3), and what it needs where nothing is discounted."""

from __future__ import annotations

import hashlib

import numpy as np

from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.mdp.chain import MarkovChain
from ltlc.mdp.end_components import maximal_end_components
from ltlc.mdp.explicit import BoolArray, ExplicitMDP, FloatArray, IntArray
from ltlc.mdp.quotient import collapse
from ltlc.mdp.reachability import attractor, distance_to
from ltlc.mdp.value_iteration import Solution

IMPROVEMENT = 1e-14
"""An action must be better by this, relative to the largest value, to replace another: rounding is not."""


def policy_iteration(
    mdp: ExplicitMDP, reward: FloatArray, *, discount: float = 1.0, max_iterations: int = 10_000
) -> Solution:
    """Optimal expected sum of rewards, exact up to rounding; `reward` has shape (n_choices,).

    Every policy must leave the process surely or be discounted: otherwise use `optimal_total_reward`.

    Raises:
        InvalidArgumentError: some policy stays for ever, so its sum of rewards need not exist.
        LimitExceeded: the policy still improves after `max_iterations` rounds.

    References:
        R. Howard, Dynamic Programming and Markov Processes, MIT Press 1960; thesis eq. 2.26-2.30.
    """
    process = mdp.reweighted(discount)
    if maximal_end_components(process).n_components:
        raise InvalidArgumentError(
            "some policy goes on for ever undiscounted; use optimal_total_reward, or discount < 1"
        )
    value, chosen, iterations = improve(process, reward, process.greedy(reward), max_iterations)
    return Solution(value, process.choice_action[chosen], 0.0, iterations)


def optimal_total_reward(mdp: ExplicitMDP, reward: FloatArray, *, max_iterations: int = 10_000) -> Solution:
    """Optimal expected sum of rewards until the process is left, discounted only by what `mdp.matrix` discounts itself.

    End components that cost nothing are collapsed, with the option to stay there for ever. States that no policy can
    leave surely, neither for such a component nor for the end, have value -inf. The rest is a stochastic shortest path
    problem, solved by policy iteration from a policy that leaves surely.

    Raises:
        InvalidArgumentError: an end component pays a positive reward, so that the sum may be infinite or undetermined.
        LimitExceeded: the policy still improves after `max_iterations` rounds.

    References:
        D. Bertsekas, J. Tsitsiklis, An analysis of stochastic shortest path problems, Mathematics of Operations
        Research 16(3), 1991, DOI 10.1287/moor.16.3.580. L. de Alfaro, Computing minimum and maximum reachability times
        in probabilistic systems, CONCUR 1999, DOI 10.1007/3-540-48320-9_7.
    """
    endless = maximal_end_components(mdp)
    if (reward[endless.choices] > 0).any():
        choice = np.flatnonzero(endless.choices & (reward > 0))[0]
        raise InvalidArgumentError(
            f"state {mdp.describe(mdp.choice_state[choice])} can be paid {reward[choice]:.6g} again and again without "
            "end: the undiscounted return may be infinite; use a discount below 1"
        )
    free = maximal_end_components(mdp, endless.choices & (reward == 0))
    quotient = collapse(mdp, free, may_stay=True)
    process = quotient.mdp
    gain = np.where(quotient.original >= 0, reward[quotient.original], 0.0)
    proper, start = _leaving_policy(process)
    value = np.full(process.n_states, -np.inf)
    chosen = np.where(start >= 0, start, process.choice_start[:-1])
    iterations = 0
    if proper.any():
        part, rows = _restricted(process, proper)
        local_start = np.searchsorted(rows, start[proper])
        value[proper], picked, iterations = improve(part, gain[rows], local_start, max_iterations)
        chosen[proper] = rows[picked]
    choice = quotient.expand(chosen, mdp, free)
    return Solution(value[quotient.block], mdp.choice_action[choice], 0.0, iterations)


def improve(
    mdp: ExplicitMDP, reward: FloatArray, chosen: IntArray, max_iterations: int = 10_000
) -> tuple[FloatArray, IntArray, int]:
    """Policy iteration from the policy that takes the choices `chosen` (n_states,), which must leave surely.

    A policy comes again only by rounding, between some that are equally good as far as can be told; then it is done.

    Returns:
        values and choices, both shape (n_states,), and the number of rounds.
    """
    seen: set[bytes] = set()
    for iteration in range(1, max_iterations + 1):
        chain = MarkovChain.under(mdp, mdp.choice_matrix(chosen))
        value = chain.total(reward[chosen])
        choice_value = reward + mdp.matrix @ value
        better = mdp.best(choice_value)
        slack = IMPROVEMENT * (1 + np.abs(value).max(initial=0.0))
        switch = better > choice_value[chosen] + slack
        policy = hashlib.sha256(chosen.tobytes()).digest()
        if not switch.any() or policy in seen:
            return value, chosen, iteration
        seen.add(policy)
        chosen = np.where(switch, mdp.greedy(choice_value), chosen)
    raise LimitExceeded(f"the policy still improves after {max_iterations} rounds of policy iteration")


def _leaving_policy(mdp: ExplicitMDP) -> tuple[BoolArray, IntArray]:
    """The states that some policy leaves the process from surely, and the choices of such a policy (-1 elsewhere)."""
    region = np.ones(mdp.n_states, dtype=np.bool_)
    while True:
        safe = ~mdp.enters(~region)
        exits = safe & (mdp.exit_probability > 0)
        door = np.logical_or.reduceat(exits, mdp.choice_start[:-1])
        reaching = distance_to(mdp, door, safe) >= 0
        if np.array_equal(reaching, region):
            break
        region = reaching
    first_exit = mdp.greedy(exits.astype(np.float64))
    return region, np.where(door, first_exit, attractor(mdp, door, safe))


def _restricted(mdp: ExplicitMDP, region: BoolArray) -> tuple[ExplicitMDP, IntArray]:
    """The states in `region` with the choices that never enter another one, and which choices those are."""
    rows = np.flatnonzero(region[mdp.choice_state] & ~mdp.enters(~region))
    counts = np.bincount(mdp.choice_state[rows], minlength=mdp.n_states)[region]
    part = ExplicitMDP(
        mdp.matrix[rows][:, np.flatnonzero(region)],
        np.concatenate(([0], np.cumsum(counts))),
        mdp.choice_action[rows],
        mdp.initial[region],
        exit_probability=mdp.exit_probability[rows],
        n_actions=mdp.n_actions,
    )
    return part, rows
