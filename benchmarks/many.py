"""Formulas a second with `compile_many`: random reach-avoid sequences, as agents for many tasks are trained on.

    python benchmarks/many.py [--formulas 5000] [--depth 5] [--propositions 12] [--workers 1 2] [--json FILE]

A sequence reaches one place while avoiding up to two others, then the next, and so on.
"""

from __future__ import annotations

import argparse
import json
import random
import time
from pathlib import Path

from ltlc import compile_many


def reach_avoid(rng: random.Random, places: list[str], depth: int) -> str:
    """The last place to reach is innermost."""
    task = ""
    for _ in range(depth):
        *avoid, reach = rng.sample(places, rng.randint(1, 3))
        goal = f"({reach} & {task})" if task else reach
        task = f"(!({' | '.join(avoid)}) U {goal})" if avoid else f"F {goal}"
    return task


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--formulas", type=int, default=5000)
    parser.add_argument("--depth", type=int, default=5)
    parser.add_argument("--propositions", type=int, default=12)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--effort", choices=("fast", "default"), default="default")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the measurements too")
    options = parser.parse_args()

    rng = random.Random(0)
    places = [f"p{i}" for i in range(options.propositions)]
    formulas = [reach_avoid(rng, places, options.depth) for _ in range(options.formulas)]
    print(f"{len(formulas)} formulas such as {formulas[0]}\n")
    print("workers  seconds  formulas/s  states on average")
    results = []
    for workers in options.workers:
        start = time.perf_counter()
        automata = compile_many(formulas, workers=workers, effort=options.effort)
        seconds = time.perf_counter() - start
        states = sum(automaton.n_states for automaton in automata) / len(automata)
        print(f"{workers:7} {seconds:8.2f} {len(formulas) / seconds:11.0f} {states:18.2f}")
        results.append({"workers": workers, "seconds": seconds, "per_second": len(formulas) / seconds})
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
