"""Faithfulness of the reward schemes: the true satisfaction probability of the policy that is optimal for each.

    python benchmarks/faithful.py [--json FILE] [TASK ...]

Prints a row per task and reward: the probability, and what it misses the maximum by. The tasks are small, published and
given below as maps; everything is computed exactly, nothing is learned.

Sources of the tasks: E. M. Hahn et al., TACAS 2019, doi 10.1007/978-3-030-17462-0_27 (risk and reward); Mungojerrie,
TACAS 2023, doi 10.1007/978-3-031-30823-9_27 (devious, two pairs); A. K. Bozkurt et al., ICRA 2020,
doi 10.1109/ICRA40945.2020.9196796 (safe absorbing); D. Shao, M. Kwiatkowska, IJCAI 2023, doi 10.24963/ijcai.2023/465
(gate, frozen 8x8); Q. Gao, thesis, Duke University, 2018, https://hdl.handle.net/10161/17056 (10x10).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ltlc import compile
from ltlc.faithful import Candidate, FaithfulnessReport, faithfulness
from ltlc.mdp import LabelledMDP

UP, RIGHT, DOWN, LEFT = (-1, 0), (0, 1), (1, 0), (0, -1)
Cell = tuple[int, int]
Outcomes = Mapping[Cell, float]
"""move -> probability"""


@dataclass(frozen=True)
class Task:
    """A model with a formula and its certified maximum."""

    model: Callable[[], LabelledMDP]
    formula: str
    maximum: float


def grid(
    height: int,
    width: int,
    actions: Sequence[Outcomes],
    labels: Mapping[Cell, str],
    *,
    start: Cell = (0, 0),
    blocked: Sequence[Cell] = (),
    absorbing: Sequence[Cell] = (),
    special: Mapping[Cell, Sequence[Outcomes]] | None = None,
    aps: str | None = None,
) -> LabelledMDP:
    """A grid world; a move over the edge or into a blocked cell stays. Labels are one character per name."""
    p = np.zeros((len(actions), height * width, height * width))
    for row, column in np.ndindex(height, width):
        here = row * width + column
        for a, outcomes in enumerate((special or {}).get((row, column), actions)):
            for (down, right), chance in outcomes.items():
                to = (row + down, column + right)
                stays = not (0 <= to[0] < height and 0 <= to[1] < width) or to in blocked or (row, column) in absorbing
                p[a, here, here if stays else to[0] * width + to[1]] += chance
    names = sorted(set(aps or "".join(labels.values())))
    flat = {row * width + column: list(label) for (row, column), label in labels.items()}
    return LabelledMDP.from_arrays(p, aps=names, labels=flat, initial_state=start[0] * width + start[1])


def noisy(moves: Sequence[Cell], intended: float) -> list[Outcomes]:
    """Each action succeeds with probability `intended`; the rest is shared by the other moves."""
    other = (1 - intended) / (len(moves) - 1)
    return [{move: intended if move == chosen else other for move in moves} for chosen in moves]


def sideways(intended: float, side: float) -> list[Outcomes]:
    """Up, right, down, left; slips to both perpendicular directions."""
    turn = [UP, RIGHT, DOWN, LEFT]
    return [{turn[i]: intended, turn[(i + 1) % 4]: side, turn[i - 1]: side} for i in range(4)]


def risk_reward() -> LabelledMDP:
    """A risky and a safe way to a reward; actions risky, safe, reset, stay."""
    p = np.zeros((4, 4, 4))
    p[0, 0, [2, 3]] = 0.9, 0.1
    p[1, 0, 1] = 1
    p[2, [1, 2, 3], 0] = 1
    p[3, [0, 2, 3], [0, 2, 3]] = 1
    return LabelledMDP.from_arrays(p, aps=("g", "b"), labels={1: "g", 2: "g", 3: "b"})


def devious() -> LabelledMDP:
    """A sure loop with rare rewards against a likely one with many."""
    states = [(0, 0), (2, 0), (3, 0), *[(1, n) for n in range(8)]]
    index = {state: i for i, state in enumerate(states)}
    p = np.zeros((3, len(states), len(states)))
    p[0, 0, index[1, 0]] = 1
    p[1, 0, [index[2, 0], index[3, 0]]] = 0.75, 0.25
    p[2, [1, 2], [1, 2]] = 1
    p[0, index[1, 0], index[1, 1]] = p[0, index[1, 1], index[1, 2]] = p[1, index[1, 1], index[1, 5]] = 1
    for n in range(2, 8):
        p[0, index[1, n], index[1, (n + 1) % 5 if n <= 4 else min(n + 1, 7)]] = 1
    return LabelledMDP.from_arrays(p, aps=("g",), labels={index[s]: "g" for s in [(1, 0), (1, 5), (1, 6), (2, 0)]})


def two_pairs() -> LabelledMDP:
    """Two goals and a trap on 2x2 cells; moving flips the row or the column."""
    p = np.zeros((2, 4, 4))
    p[0, [0, 0, 1, 1, 2, 2, 3, 3], [1, 2, 0, 3, 0, 3, 1, 2]] = 0.5
    p[1] = np.eye(4)
    return LabelledMDP.from_arrays(p, aps=("goal0", "goal1", "trap"), labels={2: ["goal0"], 1: ["goal1"], 3: ["trap"]})


def safe_absorbing() -> LabelledMDP:
    """The 5x4 grid with absorbing cells."""
    labels = {(0, 2): "c", (1, 2): "a", (1, 3): "b", (2, 2): "c", (3, 0): "b", (3, 2): "a", (4, 1): "c", (4, 3): "c"}
    absorbing = [(1, 3), (3, 0), (3, 2)]
    return grid(5, 4, sideways(0.8, 0.1), labels, blocked=[(2, 0)], absorbing=absorbing)


def gate() -> LabelledMDP:
    """A corridor to the right that may end in a trap, or none."""
    right = {RIGHT: 1.0}
    blocked = [(row, column) for row in (1, 3) for column in range(1, 10)]
    absorbing = [(0, 9), (2, 9), (3, 0)]
    special = {(0, column): [right] * 4 for column in range(9)} | {(2, 0): [{RIGHT: 0.8, DOWN: 0.2}] * 4}
    labels = {(0, column): "a" for column in range(9)} | {(2, 9): "a", (3, 0): "c"}
    return grid(4, 10, sideways(0.8, 0.1), labels, start=(1, 0), blocked=blocked, absorbing=absorbing, special=special)


def frozen_8x8() -> LabelledMDP:
    """A slippery lake with ten holes; they and cell a are not slippery."""
    holes = [(2, 3), (3, 5), (4, 3), (5, 1), (5, 2), (5, 6), (6, 1), (6, 4), (6, 6), (7, 3)]
    labels = dict.fromkeys(holes, "h") | {(4, 6): "b", (7, 7): "a"}
    firm = dict.fromkeys([*holes, (7, 7)], sideways(1.0, 0.0))
    return grid(8, 8, sideways(0.34, 0.33), labels, special=firm)


def lake_4x4() -> LabelledMDP:
    """Gymnasium's FrozenLake-v1: holes and goal absorbing."""
    holes = [(1, 1), (1, 3), (2, 3), (3, 0)]
    third = 1 / 3
    return grid(4, 4, sideways(third, third), dict.fromkeys(holes, "h") | {(3, 3): "g"}, absorbing=[*holes, (3, 3)])


