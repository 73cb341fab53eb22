"""Why a policy satisfies its formula with a probability below 1: how runs get lost, and where they then stay.

A product state is *lost* if the probability of satisfaction from it is exactly 0. What is missing to 1 is the
probability of ever entering a lost state, and each run that does enters once: so the loss is the sum over the steps
into lost states, and over the finite paths that end with such a step.

References:
    T. Han, J.-P. Katoen, B. Damman: Counterexample Generation in Probabilistic Model Checking. IEEE Transactions on
    Software Engineering 35(2), 2009, doi 10.1109/TSE.2009.5 (the most probable paths).
    H. Aljazzar, S. Leue: K*: A heuristic search algorithm for finding the k shortest paths. Artificial Intelligence
    175(18), 2011, doi 10.1016/j.artint.2011.07.003 (best-first search for them).
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.budget import check_time
from ltlc.mdp.absorption import absorption
from ltlc.mdp.chain import MarkovChain, induced_chain, solve
from ltlc.mdp.explicit import BoolArray, FloatArray, IntArray
from ltlc.mdp.product import Product
from ltlc.mdp.routes import Route, most_probable_routes
from ltlc.mdp.satisfaction import PolicySatisfaction, satisfaction_probability

SHARE = 0.9
"""of the loss that the ways to fail are to carry together."""
MAX_PATHS = 100
_MAX_STEPS = 200_000
"""of the search for the most probable paths."""


@dataclass(frozen=True)
class FailingPath:
    """A finite path to a lost state, and its probability.

    Attributes:
        states: product states; the last one is the first that is lost.
        probability: that a run begins with it.
    """

    states: tuple[int, ...]
    probability: float


@dataclass(frozen=True)
class Entry:
    """A step into the lost states.

    Attributes:
        source: the product state before, or None where the first state is lost.
        target: the lost product state that is entered.
        probability: that a run gets lost by this step.
        path: the most probable path that ends with it.
    """

    source: int | None
    target: int
    probability: float
    path: FailingPath


@dataclass(frozen=True)
class Trap:
    """Where lost runs stay for ever.

    Attributes:
        states: product states: of a bottom component; or of all states from which no word is accepted any more.
        probability: that a run ends up there.
        violated: whether no word is accepted from there any more, so that it does not matter where it stays.
        fin: the pairs whose Fin marks are seen again and again.
        inf: the pairs whose Inf marks are.
    """

    states: tuple[int, ...]
    probability: float
    violated: bool
    fin: tuple[int, ...]
    inf: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Failure:
    """How a policy fails.

    Attributes:
        satisfaction: the probability of satisfaction, with bounds.
        loss: what is missing to 1, as the sum over all entries.
        paths: the most probable finite paths, down to `share` of the loss, or the first `MAX_PATHS` if that takes more.
        routes: the most probable paths with the detours left out, down to `share` of the loss, or `MAX_PATHS`; none
            where the undecided states are more than 400. See `ltlc.mdp.routes`.
        entries: the most probable steps into lost states that carry `share` of the loss together.
        traps: where lost runs stay, the most probable first.
        why: why neither paths nor routes carry `share` of the loss; empty if one of them do.
        steps: expected steps before a run is lost or won.
    """

    satisfaction: PolicySatisfaction
    loss: float
    paths: tuple[FailingPath, ...]
    routes: tuple[Route, ...]
    entries: tuple[Entry, ...]
    traps: tuple[Trap, ...]
    why: str
    steps: float

    @property
    def paths_carry(self) -> float:
        """The part of the loss that the paths carry; 1 where nothing is lost."""
        return _part(sum(path.probability for path in self.paths), self.loss)

    @property
    def routes_carry(self) -> float:
        """The part of the loss that the routes carry."""
        return _part(sum(route.probability for route in self.routes), self.loss)

    @property
    def entries_carry(self) -> float:
        """The part of the loss that the entries carry."""
        return _part(sum(entry.probability for entry in self.entries), self.loss)


def failure(product: Product, policy: npt.ArrayLike, *, share: float = SHARE, max_paths: int = MAX_PATHS) -> Failure:
    """How a policy fails: the most probable paths and steps into lost states, and where lost runs stay.

    Args:
        product: of the model and the automaton.
        policy: on its states, as `satisfaction_probability` takes it.
        share: of the loss, in (0, 1].
        max_paths: how many paths there may be.

    Raises:
        InvalidArgumentError: the policy does not fit the product.

    Example:
        >>> import ltlc
        >>> from ltlc.mdp import LabelledMDP, Product
        >>> slippery = LabelledMDP.from_arrays(
        ...     [[[0.5, 0.25, 0.25], [0, 1, 0], [0, 0, 1]]], aps=["goal"], labels=[[], ["goal"], []]
        ... )
        >>> found = failure(Product(slippery, ltlc.compile("F goal")), [0, 0, 0])
        >>> found.loss, [path.probability for path in found.paths][:2], found.traps[0].probability
        (0.5, [0.25, 0.125], 0.5)
    """
    satisfaction = satisfaction_probability(product, policy)
    chain = induced_chain(product, policy)
    lost = satisfaction.state_probability == 0
    live = ~lost & (satisfaction.state_probability < 1)
    visits = _visits(chain, live, chain.initial)
    source, target, flow = _entries(chain, live, lost, visits)
    at_once = np.where(lost, chain.initial, 0.0)
    loss = float(flow.sum() + at_once.sum())
    paths = _most_probable(chain, live, lost, share * loss, max_paths)
    routes = most_probable_routes(chain, live, lost, share * loss, max_paths)
    entries = _listed(chain, live, (source, target, flow), at_once, share * loss)
    traps = _traps(product, chain, lost)
    steps = float(visits.sum())
    carried = max(sum(path.probability for path in paths), sum(route.probability for route in routes))
    why = ""
    if loss > 0 and carried < share * loss * (1 - 1e-12):
        why = (
            f"the most probable paths that are listed carry {carried / loss:.1%} of the loss, with their detours: a run"
            f" takes {steps:.3g} steps on average until it is decided, in many different orders"
        )
    return Failure(satisfaction, loss, paths, routes, entries, traps, why, steps)


def _part(carried: float, loss: float) -> float:
    return carried / loss if loss > 0 else 1.0


def _visits(chain: MarkovChain, inside: BoolArray, start: FloatArray) -> FloatArray:
    """The expected visits of transient states, when runs begin as `start` says; 0 elsewhere."""
    visits = np.zeros(chain.n_states)
    members = np.flatnonzero(inside)
    if members.size:
        visits[members] = np.maximum(solve(chain.matrix[members][:, members].T, start[members]), 0.0)
    return visits


def _entries(
    chain: MarkovChain, live: BoolArray, lost: BoolArray, visits: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """The steps from live to lost states: source, target, and the probability that a run gets lost by it."""
    matrix = chain.matrix.tocoo()
    row, column = matrix.coords
    chosen = live[row] & lost[column] & (matrix.data > 0)
    return row[chosen], column[chosen], visits[row[chosen]] * matrix.data[chosen]


def _best_from_start(chain: MarkovChain, live: BoolArray) -> tuple[FloatArray, IntArray]:
    """The probability of the most probable path to each live state, and the state before on it (-1: it begins)."""
    best, before = np.zeros(chain.n_states), np.full(chain.n_states, -1, dtype=np.int64)
    best[live] = chain.initial[live]
    queue = [(-p, q) for q, p in enumerate(best.tolist()) if p > 0]
    heapq.heapify(queue)
    while queue:
        p, q = heapq.heappop(queue)
        if -p < best[q]:
            continue
        for target, step in _steps(chain, q):
            if live[target] and -p * step > best[target]:
                best[target], before[target] = -p * step, q
                heapq.heappush(queue, (p * step, target))
    return best, before


def _steps(chain: MarkovChain, state: int) -> list[tuple[int, float]]:
    start, end = chain.matrix.indptr[state], chain.matrix.indptr[state + 1]
    return list(zip(chain.matrix.indices[start:end].tolist(), chain.matrix.data[start:end].tolist(), strict=True))


def _listed(
    chain: MarkovChain,
    live: BoolArray,
    steps: tuple[IntArray, IntArray, FloatArray],
    at_once: FloatArray,
    needed: float,
) -> tuple[Entry, ...]:
    """The most probable entries, until they carry what is needed."""
    first = np.flatnonzero(at_once)
    source = np.concatenate((np.full(len(first), -1), steps[0]))
    target, flow = np.concatenate((first, steps[1])), np.concatenate((at_once[first], steps[2]))
    best, before = _best_from_start(chain, live)
    entries: list[Entry] = []
    carried = 0.0
    for i in np.lexsort((target, source, -flow)).tolist():
        if carried >= needed:
            break
        s, t, probability = int(source[i]), int(target[i]), float(flow[i])
        if s < 0:
            entries.append(Entry(None, t, probability, FailingPath((t,), probability)))
        else:
            states, chance = [t, s], float(best[s]) * float(chain.matrix[s, t])
            while before[states[-1]] >= 0:
                states.append(int(before[states[-1]]))
            entries.append(Entry(s, t, probability, FailingPath(tuple(reversed(states)), chance)))
        carried += probability
    return tuple(entries)


def _most_probable(
    chain: MarkovChain, live: BoolArray, lost: BoolArray, needed: float, max_paths: int
) -> tuple[FailingPath, ...]:
    """The most probable paths into lost states in decreasing order, until they carry what is needed."""
    promise = _best_to(chain, live, lost)
    queue: list[tuple[float, int, int, float, Any]] = []
    number = 0
    for q in np.flatnonzero(chain.initial > 0).tolist():
        if promise[q] > 0:
            p = float(chain.initial[q])
            heapq.heappush(queue, (-p * promise[q], number, q, p, None))
            number += 1
    paths: list[FailingPath] = []
    carried = 0.0
    for step in range(_MAX_STEPS):
        if not queue or len(paths) >= max_paths or carried >= needed:
            break
        if not step & 1023:
            check_time()
        _, _, q, p, trail = heapq.heappop(queue)
        if lost[q]:
            states = [q]
            while trail is not None:
                state, trail = trail
                states.append(state)
            paths.append(FailingPath(tuple(reversed(states)), p))
            carried += p
            continue
        for target, chance in _steps(chain, q):
            if promise[target] > 0:
                heapq.heappush(queue, (-p * chance * promise[target], number, target, p * chance, (q, trail)))
                number += 1
    return tuple(paths)


def _best_to(chain: MarkovChain, live: BoolArray, lost: BoolArray) -> FloatArray:
    """The probability of the most probable path from each state into a lost one; 0 from those that cannot."""
    best = np.where(lost, 1.0, 0.0)
    columns = chain.matrix.tocsc()
    queue = [(-1.0, q) for q in np.flatnonzero(lost).tolist()]
    while queue:
        p, q = heapq.heappop(queue)
        if -p < best[q]:
            continue
        start, end = columns.indptr[q], columns.indptr[q + 1]
        for source, step in zip(columns.indices[start:end].tolist(), columns.data[start:end].tolist(), strict=True):
            if live[source] and -p * step > best[source]:
                best[source] = -p * step
                heapq.heappush(queue, (p * step, source))
    return best


def _traps(product: Product, chain: MarkovChain, lost: BoolArray) -> tuple[Trap, ...]:
    """Where lost runs stay, and how probably; all violations are one trap."""
    bottom = chain.bottom_component
    violated = (bottom >= 0) & np.isin(product.machine_state, product.automaton.deadlocks)
    seen = [
        [chain.of_choices(marks.astype(np.float64)) > 0 for marks in table]
        for table in (product.choice_fin, product.choice_inf)
    ]
    traps = []
    if violated.any():
        # The states in which a run is violated first, which need not be those where it stays.
        broken = np.isin(product.machine_state, product.automaton.deadlocks)
        matrix = chain.matrix.tocoo()
        row, column = matrix.coords
        entered = np.unique(column[broken[column] & ~broken[row] & (matrix.data > 0)])
        entered = np.union1d(entered, np.flatnonzero(broken & (chain.initial > 0)))
        traps.append(Trap(tuple(entered.tolist()), _ends_in(chain, violated), True, (), ()))
    for component in np.unique(bottom[lost & ~violated & (bottom >= 0)]).tolist():
        inside = bottom == component
        fin, inf = (tuple(i for i, marks in enumerate(kind) if marks[inside].any()) for kind in seen)
        traps.append(Trap(tuple(np.flatnonzero(inside).tolist()), _ends_in(chain, inside), False, fin, inf))
    return tuple(sorted((trap for trap in traps if trap.probability > 0), key=lambda trap: -trap.probability))


def _ends_in(chain: MarkovChain, inside: BoolArray) -> float:
    """The probability that a run ends up in some bottom components."""
    return float(chain.initial @ absorption(chain, inside).value)
