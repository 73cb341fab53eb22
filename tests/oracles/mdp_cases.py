"""Tasks with known answers: grid worlds, automata written by hand, and the thesis' recorded automata and rewards."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from suite_tasks import Cell, build, load_worlds

from ltlc.automata.rabin import DRA
from ltlc.mdp import LabelledMDP

Mark = Callable[[int, frozenset[str]], bool]


def world(name: str, **changes: Any) -> LabelledMDP:
    """A world of the suite; `changes` replace parts of its entry."""
    return build(load_worlds()[name] | changes)


def automaton(
    aps: Sequence[str],
    n_states: int,
    step: Callable[[int, frozenset[str]], int],
    pairs: Sequence[tuple[Mark, Mark]],
    initial: int = 0,
) -> DRA:
    """A transition-based Rabin automaton with one class per letter, from Python functions."""
    letters = [frozenset(ap for i, ap in enumerate(aps) if mask >> i & 1) for mask in range(2 ** len(aps))]
    delta = np.array([[step(q, letter) for letter in letters] for q in range(n_states)])

    def table(mark: Mark) -> list[list[bool]]:
        return [[mark(q, letter) for letter in letters] for q in range(n_states)]

    shape = (len(pairs), n_states, len(letters))
    return DRA(
        aps=tuple(aps),
        delta=delta,
        letter_class=np.arange(len(letters)),
        fin=np.array([table(fin) for fin, _ in pairs], dtype=bool).reshape(shape),
        inf=np.array([table(inf) for _, inf in pairs], dtype=bool).reshape(shape),
        initial_state=initial,
        acceptance="transition",
    )


def never(q: int, letter: frozenset[str]) -> bool:
    """No mark."""
    return False


def safely(aps: Sequence[str], bad: str, pairs: Sequence[tuple[Callable[..., bool], Callable[..., bool]]]) -> DRA:
    """G !bad & a condition on letters seen infinitely often: pairs of predicates on letters, the first rejects."""
    return automaton(
        aps,
        2,
        lambda q, letter: 1 if q == 1 or bad in letter else 0,
        [
            (
                lambda q, letter, fin=fin: q == 1 or bad in letter or fin(letter),
                lambda q, letter, inf=inf: q == 0 and bad not in letter and inf(letter),
            )
            for fin, inf in pairs
        ],
    )


def sequence(goals: Sequence[str], bad: str | None = None, *, safe_for_ever: bool = False) -> DRA:
    """!bad U (goals[0] & (!bad U (goals[1] & ...))); with `safe_for_ever` the last goal does not lift the ban."""
    n = len(goals)
    aps = [*dict.fromkeys(goals)] + ([bad] if bad else [])

    def step(q: int, letter: frozenset[str]) -> int:
        while q < n and goals[q] in letter:
            q += 1
        if q == n + 1 or (bad in letter and (q < n or safe_for_ever)):
            return n + 1
        return q

    return automaton(aps, n + 2, step, [(never, lambda q, letter: step(q, letter) == n)])


def state_based(
    aps: Sequence[str],
    rows: Mapping[int, Sequence[int]],
    *,
    initial: int,
    sink: int | None,
    fin: Sequence[int],
    inf: Sequence[int],
) -> DRA:
    """A recorded table: successors on {}, A, B, T for each state; C, if read at all, leads to the sink."""
    n = max([*rows, *(s for row in rows.values() for s in row), *([] if sink is None else [sink])]) + 1
    bits = {frozenset(): 0, **{frozenset(name): i + 1 for i, name in enumerate("ABT")}}
    delta = np.empty((n, 2 ** len(aps)), dtype=np.int64)
    for q in range(n):
        for mask in range(2 ** len(aps)):
            letter = frozenset(ap for i, ap in enumerate(aps) if mask >> i & 1)
            row = rows.get(q)
            if row is None or "C" in letter:
                delta[q, mask] = q if sink is None else sink
            else:
                delta[q, mask] = row[bits.get(letter, 0)]  # letters with two goals do not occur
    marks = np.zeros((2, 1, n), dtype=bool)
    marks[0, 0, list(fin)] = True
    marks[1, 0, list(inf)] = True
    return DRA(tuple(aps), delta, np.arange(2 ** len(aps)), marks[0], marks[1], initial_state=initial)


_PHI_2_ROWS = {
    3: (4, 5, 4, 4), 4: (4, 7, 4, 4), 5: (5, 7, 6, 5), 6: (6, 8, 6, 9), 7: (7, 7, 8, 7), 8: (8, 8, 8, 10),
    0: (13, 1, 13, 13), 1: (14, 14, 13, 14), 9: (9, 11, 9, 9), 10: (10, 11, 10, 10), 11: (11, 11, 12, 11),
    12: (15, 14, 15, 15), 13: (13, 1, 13, 13), 14: (14, 14, 13, 14), 15: (15, 14, 15, 15),
}  # fmt: skip


def phi(number: int) -> DRA:
    """The automata of the thesis' four formulas, as its code recorded them."""
    if number == 1:
        rows = {1: (1, 2, 1, 1), 2: (2, 2, 3, 2), 3: (3, 3, 3, 4), 4: (3, 3, 3, 5), 5: (3, 3, 3, 5)}
        return state_based("ABCT", rows, initial=1, sink=0, fin=range(5), inf=[5])
    if number == 2:
        return state_based("ABCT", _PHI_2_ROWS, initial=3, sink=2, fin=range(2, 13), inf=[0, 1])
    if number == 3:
        rows = {3: (3, 2, 3, 3), 2: (2, 2, 1, 2), 1: (1, 1, 1, 0), 0: (0, 0, 0, 0)}
        return state_based("ABT", rows, initial=3, sink=None, fin=[], inf=[0])
    return state_based("ABT", _PHI_2_ROWS, initial=3, sink=None, fin=range(3, 13), inf=[0, 1])


