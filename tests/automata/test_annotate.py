"""Annotations, emptiness and canonical numbering against slow truths."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from random_automata import random_automata, random_automaton, short_lassos

from ltlc.automata import DRA, ComponentKind, canonical, equivalent, simplify_marks
from ltlc.automata.acceptance import Acceptance, Clause, conjunction, disjunction, holds, negation
from ltlc.automata.emptiness import accepting_nodes, accepting_parts, accepting_walk
from ltlc.errors import InvalidAutomatonError
from ltlc.minimize.reduce import normalized


def eventually_a_always_after() -> DRA:
    """F(a & X G a), with two states of empty language: once a breaks, nothing is accepted."""
    return DRA(
        aps=("a", "b"),
        delta=np.array([[0, 1], [2, 1], [3, 3], [2, 3]]),
        letter_class=np.array([0, 1, 0, 1]),
        fin=np.zeros((1, 4)),
        inf=np.array([[0, 1, 0, 0]]),
    )


def test_annotations_of_a_small_automaton() -> None:
    automaton = eventually_a_always_after()
    annotations = automaton.annotations
    assert automaton.deadlocks == (2, 3)
    assert automaton.accepting_sinks == ()
    assert annotations.scc.tolist() == [0, 1, 2, 2]
    assert annotations.scc_kinds == (ComponentKind.REJECTING, ComponentKind.ACCEPTING, ComponentKind.REJECTING)
    assert annotations.distance.tolist() == [1, 0, -1, -1]
    assert annotations.live_pairs.tolist() == [[True, True, False, False]]
    assert annotations.n_sccs == 3
    assert automaton.annotations is annotations


def accepted_cycles(automaton: DRA) -> np.ndarray:
    """Shape (n_states, n_lassos): verdicts of each state on all short lasso words, by running them."""
    lassos = short_lassos(2 ** len(automaton.aps), max_prefix=2, max_cycle=4)
    starts = [replace(automaton, initial_state=q) for q in range(automaton.n_states)]
    return np.array([[start.accepts_letters(u, v) for u, v in lassos] for start in starts])


def test_deadlocks_and_sinks_agree_with_words() -> None:
    # With at most three states and one proposition, words this short decide emptiness and universality.
    for seed in range(60):
        rng = np.random.default_rng(seed)
        automaton = random_automaton(rng, int(rng.integers(1, 4)), 1, 2, ("state", "transition")[seed % 2])
        verdicts = accepted_cycles(automaton)
        assert automaton.deadlocks == tuple(np.flatnonzero(~verdicts.any(axis=1)))
        assert automaton.accepting_sinks == tuple(np.flatnonzero(verdicts.all(axis=1)))


def test_live_pairs_and_distance_are_consistent() -> None:
    for automaton in random_automata(60):
        annotations = automaton.annotations
        live = annotations.live_pairs.any(axis=0)
        assert (live == (annotations.distance >= 0)).all()
        for i in range(automaton.n_pairs):
            alone = replace(automaton, fin=automaton.fin[i : i + 1], inf=automaton.inf[i : i + 1])
            assert (alone.annotations.live_pairs[0] == annotations.live_pairs[i]).all()
        successors = annotations.distance[automaton.delta]
        for q, distance in enumerate(annotations.distance):
            if distance > 0:
                assert successors[q][successors[q] >= 0].min() == distance - 1


def random_condition(rng: np.random.Generator, depth: int) -> Acceptance:
    if depth == 0 or rng.random() < 0.2:
        mark, partner = (1 << int(mark) for mark in rng.integers(4, size=2))
        return ((Clause(mark, 0),), (Clause(0, mark),), (Clause(0, 0, ((mark, partner),)),))[rng.integers(3)]
    parts = [random_condition(rng, depth - 1) for _ in range(int(rng.integers(1, 4)))]
    return functools.reduce(conjunction if rng.random() < 0.5 else disjunction, parts)


def brute_force(edges: list[list[tuple[int, int]]], condition: Acceptance) -> set[int]:
    """Nodes on an accepting closed walk: all sets of marks that a closed walk from each node can collect."""
    found = set()
    for start in range(len(edges)):
        seen = {(start, 0)}
        todo = [(start, 0)]
        for node, marks in todo:
            for target, new in edges[node]:
                following = (target, marks | new)
                if target == start and holds(condition, following[1]):
                    found.add(start)
                if following not in seen:
                    seen.add(following)
                    todo.append(following)
    return found


@pytest.mark.parametrize("seed", range(120))
def test_generic_emptiness(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 7))
    edges = [
        [(int(rng.integers(n)), int(sum((rng.random() < 0.25) << i for i in range(4)))) for _ in range(rng.integers(3))]
        for _ in range(n)
    ]
    condition = random_condition(rng, 3)
    expected = brute_force(edges, condition)
    assert accepting_nodes(edges, condition) == expected
    for seen in range(16):
        assert holds(negation(condition), seen) != holds(condition, seen)
    for start in range(n):
        walk = accepting_walk(edges, condition, start)
        if walk is None:
            continue
        prefix, cycle = walk
        assert all((target, marks) in edges[source] for source, target, marks in prefix + cycle)
        assert [edge[0] for edge in prefix + cycle] == [start, *(edge[1] for edge in prefix + cycle)][:-1]
        assert cycle[-1][1] == cycle[0][0]
        assert holds(condition, int(np.bitwise_or.reduce([edge[2] for edge in cycle])))
    as_masks = list(accepting_parts([sorted(row) for row in edges], condition))
    monkeypatch.setattr("ltlc.automata.emptiness.MAX_MASK", 0)
    assert list(accepting_parts([sorted(row) for row in edges], condition)) == as_masks


def shuffled(automaton: DRA, rng: np.random.Generator) -> DRA:
    """The same automaton with other numbers of states and letter classes."""
    states, classes = rng.permutation(automaton.n_states), rng.permutation(automaton.n_classes)
    delta = np.empty_like(automaton.delta)
    delta[np.ix_(states, classes)] = states[automaton.delta]
    fin, inf = np.empty_like(automaton.fin), np.empty_like(automaton.inf)
    where = (slice(None), states) if automaton.acceptance == "state" else np.ix_(range(len(fin)), states, classes)
    fin[where], inf[where] = automaton.fin, automaton.inf
    return replace(
        automaton,
        delta=delta,
        letter_class=classes[automaton.letter_class],
        fin=fin,
        inf=inf,
        initial_state=int(states[automaton.initial_state]),
    )


@pytest.mark.slow
def test_canonical_forgets_the_numbering() -> None:
    for seed, automaton in enumerate(random_automata(60)):
        once = canonical(automaton)
        for other in (canonical(once), canonical(shuffled(automaton, np.random.default_rng(seed)))):
            for field in ("delta", "letter_class", "fin", "inf"):
                assert getattr(once, field).tobytes() == getattr(other, field).tobytes()
        for u, v in short_lassos(2 ** len(automaton.aps), 1, 2):
            assert once.accepts_letters(u, v) == automaton.accepts_letters(u, v)


def test_canonical_drops_and_merges() -> None:
    automaton = DRA(
        aps=("a",),
        delta=np.array([[0, 0], [2, 2], [1, 1]]),
        letter_class=np.array([1, 0]),
        fin=np.zeros((1, 3)),
        inf=np.ones((1, 3)),
        initial_state=1,
        state_names=("p", "q", "r"),
    )
    small = canonical(automaton)
    assert (small.n_states, small.n_classes, small.state_names) == (2, 1, ("q", "r"))
    assert small.aps == ("a",)


def test_letter_classes_are_checked() -> None:
    with pytest.raises(InvalidAutomatonError, match="letter classes"):
        DRA(("a",), np.zeros((1, 2)), np.array([0, 0]), np.zeros((1, 1)), np.zeros((1, 1)))


def test_normal_forms_are_made_once() -> None:
    """What is known of an automaton is not worked out again, and is not believed of what is made from it."""
    for automaton in random_automata(30):
        for form in (canonical, simplify_marks, normalized):
            once = form(automaton)
            assert form(once) is once
            assert not replace(once).forms and replace(once).known_languages is None
            again = form(replace(once))
            assert equivalent(again, automaton) and again.n_states <= once.n_states
