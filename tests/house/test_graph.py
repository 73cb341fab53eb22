"""Graph algorithms against definitions by brute force."""

from __future__ import annotations

import numpy as np
import pytest

from ltlc import graph


def closure(successors: list[list[int]]) -> np.ndarray:
    """Reflexive-transitive closure, by squaring."""
    n = len(successors)
    reach = np.eye(n, dtype=bool)
    for q, row in enumerate(successors):
        reach[q, row] = True
    for _ in range(n.bit_length() + 1):
        reach = reach @ reach
    return reach


def random_graph(seed: int) -> list[list[int]]:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    n_edges = int(rng.integers(0, 2 * n + 1))
    return graph.from_edges(n, [(q, t) for q, t in rng.integers(0, n, (n_edges, 2)).tolist()])


@pytest.mark.parametrize("seed", range(60))
def test_components_reachability_and_distances(seed: int) -> None:
    successors = random_graph(seed)
    n = len(successors)
    reach = closure(successors)
    component = graph.strong_components(successors)
    assert sorted(set(component)) == list(range(max(component) + 1))
    for q in range(n):
        assert sorted(graph.reachable(successors, [q])) == np.flatnonzero(reach[q]).tolist()
        assert sorted(graph.coreachable(successors, [q])) == np.flatnonzero(reach[:, q]).tolist()
        for t in range(n):
            assert (component[q] == component[t]) == (reach[q, t] and reach[t, q])
        assert all(component[q] <= component[t] for t in successors[q])
        away = graph.distances(successors, [q])
        assert [d >= 0 for d in away] == reach[q].tolist()
        ends = np.eye(n, dtype=np.bool_)[q]
        for length in range(n):  # where the walks of this length end; the first to arrive is a shortest one
            assert all(0 <= away[t] <= length for t in np.flatnonzero(ends))
            assert all(ends[t] for t in range(n) if away[t] == length)
            ends = np.array([any(ends[p] and t in successors[p] for p in range(n)) for t in range(n)])


@pytest.mark.parametrize("seed", range(60))
def test_sets_of_nodes_have_the_same_components(seed: int) -> None:
    successors = [sorted(set(row)) for row in random_graph(seed)]
    kept = [q for q in range(len(successors)) if (q + seed) % 4]
    number = {q: i for i, q in enumerate(kept)}
    inner = [[number[t] for t in successors[q] if t in number] for q in kept]
    expected = [
        sum(1 << kept[i] for i in members)
        for members in graph.component_members(graph.strong_components(inner))
        if len(members) > 1 or members[0] in inner[members[0]]
    ]
    masks = [sum(1 << t for t in row) for row in successors]
    assert graph.strong_sets(masks, sum(1 << q for q in kept)) == expected


def test_members_follow_the_component_numbers() -> None:
    component = graph.strong_components([[1], [0, 2], [2], []])
    assert graph.component_members(component) == [[3], [0, 1], [2]]


def test_arrays_are_graphs_too() -> None:
    delta = np.array([[1, 1], [2, 0], [2, 2]])
    assert graph.strong_components(delta) == [0, 0, 1]
    assert graph.reachable(delta, [2]) == [2]
    assert graph.distances(delta, [0]) == [0, 1, 2]
    assert graph.predecessor_lists(delta) == [[1], [0], [1, 2]]


@pytest.mark.slow
def test_a_long_path_needs_no_recursion() -> None:
    n = 50_000
    component = graph.strong_components([[q + 1] for q in range(n)] + [[]])
    assert component == list(range(n + 1))
