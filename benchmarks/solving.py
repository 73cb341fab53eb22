"""Exact solving at scale: the maximum satisfaction probability on large grids, beside Storm's sparse engine.

    python benchmarks/solving.py [--cells 100 300] [--formula NAME] [--no-storm] [--repeat 1] [--json FILE]

The world is the 10x10 map of Q. Gao's thesis (Duke University, 2018, https://hdl.handle.net/10161/17056) with every
coordinate multiplied, one cell a label, five moves, 0.6 for the one chosen. Each solver runs in a process of its own;
its time goes from the labelled MDP (Storm: from the loaded sparse model) to the answer, automaton included. Storm is
left out where stormpy is not installed.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy import sparse

from ltlc.mdp import LabelledMDP

FORMULAS = {
    "phi3": ("F(A & F(B & F T))", 'F("A" & F("B" & F "T"))'),
    "phi4": ("F(A & F(B & F T)) & G F A & G F B", '(F("A" & F("B" & F "T"))) & (G F "A") & (G F "B")'),
    "until": (
        "!C U (A & (!C U (B & (!C U T))))",
        '!"C" U ("A" & (!"C" U ("B" & (!"C" U "T"))))',
    ),
}
CELLS = {"A": [(2, 7)], "B": [(5, 2)], "T": [(8, 8)], "C": [(i, i) for i in range(2, 7)]}
START = (4, 1)
MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def world(side: int) -> LabelledMDP:
    """The map, `side` cells wide and high; `side` is a multiple of 10."""
    n, factor = side * side, side // 10
    row, column = np.divmod(np.arange(n), side)
    reached = [np.clip(row + d, 0, side - 1) * side + np.clip(column + r, 0, side - 1) for d, r in MOVES]
    targets = np.stack(reached, axis=1).ravel()
    source = np.repeat(np.arange(n), len(MOVES))
    transitions = [
        sparse.csr_array((np.tile(np.where(np.arange(5) == a, 0.6, 0.1), n), (source, targets)), shape=(n, n))
        for a in range(len(MOVES))
    ]
    labels = {factor * (r * side + c): [name] for name, cells in CELLS.items() for r, c in cells}
    start = factor * (START[0] * side + START[1])
    return LabelledMDP.from_arrays(transitions, aps="ABCT", labels=labels, initial_state=start)


def ours(side: int, formula: str) -> dict[str, float]:
    from ltlc import compile
    from ltlc.mdp import Product, max_satisfaction_probability

    mdp = world(side)
    before = time.perf_counter()
    answer = max_satisfaction_probability(Product(mdp, compile(FORMULAS[formula][0])))
    seconds = time.perf_counter() - before
    return {"seconds": seconds, "value": answer.probability, "lower": answer.lower, "upper": answer.upper}


def storms(files: str, formula: str) -> dict[str, float]:
    import stormpy

    build = getattr(stormpy, "build_model_from_explicit", None) or stormpy.build_sparse_model_from_explicit
    model = build(f"{files}.tra", f"{files}.lab")
    question = stormpy.parse_properties(f"Pmax=? [{FORMULAS[formula][1]}]")[0]
    before = time.perf_counter()
    result = stormpy.model_checking(model, question, only_initial_states=True)
    seconds = time.perf_counter() - before
    state = model.initial_states[0]
    value = result.get_value(state) if hasattr(result, "get_value") else result.at(state)
    return {"seconds": seconds, "value": value}


def in_a_process(*arguments: str) -> dict[str, float]:
    """The answer of a fresh process, with its peak memory in MiB."""
    child = subprocess.run([sys.executable, __file__, *arguments], stdout=subprocess.PIPE, text=True, check=True)
    return dict(json.loads(child.stdout.splitlines()[-1]))


def compare(side: int, formula: str, *, storm: bool, repeat: int) -> dict[str, object]:
    from ltlc.mdp import write_explicit

    runs = {"ltlc": [in_a_process("--worker", "ltlc", str(side), formula) for _ in range(repeat)]}
    if storm:
        with tempfile.TemporaryDirectory() as folder:
            files = str(Path(folder) / "model")
            write_explicit(world(side), files, style="storm")
            runs["storm"] = [in_a_process("--worker", "storm", files, formula) for _ in range(repeat)]
    best = {name: min(found, key=lambda run: run["seconds"]) for name, found in runs.items()}
    return {"side": side, "formula": formula, **best}


def main() -> None:
    if sys.argv[1:2] == ["--worker"]:
        _, _, solver, model, formula = sys.argv
        answer = ours(int(model), formula) if solver == "ltlc" else storms(model, formula)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(json.dumps(answer | {"peak_mib": peak}))
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="*", default=[100, 300], help="sides of the grids, multiples of 10")
    parser.add_argument("--formula", choices=FORMULAS, default="phi4")
    parser.add_argument("--no-storm", action="store_true")
    parser.add_argument("--repeat", type=int, default=1, help="runs of each solver; the fastest counts")
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    storm = not arguments.no_storm
    if storm:
        try:
            import stormpy  # noqa: F401
        except ImportError:
            storm = False
    rows = []
    print(f"{FORMULAS[arguments.formula][0]}")
    print(f"{'grid':>11} {'solver':>7} {'seconds':>9} {'peak MiB':>9}  Pmax")
    for side in arguments.cells:
        row = compare(side, arguments.formula, storm=storm, repeat=arguments.repeat)
        rows.append(row)
        found = {name: row[name] for name in ("ltlc", "storm") if name in row}
        for name, run in found.items():
            assert isinstance(run, dict)
            print(f"{side:>5}x{side:<5} {name:>7} {run['seconds']:9.2f} {run['peak_mib']:9.0f}  {run['value']:.9g}")
        if len(found) == 2:
            print(f"{'':11} {'ratio':>7} {row['ltlc']['seconds'] / row['storm']['seconds']:9.2f}")  # type: ignore[index]
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=2), encoding="utf-8")


if __name__ == "__main__":
    main()
