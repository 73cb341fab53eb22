"""Seeded random Rabin automata and lasso words for tests."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import product

import numpy as np

from ltlc.automata import DRA
from ltlc.automata.buchi import BuchiAutomaton
from ltlc.automata.emerson_lei import LetterEdge
from ltlc.automata.rabin import AcceptanceKind

Lasso = tuple[tuple[int, ...], tuple[int, ...]]


def random_automaton(
    rng: np.random.Generator,
    n_states: int,
    n_aps: int,
    n_pairs: int,
    acceptance: AcceptanceKind,
    density: float = 0.3,
) -> DRA:
    """Uniform successors; every letter a class of its own, in shuffled numbering; each mark with this probability."""
    n_letters = 2**n_aps
    shape = (n_pairs, n_states) if acceptance == "state" else (n_pairs, n_states, n_letters)
    return DRA(
        aps=tuple("abcdefgh"[:n_aps]),
        delta=rng.integers(0, n_states, (n_states, n_letters)),
        letter_class=rng.permutation(n_letters),
        fin=rng.random(shape) < density,
        inf=rng.random(shape) < density,
        initial_state=int(rng.integers(n_states)),
        acceptance=acceptance,
    )


def random_automata(count: int, max_states: int = 6, max_aps: int = 2, max_pairs: int = 3) -> Iterator[DRA]:
    """`count` automata of both kinds, of all small sizes."""
    for seed in range(count):
        rng = np.random.default_rng(seed)
        acceptance: AcceptanceKind = "state" if seed % 2 else "transition"
        sizes = (int(rng.integers(1, limit + 1)) for limit in (max_states, max_aps, max_pairs))
        yield random_automaton(rng, *sizes, acceptance, density=float(rng.choice([0.1, 0.3, 0.5])))


def short_lassos(n_letters: int, max_prefix: int = 1, max_cycle: int = 3) -> list[Lasso]:
    """All lasso words with prefix and cycle of at most these lengths."""
    letters = range(n_letters)
    prefixes = [u for length in range(max_prefix + 1) for u in product(letters, repeat=length)]
    cycles = [v for length in range(1, max_cycle + 1) for v in product(letters, repeat=length)]
    return [(u, v) for u in prefixes for v in cycles]


def random_lassos(rng: np.random.Generator, n_letters: int, count: int) -> list[Lasso]:
    """Lasso words with prefixes up to 4 and cycles up to 8 letters."""

    def letters(least: int, most: int) -> tuple[int, ...]:
        return tuple(rng.integers(0, n_letters, rng.integers(least, most + 1)).tolist())

    return [(letters(0, 4), letters(1, 8)) for _ in range(count)]


def random_buchi(rng: random.Random) -> BuchiAutomaton:
    """A nondeterministic automaton with at most 4 states, 3 letters and 3 acceptance sets."""
    n_letters, n_states, n_sets = rng.randint(1, 3), rng.randint(1, 4), rng.randint(0, 3)

    def edge() -> LetterEdge:
        marks = sum(1 << i for i in range(n_sets) if rng.random() < 0.4)
        return LetterEdge(rng.randrange(1, 1 << n_letters), rng.randrange(n_states), marks)

    edges = tuple(tuple(edge() for _ in range(rng.randint(0, 3))) for _ in range(n_states))
    return BuchiAutomaton(n_letters, tuple(range(rng.randint(1, n_states))), edges, n_sets)