def thesis_world(
    size: int, *, intended: float = 0.6, dynamic: bool = False, absorbing: Sequence[Cell] = ()
) -> LabelledMDP:
    """The thesis' 10x10 or 5x5 map; `dynamic` shows A, B, T with probability 0.8 and C with 0.05."""
    found = world(f"thesis-{size}x{size}", motion={"intended": intended}, absorbing=absorbing)
    if not dynamic:
        return found
    chance = {"A": 0.8, "B": 0.8, "T": 0.8, "C": 0.05}
    letters = found.letters[found.label_probability.argmax(axis=1)]
    names = [[name for i, name in enumerate(found.aps) if letter >> i & 1] for letter in letters]
    return found.with_labels(found.aps, [{name: chance[name] for name in shown} for shown in names])


@dataclass(frozen=True)
class Tables:
    """Reward tables with the columns that `ltlc.mdp.RewardColumns` asks for."""

    aps: tuple[str, ...]
    letter_class: Any
    initial_state: int
    next_state: Any
    reward: Any
    discount: Any
    stop: Any
    stop_reward: Any
    violated: Any
    accepted: Any


def tables(dra: DRA, **columns: Any) -> Tables:
    """Tables that follow the automaton and pay nothing, except for the columns given."""
    zero = np.zeros(dra.delta.shape)
    default = {
        "next_state": dra.delta, "reward": zero, "discount": zero + 1, "stop": zero, "stop_reward": zero,
        "violated": zero.astype(bool), "accepted": dra.edge_inf.any(axis=0),
    }  # fmt: skip
    return Tables(dra.aps, dra.letter_class, dra.initial_state, **(default | columns))


def thesis_tables(dra: DRA, deadlock: int | None) -> Tables:
    """Rewards (4.3): G -1 and the episode ends, deadlock -100 and q is kept, B -10, otherwise -1."""
    entered = dra.delta
    goal, bad = dra.edge_inf[0], dra.edge_fin[0]
    violated = np.zeros(entered.shape, dtype=bool) if deadlock is None else entered == deadlock
    reward = np.select([goal, violated, bad], [-1.0, -100.0, -10.0], -1.0)
    kept = np.where(violated, np.arange(dra.n_states)[:, None], entered)
    return tables(dra, next_state=kept, reward=reward, stop=goal.astype(float), violated=violated, accepted=goal)


def goal_or_dock(*terminal: int) -> LabelledMDP:
    """Action 0 is likely to reach the goal, action 1 less likely the dock; else all is lost in state 3."""
    p = np.zeros((2, 4, 4))
    p[0, 0, [1, 3]] = 0.9, 0.1
    p[1, 0, [2, 3]] = 0.5, 0.5
    p[:, [1, 2, 3], [1, 2, 3]] = 1
    ends = np.isin(np.arange(4), terminal)
    return LabelledMDP.from_arrays(p, aps=("goal", "dock"), labels={1: "goal", 2: "dock"}, terminal=ends)


GOAL_OR_DOCK = ("G F goal | G F dock", "F G goal | F G dock", "(G F goal & F G !dock) | F G dock")
