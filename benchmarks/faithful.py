"""Faithfulness of the reward schemes: the true satisfaction probability of the policy that is optimal for each.

    python benchmarks/faithful.py [--json FILE] [TASK ...]

Prints a row per task and reward: the probability, and what it misses the maximum by. The tasks are small and published,
from the suite (`suite_tasks.toml`, with their sources); everything is computed exactly, nothing is learned.

Two rewards are also taken as they were first compared, before deadlocks ended episodes: the code of the thesis goes on
to be paid in an accepting sink (10 a step, worth 1000), and Sadigh's weights are those of a parity condition, where a
deadlock with a Fin mark costs for ever and one without costs nothing ("marks only").
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace

from suite_tasks import load_suite

from ltlc import compile
from ltlc.automata import DRA, to_parity
from ltlc.faithful import Candidate, FaithfulnessReport, faithfulness
from ltlc.mdp import LabelledMDP
from ltlc.rewards.sadigh import Sadigh

SUITE = load_suite()
TASKS = {
    name: SUITE[name]
    for name in (
        "risk-reward", "devious", "safe-absorbing", "gate", "frozen-8x8", "four-moves-until", "frozen-lake-4x4-until",
        "two-pairs",
    )
}  # fmt: skip

CANDIDATES = {
    "sadigh .99": Candidate.from_name("sadigh"),
    "sadigh .9999": Candidate.from_name("sadigh", gamma=0.9999),
    "sadigh .99, marks only": Candidate.from_name("sadigh"),
    "sadigh .9999, marks only": Candidate.from_name("sadigh", gamma=0.9999),
    "sadigh, pair 0": Candidate.from_name("sadigh", pair=0),
    "accept .99": Candidate.from_name("accept"),
    "accept .9999": Candidate.from_name("accept", gamma=0.9999),
    "code, reset": Candidate.from_name("thesis-code", "initial", terminate_on_accept=False, terminal=1000.0),
    "code, end": Candidate.from_name("thesis-code", "terminate", terminate_on_accept=False),
    "parity .1": Candidate.from_name("parity", epsilon=0.1),
    "parity .01": Candidate.from_name("parity", epsilon=0.01),
    "parity .001": Candidate.from_name("parity", epsilon=0.001),
    "two-discount .99 .999": Candidate.from_name("two-discount", gamma_accept=0.99, gamma=0.999),
    "two-discount .99 .9999": Candidate.from_name("two-discount", gamma_accept=0.99, gamma=0.9999),
    "two-discount .99 .99999": Candidate.from_name("two-discount", gamma_accept=0.99, gamma=0.99999),
    "two-discount .9 .999": Candidate.from_name("two-discount", gamma_accept=0.9, gamma=0.999),
    "zeta-reach .9": Candidate.from_name("zeta-reach", zeta=0.9),
    "zeta-reach .99": Candidate.from_name("zeta-reach", zeta=0.99),
    "zeta-discount .99": Candidate.from_name("zeta-discount", zeta=0.99),
    "eventual .9": Candidate.from_name("eventual", gamma=0.9),
    "eventual .99": Candidate.from_name("eventual", gamma=0.99),
    "frontier": Candidate.from_name("frontier"),
}


def report(task: str, candidates: Sequence[str] | None = None) -> FaithfulnessReport:
    """The faithfulness of some or all candidates in one task."""
    case = TASKS[task]
    automaton = compile(case.formula, acceptance="transition")
    found = [one_report(case.model, automaton, name) for name in candidates or CANDIDATES]
    return replace(found[0], rows=tuple(row for one in found for row in one.rows))


def one_report(model: LabelledMDP, automaton: DRA, name: str) -> FaithfulnessReport:
    """The faithfulness of one candidate."""
    candidate = CANDIDATES[name]
    if name.endswith("marks only") and isinstance(candidate.scheme, Sadigh):
        automaton = to_parity(automaton).automaton
        for_ever = candidate.scheme.weight_fin / (1 - candidate.scheme.gamma)
        scheme = replace(candidate.scheme, violation=for_ever if automaton.fin.any() else 0.0)
        candidate = replace(candidate, scheme=scheme)
    return faithfulness(model, automaton, [candidate])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help=f"of {', '.join(TASKS)}; default all")
    parser.add_argument("--json", metavar="FILE", help="write the table as JSON")
    arguments = parser.parse_args()
    result = {}
    for task in arguments.tasks or TASKS:
        found = report(task)
        result[task] = found.to_dict()
        print(f"\n{task}: {TASKS[task].formula}, Pmax {found.maximum:.6g} (certified {TASKS[task].pmax:.6g})")
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
