"""Small random worlds that end, and formulas to satisfy in them."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
from random_ltl import random_formula
from scipy import sparse

from ltlc.ltl import Formula, parse
from ltlc.mdp import LabelledMDP

NAMES = ("a", "b", "c")
SEVERAL_PAIRS = (
    "FG a | GF b",
    "(FG a & GF b) | (FG c & GF !b)",
    "(FG a | GF b) & (FG b | GF c)",
    "(GF a & FG !b) | (GF b & FG !c)",
    "X((FG a & GF c) | FG b)",
    "F a & (FG a | FG b | FG c)",
    "(a U b) & (FG a | (GF b & FG !c))",
)


def random_world(rng: np.random.Generator, *, ends: float = 0.35, chance: float = 0.2) -> LabelledMDP:
    """An MDP of 2 to 8 states and two actions; some states are terminal, and some labels are random, there too.

    Args:
        rng: random numbers.
        ends: probability that a state is terminal.
        chance: probability that a proposition of a state is drawn at random.
    """
    n = int(rng.integers(2, 9))
    terminal = rng.random(n) < ends
    p = np.zeros((2, n, n))
    for action in range(2):
        for state in range(n):
            if terminal[state]:
                p[action, state, state] = 1
            else:
                targets = rng.choice(n, min(int(rng.integers(1, 4)), n), replace=False)
                p[action, state, targets] = rng.dirichlet(np.ones(len(targets)))
    labels = []
    for _ in range(n):
        kind = rng.random(len(NAMES))
        sure = {name: 1.0 for name, k in zip(NAMES, kind, strict=True) if k < 0.35}
        drawn = {
            name: float(rng.choice([0.3, 0.5, 0.8])) for name, k in zip(NAMES, kind, strict=True) if k > 1 - chance
        }
        labels.append(sure | drawn)
    return LabelledMDP.from_arrays(p, aps=NAMES, labels=labels, terminal=terminal)


def united(worlds: Sequence[LabelledMDP]) -> LabelledMDP:
    """Random worlds side by side; it begins in each as probably, so what it comes to is the mean of theirs."""
    if len(worlds) == 1:
        return worlds[0]
    letters = np.unique(np.concatenate([world.letters for world in worlds]))
    labels = [world.label_probability @ (world.letters[:, None] == letters) for world in worlds]
    moves = zip(*(world.transitions for world in worlds), strict=True)
    return LabelledMDP(
        NAMES, tuple(sparse.csr_array(sparse.block_diag(move)) for move in moves), letters,
        sparse.csr_array(np.concatenate(labels)),
        initial_distribution=np.concatenate([world.start for world in worlds]) / len(worlds),
        terminal=np.concatenate([world.terminal for world in worlds]),
    )  # fmt: skip


def random_task(rng: random.Random) -> Formula:
    """A formula; every third has an automaton of several pairs."""
    if rng.random() < 0.35:
        return parse(rng.choice(SEVERAL_PAIRS))
    return random_formula(rng, rng.randint(3, 10))
