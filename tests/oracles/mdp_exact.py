"""Maximum satisfaction probabilities in fractions, by definition and without haste: the oracle for the judge."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from ltlc.automata.rabin import DRA
from ltlc.mdp import LabelledMDP

State = tuple[int, int]
Row = dict[int, Fraction]
Choice = tuple[dict[State, Fraction], frozenset[tuple[str, int]]]


class ExactTask:
    """A random MDP over propositions a and b and a random automaton, all numbers fractions; the word starts in 0.

    With `tiny`, probabilities range down to about 1e-12.
    """

    def __init__(self, seed: int, *, tiny: bool = False) -> None:
        rng = np.random.default_rng(seed)
        self.n, self.n_actions = int(rng.integers(4, 8)), int(rng.integers(1, 4))
        self.rows: dict[tuple[int, int], Row] = {}
        for state in range(self.n):
            if state and rng.random() < 0.3:
                self.rows[state, int(rng.integers(self.n_actions))] = {state: Fraction(1)}
                continue
            offered = [a for a in range(self.n_actions) if rng.random() < 0.7] or [0]
            for action in offered:
                found = rng.choice(self.n, size=int(rng.integers(1, 4)), replace=False)
                weight = [10 ** int(rng.integers(13)) if tiny else int(rng.integers(1, 10)) for _ in found]
                self.rows[state, action] = {
                    int(t): Fraction(w, sum(weight)) for t, w in zip(found, weight, strict=True)
                }
        chances = [Fraction(0), Fraction(1), Fraction(1, 2), Fraction(1, 10**12 if tiny else 3)]
        self.labels = [{ap: chances[rng.choice(4, p=[0.45, 0.3, 0.2, 0.05])] for ap in "ab"} for _ in range(self.n)]
        n, n_pairs = int(rng.integers(1, 4)), int(rng.integers(1, 4))
        fin, inf = rng.random((n_pairs, n, 4)) < 0.3, rng.random((n_pairs, n, 4)) < 0.3
        delta = rng.integers(n, size=(n, 4))
        self.automaton = DRA(("a", "b"), delta, np.arange(4), fin, inf, acceptance="transition")

    def model(self) -> LabelledMDP:
        """The MDP in floating point."""
        matrices = np.zeros((self.n_actions, self.n, self.n))
        for (state, action), row in self.rows.items():
            for target, p in row.items():
                matrices[action, state, target] = float(p)
        labels = [{ap: float(p) for ap, p in label.items()} for label in self.labels]
        return LabelledMDP.from_arrays(matrices, aps="ab", labels=labels)

    def letters(self, state: int) -> Iterator[tuple[int, Fraction]]:
        a, b = self.labels[state]["a"], self.labels[state]["b"]
        chances = [(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b]
        return ((letter, p) for letter, p in enumerate(chances) if p)

    def product(self) -> dict[State, list[Choice]]:
        """The reachable states, and what each of their choices may lead to and is marked with."""
        dra = self.automaton
        todo = [(0, int(dra.delta[dra.initial_state, letter])) for letter, _ in self.letters(0)]
        found: dict[State, list[Choice]] = {}
        while todo:
            state = todo.pop()
            if state in found:
                continue
            found[state] = []
            for row in (row for (s, _), row in sorted(self.rows.items()) if s == state[0]):
                after: dict[State, Fraction] = {}
                marks = set()
                for target, p in row.items():
                    for letter, chance in self.letters(target):
                        to = (target, int(dra.delta[state[1], letter]))
                        after[to] = after.get(to, Fraction(0)) + p * chance
                        marks |= {("fin", i) for i in np.flatnonzero(dra.edge_fin[:, state[1], letter])}
                        marks |= {("inf", i) for i in np.flatnonzero(dra.edge_inf[:, state[1], letter])}
                found[state].append((after, frozenset(marks)))
                todo += after
        return found

    def probabilities(self) -> dict[State, Fraction]:
        """The maximum satisfaction probability from each product state."""
        product = self.product()
        won: set[State] = set()
        for pair in range(self.automaton.n_pairs):
            free = {s: [c for c in choices if ("fin", pair) not in c[1]] for s, choices in product.items()}
            for component, inner in end_components(free):
                if any(("inf", pair) in c[1] for c in inner):
                    won |= component
        return max_reachability(product, won)


def end_components(choices: dict[State, list[Choice]]) -> Iterator[tuple[set[State], list[Choice]]]:
    """The maximal end components, with the choices that stay inside."""
    todo = [set(choices)]
    while todo:
        states = todo.pop()
        inner = {s: [c for c in choices[s] if set(c[0]) <= states] for s in states}
        if alive := {s for s in states if inner[s]}:
            reach = {s: {s} for s in alive}
            for _ in alive:
                for s in alive:
                    reach[s] = reach[s].union(*(reach.get(t, {t}) for c in inner[s] for t in c[0]))
            parts = {frozenset(t for t in reach[s] & alive if s in reach[t]) for s in alive}
            if parts == {frozenset(states)}:
                yield states, [c for s in states for c in inner[s]]
            else:
                todo += [set(part) for part in sorted(parts, key=min)]


def max_reachability(product: dict[State, list[Choice]], won: set[State]) -> dict[State, Fraction]:
    """Policy iteration on the process with its end components collapsed, where every policy leaves in the end."""
    block, inside = {s: s for s in product}, set()
    for component, inner in end_components({s: c for s, c in product.items() if s not in won}):
        block |= dict.fromkeys(component, min(component))
        inside |= {id(c) for c in inner}
    rows: dict[State, list[tuple[Fraction, dict[State, Fraction]]]] = {}
    for state in product.keys() - won:
        for choice in product[state]:
            if id(choice) not in inside:
                after: dict[State, Fraction] = {}
                for t, p in choice[0].items():
                    after[block[t]] = after.get(block[t], Fraction(0)) + (0 if t in won else p)
                gain = sum((p for t, p in choice[0].items() if t in won), Fraction(0))
                rows.setdefault(block[state], []).append((gain, after))
    policy, value = dict.fromkeys(rows, 0), {}
    while True:
        value = evaluate({s: rows[s][policy[s]] for s in rows})
        worth = {s: [g + sum(p * value.get(t, 0) for t, p in row.items()) for g, row in rows[s]] for s in rows}
        better = {s: worths.index(max(worths)) for s, worths in worth.items() if max(worths) > value[s]}
        if not better:
            return {s: Fraction(1) if s in won else value.get(block[s], Fraction(0)) for s in product}
        policy |= better


def evaluate(rows: dict[State, tuple[Fraction, dict[State, Fraction]]]) -> dict[State, Fraction]:
    """The solution of v = gain + P v, by elimination of one state after the other."""
    left = {s: (gain, {t: p for t, p in row.items() if t in rows}) for s, (gain, row) in rows.items()}
    done = []
    while left:
        s, (gain, row) = left.popitem()
        stay = 1 - row.pop(s, Fraction(0))
        gain, row = gain / stay, {t: p / stay for t, p in row.items()}
        done.append((s, gain, row))
        for t, (other_gain, other) in left.items():
            if s in other:
                p = other.pop(s)
                for u, q in row.items():
                    other[u] = other.get(u, Fraction(0)) + p * q
                left[t] = (other_gain + p * gain, other)
    value: dict[State, Fraction] = {}
    for s, gain, row in reversed(done):
        value[s] = gain + sum(p * value[t] for t, p in row.items())
    return value
