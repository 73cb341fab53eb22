"""Exact solving at scale: the maximum satisfaction probability on large grids, beside Storm's sparse engine.

    python benchmarks/solving.py [--cells 100 300] [--formulas phi4 until] [--no-storm] [--storm-limit 300]
                                 [--repeat 1] [--json FILE]

The world is the 10x10 map of Q. Gao's thesis (Duke University, 2018, https://hdl.handle.net/10161/17056) with every
coordinate multiplied, one cell a label, five moves, 0.6 for the one chosen. Each solver runs in a process of its own;
its time goes from the labelled MDP (Storm: from the loaded sparse model) to the answer, automaton included. Storm runs
as stormpy configures it: sound methods, precision 1e-6. It is left out where stormpy is not installed, and stopped
after `--storm-limit` seconds, loading included; a ratio against a limit is an upper one.

The width is the distance between the two proved bounds on the probability from the initial state.
"""

from __future__ import annotations

import argparse
import importlib.util
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
    product = Product(mdp, compile(FORMULAS[formula][0]))
    answer = max_satisfaction_probability(product)
    seconds = time.perf_counter() - before
    return {
        "seconds": seconds,
        "states": product.n_states,
        "value": answer.probability,
        "lower": answer.lower,
        "upper": answer.upper,
        "widest": float((answer.state_upper - answer.state_lower).max()),
    }


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


def in_a_process(*arguments: str, limit: float | None = None) -> dict[str, float]:
    """The answer of a fresh process, with its peak memory in MiB; only `limit` seconds where it takes longer."""
    command = [sys.executable, __file__, *arguments]
    try:
        child = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=limit)
    except subprocess.TimeoutExpired:
        assert limit is not None
        return {"limit": limit}
    return dict(json.loads(child.stdout.splitlines()[-1]))


def compare(side: int, formula: str, *, storm: bool, storm_limit: float, repeat: int) -> dict[str, object]:
    from ltlc.prism import write_explicit

    runs = {"ltlc": [in_a_process("--worker", "ltlc", str(side), formula) for _ in range(repeat)]}
    if storm:
        with tempfile.TemporaryDirectory() as folder:
            files = str(Path(folder) / "model")
            write_explicit(world(side), files, style="storm")
            runs["storm"] = [
                in_a_process("--worker", "storm", files, formula, limit=storm_limit) for _ in range(repeat)
            ]
    best = {name: min(found, key=lambda run: run.get("seconds", float("inf"))) for name, found in runs.items()}
    return {"side": side, "formula": formula, **best}


def line(side: int, run: dict[str, float], storm: dict[str, float] | None) -> str:
    """A row of the table."""
    width = run["upper"] - run["lower"]
    text = f"{side:>5}x{side:<5} {run['states']:9} {run['seconds']:8.2f} {run['peak_mib']:6.0f} {width:8.1e}"
    text += f"  {run['value']:<12.9g}"
    if storm is None:
        return text
    if "limit" in storm:
        return text + f" > {storm['limit']:6.0f} {'':6} {run['seconds'] / storm['limit']:6.2f}"
    ratio = run["seconds"] / storm["seconds"]
    return text + f" {storm['seconds']:8.2f} {storm['peak_mib']:6.0f} {ratio:6.2f}  {storm['value']:.9g}"


def main() -> None:
    if sys.argv[1:2] == ["--worker"]:
        _, _, solver, model, formula = sys.argv
        answer = ours(int(model), formula) if solver == "ltlc" else storms(model, formula)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(json.dumps(answer | {"peak_mib": peak}))
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="*", default=[100, 300], help="sides of the grids, multiples of 10")
    parser.add_argument("--formulas", choices=FORMULAS, nargs="*", default=["phi4", "until"])
    parser.add_argument("--no-storm", action="store_true")
    parser.add_argument("--storm-limit", type=float, default=300, metavar="SECONDS")
    parser.add_argument("--repeat", type=int, default=1, help="runs of each solver; the fastest counts")
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    storm = not arguments.no_storm and importlib.util.find_spec("stormpy") is not None
    rows = []
    for formula in arguments.formulas:
        print(FORMULAS[formula][0])
        print(f"{'grid':>11} {'states':>9} {'seconds':>8} {'MiB':>6} {'width':>8}  {'Pmax':<12}", end="")
        print(f" {'Storm s':>8} {'MiB':>6} {'ratio':>6}  its Pmax" if storm else "")
        for side in arguments.cells:
            row = compare(side, formula, storm=storm, storm_limit=arguments.storm_limit, repeat=arguments.repeat)
            rows.append(row)
            print(line(side, row["ltlc"], row.get("storm")), flush=True)  # type: ignore[arg-type]
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=2), encoding="utf-8")


if __name__ == "__main__":
    main()
