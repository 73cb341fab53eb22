"""Why a policy fails: paths, routes, entries and traps against slower ways to compute them."""

from __future__ import annotations

from collections import defaultdict
from fractions import Fraction

import numpy as np
import pytest
from suite_tasks import load_suite

import ltlc
from ltlc.mdp import LabelledMDP, Product, induced_chain
from ltlc.mdp.failure import failure
from ltlc.mdp.routes import most_probable_routes


def random_product(seed: int) -> tuple[Product, np.ndarray]:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 7))
    names = ("goal", "trap")
    rows = rng.random((2, n, n)) * (rng.random((2, n, n)) < 0.5) + 1e-9 * np.eye(n)
    rows += 0.05 * np.eye(n)[rng.permutation(n)]
    matrices = rows / rows.sum(axis=2, keepdims=True)
    matrices[:, -1] = np.eye(n)[-1]
    matrices[:, -2] = np.eye(n)[-2]
    labels = [[name for name in names if rng.random() < 0.2] for _ in range(n - 2)] + [["trap"], ["goal"]]
    mdp = LabelledMDP.from_arrays(matrices, aps=names, labels=labels)
    text = ("F goal & G !trap", "GF goal", "!trap U goal", "FG goal | F(trap & X goal)")[seed % 4]
    product = Product(mdp, ltlc.compile(text))
    return product, rng.integers(0, 2, product.n_states)


def routes_by_steps(chain: object, live: np.ndarray, lost: np.ndarray, n_steps: int) -> dict[tuple[int, ...], float]:
    """Erase circles while the run goes: the distribution of the path so far without circles, step by step."""
    matrix = chain.matrix.toarray()  # type: ignore[attr-defined]
    now: dict[tuple[int, ...], float] = {
        (q,): float(p)
        for q, p in enumerate(chain.initial)  # type: ignore[attr-defined]
        if p > 0
    }
    ended: dict[tuple[int, ...], float] = defaultdict(float)
    for _ in range(n_steps):
        following: dict[tuple[int, ...], float] = defaultdict(float)
        for path, p in now.items():
            if lost[path[-1]]:
                ended[path] += p
                continue
            if not live[path[-1]]:
                continue
            for target in np.flatnonzero(matrix[path[-1]]).tolist():
                place = path.index(target) if target in path else len(path)
                following[*path[:place], target] += p * matrix[path[-1], target]
        now = {path: p for path, p in following.items() if p > 1e-13}
    return ended


@pytest.mark.slow
def test_random_models() -> None:
    n_lost = 0
    for seed in range(80):
        product, policy = random_product(seed)
        found = failure(product, policy, share=1.0, max_paths=40)
        chain = induced_chain(product, policy)
        probability = found.satisfaction.state_probability
        lost, live = probability == 0, (probability > 0) & (probability < 1)
        assert found.loss == pytest.approx(1 - found.satisfaction.probability, abs=1e-9)
        assert sum(trap.probability for trap in found.traps) == pytest.approx(found.loss, abs=1e-9)
        assert sum(entry.probability for entry in found.entries) == pytest.approx(found.loss, abs=1e-9)
        n_lost += 0 < found.loss < 1
        chances = [path.probability for path in found.paths]
        assert chances == sorted(chances, reverse=True)
        assert len({path.states for path in found.paths}) == len(found.paths)
        for path in [*found.paths, *(entry.path for entry in found.entries)]:
            exact = Fraction(float(chain.initial[path.states[0]]))
            for source, target in zip(path.states, path.states[1:], strict=False):
                exact *= Fraction(float(chain.matrix[source, target]))
            assert path.probability == pytest.approx(float(exact), rel=1e-12)
            assert lost[path.states[-1]]
            assert all(live[q] for q in path.states[:-1])
        assert sum(chances) <= found.loss * (1 + 1e-9)
        every = most_probable_routes(chain, live, lost, 2.0, 10**6)
        assert sum(route.probability for route in every) == pytest.approx(found.loss, abs=1e-9)
        assert list(found.routes) == list(every[: len(found.routes)])
        if seed < 16 and chain.n_states < 9:
            oracle = routes_by_steps(chain, live, lost, 3000)
            settled = sum(oracle.values())
            if settled > found.loss - 1e-6:  # else it goes in circles for longer than that
                assert {route.states for route in every if route.probability > 1e-5} <= oracle.keys()
                for route in every:
                    assert route.probability == pytest.approx(oracle.get(route.states, 0.0), abs=2e-6)
    assert n_lost > 20


def test_the_most_probable_paths_are_found() -> None:
    product, policy = random_product(4)
    found = failure(product, policy, share=1.0, max_paths=30)
    chain = induced_chain(product, policy)
    probability = found.satisfaction.state_probability
    least = found.paths[-1].probability
    paths: list[tuple[tuple[int, ...], float]] = [((q,), float(p)) for q, p in enumerate(chain.initial) if p > 0]
    ended = []
    while paths:
        states, p = paths.pop()
        if probability[states[-1]] == 0:
            ended.append(p)
        elif probability[states[-1]] < 1:
            row = chain.matrix[[states[-1]]]
            steps = zip(row.indices.tolist(), row.data.tolist(), strict=True)
            paths += [((*states, q), p * step) for q, step in steps if p * step >= least]
    assert sorted(ended, reverse=True)[: len(found.paths)] == pytest.approx([path.probability for path in found.paths])


def test_nothing_is_lost_and_everything_is() -> None:
    loop = LabelledMDP.from_arrays([[[1.0]]], aps=["a"], labels=[["a"]])
    assert failure(Product(loop, ltlc.compile("G a")), [0]).paths == ()
    found = failure(Product(loop, ltlc.compile("F !a")), [0])
    assert (found.loss, found.paths[0].states, found.routes[0].probability) == (1.0, (0,), 1.0)
    assert not found.traps[0].violated
    assert found.why == ""


@pytest.mark.slow
def test_the_suite() -> None:
    """On every task that cannot be satisfied surely, what is listed carries 90 % of the loss, or it is said why not."""
    checked = 0
    for task in load_suite().values():
        judge = ltlc.Judge(task.model, ltlc.Task(task.formula))
        if judge.maximum.probability >= 1 or judge.words.n_states > 300:
            continue
        found = failure(judge.words, judge.maximum.policy)
        checked += 1
        assert found.loss == pytest.approx(1 - found.satisfaction.probability, abs=1e-7)
        assert sum(trap.probability for trap in found.traps) == pytest.approx(found.loss, abs=1e-7)
        assert found.entries_carry >= 0.9 - 1e-9
        assert found.why or max(found.routes_carry, found.paths_carry) >= 0.9 - 1e-9
    assert checked > 12
