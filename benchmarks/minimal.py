"""How many of our automata are proven smallest: by the lower bound alone, and by the SAT-based minimiser.

    python benchmarks/minimal.py sizes.tsv [--acceptance transition|state] [--timeout 10] [--json out.json]

The reference file has the columns formula, spot_transition, spot_state, owl_rabin and proven_rabin1, separated by tabs;
lines that start with # are comments. Sizes do not count the rejecting sink.

With `spottl` installed and acceptance on transitions, Spot's deterministic automata with any Emerson-Lei acceptance are
counted, too: some are smaller than any Rabin automaton can be.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
import time
import warnings
from collections import Counter
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ltlc.automata import DRA, equivalent
from ltlc.errors import LimitExceeded
from ltlc.ltl import parse, to_text
from ltlc.minimize import collapse, minimize
from ltlc.translate import Options, translate


def main() -> None:
    options = read_options()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on the spelling of the formulas
        results = [measured(row, options) for row in rows(options.reference)[: options.first]]
    report(results, options.acceptance)
    if options.json:
        options.json.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
        print(f"wrote {options.json}")


def read_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", type=Path, help="file with the reference sizes")
    parser.add_argument("--acceptance", choices=["transition", "state"], default="transition")
    parser.add_argument("--timeout", type=float, default=10, help="seconds of SAT per formula; 0: lower bound only")
    parser.add_argument("--first", type=int, help="only so many formulas")
    parser.add_argument("--json", type=Path, help="write the results to this file")
    return parser.parse_args()


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        lines = [line for line in file if not line.startswith("#")]
    return list(csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE))


def measured(row: dict[str, str], options: argparse.Namespace) -> dict[str, Any]:
    """Sizes of one formula, and how far they are proven."""
    reference = {name: int(value) for name, value in row.items() if name != "formula" and value}
    result: dict[str, Any] = {"formula": row["formula"], "reference": reference}
    try:
        automaton = translate(parse(row["formula"]), Options(acceptance=options.acceptance, timeout=60))
    except LimitExceeded as error:
        return result | {"status": "not translated", "reason": str(error)}
    started = time.perf_counter()
    found = collapse(automaton)
    result["bound_seconds"] = round(time.perf_counter() - started, 4)
    status = "proven by lower bound" if found.is_proven else "open"
    if not found.is_proven and options.timeout:
        started = time.perf_counter()
        found = minimize(found.automaton, timeout=options.timeout)
        result["sat_seconds"] = round(time.perf_counter() - started, 2)
        status = "proven by SAT" if found.is_proven else "open"
    if not equivalent(found.automaton, automaton):
        sys.exit(f"wrong: {row['formula']}")
    sink = len(found.automaton.deadlocks)
    if find_spec("spot") is not None and options.acceptance == "transition":
        result["emerson_lei"] = emerson_lei_states(row["formula"])
    return result | {
        "status": status,
        "translated": without_sink(automaton),
        "smallest_found": found.automaton.n_states - sink,
        "lower_bound": found.lower_bound - sink,  # one residual is empty iff there is a sink
        "n_pairs": found.automaton.n_pairs,
    }


def emerson_lei_states(formula: str) -> int:
    """States of Spot's deterministic automaton with any acceptance condition."""
    import spot

    states: int = spot.translate(to_text(parse(formula), "spot"), "det", "generic").num_states()
    return states


def without_sink(automaton: DRA) -> int:
    return automaton.n_states - len(automaton.deadlocks)


def report(results: list[dict[str, Any]], acceptance: str) -> None:
    print(f"{len(results)} formulas, acceptance on {acceptance}s, sizes without the rejecting sink")
    for status, count in Counter(result["status"] for result in results).most_common():
        print(f"  {count:4} {status}")
    done = [result for result in results if "translated" in result]
    for name in ("translated", "smallest_found", "lower_bound"):
        print(f"  {name:15} {sum(result[name] for result in done):6} states in all")
    smaller = [result for result in done if result.get("emerson_lei", math.inf) < result["translated"]]
    proven = sum(result["translated"] == result["lower_bound"] for result in smaller)
    print(f"  {len(smaller)} have an Emerson-Lei automaton with fewer states; {proven} of these are proven smallest")
    print("not proven, or not smallest as translated:")
    print("  translated  found  bound  pairs  status                 formula")
    for r in done:
        if r["status"] == "open" or r["translated"] > r["smallest_found"]:
            numbers = f"{r['translated']:10} {r['smallest_found']:6} {r['lower_bound']:6} {r['n_pairs']:6}"
            print(f"  {numbers}  {r['status']:21}  {r['formula'][:80]}")


if __name__ == "__main__":
    main()
