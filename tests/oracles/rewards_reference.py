"""Random automata, and a slow reading of the reward rules to compare the tables with."""

from __future__ import annotations

import numpy as np

from ltlc.automata import DRA


def random_automaton(
    seed: int, *, n_states: int = 5, n_aps: int = 2, n_pairs: int = 2, density: float = 0.3, acceptance: str = "state"
) -> DRA:
    rng = np.random.default_rng(seed)
    letters = 1 << n_aps
    delta = rng.integers(0, n_states, (n_states, letters))
    for trap in range(n_states):  # self-loops make deadlocks and sinks likely
        if rng.random() < 0.25:
            delta[trap] = trap
    shape = (n_pairs, n_states) if acceptance == "state" else (n_pairs, n_states, letters)
    return DRA(
        aps=tuple("abcdef"[:n_aps]),
        delta=delta,
        letter_class=np.arange(letters),
        fin=rng.random(shape) < density,
        inf=rng.random(shape) < density,
        acceptance=acceptance,
    )


def buchi_automaton(dra: DRA, marks: np.ndarray) -> DRA:
    """The same structure with Büchi acceptance on the marked edges."""
    return DRA(
        aps=dra.aps,
        delta=dra.delta,
        letter_class=dra.letter_class,
        fin=np.zeros((1, *dra.delta.shape), dtype=bool),
        inf=np.asarray(marks)[None],
        initial_state=dra.initial_state,
        acceptance="transition",
    )


def thesis_step(dra: DRA, q: int, letter: int, mode: str, reward: dict[str, float]) -> tuple[float, int, bool]:
    """Reward, next state and end of one step, read off the thesis: terminal > deadlock > G > B > rest.

    A deadlock has no accepting continuation, so an Inf mark there ends nothing.
    """
    entered = int(dra.delta[q, dra.letter_class[letter]])
    marks_inf = bool(dra.edge_inf[:, q, dra.letter_class[letter]].any())
    marks_fin = bool(dra.edge_fin[:, q, dra.letter_class[letter]].any())
    if entered in dra.deadlocks:
        after = {"stay": q, "initial": dra.initial_state, "terminate": entered}[mode]
        return reward["deadlock"], after, mode == "terminate"
    if (marks_inf and reward["terminate_on_accept"]) or entered in dra.accepting_sinks:
        return reward["terminal"], entered, True
    if marks_inf:
        return reward["accepting"], entered, False
    return (reward["rejecting"] if marks_fin else reward["other"]), entered, False