def thesis_10x10() -> LabelledMDP:
    """The 10x10 map with four moves, 0.7 intended."""
    labels = {(2, 7): "A", (5, 2): "B", (8, 8): "T"} | {(i, i): "C" for i in range(2, 7)}
    return grid(10, 10, noisy([UP, RIGHT, DOWN, LEFT], 0.7), labels, start=(4, 1))


TASKS = {
    "risk and reward": Task(risk_reward, "G F g & G !b", 1),
    "devious": Task(devious, "G F g", 1),
    "safe absorbing": Task(safe_absorbing, "(F G a | F G b) & G !c", 1),
    "gate": Task(gate, "F G a & G !c", 0.8),
    "frozen 8x8": Task(frozen_8x8, "(G F a | G F b) & G !h", 1),
    "thesis 10x10": Task(thesis_10x10, "!C U (A & (!C U (B & (!C U T))))", 0.950719),
    "lake 4x4": Task(lake_4x4, "!h U g", 14 / 17),
    "two pairs": Task(two_pairs, "(F G goal0 | F G goal1) & G !trap", 1),
}

CANDIDATES = {
    "sadigh .99": Candidate.of("sadigh"),
    "sadigh .9999": Candidate.of("sadigh", gamma=0.9999),
    "sadigh, pair 0": Candidate.of("sadigh", pair=0),
    "accept .99": Candidate.of("accept"),
    "accept .9999": Candidate.of("accept", gamma=0.9999),
    "code, reset": Candidate.of("thesis-code", "initial", terminate_on_accept=False),
    "code, end": Candidate.of("thesis-code", "terminate", terminate_on_accept=False),
    "parity .1": Candidate.of("parity", epsilon=0.1),
    "parity .01": Candidate.of("parity", epsilon=0.01),
    "parity .001": Candidate.of("parity", epsilon=0.001),
    "two-discount .99 .999": Candidate.of("two-discount", gamma_accept=0.99, gamma=0.999),
    "two-discount .99 .9999": Candidate.of("two-discount", gamma_accept=0.99, gamma=0.9999),
    "two-discount .99 .99999": Candidate.of("two-discount", gamma_accept=0.99, gamma=0.99999),
    "two-discount .9 .999": Candidate.of("two-discount", gamma_accept=0.9, gamma=0.999),
    "zeta-reach .9": Candidate.of("zeta-reach", zeta=0.9),
    "zeta-reach .99": Candidate.of("zeta-reach", zeta=0.99),
    "zeta-discount .99": Candidate.of("zeta-discount", zeta=0.99),
    "eventual .9": Candidate.of("eventual", gamma=0.9),
    "eventual .99": Candidate.of("eventual", gamma=0.99),
    "frontier": Candidate.of("frontier"),
}


def report(task: str, candidates: Sequence[str] | None = None) -> FaithfulnessReport:
    """The faithfulness of some or all candidates in one task."""
    case = TASKS[task]
    automaton = compile(case.formula, acceptance="transition")
    return faithfulness(case.model(), automaton, [CANDIDATES[name] for name in candidates or CANDIDATES])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help=f"of {', '.join(TASKS)}; default all")
    parser.add_argument("--json", metavar="FILE", help="write the table as JSON")
    arguments = parser.parse_args()
    result = {}
    for task in arguments.tasks or TASKS:
        found = report(task)
        result[task] = found.to_dict()
        print(f"\n{task}: {TASKS[task].formula}, Pmax {found.maximum:.6g} (certified {TASKS[task].maximum:.6g})")
        for label, row in zip(CANDIDATES, found.rows, strict=True):
            if row.satisfaction is None or row.gap is None:
                print(f"  {label:26} -         {row.problem}")
            else:
                print(f"  {label:26} {row.satisfaction:.6f}  {'' if row.faithful else f'loses {row.gap:.6f}'}")
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump(result, file, indent=2)


if __name__ == "__main__":
    main()
