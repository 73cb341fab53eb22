"""Closures of random formulas, and runs of Emerson-Lei automata."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator

from formula_of_node import closure_of
from random_ltl import random_formula, random_nesting, random_task

from ltlc.automata.acceptance import (
    holds,
)
from ltlc.automata.emerson_lei import EmersonLei
from ltlc.ltl import Formula, LassoWord
from ltlc.translate.closure import Closure


def random_closures(seed: int, count: int, size: int = 9) -> Iterator[tuple[random.Random, Formula, Closure]]:
    rng = random.Random(seed)
    for _ in range(count):
        names = "abc"[: rng.randint(1, 3)]
        kind = rng.randrange(4)
        if kind == 0:
            formula = random_nesting(rng, names)
        elif kind == 1:
            formula = random_task(rng, names)
        else:
            formula = random_formula(rng, rng.randint(2, size), names)
        yield rng, formula, closure_of(formula)


def letters_of(closure: Closure, word: LassoWord) -> tuple[list[int], list[int]]:
    """The word in letter classes."""
    aps, letter_class = closure.letters.aps, closure.letters.letter_class

    def number(letter: Iterable[str]) -> int:
        return int(letter_class[sum(1 << aps.index(name) for name in letter)])

    return [number(letter) for letter in word.prefix], [number(letter) for letter in word.cycle]


def accepts(automaton: EmersonLei, prefix: list[int], cycle: list[int]) -> bool:
    """Truth by running: the marks of the loop, judged by the condition of a state on it."""

    def read(state: int, letters: list[int]) -> tuple[int, int]:
        seen = 0
        for letter in letters:
            edge = next(e for e in automaton.edges[state] if e.letters >> letter & 1)
            state, seen = edge.target, seen | edge.marks
        return state, seen

    state, _ = read(0, prefix)
    for _ in range(automaton.n_states):
        state, _ = read(state, cycle)
    start, seen = state, 0
    while True:
        state, more = read(state, cycle)
        seen |= more
        if state == start:
            return holds(automaton.acceptance[state], seen)
